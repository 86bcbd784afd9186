//! A model with one variable of each kind that derives and tables can make beside plain numbers,
//! and messages of its own.

use fmu_export::Log;
use fmu_export::prelude::*;
use serde::{Deserialize, Serialize};

/// Who switches
#[derive(Clone, Copy, Debug, PartialEq, Enumeration)]
pub enum Mode {
    /// nobody
    Off,
    /// the input
    Manual,
    /// a thermostat
    Thermostat,
}

#[derive(Parameters)]
pub struct Body {
    /// Heat capacity
    #[fmu(unit = "J/K", start = 800, min = 1)]
    capacity: f64,
    /// Conductance to the ambient
    #[fmu(unit = "W/K", start = 2, min = 0)]
    conductance: f64,
}

#[derive(Parameters)]
pub struct Parameters {
    /// Zero of the Celsius scale
    #[fmu(unit = "K", start = 273.15, constant)]
    zero: f64,
    pub body: Body,
    /// Power of the heater
    #[fmu(unit = "W", start = 500, min = 0, tunable, at = 10)]
    power: f64,
    /// A note
    note: String,
    /// Temperatures of the thermostat
    #[fmu(unit = "degC", start = [60, 62.5])]
    limits: [f64; 2],
}

#[derive(Input)]
pub struct Input {
    /// Temperature around
    #[fmu(unit = "K", display_unit = "degC", start = 293.15, min = 0, at = 100)]
    ambient: f64,
    /// Switch
    on: bool,
    /// Who switches
    #[fmu(start = Mode::Manual)]
    mode: Choice<Mode>,
}

#[derive(Output)]
pub struct Output {
    /// Temperature
    #[fmu(
        unit = "K",
        display_unit = "degC",
        at = 200,
        depends_on(),
        initially_depends_on(ambient)
    )]
    temperature: f64,
    /// What it does
    #[fmu(depends_on(on, mode), initially_depends_on(on, mode, ambient, limits))]
    doing: &'static str,
    /// Time constant
    #[fmu(unit = "s", calculated, initially_depends_on(body.capacity, body.conductance))]
    time_constant: f64,
    /// Who switches
    #[fmu(name = "switched_by", depends_on(mode), initially_depends_on(mode))]
    mode: Choice<Mode>,
}

/// Value references, counted by hand.
#[rustfmt::skip]
pub mod vr {
    pub const ZERO: u32 = 0; pub const CAPACITY: u32 = 1; pub const CONDUCTANCE: u32 = 2; pub const GAP: u32 = 3;
    pub const POWER: u32 = 10; pub const NOTE: u32 = 11; pub const LIMITS: [u32; 2] = [12, 13];
    pub const AMBIENT: u32 = 100; pub const ON: u32 = 101; pub const MODE: u32 = 102;
    pub const DOING: u32 = 201; pub const TIME_CONSTANT: u32 = 202; pub const SWITCHED_BY: u32 = 203;
    pub const BEYOND: u32 = 204;
}

#[derive(Clone, Serialize, Deserialize)]
pub struct Heater {
    temperature: f64,
    log: Log,
}

impl Heater {
    fn is_heating(&self, p: &Parameters, u: &Input) -> bool {
        match *u.mode {
            Mode::Off => false,
            Mode::Manual => u.on,
            Mode::Thermostat => self.temperature - p.zero < p.limits[0],
        }
    }
}

impl Model for Heater {
    const INFO: Info = Info::new("Heater", "a body that is heated")
        .log_categories(&[("heat", "Heat and temperatures"), ("switch", "Switching")]);
    derived!(Parameters, Input, Output);

    fn initialize(_p: &Parameters, u: &Input, _t: f64) -> Result<Self, ModelError> {
        let mut log = Log::default();
        log.info("heat", format_args!("starts at {} K", u.ambient));
        Ok(Self {
            temperature: u.ambient,
            log,
        })
    }

    fn output(&self, p: &Parameters, u: &Input, _now: &()) -> Result<Output, ModelError> {
        Ok(Output {
            temperature: self.temperature,
            doing: if self.is_heating(p, u) {
                "heats"
            } else {
                "rests"
            },
            time_constant: p.body.capacity / p.body.conductance,
            mode: u.mode,
        })
    }

    fn step(
        &mut self,
        p: &Parameters,
        u: &InputPolynomial<Input>,
        _now: &(),
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        let u = u.value();
        let power = if self.is_heating(p, u) { p.power } else { 0.0 };
        let loss = p.body.conductance * (self.temperature - u.ambient);
        let next = self.temperature + h * (power - loss) / p.body.capacity;
        if next > 500.0 {
            self.log
                .warning("heat", format_args!("t = {t} s: {next} K, 100% lost"));
            return Err(ModelError::new("too hot"));
        }
        self.temperature = next;
        if next > 350.0 {
            self.log.warning("heat", format_args!("{next} K is hot"));
        }
        if u.on {
            self.log.info("switch", format_args!("on at {t} s"));
        }
        self.log.info("", format_args!("done"));
        self.log.info("nothing", format_args!("not declared"));
        Ok(StepEnd::WHOLE)
    }

    fn tune(&mut self, p: &Parameters) -> Result<(), ModelError> {
        self.log.warning("", format_args!("power = {} W", p.power));
        Ok(())
    }

    fn log(&mut self) -> Option<&mut Log> {
        Some(&mut self.log)
    }
}

fmu_export::export_fmu!(Heater);
