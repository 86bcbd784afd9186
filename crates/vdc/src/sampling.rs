//! When the controller samples, and how late its commands act.

use crate::evaluation::Evaluation;
use crate::prediction::Planned;
use crate::{Controller, ControllerError, Input, Settings};
use serde::{Deserialize, Serialize};

/// Most communication steps that commands may be late.
pub const DELAY_MAX: u32 = 4;
/// Most samples in one step.
const SAMPLES_MAX: f64 = 1e5;
/// Part of a sample by which a communication point may miss it: importers' clocks are off by rounding.
const SLACK: f64 = 1e-3;

/// Share of the difference between measured and predicted force that the next prediction takes over. The force as it is read before
/// new rod motions are set is out of date, by a part that grows with the rod's acceleration and would destabilize the machine at rest;
/// the prediction alone would drift.
///
/// With the share s the force settles e/s beside the measured one, where e is the error of one prediction, and follows it with the time
/// constant h/s (10 ms at steps of 1 ms); an out-of-date part acts s times as strongly. The value was found by trial
/// on the reference machine; it is not derived.
const FORCE_SHARE: f64 = 0.1;

/// When the controller samples, and how late its commands act; the default, all zero, is the paper's: it samples at each
/// communication point, and its commands act at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Time between two samples, s: outputs change at its multiples after the start only, whatever the communication steps. Zero: every
    /// communication point is a sample.
    pub sample_time: f64,
    /// Communication steps by which the commands act later than they are measured for, at most [`DELAY_MAX`]: 1 where an importer reads
    /// all outputs before it sets any input. With a delay, samples are taken at communication points only.
    pub delay: u32,
}

/// Where the controller is between two samples.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Sampling {
    /// Samples taken.
    count: u64,
    /// Measurements that the present outputs belong to; None: those of the moment.
    held: Option<Input>,
    /// What acts in this step and in those to come, as far as it is decided; read from the first step on with a delay.
    planned: [Planned; DELAY_MAX as usize],
}

impl Sampling {
    /// Measurements that the present outputs belong to, where these are not the inputs of the moment.
    pub(crate) fn held(&self) -> Option<&Input> {
        self.held.as_ref()
    }
}

impl Controller {
    /// Time of sample `k`, s.
    #[expect(clippy::cast_precision_loss, reason = "2^53 samples are never reached")]
    fn sample(&self, k: u64) -> f64 {
        self.state.t_start + k as f64 * self.timing().sample_time
    }

    /// A step without delay: measurements are held from one sample to the next, those of a sample inside the step are `input`.
    pub(crate) fn step_sampled(
        &mut self,
        now: &Evaluation,
        settings: &Settings,
        input: &Input,
        t: f64,
        h: f64,
    ) -> Result<(), ControllerError> {
        let T = self.timing().sample_time;
        if h > SAMPLES_MAX * T {
            return Err(ControllerError::BadStep { t, h });
        }
        let before = self.state.clone();
        let (end, slack) = (t + h, SLACK * T);
        let mut now = *now;
        loop {
            let measured = *self.state.sampling.held.get_or_insert(*input);
            let next = self.sample(self.state.sampling.count + 1);
            if next > end + slack {
                return Ok(());
            }
            self.advance(&now, settings, &measured, T);
            self.state.t = next;
            self.state.sampling.count += 1;
            self.state.sampling.held = None;
            if next >= end - slack {
                return Ok(());
            }
            match self.evaluate(settings, input) {
                Ok(inside) => now = inside,
                Err(error) => {
                    self.state = before;
                    return Err(error);
                }
            }
        }
    }

    /// A step after which the outputs belong to the time at which they act: measurements are predicted over the delay, with the
    /// commands that act meanwhile.
    pub(crate) fn step_delayed(
        &mut self,
        now: &Evaluation,
        settings: &Settings,
        input: &Input,
        t: f64,
        h: f64,
    ) -> Result<(), ControllerError> {
        let timing = self.timing();
        let T = timing.sample_time;
        let delay = timing.delay.min(DELAY_MAX) as usize;
        let mut sampling = self.state.sampling;
        if sampling.count == 0 {
            sampling.planned = [Planned::of(now); DELAY_MAX as usize];
        }
        sampling.planned[delay - 1] = Planned::of(now);
        let is_sample = T == 0.0 || t >= self.sample(sampling.count) - SLACK * T;
        if is_sample {
            let mut ahead = *input;
            // The actuators give their force one step ahead (their delay is 1); before their first step it is that of the moment. The lead is
            // taken off the whole force, not off its measured share alone: this damps the boom on the locked motors (tried; at 2 ms it is needed).
            let mut lead = 0.0;
            if let Some(held) = sampling.held() {
                lead = h;
                for i in 0..3 {
                    ahead.F[i] = held.F[i] + FORCE_SHARE * (input.F[i] - held.F[i]);
                }
            }
            for planned in &sampling.planned[..delay] {
                ahead = self.predicted(&ahead, planned, settings, lead, t, h)?;
                lead = 0.0;
            }
            let acts = t + delay as f64 * h;
            let measured = *sampling.held().unwrap_or(input);
            self.advance(now, settings, &measured, (acts - self.state.t).max(0.0));
            self.state.t = acts;
            sampling.count += 1;
            sampling.held = Some(ahead);
        }
        sampling.planned.rotate_left(1);
        self.state.sampling = sampling;
        Ok(())
    }
}
