//! FMU `Controller` for co-simulation in FMI 2.0 and 3.0: the adaptive modular controller of the
//! manipulator.
//!
//! `table` is the single source of names, units, bounds and dependencies; this file connects it
//! to the `vdc` library.
#![allow(non_snake_case)] // the paper's symbols

mod table;

use emla::Surrogate;
use fmu_export::{Counted, Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
use machine::Machine;
use serde::{Deserialize, Serialize};
use std::ops::{Deref, DerefMut};
use table::TrajectoryItem;
use tip_path::PathFile;
use vdc::{
    Controller, ControllerError, Derating, Evaluation, Level, Mode, NamedMode, Output, RateCommand,
    RateLimits, ReportedTroubles, Settings, Timing, Trajectory,
};

/// The controller behind the FMI border.
#[derive(Clone, Serialize, Deserialize)]
pub struct ControllerFmu {
    controller: Controller,
    /// Troubles that were reported to the importer and that last.
    #[serde(skip)]
    reported: ReportedTroubles,
    /// Not part of the behaviour: handed to the importer's log once.
    #[serde(skip)]
    warning: Option<String>,
}

/// Inputs as the importer sees them.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Input {
    u: vdc::Input,
    /// Voltage of the DC link, V; counts once it was set.
    v_dc: Counted<f64>,
}

impl Input {
    /// What the controller reads.
    fn measured(&self) -> vdc::Input {
        vdc::Input {
            v_dc: self.v_dc.told(),
            ..self.u
        }
    }
}

impl Deref for Input {
    type Target = vdc::Input;

    fn deref(&self) -> &vdc::Input {
        &self.u
    }
}

impl DerefMut for Input {
    fn deref_mut(&mut self) -> &mut vdc::Input {
        &mut self.u
    }
}

/// Parameters as the importer sees them.
#[derive(Clone, Serialize, Deserialize)]
pub struct Parameters {
    /// Nominal machine with the gains in `machine.controller`.
    machine: Machine,
    /// File the machine came from; empty: the embedded reference machine.
    machine_file: String,
    /// Network of the hybrid actuators.
    surrogate: Surrogate,
    /// File the network came from; empty: the embedded one.
    surrogate_file: String,
    /// Path to follow.
    path: Option<PathFile>,
    /// File the path came from, or the name of a built-in one; empty: none.
    path_file: String,
    /// Whether a path that the nominal machine cannot do is refused.
    path_check: bool,
    /// Blending factor the low-level law reckons with.
    alpha: f64,
    /// Number of an item of [`table::LEVEL`].
    level: i32,
    /// Number of an item of [`table::MODE`].
    mode: i32,
    /// Number of an item of [`table::TRAJECTORY`].
    trajectory: i32,
    /// Inertia of the plant over nominal, for the Lyapunov outputs.
    true_inertia_scale: f64,
    /// Time between two samples, s; 0: each communication point is one.
    sample_time: f64,
    /// Communication steps by which the commands act late.
    delay: i32,
    /// Whether hot windings get less current.
    derating: bool,
    /// How much less.
    derated: Derating,
    /// Number of an item of [`table::RATE_COMMAND`].
    rate_command: i32,
    /// Limits of commanded rates.
    rates: RateLimits,
    /// Whether it is told of the loads that a path picks up.
    load_told: bool,
}

impl Parameters {
    fn settings(&self) -> Result<Settings, ModelError> {
        let NamedMode { mode, integral } = table::MODE.item(self.mode)?;
        Ok(Settings {
            mode,
            integral,
            level: table::LEVEL.item(self.level)?,
            gains: self.machine.controller,
            alpha: self.alpha,
            true_inertia_scale: self.true_inertia_scale,
            derating: self.derating.then_some(self.derated),
            rate_command: table::RATE_COMMAND.item(self.rate_command)?,
            load_told: self.load_told,
        })
    }

    fn timing(&self) -> Result<Timing, ModelError> {
        Ok(Timing {
            sample_time: self.sample_time,
            delay: u32::try_from(self.delay)?,
        })
    }

    fn trajectory(&self) -> Result<Trajectory<'_>, ModelError> {
        Ok(match table::TRAJECTORY.item(self.trajectory)? {
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

    /// Why there is no controller; what is wrong with a path is said of its file.
    fn refusal(&self, error: ControllerError) -> ModelError {
        let hint = match &error {
            ControllerError::Refused(_) => "; with `path_check` = false it is tried nevertheless",
            ControllerError::Path(_) | ControllerError::Plant(_) => "",
            _ => return error.into(),
        };
        ModelError::new(format!("path `{}`: {error}{hint}", self.path_file))
    }
}

impl ControllerFmu {
    /// What to tell the importer about the stability conditions of the low-level law, if they fail.
    fn stability_warning(&self, p: &Parameters) -> Option<String> {
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

impl fmu_export::Evaluation<ControllerFmu> for Evaluation {
    fn of(model: &ControllerFmu, p: &Parameters, u: &Input) -> Result<Self, ModelError> {
        Ok(model.controller.evaluate(&p.settings()?, &u.measured())?)
    }
}

impl Model for ControllerFmu {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = Evaluation;
    const INFO: Info = table::INFO;

    fn variables() -> &'static [Variable<Self>] {
        table::VARIABLES
    }

    fn defaults() -> (Parameters, Input) {
        let machine = Machine::reference();
        let (position, orientation) =
            vdc::tip_pose(&machine, &machine.start.zeta).expect("the reference machine works");
        let input = Input {
            u: vdc::Input {
                zeta: machine.start.zeta,
                reference_position: position,
                reference_orientation: orientation,
                T_winding: [table::ROOM; 3],
                ..vdc::Input::default()
            },
            v_dc: Counted::unset(machine.emla.lift.link_voltage()),
        };
        let parameters = Parameters {
            machine,
            machine_file: String::new(),
            surrogate: Surrogate::reference(),
            surrogate_file: String::new(),
            path: None,
            path_file: String::new(),
            path_check: true,
            alpha: 0.0,
            level: table::LEVEL.number(Level::Machine),
            mode: table::MODE.number(NamedMode {
                mode: Mode::Adaptive,
                integral: false,
            }),
            trajectory: table::TRAJECTORY.number(TrajectoryItem::Cubic),
            true_inertia_scale: 1.0,
            sample_time: 0.0,
            delay: 0,
            derating: false,
            derated: table::DERATED,
            rate_command: table::RATE_COMMAND.number(RateCommand::Joint),
            rates: RateLimits::default(),
            load_told: true,
        };
        (parameters, input)
    }

    fn initialize(p: &Parameters, u: &Input, t: f64) -> Result<Self, ModelError> {
        if p.derated.start >= p.derated.end {
            let Derating { start, end } = p.derated;
            return Err(ModelError::new(format!(
                "`derating.start` = {start} K must be below `derating.end` = {end} K"
            )));
        }
        let (settings, measured) = (p.settings()?, u.measured());
        let trajectory = p.trajectory()?;
        let controller = Controller::new(
            &p.machine,
            &p.surrogate,
            trajectory,
            &settings,
            &measured,
            t,
        );
        let controller = controller.map_err(|error| p.refusal(error))?;
        let controller = controller.with_timing(p.timing()?);
        let mut fmu = Self {
            controller,
            reported: ReportedTroubles::default(),
            warning: None,
        };
        fmu.warning = fmu.stability_warning(p);
        Ok(fmu)
    }

    fn tune(&mut self, p: &Parameters) -> Result<(), ModelError> {
        p.machine.controller.check()?;
        self.warning = self.stability_warning(p);
        Ok(())
    }

    fn output(&self, _p: &Parameters, u: &Input, now: &Evaluation) -> Result<Output, ModelError> {
        Ok(now.output(&u.F))
    }

    fn step(
        &mut self,
        p: &Parameters,
        u: &InputPolynomial<Input>,
        now: &Evaluation,
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        // A sampled controller: it uses the measurements of the communication point.
        let settings = p.settings()?;
        let measured = u.value().measured();
        self.controller.step(now, &settings, &measured, t, h)?;
        let trouble = self
            .controller
            .trouble(now, &settings, &mut self.reported, t, h);
        self.warning = trouble.map(|trouble| trouble.to_string());
        Ok(StepEnd::WHOLE)
    }

    fn take_warning(&mut self) -> Option<String> {
        self.warning.take()
    }
}

fmu_export::export_fmu!(ControllerFmu);

#[cfg(test)]
mod tests {
    use super::*;

    /// Accessors, and dependencies against trying.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<ControllerFmu>(), [""; 0]);
    }
}
