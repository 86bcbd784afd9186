//! FMI 2.0 co-simulation FMU `Rig`: the electromechanical linear actuator as built.
//!
//! `table` is the single source of names, units, bounds and dependencies; this file connects it to the `rig` library.
#![allow(non_snake_case)] // the paper's symbols

mod table;

use fmu_export::{Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use machine::{EmlaFields, Machine};
use rig::{Drive, Extras, Output, Rig, State};
use serde::{Deserialize, Serialize};

/// The actuator behind the FMI border.
#[derive(Clone, Serialize, Deserialize)]
pub struct RigFmu {
    rig: Rig,
    state: State,
    rod: Rod,
    /// Not part of the behaviour: handed to the importer's log once.
    #[serde(skip)]
    warning: Option<String>,
}

/// Where the rod is between two sets of the input `x`: it moves on with its velocity, in a step and from one step to the next, because
/// holding it while x_dot ≠ 0 would cost kilonewtons.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct Rod {
    /// How often the input `x` had been set.
    sets: u32,
    /// Where the rod is until it is set again, m.
    x: f64,
}

impl Rod {
    fn at(u: &Input) -> Self {
        Self {
            sets: u.x_sets,
            x: u.u.x,
        }
    }

    /// The inputs with the rod where it is.
    fn input(&self, u: &Input, rig: &Rig) -> rig::Input {
        let x = if u.x_sets == self.sets { self.x } else { u.u.x };
        rig::Input { x, ..u.fed(rig) }
    }

    /// The rod after a step of `h` s that began with the inputs `now`, if it has stayed within the bounds of `x`.
    fn moved(u: &Input, now: &rig::Input, h: f64) -> Result<Self, ModelError> {
        let (x, limit) = (now.moved(h).x, table::X_LARGEST);
        if x.abs() > limit {
            return Err(ModelError::new(format!(
                "`x_dot` moves the rod to x = {x} m within the step; it must stay within {limit} m of 0"
            )));
        }
        Ok(Self { sets: u.x_sets, x })
    }
}

/// Inputs as the importer sees them.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Input {
    u: rig::Input,
    /// How often `v_dc` was set.
    v_dc_sets: u32,
    /// How often `x` was set.
    x_sets: u32,
}

impl Input {
    /// The inputs; a voltage of the DC link that nobody has set is the machine's.
    fn fed(&self, rig: &Rig) -> rig::Input {
        let mut u = self.u;
        if self.v_dc_sets == 0 {
            u.v_dc = rig.params().link_voltage();
        }
        u
    }
}

/// Parameters as the importer sees them.
#[derive(Clone, Serialize, Deserialize)]
pub struct Parameters {
    /// Item of `table::DRIVE`.
    drive: i32,
    /// Communication steps by which the force acts late.
    delay: i32,
    /// Item of `table::AXIS`.
    axis: i32,
    /// The machine's section `emla`.
    of_machine: EmlaFields,
    extras: Extras,
    /// Voltage of the DC link below which an enabled drive trips, V.
    undervoltage: f64,
    /// Temperatures of winding and housing at the start, K.
    T_start: [f64; 2],
    /// File the machine came from; empty: the embedded reference machine.
    machine_file: String,
}

impl Parameters {
    fn reference() -> Self {
        Self {
            drive: table::DRIVE_MOTION,
            delay: 0,
            axis: table::AXIS_SLEW,
            of_machine: EmlaFields::new(Machine::reference().emla.slew),
            extras: Extras::AS_BUILT,
            undervoltage: 0.0,
            T_start: [table::ROOM; 2],
            machine_file: String::new(),
        }
    }

    fn actuator(&self) -> Result<Rig, ModelError> {
        let p = self.of_machine.section()?;
        let drive = match self.drive {
            table::DRIVE_MOTION => Drive::Motion,
            _ => Drive::Force,
        };
        Ok(Rig::new(p, self.extras, drive)?
            .with_undervoltage(self.undervoltage)
            .with_delay(u32::try_from(self.delay)?))
    }
}

/// What to tell when the drive trips at time `t`, s.
fn trip(rig: &Rig, u: &rig::Input, t: f64) -> String {
    machine::trip_message(t, u.v_dc, rig.undervoltage())
}

impl Model for RigFmu {
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
        let u = rig::Input {
            x: table::X_START,
            v_dc: parameters.of_machine.inverter.v_dc,
            T_ambient: table::ROOM,
            ..rig::Input::default()
        };
        let input = Input {
            u,
            ..Input::default()
        };
        (parameters, input)
    }

    fn initialize(p: &Parameters, u: &Input, t: f64) -> Result<Self, ModelError> {
        let (rig, rod) = (p.actuator()?, Rod::at(u));
        let u = rod.input(u, &rig);
        let state = rig.start(&u, p.T_start)?;
        let warning = state.tripped.then(|| trip(&rig, &u, t));
        Ok(Self {
            rig,
            state,
            rod,
            warning,
        })
    }

    fn output(&self, _p: &Parameters, u: &Input, _now: &()) -> Result<Output, ModelError> {
        Ok(self.rig.output(&self.state, &self.rod.input(u, &self.rig)))
    }

    fn step(
        &mut self,
        _p: &Parameters,
        u: &InputPolynomial<Input>,
        _now: &(),
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        let now = self.rod.input(u.value(), &self.rig);
        let mut state = self.rig.step(&self.state, &now, t, h)?;
        state.shift += self.rig.work_of_shift(&self.state, self.rod.x, now.x);
        if state.tripped && !self.state.tripped {
            self.warning = Some(trip(&self.rig, &now, t));
        }
        if self.rig.drive() == Drive::Motion {
            self.rod = Rod::moved(u.value(), &now, h)?; // with a free rod `x` counts at the start only
        }
        self.state = state;
        Ok(StepEnd::WHOLE)
    }

    fn take_warning(&mut self) -> Option<String> {
        self.warning.take()
    }
}

fmu_export::export_fmu!(RigFmu);

#[cfg(test)]
mod tests {
    use super::*;

    /// Accessors, and dependencies against trying.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<RigFmu>(), [""; 0]);
    }

    /// Set once, and set at every communication point to where the velocity has taken the rod: the same motion, to the rounding of a
    /// position that 1000 sums have made. Beyond the bounds of `x` a step is refused and changes nothing.
    #[test]
    fn a_rod_that_is_set_once_moves_on() {
        let (parameters, defaults) = RigFmu::defaults();
        let at = |k: u32, x: f64| Input {
            u: rig::Input {
                x,
                x_dot: 0.1,
                v_q: 30.0,
                ..defaults.u
            },
            x_sets: k,
            ..defaults
        };
        let start = at(0, 0.3);
        let fmu = RigFmu::initialize(&parameters, &start, 0.0).expect("valid");
        let (mut once, mut each) = (fmu.clone(), fmu);
        let step = |fmu: &mut RigFmu, u: Input| {
            fmu.step(&parameters, &InputPolynomial::held(u), &(), 0.0, 1e-3)
        };
        for k in 0..1000 {
            step(&mut once, start).expect("within");
            step(&mut each, at(k, 0.3 + f64::from(k) * 1e-4)).expect("within");
            let of = |fmu: &RigFmu, u| fmu.output(&parameters, &u, &()).expect("finite").F;
            let difference = of(&once, start) - of(&each, at(k + 1, 0.3 + f64::from(k + 1) * 1e-4));
            assert!(difference.abs() < 1e-4, "{k}: {difference}");
        }
        let before = once.state;
        let beyond = step(&mut once, at(7, 9.99995)).expect_err("beyond 10 m");
        assert!(beyond.to_string().contains("10.0000"), "{beyond}");
        assert_eq!(once.state, before);
    }
}
