//! State, inputs and parameters of the FMU `Hdrm`, for this crate's FMI calls and table.

use fmu_export::{Evaluation, ModelError};
use hdrm::{DOF, Dynamics, Hdrm, Load, Options, Slips, State};
use machine_file::Machine;
use serde::{Deserialize, Serialize};

/// The FMU's instance: manipulator and state.
#[derive(Clone, Serialize, Deserialize)]
pub struct HdrmFmu {
    pub(crate) plant: Hdrm,
    pub(crate) state: State,
    pub(crate) is_pushed: bool,
    /// Slip directions of the wrist's motors, in Model Exchange.
    pub(crate) slips: Slips,
    /// When commanded brakes of the wrist act in Model Exchange, s.
    pub(crate) closes: [Option<f64>; 3],
}

/// Inputs of the FMU.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Input {
    /// Inputs of the plant.
    pub(crate) u: hdrm::Input,
    /// Mass of the load, kg.
    pub(crate) load_mass: f64,
    /// Position of the load from the tip, m.
    pub(crate) load_com: [f64; 3],
}

/// The dynamics at the present state and base motion, which outputs and the first stage of a step
/// share.
impl Evaluation<HdrmFmu> for Dynamics {
    fn new(model: &HdrmFmu, _p: &Parameters, u: &Input) -> Result<Self, ModelError> {
        Ok(model.plant.dynamics_with(&model.state, &u.u))
    }
}

/// Parameters of the FMU.
#[derive(Clone, Serialize, Deserialize)]
pub struct Parameters {
    pub(crate) machine: Machine,
    /// File the machine came from; empty: the embedded reference machine.
    pub(crate) machine_file: String,
    pub(crate) options: Options,
    pub(crate) zeta_start: [f64; DOF],
    pub(crate) zeta_dot_start: [f64; DOF],
    /// Whether loads are picked up with the velocity of the end-effector.
    pub(crate) load_moves_with_tip: bool,
    /// Otherwise their velocity, m/s in the world.
    pub(crate) load_velocity: [f64; 3],
    pub(crate) push: Push,
}

/// A push on the tip: a force in T4's axes for some time.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Push {
    /// N.
    pub(crate) force: [f64; 3],
    /// s.
    pub(crate) start: f64,
    /// s.
    pub(crate) duration: f64,
}

impl Push {
    /// Whether it acts at the time `t`, s.
    pub(crate) fn acts(&self, t: f64) -> bool {
        // Rounding of a sum of steps does not decide whether it acts.
        const SLACK: f64 = 1e-9;
        let since = t - self.start + SLACK;
        since >= 0.0 && since < self.duration
    }

    /// Next time after `t` at which the push starts or ends, both s.
    pub(crate) fn next(&self, t: f64) -> Option<f64> {
        match self.acts(t) {
            true => Some(self.start + self.duration),
            false => Some(self.start).filter(|start| t < *start && self.duration > 0.0),
        }
    }

    /// Adds the push to the inputs `u` if it acts.
    pub(crate) fn on(&self, mut u: hdrm::Input, acts: bool) -> hdrm::Input {
        if acts {
            for (sum, force) in u.wrench_env.iter_mut().zip(self.force) {
                *sum += force;
            }
        }
        u
    }
}

impl Parameters {
    pub(crate) fn new(machine: Machine, machine_file: String) -> Self {
        Self {
            options: Options::from_machine(&machine),
            zeta_start: machine.start.zeta,
            zeta_dot_start: [0.0; DOF],
            load_moves_with_tip: true,
            load_velocity: [0.0; 3],
            push: Push::default(),
            machine,
            machine_file,
        }
    }

    /// The load that parameters and inputs give.
    pub(crate) fn load(&self, u: &Input) -> Load {
        Load {
            mass: u.load_mass,
            com: u.load_com,
            ..self.options.load
        }
    }

    /// Refuses a start pose outside the joint limits, which would be inside an end stop.
    pub(crate) fn check_start(&self) -> Result<(), ModelError> {
        for (i, [min, max]) in self.machine.limits.zeta().into_iter().enumerate() {
            let zeta = self.zeta_start[i];
            if !(min..=max).contains(&zeta) {
                let name = i + 1;
                return Err(ModelError::new(format!(
                    "`zeta_start[{name}]` = {zeta} rad must be within the joint limits [{min}, {max}] rad"
                )));
            }
        }
        Ok(())
    }
}
