//! FMI 2.0 co-simulation FMU `Emla`: an electromechanical linear actuator.
//!
//! `table` is the single source of names, units, bounds and dependencies; this file connects it to the
//! `emla` library.
#![allow(non_snake_case)] // the paper's symbols

mod table;

use emla::{Drive, Emla, Input, InputPath, Output, State, Surrogate};
use fmu_export::{Info, InputPolynomial, Model, ModelError, Variable};
use machine::{CoreLosses, InverterLosses, Machine};
use serde::{Deserialize, Serialize};

/// The actuator behind the FMI border.
#[derive(Clone, Serialize, Deserialize)]
pub struct EmlaFmu {
    emla: Emla,
    state: State,
}

/// Parameters as the importer sees them.
#[derive(Clone, Serialize, Deserialize)]
pub struct Parameters {
    /// Item of `table::DRIVE`.
    drive: i32,
    /// Blending of the network, 0…1.
    alpha: f64,
    /// All but pole pairs and losses, which have fields of their own here.
    emla: machine::Emla,
    /// FMI integers are signed.
    pole_pairs: i32,
    /// Zero where the machine has none.
    core: CoreLosses,
    /// Zero where the machine has none.
    inverter: InverterLosses,
    /// File the machine came from; empty: the embedded reference machine.
    machine_file: String,
    /// Network behind the blending.
    surrogate: Surrogate,
    /// File the network came from; empty: the embedded network.
    surrogate_file: String,
}

impl Parameters {
    fn reference() -> Self {
        let mut parameters = Self {
            drive: table::DRIVE_MOTION,
            alpha: 0.0,
            emla: Machine::reference().emla,
            pole_pairs: 0,
            core: NO_CORE,
            inverter: NO_INVERTER,
            machine_file: String::new(),
            surrogate: Surrogate::reference(),
            surrogate_file: String::new(),
        };
        parameters.take(Machine::reference().emla);
        parameters
    }

    /// Replaces everything that the machine's JSON says of an actuator.
    fn take(&mut self, emla: machine::Emla) {
        self.pole_pairs = i32::try_from(emla.p).unwrap_or(i32::MAX);
        self.core = emla.core.unwrap_or(NO_CORE);
        self.inverter = emla.inverter.unwrap_or(NO_INVERTER);
        self.emla = emla;
    }

    fn actuator(&self) -> Result<Emla, ModelError> {
        let p = machine::Emla {
            p: u32::try_from(self.pole_pairs)?,
            core: Some(self.core),
            inverter: Some(self.inverter),
            ..self.emla
        };
        let drive = match self.drive {
            table::DRIVE_MOTION => Drive::Motion,
            _ => Drive::Force,
        };
        Ok(Emla::new(p, drive)?.with_surrogate(self.surrogate.clone(), self.alpha))
    }
}

const NO_CORE: CoreLosses = CoreLosses { k_h: 0.0, k_e: 0.0 };
const NO_INVERTER: InverterLosses = InverterLosses {
    v_dc: 0.0,
    f_sw: 0.0,
    k_sw: 0.0,
    v_0: 0.0,
    r_0: 0.0,
};

/// The importer's polynomial in the library's form.
fn path(u: &InputPolynomial<Input>) -> InputPath {
    let mut path = InputPath::held(*u.value());
    for (order, derivative) in (1..=u.order()).zip(&mut path.derivatives) {
        *derivative = u.derivative(order);
    }
    path
}

impl Model for EmlaFmu {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    const INFO: Info = table::INFO;

    fn variables() -> &'static [Variable<Self>] {
        table::VARIABLES
    }

    fn defaults() -> (Parameters, Input) {
        let input = Input {
            x: table::X_START,
            ..Input::default()
        };
        (Parameters::reference(), input)
    }

    fn initialize(p: &Parameters, u: &Input, _t: f64) -> Result<Self, ModelError> {
        let emla = p.actuator()?;
        let state = emla.start(u)?;
        Ok(Self { emla, state })
    }

    fn tune(&mut self, p: &Parameters) -> Result<(), ModelError> {
        self.emla.set_alpha(p.alpha);
        Ok(())
    }

    fn output(&self, _p: &Parameters, u: &Input) -> Result<Output, ModelError> {
        Ok(self.emla.output(&self.state, u))
    }

    fn step(
        &mut self,
        _p: &Parameters,
        u: &InputPolynomial<Input>,
        t: f64,
        h: f64,
    ) -> Result<(), ModelError> {
        self.state = self.emla.step(&self.state, &path(u), t, h)?;
        Ok(())
    }

    /// The rod moves on with its velocity: after a step F belongs to the new time.
    fn extrapolate(_p: &Parameters, u: &InputPolynomial<Input>, h: f64) -> Input {
        path(u).at(h)
    }

    fn output_derivative(
        &self,
        _p: &Parameters,
        u: &Input,
        u_dot: &Input,
    ) -> Result<Output, ModelError> {
        Ok(self.emla.output_dot(&self.state, u, u_dot))
    }

    fn directional_derivative(
        &self,
        _p: &Parameters,
        u: &Input,
        du: &Input,
    ) -> Result<Output, ModelError> {
        Ok(self.emla.output_along(&self.state, u, du))
    }
}

fmu_export::export_fmu!(EmlaFmu);
