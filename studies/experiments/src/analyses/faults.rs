//! Single faults of sensors, wires and drives, for the subcommand `faults`: each strikes a running
//! machine, which must keep its path or be stopped in time; otherwise it is lost.
//!
//! What a stop may cost is measured against an oracle, which brakes at the instant of the fault
//! ([`undisturbed`]). All faults of a run's instant go on from one saved state ([`faulty_run`]).

pub mod grid;

mod faulty_run;
mod undisturbed;

use anyhow::Result;
use cosim::{Experiment, System, Verdict};
use rayon::prelude::*;
use serde::Serialize;

use crate::runs::ended_run::Fate;
use crate::runs::run_store::RunStore;
use crate::setup::start_values::Law;
pub use faulty_run::FaultyRun;
use faulty_run::Runner;
use grid::{Fault, Instant};
use undisturbed::Undisturbed;

/// Faults that one thread takes from a saved state before the next is free to take some.
const CHUNK: usize = 16;

/// A fault, when it struck, and what became of the run.
#[derive(Clone, Debug, Serialize)]
pub struct FaultResult {
    pub path: &'static str,
    /// Payload, kg.
    pub payload: f64,
    /// Time of the fault, s.
    pub time: f64,
    pub fault: Fault,
    #[serde(flatten)]
    pub run: FaultyRun,
}

/// Runs `cases` in parallel and keeps each run in `store`; `done` is called after each.
pub fn run(
    (system, base): (&System, &Experiment),
    law: &Law,
    cases: &[(Instant, Fault)],
    store: &RunStore,
    done: impl Fn() + Sync,
) -> Result<Vec<FaultResult>> {
    let common = law.settings(system)?;
    let mut instants: Vec<Instant> = cases.iter().map(|(instant, _)| *instant).collect();
    instants.sort_by_key(Instant::order);
    instants.dedup();
    let same_run = |a: &Instant, b: &Instant| a.path == b.path && a.payload == b.payload;
    let nominal = |instants: &[Instant]| {
        let experiment = instants[0].experiment((system, base), &common)?;
        let name = format!("{} {} kg", instants[0].path, instants[0].payload);
        Undisturbed::load_or_run(&name, system, &experiment, instants, store)
    };
    let runs: Vec<&[Instant]> = instants.chunk_by(same_run).collect();
    let nominals: Vec<Undisturbed> = runs.par_iter().map(|i| nominal(i)).collect::<Result<_>>()?;
    let of_instant = |instant: &Instant| {
        let run = runs.iter().position(|run| same_run(&run[0], instant));
        &nominals[run.expect("one for each instant")]
    };
    let mut chunks = Vec::new();
    for instant in &instants {
        let own = cases.iter().filter(|(of, _)| of == instant);
        let faults: Vec<&Fault> = own.map(|(_, fault)| fault).collect();
        chunks.extend(faults.chunks(CHUNK).map(|part| (*instant, part.to_vec())));
    }
    let of_chunk = |(instant, faults): &(Instant, Vec<&Fault>)| {
        let mut runner = Runner::new(system, of_instant(instant), instant)?;
        let one = |fault: &&Fault| {
            let run = runner.load_or_run(fault, store)?;
            done();
            Ok(FaultResult {
                path: instant.path,
                payload: instant.payload,
                time: runner.time(),
                fault: (*fault).clone(),
                run,
            })
        };
        faults.iter().map(one).collect::<Result<Vec<_>>>()
    };
    let results: Vec<_> = chunks.par_iter().map(of_chunk).collect::<Result<_>>()?;
    Ok(results.into_iter().flatten().collect())
}

/// Makes the verdict bad where runs are lost; faults that are smaller than a whole one are noted.
pub fn judge(results: &[FaultResult], is_judged: bool, verdict: &mut Verdict) {
    let lost: Vec<_> = results
        .iter()
        .filter(|r| r.run.fate == Fate::Lost)
        .collect();
    let Some(first) = lost.first() else { return };
    let (count, all) = (lost.len(), results.len());
    let (fault, path, payload, time) = (&first.fault, first.path, first.payload, first.time);
    let why = &first.run.why;
    let text = format!(
        "{count} of {all} runs with a fault are lost, first {fault} at {time} s of {path} with {payload} kg: {why}"
    );
    match is_judged {
        true => verdict.object(text),
        false => verdict.note(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use grid::Kind;

    #[test]
    fn a_lost_run_is_bad_unless_its_fault_was_small() {
        let result = |fate| FaultResult {
            path: "triangular",
            payload: 300.0,
            time: 6.5,
            fault: Fault::new("controller.zeta[2]", Kind::Freeze, None),
            run: FaultyRun {
                fate,
                why: "the tip left its path".into(),
                ..FaultyRun::default()
            },
        };
        let results = [
            result(Fate::Kept),
            result(Fate::Lost),
            result(Fate::Stopped),
        ];
        for is_judged in [true, false] {
            let mut verdict = Verdict::default();
            judge(&results, is_judged, &mut verdict);
            assert_eq!(verdict.is_bad(), is_judged);
            let text = &verdict.findings()[0].text;
            assert!(
                text.starts_with(
                    "1 of 3 runs with a fault are lost, first controller.zeta[2] freeze"
                )
            );
        }
        let mut good = Verdict::default();
        judge(&results[..1], true, &mut good);
        assert!(good.findings().is_empty());
    }
}
