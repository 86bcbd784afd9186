//! What is to be reported on.

use cosim::run::Experiment;
use cosim::system::System;

/// Inertia error with which the adaptation is shown besides nominal inertias.
pub const UNCERTAIN: f64 = 1.4;

/// What is to be reported on.
pub struct Request<'a> {
    /// The machine.
    pub system: &'a System,
    /// What all runs have in common.
    pub base: &'a Experiment,
    /// The one-axis experiment, where there is one.
    pub testbed: Option<&'a System>,
    /// The machine of the real world, where there is one.
    pub real: Option<&'a System>,
    /// The machine that bends, where it is to be run.
    pub bending: Option<&'a System>,
    /// The machine fed by a battery, where there is one.
    pub electric: Option<&'a System>,
    /// A path of the reader's own by its name, and the experiment that follows it.
    pub path: Option<(String, Experiment)>,
}
