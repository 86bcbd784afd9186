//! When the controller samples, and how late its commands act.

use crate::measured::prediction::Plan;
use crate::signals::Input;
use serde::{Deserialize, Serialize};

/// Most communication steps that commands may be late.
pub const DELAY_MAX: u32 = 4;
/// Most samples in one step.
pub(crate) const SAMPLES_MAX: f64 = 1e5;
/// Part of a sample by which a communication point may miss it: importers' clocks are off by
/// rounding.
pub(crate) const SLACK: f64 = 1e-3;

/// Share of the difference between measured and predicted force that the next prediction takes
/// over. The force as it is read before new rod motions are set is out of date, by a part that
/// grows with the rod's acceleration and would destabilize the machine at rest; the prediction
/// alone would drift.
///
/// With the share s the force settles e/s beside the measured one, where e is the error of one
/// prediction, and follows it with the time constant h/s (10 ms at steps of 1 ms); an out-of-date
/// part acts s times as strongly. The value was found by trial on the reference machine; it is not
/// derived.
const FORCE_SHARE: f64 = 0.1;

/// When the controller samples, and how late its commands act; the default, all zero, is the
/// paper's: it samples at each communication point, and its commands act at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Time between two samples, s: outputs change at its multiples after the start only, whatever
    /// the communication steps. Zero: every communication point is a sample.
    pub sample_time: f64,
    /// Communication steps by which the commands act later than they are measured for, at most
    /// [`DELAY_MAX`]: 1 where an importer reads all outputs before it sets any input. With a delay,
    /// samples are taken at communication points only.
    pub delay: u32,
}

impl Timing {
    /// Time of sample `k` where the first is at `t_start`, s.
    pub(crate) fn sample_instant(&self, t_start: f64, k: u64) -> f64 {
        t_start + k as f64 * self.sample_time
    }
}

/// Where the controller is between two samples.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Sampling {
    /// Samples taken.
    pub(crate) count: u64,
    /// Measurements that the present outputs belong to; None: those of the moment.
    pub(crate) held: Option<Input>,
    /// What acts in this step and in those to come, as far as it is decided; read from the first
    /// step on with a delay.
    planned: [Plan; DELAY_MAX as usize],
}

impl Sampling {
    /// Enters what acts after `delay` steps. At the start the same acts in the steps before.
    pub(crate) fn plan(&mut self, delay: usize, planned: Plan) {
        if self.count == 0 {
            self.planned = [planned; DELAY_MAX as usize];
        }
        self.planned[delay - 1] = planned;
    }

    /// What acts in the next `delay` steps.
    pub(crate) fn planned(&self, delay: usize) -> &[Plan] {
        &self.planned[..delay]
    }

    /// The measurements `input` with which a prediction begins, and the time by which their forces
    /// are given ahead, s, in steps of `h`.
    ///
    /// The actuators give their force one step ahead (their delay is 1); before their first step it
    /// is that of the moment. The lead is subtracted from the whole force, not from its measured
    /// share alone: this damps the boom on the locked motors (found by trial; at steps of 2 ms it
    /// is needed).
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

    /// Takes the measurements `ahead` for those of the next sample.
    pub(crate) fn hold(&mut self, ahead: Input) {
        self.count += 1;
        self.held = Some(ahead);
    }

    /// Moves the plans on by a step: what was planned for the next one acts now.
    pub(crate) fn pass(&mut self) {
        self.planned.rotate_left(1);
    }
}
