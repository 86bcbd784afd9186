//! Electromechanical linear actuator: a permanent-magnet synchronous motor drives a nut over a gear
//! and a ball screw; the nut pushes a rod through a spring and a damper.
//!
//! Source: section "Integrated Dynamic Model of the EMLA" of the paper; its equation labels stand
//! at the functions, and so does each departure from it. Quantities in dq coordinates are
//! peak-valued and oriented to the rotor flux. The rod's position `x` and its force `F` are
//! positive when the actuator extends. SI units throughout.
//!
//! [`Emla`] is the configuration, immutable after [`Emla::new`]; [`State`] is what changes and is
//! passed by value, so a step that fails leaves everything as it was. Two drive modes:
//! in [`Drive::Motion`] the mechanism prescribes the rod's motion and the actuator answers with its
//! force; in [`Drive::Force`] the rod is a free mass with an external force on it.
//!
//! The maps in [`maps`] need only parameters; the controller calls them with its own nominal set.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the paper's symbols

mod dynamics;
mod efficiency;
mod heat;
mod held;
mod input;
mod losses;
pub mod maps;
mod motor;
mod output;
mod residual;
mod start;
mod step;
mod surrogate;
mod tangent;

pub use dynamics::{Energy, State};
pub use heat::{Electric, Kinds, Thermal};
pub use input::Input;
pub use losses::Losses;
pub use motor::Dq;
pub use output::Output;
pub use residual::{Residual, Untrained};
pub use step::StepError;
pub use surrogate::{
    LayerFile, MinMax, Ranges, Split, Surrogate, SurrogateError, SurrogateFile, SurrogateOutput,
    TrainingRecord, WIDTHS,
};

use serde::{Deserialize, Serialize};

/// Who moves the rod.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Drive {
    /// The rod follows the inputs `x` and `x_dot`; the force on it is the answer.
    Motion,
    /// The rod is a mass of its own against the input `F_ext`.
    Force,
}

/// One actuator: parameters, drive mode, and the surrogate network with its blending factor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Emla {
    pub(crate) p: machine::Emla,
    pub(crate) drive: Drive,
    pub(crate) electric: Electric,
    /// Voltage of the DC link where the input gives none, V.
    pub(crate) v_dc: f64,
    /// Longest substep for these parameters, s.
    pub(crate) dt_max: f64,
    pub(crate) surrogate: Option<Surrogate>,
    pub(crate) alpha: f64,
    /// Steps by which `F` acts late.
    pub(crate) delay: u32,
}

impl Emla {
    /// An actuator without a network: physics alone.
    ///
    /// `i_max` is not enforced here: it is a limit for the drive's controller. `v_max` is, and `v_dc/√3`, because no
    /// inverter can give more.
    ///
    /// # Errors
    /// A parameter outside its physical range.
    pub fn new(p: machine::Emla, drive: Drive) -> Result<Self, machine::MachineError> {
        p.check()?;
        Ok(Self {
            dt_max: step::longest_substep(&p, drive),
            electric: Electric::default(),
            v_dc: p.link_voltage(),
            p,
            drive,
            surrogate: None,
            alpha: 0.0,
            delay: 0,
        })
    }

    /// The same actuator with this network, whose residual is scaled by `alpha` (0…1). At α = 0 the network
    /// only shows in the outputs.
    #[must_use]
    pub fn with_surrogate(mut self, surrogate: Surrogate, alpha: f64) -> Self {
        self.surrogate = Some(surrogate);
        self.set_alpha(alpha);
        self
    }

    /// The same actuator, whose force acts `delay` steps later than it is given and is therefore predicted: [`Output::F`] is
    /// `F + delay·h·K_b·(ẋ_n − ẋ)`, h the last step. Whoever holds the force over the step that follows the exchange, as an
    /// importer does that reads all outputs before it sets any input, takes damping `K_b·h` from the spring without it; from
    /// `C_b = K_b·h/2` on, 2 ms here, the coupling is unstable.
    #[must_use]
    pub fn with_delay(self, delay: u32) -> Self {
        Self { delay, ..self }
    }

    /// The same actuator with this of the electrical side.
    #[must_use]
    pub fn with_electric(self, electric: Electric) -> Self {
        Self { electric, ..self }
    }

    /// Sets the blending factor, kept inside 0…1.
    pub fn set_alpha(&mut self, alpha: f64) {
        self.alpha = alpha.clamp(0.0, 1.0);
    }

    /// Parameters.
    #[must_use]
    pub fn params(&self) -> &machine::Emla {
        &self.p
    }

    /// What it does of the electrical side.
    #[must_use]
    pub fn electric(&self) -> &Electric {
        &self.electric
    }

    /// Drive mode.
    #[must_use]
    pub fn drive(&self) -> Drive {
        self.drive
    }
}
