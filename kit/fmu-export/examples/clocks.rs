//! The model `Clocks` of the Reference-FMUs, with its value references: three clocks with a model
//! partition each, one of which another starts, and a clock that ticks at each fifth tick.

use fmu_export::prelude::*;

/// Inputs
#[derive(Input)]
pub struct Input {
    /// What the second partition adds up
    #[fmu(at = 2006, clock = inClock2, name = "input2")]
    input_2: i32,
}

/// Clocks and model partitions
#[derive(State)]
#[fmu(input = Input, scheduled_execution, experiment(0, 10, 1))]
pub struct Clocks {
    /// Ticks of the first clock
    #[fmu(at = 2001, clock = inClock1, name = "inClock1Ticks")]
    ticks_1: i32,
    /// Ticks of the second clock
    #[fmu(at = 2002, clock = inClock2, name = "inClock2Ticks")]
    ticks_2: i32,
    /// Ticks of the third clock
    #[fmu(at = 2003, discrete, name = "inClock3Ticks")]
    ticks_3: i32,
    /// Ticks of all clocks
    #[fmu(at = 2004, clock = (inClock1, inClock2, inClock3), name = "totalInClockTicks")]
    ticks: i32,
    /// Sum of the inputs
    #[fmu(at = 2005, clock = inClock2, name = "result2")]
    result_2: i32,
    /// 1000 after the third partition
    #[fmu(at = 2007, clock = inClock3, name = "output3")]
    output_3: i32,
    #[fmu(skip)]
    delay: Option<f64>,
    #[fmu(skip)]
    is_fifth: bool,
}

impl Clocks {
    fn count(&mut self) {
        self.ticks += 1;
        self.is_fifth = self.ticks % 5 == 0;
    }

    fn first(&mut self, _p: &(), _u: &Input, tick: Tick) -> Result<(), ModelError> {
        self.ticks_1 += 1;
        self.count();
        if tick.time as i32 == 4 {
            self.delay = Some(0.0);
        }
        Ok(())
    }

    fn second(&mut self, _p: &(), u: &Input, _tick: Tick) -> Result<(), ModelError> {
        self.ticks_2 += 1;
        self.count();
        self.result_2 += u.input_2;
        Ok(())
    }

    fn third(&mut self, _p: &(), _u: &Input, _tick: Tick) -> Result<(), ModelError> {
        self.ticks_3 += 1;
        self.output_3 = 1000;
        self.count();
        Ok(())
    }
}

impl Ode for Clocks {
    const CLOCKS: &'static [Clock<Self>] = &[
        Clock::constant("inClock1", "Every second", 1.0, Self::first).at(1001),
        Clock::triggered("inClock2", "By the importer", Self::second).at(1002),
        Clock::countdown("inClock3", "By the first", |x| x.delay.take(), Self::third).at(1003),
        Clock::output("outClock", "Every fifth tick", |x: &mut Self| {
            std::mem::take(&mut x.is_fifth)
        })
        .at(1005),
    ];

    fn derivative(&self, _p: &(), _u: &Input, _t: f64, _dx: &mut Self) {}
}

export_fmu!(Clocks);
