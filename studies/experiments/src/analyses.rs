//! The analyses behind the subcommands, for `commands` and the report: each makes a set of runs,
//! measures them and, where there are targets, judges the result.

use cosim::Verdict;

pub mod comparison;
pub(crate) mod draws;
pub mod efficiency;
pub(crate) mod endurance;
pub(crate) mod faults;
pub(crate) mod identification;
pub(crate) mod imported_run;
pub mod inertia;
pub mod machine_check;
pub mod margins;
pub(crate) mod rest;
pub mod robustness;
pub mod sizing;
pub mod stability;
pub mod surrogate_loop;
pub mod testbed;
pub(crate) mod tournament;
pub mod trials;
pub(crate) mod weighing;

/// Says in words whether a target is met; a target that is missed makes the verdict bad with the
/// text of `objection`.
fn met(is_met: bool, verdict: &mut Verdict, objection: impl FnOnce() -> String) -> &'static str {
    if is_met {
        return "met";
    }
    verdict.object(objection());
    "NOT met"
}
