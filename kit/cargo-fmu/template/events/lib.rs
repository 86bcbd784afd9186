//! FMU `Oven`: an oven with a thermostat that switches within steps, to be replaced by a model with
//! events of your own.
//!
//! Its variables are structs with derives, as in a model of differential equations. What happens in
//! a step, though, is written out: `impl Model` in place of `impl Ode`. For importers that integrate
//! the model themselves (Model Exchange), `impl Continuous` says its equations.

use fmu_export::prelude::*;
use fmu_export::{Continuous, Log, ModelExchange};
use serde::{Deserialize, Serialize};

/// Who switches the heater
#[derive(Clone, Copy, Debug, PartialEq, Enumeration)]
enum Mode {
    /// nobody: it is off
    Off,
    /// nobody: it is on
    On,
    /// the thermostat
    Thermostat,
}

// Saved states hold parameters, inputs and the model, so all of them must be serde's `Serialize`
// and `Deserialize`. These derives bring that along for their structs.

#[derive(Parameters)]
struct Parameters {
    /// Heat capacity
    #[fmu(unit = "J/K", start = 2000.0, min = 1.0)]
    capacity: f64,
    /// Conductance to the ambient
    #[fmu(unit = "W/K", start = 5.0, min = 1e-3)]
    conductance: f64,
    /// Power of the heater
    #[fmu(unit = "W", start = 1500.0, min = 0.0)]
    power: f64,
    /// Temperature below which the thermostat switches the heater on
    #[fmu(unit = "K", display_unit = "degC", start = 453.15, min = 1.0)]
    lower: f64,
    /// Temperature above which the thermostat switches the heater off
    #[fmu(unit = "K", display_unit = "degC", start = 463.15, min = 1.0)]
    upper: f64,
    /// Temperature at the start
    #[fmu(unit = "K", display_unit = "degC", start = 293.15, min = 1.0)]
    temperature_start: f64,
}

#[derive(Input)]
struct Input {
    /// Temperature of the ambient, read at the start of a step
    #[fmu(unit = "K", display_unit = "degC", start = 293.15, min = 1.0)]
    ambient: f64,
    /// Who switches the heater
    #[fmu(start = Mode::Thermostat)]
    mode: Choice<Mode>,
}

// `depends_on` names the inputs that an output follows at once, while the state stays what it is.
// These follow none, and the last two no continuous state either.
#[derive(Output)]
struct Output {
    /// Temperature of the oven
    #[fmu(
        unit = "K",
        display_unit = "degC",
        depends_on(),
        initially_depends_on(temperature_start)
    )]
    temperature: f64,
    /// Whether the heater is on
    #[fmu(
        depends_on(no_states),
        initially_depends_on(mode, temperature_start, lower, upper)
    )]
    heating: bool,
    /// How often the heater was switched since the start
    #[fmu(depends_on(no_states), initially_depends_on())]
    switchings: i32,
}

/// The state. It is saved and restored, so it must be `Clone` and serde's; a `Log` is both.
#[derive(Clone, Serialize, Deserialize)]
struct Oven {
    temperature: f64,
    heating: bool,
    switchings: i32,
    log: Log,
}

impl Oven {
    /// Whether the heater should be on at a temperature, where it is on (`heating`) or off now.
    fn decided(p: &Parameters, u: &Input, temperature: f64, heating: bool) -> bool {
        match *u.mode {
            Mode::Off => false,
            Mode::On => true,
            Mode::Thermostat if heating => temperature < p.upper,
            Mode::Thermostat => temperature <= p.lower,
        }
    }

    /// Switches the heater at the time `t`, s, if it should be; whether it was.
    fn switch(&mut self, p: &Parameters, u: &Input, t: f64) -> bool {
        let heating = Oven::decided(p, u, self.temperature, self.heating);
        if heating == self.heating {
            return false;
        }
        self.heating = heating;
        self.switchings += 1;
        let (what, temperature) = (if heating { "on" } else { "off" }, self.temperature);
        self.log.info(
            "switch",
            format_args!("t = {t} s: the heater is switched {what} at {temperature} K"),
        );
        true
    }

    /// Time until the thermostat switches, s; infinite if it does not. T(s) = T∞ + (T − T∞)
    /// exp(−s/τ) is solved for s.
    fn time_to_switch(p: &Parameters, u: &Input, temperature: f64, heating: bool) -> f64 {
        if *u.mode != Mode::Thermostat {
            return f64::INFINITY;
        }
        let limit = if heating { p.upper } else { p.lower };
        let end = end_temperature(p, u, heating);
        let ratio = (temperature - end) / (limit - end);
        if ratio.is_finite() && ratio >= 1.0 {
            p.capacity / p.conductance * ratio.ln()
        } else {
            f64::INFINITY
        }
    }
}

/// Temperature that the oven comes to in the end, K.
fn end_temperature(p: &Parameters, u: &Input, heating: bool) -> f64 {
    let power = if heating { p.power } else { 0.0 };
    u.ambient + power / p.conductance
}

impl Model for Oven {
    const INFO: Info = Info::new("Oven", "an oven with a thermostat")
        .version(env!("CARGO_PKG_VERSION"))
        .experiment(0.0, 1000.0, 1.0)
        .log_categories(&[("switch", "When the heater is switched")]);
    const MODEL_EXCHANGE: Option<ModelExchange<Self>> = ModelExchange::from_continuous();
    derived!(Parameters, Input, Output);

    fn initialize(p: &Parameters, u: &Input, _t: f64) -> Result<Self, ModelError> {
        if p.lower >= p.upper {
            return Err(ModelError::new(format!(
                "`lower` = {} K must be below `upper` = {} K",
                p.lower, p.upper
            )));
        }
        Ok(Self {
            temperature: p.temperature_start,
            heating: Oven::decided(p, u, p.temperature_start, false),
            switchings: 0,
            log: Log::default(),
        })
    }

    fn output(&self, _p: &Parameters, _u: &Input, _now: &()) -> Result<Output, ModelError> {
        Ok(Output {
            temperature: self.temperature,
            heating: self.heating,
            switchings: self.switchings,
        })
    }

    /// The step is done to its end, whatever happens on the way: each event is found exactly, and
    /// the model goes on from there. A model that wants the importer to react first stops there
    /// instead (`StepEnd::reached`), and declares it (`Info::with_early_return`). In FMI 2.0 that
    /// is `fmi2Discard`, with which many importers end the simulation.
    fn step(
        &mut self,
        p: &Parameters,
        u: &InputPolynomial<Input>,
        _now: &(),
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        let u = u.value();
        // Nothing of this can fail. Where something can, change copies: after an error the model must
        // be as it was.
        let before = self.switchings;
        let mut now = 0.0; // s after t
        loop {
            self.switch(p, u, t + now);
            let until_switch = Oven::time_to_switch(p, u, self.temperature, self.heating);
            let end = end_temperature(p, u, self.heating);
            if now + until_switch >= h {
                let decay = (-(h - now) * p.conductance / p.capacity).exp();
                self.temperature = end + (self.temperature - end) * decay;
                break;
            }
            now += until_switch;
            self.temperature = if self.heating { p.upper } else { p.lower };
        }
        // FMI 3.0 tells the importer of the event: eventHandlingNeeded.
        let mut end = StepEnd::WHOLE;
        end.event = self.switchings != before;
        Ok(end)
    }

    fn log(&mut self) -> Option<&mut Log> {
        Some(&mut self.log)
    }
}

/// The same physics for Model Exchange: the temperature is integrated by the importer, which stops
/// where the indicator passes zero.
impl Continuous for Oven {
    fn derivative_rows() -> &'static [Variable<Self>] {
        const {
            &[Variable::derivative_of("temperature")
                .unit("K/s")
                .depends_on(&["temperature", "ambient"])]
        }
    }
    const INDICATORS: &'static [Variable<Self>] =
        &[
            Variable::indicator("until_switch", "Distance to the temperature that switches")
                .unit("K"),
        ];

    fn states(&self, x: &mut [f64]) {
        x[0] = self.temperature;
    }

    fn set_states(&mut self, x: &[f64]) {
        self.temperature = x[0];
    }

    fn derivatives(
        &self,
        p: &Parameters,
        u: &Input,
        _now: &(),
        _t: f64,
        dx: &mut Self,
    ) -> Result<(), ModelError> {
        let end = end_temperature(p, u, self.heating);
        dx.temperature = (end - self.temperature) * p.conductance / p.capacity;
        Ok(())
    }

    /// Positive while nothing is to be switched.
    fn indicators(
        &self,
        p: &Parameters,
        u: &Input,
        _now: &(),
        _t: f64,
        z: &mut [f64],
    ) -> Result<(), ModelError> {
        z[0] = match *u.mode {
            Mode::Off | Mode::On => 1.0,
            Mode::Thermostat if self.heating => p.upper - self.temperature,
            Mode::Thermostat => self.temperature - p.lower,
        };
        Ok(())
    }

    fn event(&mut self, p: &Parameters, u: &Input, t: f64) -> Result<Event, ModelError> {
        self.switch(p, u, t);
        Ok(Event::NONE)
    }
}

export_fmu!(Oven);

#[cfg(test)]
mod tests {
    use super::*;

    /// The oven after steps of these lengths, s, from the start values on.
    fn after(steps: impl Iterator<Item = f64>) -> Oven {
        let (p, u) = Oven::defaults();
        let mut oven = Oven::initialize(&p, &u, 0.0).unwrap();
        let mut t = 0.0;
        for h in steps {
            oven.step(&p, &InputPolynomial::held(u), &(), t, h).unwrap();
            t += h;
        }
        oven
    }

    /// Names, units and dependencies of the variables against what the model does.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<Oven>(), [""; 0]);
    }

    /// Oracle: from 20 °C at 1500 W towards 320 °C with τ = 400 s, 190 °C is passed after τ
    /// ln(300/130) = 334.499 s.
    #[test]
    fn the_heater_is_switched_off_in_time() {
        let before = after([334.498].into_iter());
        assert!(before.heating && before.switchings == 0);
        let behind = after([334.5].into_iter());
        assert!(!behind.heating && behind.switchings == 1);
    }

    /// Events do not wait for the end of a step, so it does not matter how long steps are.
    #[test]
    fn the_length_of_steps_does_not_matter() {
        let (once, often) = (after([1000.0].into_iter()), after((0..4000).map(|_| 0.25)));
        assert!(once.switchings > 8, "{}", once.switchings);
        assert_eq!(once.switchings, often.switchings);
        let difference = once.temperature - often.temperature;
        assert!(difference.abs() < 1e-9, "{difference}");
    }
}
