//! State, inputs and parameters of the FMU `Controller`, which `table` names and `lib` uses.

use super::enumerations::{LEVEL, MODE, RATE_COMMAND, TRAJECTORY, TrajectoryItem};
use emla::Surrogate;
use fmu_export::{CountedInput, ModelError};
use machine_file::Machine;
use serde::{Deserialize, Serialize};
use tip_path::PathFile;
use vdc::{
    Controller, ControllerError, Derating, Level, Mode, RateCommand, RateLimits, ReportedWarnings,
    Settings, Timing, Trajectory,
};

/// 20 °C, K.
const ROOM_TEMPERATURE: f64 = 293.15;
/// Class F insulation: full current up to 120 °C, none at 155 °C.
const DERATED: Derating = Derating {
    start: 393.15,
    end: 428.15,
};

/// The FMU's instance: controller and warnings.
#[derive(Clone, Serialize, Deserialize)]
pub struct ControllerFmu {
    pub(crate) controller: Controller,
    /// Conditions that were reported to the importer and still last.
    #[serde(skip)]
    pub(crate) reported: ReportedWarnings,
    /// Warning for the importer's log, not part of the state.
    #[serde(skip)]
    pub(crate) warning: Option<String>,
}

/// Inputs of the FMU.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Input {
    pub(crate) u: vdc::Input,
    /// Voltage of the DC link, V; used once it is set.
    pub(crate) v_dc: CountedInput<f64>,
    /// Motor angles, rad; used once they are set.
    pub(crate) theta_m: CountedInput<[f64; 3]>,
    /// Whether the drives' supply is ready.
    pub(crate) supply_ready: bool,
}

impl Input {
    /// Start values for `machine`.
    pub(crate) fn at_start(machine: &Machine) -> Self {
        let (position, orientation) =
            vdc::tip_pose(machine, &machine.start.zeta).expect("the reference machine works");
        Self {
            u: vdc::Input {
                zeta: machine.start.zeta,
                reference_position: position,
                reference_orientation: orientation,
                T_winding: [ROOM_TEMPERATURE; 3],
                ..vdc::Input::default()
            },
            v_dc: CountedInput::new(machine.emla.lift.link_voltage()),
            theta_m: CountedInput::default(),
            supply_ready: true,
        }
    }

    /// The controller's inputs.
    pub(crate) fn measured(&self) -> vdc::Input {
        vdc::Input {
            v_dc: self.v_dc.if_set(),
            theta_m: self.theta_m.if_set(),
            supply_missing: !self.supply_ready,
            ..self.u
        }
    }
}

/// Parameters of the FMU.
#[derive(Clone, Serialize, Deserialize)]
pub struct Parameters {
    /// Nominal machine with the gains in `machine.controller`.
    pub(crate) machine: Machine,
    /// File the machine came from; empty: the embedded reference machine.
    pub(crate) machine_file: String,
    pub(crate) surrogate: Surrogate,
    /// File the network came from; empty: the embedded one.
    pub(crate) surrogate_file: String,
    pub(crate) path: Option<PathFile>,
    /// File the path came from, or the name of a built-in one; empty: none.
    pub(crate) path_file: String,
    /// Whether a path that the nominal machine cannot follow is refused.
    pub(crate) path_check: bool,
    /// Blending factor of the network in the voltage law.
    pub(crate) alpha: f64,
    /// Number of an item of [`LEVEL`].
    pub(crate) level: i32,
    /// Number of an item of [`MODE`].
    pub(crate) mode: i32,
    /// Number of an item of [`TRAJECTORY`].
    pub(crate) trajectory: i32,
    /// Inertia of the plant over nominal, for the Lyapunov outputs.
    pub(crate) true_inertia_scale: f64,
    /// Time between two samples, s; 0: each communication point is one.
    pub(crate) sample_time: f64,
    /// Communication steps after which the commands act.
    pub(crate) delay: i32,
    /// Whether the current is reduced for hot windings.
    pub(crate) derating: bool,
    /// Temperatures of that reduction.
    pub(crate) derated: Derating,
    /// Number of an item of [`RATE_COMMAND`].
    pub(crate) rate_command: i32,
    pub(crate) rates: RateLimits,
    /// Whether the drives have their own current loops.
    pub(crate) current_loop: bool,
    /// Time after the start in which the payload is weighed, s.
    pub(crate) weighing_time: f64,
    /// Share of a lap's error that is met in the next one.
    pub(crate) learning: f64,
    /// Largest required force of a rod over its rated one.
    pub(crate) force_limit: f64,
    /// Whether a supervisor watches for oscillations.
    pub(crate) supervisor: bool,
    /// Whether the controller knows the loads of a path.
    pub(crate) load_known: bool,
}

impl Parameters {
    /// Defaults: the reference machine with the paper's controller.
    pub(crate) fn reference() -> Self {
        Self {
            machine: actuator_table::own_machine(),
            machine_file: String::new(),
            surrogate: Surrogate::reference(),
            surrogate_file: String::new(),
            path: None,
            path_file: String::new(),
            path_check: true,
            alpha: 0.0,
            level: LEVEL.number(Level::Machine),
            mode: MODE.number((Mode::Adaptive, false)),
            trajectory: TRAJECTORY.number(TrajectoryItem::Cubic),
            true_inertia_scale: 1.0,
            sample_time: 0.0,
            delay: 0,
            derating: false,
            derated: DERATED,
            rate_command: RATE_COMMAND.number(RateCommand::Joint),
            rates: RateLimits::default(),
            current_loop: false,
            weighing_time: 0.0,
            learning: 0.0,
            force_limit: 0.0,
            supervisor: false,
            load_known: true,
        }
    }

    pub(crate) fn settings(&self) -> Result<Settings, ModelError> {
        let (mode, integral) = MODE.item(self.mode)?;
        Ok(Settings {
            mode,
            integral,
            level: LEVEL.item(self.level)?,
            gains: self.machine.controller,
            alpha: self.alpha,
            true_inertia_scale: self.true_inertia_scale,
            derating: self.derating.then_some(self.derated),
            rate_command: RATE_COMMAND.item(self.rate_command)?,
            current_loop: self.current_loop,
            weighing_time: self.weighing_time,
            learning: self.learning,
            force_limit: self.force_limit,
            supervisor: self.supervisor,
            load_known: self.load_known,
        })
    }

    pub(crate) fn timing(&self) -> Result<Timing, ModelError> {
        if self.current_loop && self.delay > 0 {
            return Err(ModelError::new(format!(
                "`delay` = {} with `current_loop` = true: the prediction over the delay reckons with the voltages, which drives with a \
                 current loop of their own do not follow; set one of the two to its start value, and `reading_age` to the delay",
                self.delay
            )));
        }
        Ok(Timing {
            sample_time: self.sample_time,
            delay: u32::try_from(self.delay)?,
        })
    }

    pub(crate) fn trajectory(&self) -> Result<Trajectory<'_>, ModelError> {
        Ok(match TRAJECTORY.item(self.trajectory)? {
            TrajectoryItem::Cubic => Trajectory::Cubic,
            TrajectoryItem::Triangular => Trajectory::Triangular,
            TrajectoryItem::External => Trajectory::External,
            TrajectoryItem::Rates => Trajectory::Rates(self.rates),
            TrajectoryItem::Path => Trajectory::Path {
                file: self.path.as_ref().ok_or_else(|| {
                    ModelError::new(
                        "`path_file` is empty, but `trajectory` = path needs one: it must name a path",
                    )
                })?,
                is_checked: self.path_check,
            },
        })
    }

    /// The error for the importer; errors of a path name its file.
    pub(crate) fn refusal(&self, error: ControllerError) -> ModelError {
        let hint = match &error {
            ControllerError::Refused(_) => "; with `path_check` = false it is tried nevertheless",
            ControllerError::Path(_) | ControllerError::Plant(_) => "",
            _ => return error.into(),
        };
        ModelError::new(format!("path `{}`: {error}{hint}", self.path_file))
    }
}

impl ControllerFmu {
    /// Warning if the stability conditions of the voltage law fail.
    pub(crate) fn stability_warning(&self, p: &Parameters) -> Option<String> {
        let conditions = self.controller.conditions(&p.machine.controller);
        if conditions.hold() {
            return None;
        }
        let gains = &p.machine.controller;
        Some(format!(
            "the stability conditions of the low-level law fail: `K_i` = {}, `K_f` = {}, `K_v` = {} give \
             epsilon_max = {} A/N, K_1 = {}, K_2 = {}; all must be finite and > 0, so must the gains",
            gains.K_i, gains.K_f, gains.K_v, conditions.epsilon_max, conditions.K_1, conditions.K_2
        ))
    }
}
