//! FMI 2.0 co-simulation FMU `Emla`: an electromechanical linear actuator.
//!
//! `table` is the single source of names, units, bounds and dependencies; this file connects it to the
//! `emla` library.
#![allow(non_snake_case)] // the paper's symbols

mod rod;
mod table;

use emla::{Drive, Electric, Emla, Output, State, Surrogate};
use fmu_export::{Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use machine::{EmlaFields, Machine};
use rod::Rod;
use serde::{Deserialize, Serialize};
use std::ops::{Deref, DerefMut};

/// The actuator behind the FMI border.
#[derive(Clone, Serialize, Deserialize)]
pub struct EmlaFmu {
    emla: Emla,
    state: State,
    rod: Rod,
    /// Whether the importer was told that the network is used where it was not trained.
    #[serde(skip)]
    told: bool,
    /// Not part of the behaviour: handed to the importer's log once.
    #[serde(skip)]
    warning: Option<String>,
}

/// Inputs as the importer sees them.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Input {
    u: emla::Input,
    /// Voltage of the DC link, V; counts once it was set.
    v_dc: f64,
    /// How often it was set.
    v_dc_sets: u32,
    /// How often `x` was set.
    x_sets: u32,
}

impl Input {
    /// The direction of a derivative, or a derivative by time: in them nothing is set, and every number counts.
    fn direction(&self) -> emla::Input {
        emla::Input {
            v_dc: Some(self.v_dc),
            ..self.u
        }
    }
}

impl Deref for Input {
    type Target = emla::Input;

    fn deref(&self) -> &emla::Input {
        &self.u
    }
}

impl DerefMut for Input {
    fn deref_mut(&mut self) -> &mut emla::Input {
        &mut self.u
    }
}

/// Parameters as the importer sees them.
#[derive(Clone, Serialize, Deserialize)]
pub struct Parameters {
    /// Item of `table::DRIVE`.
    drive: i32,
    /// Blending of the network, 0…1.
    alpha: f64,
    /// Communication steps by which the force acts late.
    delay: i32,
    /// What the electrical side does beyond the paper.
    electric: Electric,
    /// Temperatures of winding and housing at the start, K.
    T_start: [f64; 2],
    /// Item of `table::AXIS`.
    axis: i32,
    /// The machine's section `emla`.
    of_machine: EmlaFields,
    /// File the machine came from; empty: the embedded reference machine.
    machine_file: String,
    /// Network behind the blending.
    surrogate: Surrogate,
    /// File the network came from; empty: the embedded network.
    surrogate_file: String,
}

impl Parameters {
    fn reference() -> Self {
        Self {
            drive: table::DRIVE_MOTION,
            alpha: 0.0,
            delay: 0,
            electric: Electric::default(),
            T_start: [table::ROOM; 2],
            axis: table::AXIS_SLEW,
            of_machine: EmlaFields::new(Machine::reference().emla.slew),
            machine_file: String::new(),
            surrogate: Surrogate::reference(),
            surrogate_file: String::new(),
        }
    }

    fn actuator(&self) -> Result<Emla, ModelError> {
        let p = self.of_machine.section()?;
        let drive = match self.drive {
            table::DRIVE_MOTION => Drive::Motion,
            _ => Drive::Force,
        };
        Ok(Emla::new(p, drive)?
            .with_surrogate(self.surrogate.clone(), self.alpha)
            .with_electric(self.electric)
            .with_delay(u32::try_from(self.delay)?))
    }
}

/// What to tell when the drive trips at time `t`, s.
fn trip(emla: &Emla, u: &emla::Input, t: f64) -> String {
    machine::trip_message(t, emla.link_voltage(u), emla.electric().undervoltage)
}

impl Model for EmlaFmu {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = ();
    const INFO: Info = table::INFO;

    fn variables() -> &'static [Variable<Self>] {
        table::VARIABLES
    }

    fn defaults() -> (Parameters, Input) {
        let parameters = Parameters::reference();
        let input = Input {
            u: emla::Input {
                x: table::X_START,
                T_ambient: table::ROOM,
                ..emla::Input::default()
            },
            v_dc: parameters.of_machine.inverter.v_dc,
            ..Input::default()
        };
        (parameters, input)
    }

    fn initialize(p: &Parameters, u: &Input, t: f64) -> Result<Self, ModelError> {
        let emla = p.actuator()?;
        let rod = Rod::at(u);
        let u = rod.input(u);
        let state = emla.start_at(&u, p.T_start)?;
        let warning = state.tripped.then(|| trip(&emla, &u, t));
        Ok(Self {
            emla,
            state,
            rod,
            told: false,
            warning,
        })
    }

    fn tune(&mut self, p: &Parameters) -> Result<(), ModelError> {
        self.emla.set_alpha(p.alpha);
        Ok(())
    }

    fn output(&self, _p: &Parameters, u: &Input, _now: &()) -> Result<Output, ModelError> {
        Ok(self.emla.output(&self.state, &self.rod.input(u)))
    }

    fn step(
        &mut self,
        _p: &Parameters,
        u: &InputPolynomial<Input>,
        _now: &(),
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        let course = self.rod.course(u);
        let mut state = self.emla.step(&self.state, |s| course.at(s), t, h)?;
        state.shift += course.work_of_shift(&self.emla, &self.state);
        if state.tripped && !self.state.tripped {
            let u = self.rod.input(u.value());
            self.warning = Some(trip(&self.emla, &u, t));
        }
        if self.emla.drive() == Drive::Motion {
            self.rod = course.end(h)?; // with a free rod `x` counts at the start only
        }
        self.state = state;
        let untrained = self.emla.untrained(&self.state);
        if let Some(point) = untrained.filter(|_| !self.told) {
            self.warning = Some(format!("t = {} s: {point}", t + h));
        }
        self.told = untrained.is_some();
        Ok(StepEnd::WHOLE)
    }

    fn output_derivative(
        &self,
        _p: &Parameters,
        u: &Input,
        _now: &(),
        u_dot: &Input,
    ) -> Result<Output, ModelError> {
        Ok((self.emla).output_dot(&self.state, &self.rod.input(u), &u_dot.direction()))
    }

    fn directional_derivative(
        &self,
        _p: &Parameters,
        u: &Input,
        _now: &(),
        du: &Input,
    ) -> Result<Output, ModelError> {
        Ok((self.emla).output_along(&self.state, &self.rod.input(u), &du.direction()))
    }

    fn take_warning(&mut self) -> Option<String> {
        self.warning.take()
    }
}

fmu_export::export_fmu!(EmlaFmu);

#[cfg(test)]
mod tests {
    use super::*;

    /// Accessors, and dependencies against trying.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<EmlaFmu>(), [""; 0]);
    }
}
