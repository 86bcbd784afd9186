//! A model with a clock of each kind, and a list of its ticks.

use fmu_export::prelude::*;

/// Most ticks.
pub const MOST: usize = 64;

#[derive(Parameters)]
pub struct Parameters {
    /// Period of `calculated`
    #[fmu(unit = "s", start = 0.3, min = 0.01)]
    pub calculated_period: f64,
    /// Period of `tunable`
    #[fmu(unit = "s", start = 0.25, min = 0.01, tunable)]
    pub tunable_period: f64,
    /// Level at which `alarm` is started
    #[fmu(unit = "1", start = 0.33)]
    pub level: f64,
}

#[derive(Input)]
pub struct Input {
    /// What `constant` samples
    #[fmu(unit = "1", clock = constant)]
    u: f64,
}

/// Clocks of each kind that follows time
#[derive(State)]
#[fmu(parameters = Parameters, input = Input, model_exchange, max_step = 0.01, experiment(0, 1, 0.05))]
pub struct Ticking {
    /// Grows by 1 per s
    #[fmu(unit = "1")]
    x: f64,
    /// Sum of the samples
    #[fmu(clock = constant, unit = "1", previous = sum_before)]
    sum: f64,
    /// The same at the tick before
    #[fmu(clock = constant, unit = "1")]
    sum_before: f64,
    /// Times of the ticks
    #[fmu(discrete, unit = "s")]
    times: [f64; MOST],
    /// Which clock it was
    #[fmu(discrete, unit = "1")]
    kinds: [f64; MOST],
    /// Intervals of the ticks
    #[fmu(discrete, unit = "s")]
    intervals: [f64; MOST],
    #[fmu(skip)]
    count: i32,
    #[fmu(skip)]
    is_above: bool,
    #[fmu(skip)]
    delay: Option<f64>,
}

impl Ticking {
    fn sample(&mut self, _p: &Parameters, u: &Input, tick: Tick) -> Result<(), ModelError> {
        (self.sum_before, self.sum) = (self.sum, self.sum + u.u);
        self.record(1, tick);
        Ok(())
    }

    fn tick<const KIND: i32>(
        &mut self,
        _p: &Parameters,
        _u: &Input,
        tick: Tick,
    ) -> Result<(), ModelError> {
        self.record(KIND, tick);
        Ok(())
    }

    fn record(&mut self, kind: i32, tick: Tick) {
        let k = self.count as usize;
        (self.times[k], self.kinds[k], self.intervals[k]) =
            (tick.time, f64::from(kind), tick.interval);
        self.count += 1;
    }
}

impl Ode for Ticking {
    fn derivative(&self, _p: &Parameters, _u: &Input, _t: f64, dx: &mut Self) {
        dx.x = 1.0;
    }

    const CLOCKS: &'static [Clock<Self>] = &[
        Clock::constant("constant", "Every 0.1 s", 0.1, Self::sample),
        Clock::fixed("fixed", "From 0.05 s on", 0.2, Self::tick::<2>).shift(0.05),
        Clock::calculated(
            "calculated",
            "Of a parameter",
            |p| p.calculated_period,
            Self::tick::<3>,
        ),
        Clock::tunable(
            "tunable",
            "Of a tunable parameter",
            |p| p.tunable_period,
            Self::tick::<4>,
        ),
        Clock::changing(
            "changing",
            "Longer each time",
            |x, _p| 0.11 * f64::from(x.kinds().filter(|k| *k == 5.0).count() as i32 + 1),
            Self::tick::<5>,
        ),
        Clock::countdown(
            "alarm",
            "12.5 ms after a level",
            |x| x.delay.take(),
            Self::tick::<6>,
        ),
    ];

    const INDICATORS: &'static [Variable<Self>] =
        &[Variable::indicator("below", "Below the level").unit("1")];

    fn indicators(&self, p: &Parameters, _u: &Input, _t: f64, z: &mut [f64]) {
        z[0] = p.level - self.x;
    }

    fn event(&mut self, p: &Parameters, _u: &Input, _t: f64) -> Event {
        if self.x >= p.level && !self.is_above {
            (self.is_above, self.delay) = (true, Some(0.0125));
        }
        Event::NONE
    }
}

impl Ticking {
    fn kinds(&self) -> impl Iterator<Item = f64> {
        self.kinds.into_iter().take(self.count as usize)
    }
}
fmu_export::export_fmu!(Ticking);
