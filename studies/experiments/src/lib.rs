//! Experiments on the coupled manipulator, run with the co-simulation master `cosim`: the library
//! behind the program `hdrm-fmu`, used by the report and the Python package too.
//!
//! A command ([`commands`]) sets up a run ([`setup`]: system, world, machine file, path, start
//! values). An analysis ([`analyses`]: the paper's table, other errors, comparison of laws,
//! testbed, stability proof, motors, a long run) executes many such runs ([`runs`]) on the machines
//! of a world ([`worlds`]) and measures each ([`measures`]: tip, tracking, accuracy, energy,
//! limits). [`mod@print`] turns the results into text, CSV and JSON. [`machines`] computes from a
//! machine file without a run: other sizes, continuous torques, margins along a path.
//!
//! All models run as FMUs; names such as `tip_error_norm`, `settle_time` or `inertia_scale` are
//! their variables. The crate `machine-file` gives the machine's limits and ratings, `hdrm` checks
//! machine files, `surrogate` and `emla` give the network's predictions, and `rig` controls a rig
//! that loads another one. Crate `report` draws the results.
#![forbid(unsafe_code)]
#![cfg_attr(
    not(feature = "commands"),
    allow(
        dead_code,
        unused_imports,
        reason = "the Python package is built without the commands, which use it"
    )
)]

pub mod analyses;
#[cfg(feature = "commands")]
#[allow(
    missing_docs,
    reason = "the help texts of the arguments are their documentation"
)]
pub mod commands;
pub mod machines;
pub mod measures;
pub mod print;
pub mod runs;
pub mod setup;
pub mod worlds;
