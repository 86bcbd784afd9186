//! Samples an input every 100 ms and every 130 ms, and grows faster at each level: a list of events.

use fmu_export::prelude::*;

/// Most events.
pub const MOST: usize = 32;

#[derive(Input)]
pub struct Input {
    /// What is sampled
    #[fmu(unit = "1", discrete)]
    w: f64,
}

/// Events and when they were
#[derive(State)]
#[fmu(input = Input, model_exchange, max_step = 0.01)]
pub struct Sampler {
    /// Grows
    #[fmu(unit = "1")]
    x: f64,
    /// Times of the events
    #[fmu(discrete, unit = "s")]
    times: [f64; MOST],
    /// What they are: 1 and 2 samples, 3 a level
    #[fmu(discrete, unit = "1")]
    kinds: [f64; MOST],
    /// The sample or the level
    #[fmu(discrete, unit = "1")]
    values: [f64; MOST],
    #[fmu(skip)]
    counts: [i32; 4],
}

const STEPS: [f64; 3] = [f64::NAN, 0.1, 0.13];

impl Sampler {
    fn record(&mut self, t: f64, kind: usize, value: f64) {
        let k = self.counts[0] as usize;
        (self.times[k], self.kinds[k], self.values[k]) = (t, kind as f64, value);
        self.counts[0] += 1;
        self.counts[kind] += 1;
    }

    fn level(&self) -> f64 {
        0.33 * f64::from(self.counts[3] + 1)
    }
}

impl Ode for Sampler {
    fn derivative(&self, _p: &(), _u: &Input, _t: f64, dx: &mut Self) {
        dx.x = f64::from(self.counts[3] + 1);
    }

    const INDICATORS: &'static [Variable<Self>] =
        &[Variable::indicator("below", "Below the next level").unit("1")];

    fn indicators(&self, _p: &(), _u: &Input, _t: f64, z: &mut [f64]) {
        z[0] = self.level() - self.x;
    }

    /// What is due and nothing else, whenever it is called.
    fn event(&mut self, _p: &(), u: &Input, t: f64) -> Event {
        let mut next = f64::INFINITY;
        for kind in [1, 2] {
            // The second clock begins one period later.
            let start = if kind == 1 { 0 } else { 1 };
            while t >= STEPS[kind] * f64::from(self.counts[kind] + start) {
                self.record(t, kind, u.w);
            }
            next = next.min(STEPS[kind] * f64::from(self.counts[kind] + start));
        }
        if self.x >= self.level() {
            self.record(t, 3, self.x);
        }
        Event::at(next)
    }
}

export_fmu!(Sampler);
