//! An actuator, built by FMU, controller and studies: parameters, drive mode, surrogate network.

use crate::options::Electric;
use crate::substep::longest_substep;
use crate::surrogate::{EfficiencyBound, Surrogate};
use machine_file::Drive;
use serde::{Deserialize, Serialize};

/// Error: the network has no bound on the error of its efficiency.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the network's file has no `efficiency_bound`, which the interval of the efficiency needs: calibrate it with `hdrm-fmu surrogate calibrate`"
)]
pub struct NoErrorBound;

/// One actuator: parameters, drive mode, and the surrogate network with its blending factor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Emla {
    pub(crate) p: machine_file::Emla,
    pub(crate) drive: Drive,
    pub(crate) electric: Electric,
    /// Voltage of the DC link if the input gives none, V.
    pub(crate) v_dc: f64,
    /// Longest substep for these parameters, s.
    pub(crate) dt_max: f64,
    pub(crate) surrogate: Option<Surrogate>,
    pub(crate) alpha: f64,
    /// Number of steps after which `F` acts.
    pub(crate) delay: u32,
    /// The network's bound, if the interval of the efficiency is an output.
    pub(crate) bound: Option<EfficiencyBound>,
}

impl Emla {
    /// An actuator without a network. Voltages are limited to `v_max` and `v_dc/√3`, which no
    /// inverter can exceed; `i_max` is not enforced, it is a limit for the drive's controller.
    pub fn new(p: machine_file::Emla, drive: Drive) -> Result<Self, machine_file::MachineError> {
        p.check()?;
        Ok(Self {
            dt_max: longest_substep(&p, drive),
            electric: Electric::default(),
            v_dc: p.link_voltage(),
            p,
            drive,
            surrogate: None,
            alpha: 0.0,
            delay: 0,
            bound: None,
        })
    }

    /// Adds a network with its blending factor `alpha` (0…1); at 0 it only appears in outputs.
    #[must_use]
    pub fn with_surrogate(mut self, surrogate: Surrogate, alpha: f64) -> Self {
        self.surrogate = Some(surrogate);
        self.set_alpha(alpha);
        self
    }

    /// Sets the number of steps after which the force acts, for an importer that reads all outputs
    /// before it sets any input. The force is predicted over that time: [`crate::Output::F`] is
    /// `F + delay·h·K_b·(ẋ_n − ẋ)`, h the last step. Without the prediction the delay takes the
    /// damping `K_b·h` away from the spring, and from `C_b = K_b·h/2` on (2 ms here) the coupling
    /// is unstable.
    #[must_use]
    pub fn with_delay(self, delay: u32) -> Self {
        Self { delay, ..self }
    }

    /// Sets the options of the electrical side.
    #[must_use]
    pub fn with_electric(self, electric: Electric) -> Self {
        Self { electric, ..self }
    }

    /// Makes the interval of the efficiency an output; needs a network with a calibrated bound.
    pub fn with_interval(self) -> Result<Self, NoErrorBound> {
        let network = self.surrogate.as_ref();
        let bound = network.and_then(Surrogate::efficiency_bound);
        let bound = Some(bound.ok_or(NoErrorBound)?);
        Ok(Self { bound, ..self })
    }

    /// Sets the blending factor α, limited to 0…1.
    pub fn set_alpha(&mut self, alpha: f64) {
        self.alpha = alpha.clamp(0.0, 1.0);
    }

    /// Parameters.
    pub fn params(&self) -> &machine_file::Emla {
        &self.p
    }

    /// Options of its electrical side.
    pub fn electric(&self) -> &Electric {
        &self.electric
    }

    /// Drive mode.
    pub fn drive(&self) -> Drive {
        self.drive
    }
}
