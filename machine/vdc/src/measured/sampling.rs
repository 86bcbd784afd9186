//! Sample time and delay as the FMU sets them, with held measurements and plans for `controller`.

use crate::measured::prediction::Plan;
use crate::signals::Input;
use serde::{Deserialize, Serialize};

/// Largest delay of commands, communication steps.
pub const DELAY_MAX: u32 = 4;
/// Largest number of samples in one step.
pub(crate) const SAMPLES_MAX: f64 = 1e5;
/// Tolerance of communication points over the sample time, for rounding of importers' clocks.
pub(crate) const SLACK: f64 = 1e-3;

/// Correction gain of the predicted force by the measured one. The force read before new rod
/// motions are set is out of date by a part that grows with the rod's acceleration and would
/// destabilise the machine at rest; the prediction alone would drift.
///
/// With the gain s the force settles e/s away from the measured one, e the error of one prediction,
/// and follows it with the time constant h/s (10 ms at steps of 1 ms); the out-of-date part acts s
/// times as strongly. The value was tuned on the reference machine, not derived.
const FORCE_SHARE: f64 = 0.1;

/// Sample time and delay. The default (all zero) is the paper's: the controller samples at each
/// communication point, and its commands act at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Time between two samples, s: outputs change only at its multiples after the start, whatever
    /// the communication steps. 0: every communication point is a sample.
    pub sample_time: f64,
    /// Communication steps between measurement and effect of the commands, at most [`DELAY_MAX`]: 1
    /// if an importer reads all outputs before it sets any input. With a delay, samples are taken
    /// at communication points only.
    pub delay: u32,
}

impl Timing {
    /// Time of sample `k` where the first is at `t_start`, s.
    pub(crate) fn sample_instant(&self, t_start: f64, k: u64) -> f64 {
        t_start + k as f64 * self.sample_time
    }
}

/// State of sample and hold.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Sampling {
    pub(crate) count: u64,
    /// Measurements that the present outputs belong to; None: the present ones.
    pub(crate) held: Option<Input>,
    /// Plans of this step and the next ones; used with a delay.
    planned: [Plan; DELAY_MAX as usize],
}

impl Sampling {
    /// Sets the plan that acts after `delay` steps; at the start also those of the steps before.
    pub(crate) fn plan(&mut self, delay: usize, planned: Plan) {
        if self.count == 0 {
            self.planned = [planned; DELAY_MAX as usize];
        }
        self.planned[delay - 1] = planned;
    }

    /// The plans of the next `delay` steps.
    pub(crate) fn planned(&self, delay: usize) -> &[Plan] {
        &self.planned[..delay]
    }

    /// The measurements with which a prediction starts, and the time, s, over which their forces
    /// are already predicted, for steps of `h`.
    ///
    /// The actuators predict their force by one step (their delay is 1), except before their first
    /// step. The lead is subtracted from the whole force, not only from its measured part: this
    /// damps the boom on the locked motors (found empirically; needed at steps of 2 ms).
    pub(crate) fn first(&self, input: &Input, h: f64) -> (Input, f64) {
        let mut first = *input;
        let Some(held) = &self.held else {
            return (first, 0.0);
        };
        for i in 0..3 {
            first.F[i] = held.F[i] + FORCE_SHARE * (input.F[i] - held.F[i]);
        }
        (first, h)
    }

    /// Holds the predicted measurements `ahead` for the next sample.
    pub(crate) fn hold(&mut self, ahead: Input) {
        self.count += 1;
        self.held = Some(ahead);
    }

    pub(crate) fn pass(&mut self) {
        self.planned.rotate_left(1);
    }
}
