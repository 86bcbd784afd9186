//! One run of the testbed, for `study`: the actuator level of the controller tracks the rods'
//! recorded motion, and load emulators or loading rigs replay the recorded forces.
#![allow(non_snake_case)] // the paper's symbols

use anyhow::Result;
use cosim::master::Stepping;
use cosim::{Master, Setting, Signals, System};

use super::axis::{AXES, CONTROLLER, Course, Load, TestedLaw, inputs, ports};
use super::load_rig::{self, LoadRigs};
use super::profile::Profile;

/// Communication step of two rigs against each other, s: the rod between them weighs 24 kg and
/// hangs between two stiff springs.
const STEP: f64 = 1e-4;

/// The testbed, set up for a run.
pub(super) struct Bed<'a> {
    pub system: &'a System,
    pub settings: &'a [Setting],
    /// Communication steps of the recorded run.
    pub stepping: Stepping,
    /// Whether its actuators are rigs, with loading rigs opposite to them.
    pub is_as_built: bool,
    pub load: Load,
    /// Time constant of the loads, s.
    pub lag: f64,
    pub law: TestedLaw,
}

impl Bed<'_> {
    /// Share of the load's force that is previewed to the controller.
    fn preview(&self) -> f64 {
        f64::from(self.law.previewed)
    }

    /// Start values: the rods where the recording starts, in equilibrium with its forces.
    fn start(&self, profiles: &[Profile; 2]) -> Result<Vec<Setting>> {
        let mut settings = self.settings.to_vec();
        for ((_, rod, actuator), p) in AXES.into_iter().zip(profiles) {
            for (variable, value) in [
                (format!("{actuator}.x"), p.x[0]),
                (format!("{actuator}.x_dot"), p.x_dot[0]),
                (format!("{actuator}.F_hold"), p.F[0]),
                (format!("{actuator}.F_ext"), p.F[0]),
                (reference("position", rod), p.x[0]),
                (reference("velocity", rod), p.x_dot[0]),
                (reference("force", rod), self.preview() * p.F[0]),
            ] {
                settings.push(self.system.setting(&variable, value)?);
            }
        }
        if self.is_as_built {
            settings.extend(load_rig::start(self.system, profiles)?);
        }
        let mode = format!("{CONTROLLER}.mode");
        settings.push(self.system.setting(&mode, self.law.mode)?);
        Ok(settings)
    }

    /// Makes the run; courses of both axes at the recorded points.
    pub(super) fn replay(&self, profiles: &[Profile; 2]) -> Result<[Course; 2]> {
        let (system, preview) = (self.system, self.preview());
        // Communication steps from one recorded point to the next.
        let parts = match self.load {
            Load::Emulator => 1,
            Load::Rig => (self.stepping.step / STEP).ceil() as usize,
        };
        let points = profiles[0].x.len();
        let h = self.stepping.step / parts as f64;
        let stepping = Stepping {
            step: h,
            ..self.stepping
        };
        let quantities = ["position", "velocity", "acceleration", "force"];
        let names = AXES.map(|(_, rod, _)| quantities.map(|q| reference(q, rod)));
        let mut references = inputs(system, names.as_flattened())?;
        let mut forces = inputs(system, &AXES.map(|(_, _, a)| format!("{a}.F_ext")))?;
        let outputs = AXES.map(|(_, _, a)| ["x_rod", "x_rod_dot", "F"].map(|v| format!("{a}.{v}")));
        let mut rods = Signals::new(system, &ports(system, outputs.as_flattened())?)?;
        let rigs = (self.load == Load::Rig).then(|| LoadRigs::new(system, self.lag));
        let mut rigs = rigs.transpose()?;
        let mut master = Master::new(system, &self.start(profiles)?, stepping)?;
        let mut emulated = profiles.each_ref().map(|p| p.F[0]);
        let mut courses = [Course::default(), Course::default()];
        for k in 0..points {
            let next = (k + 1).min(points - 1);
            for part in 0..parts {
                let share = part as f64 / parts as f64;
                let wanted = profiles.each_ref().map(|p| p.between(k, share));
                let mut rod = [[0.0; 3]; 2];
                rod.as_flattened_mut().copy_from_slice(rods.read(&master)?);
                if part == 0 {
                    let pairs = courses.iter_mut().zip(wanted).zip(rod);
                    for ((course, [x, x_dot, _, F]), actual) in pairs {
                        course.add(master.time(), [x, x_dot, F], &actual);
                    }
                }
                let known = wanted.map(|[x, x_dot, x_ddot, F]| [x, x_dot, x_ddot, preview * F]);
                references.set(&master, known.as_flattened())?;
                let force = match &mut rigs {
                    Some(rigs) => rigs.press(&master, rod, wanted, h)?,
                    None => [0, 1].map(|i| {
                        let F = &profiles[i].F;
                        emulate(&mut emulated[i], F[k], F[next], h, self.lag)
                    }),
                };
                forces.set(&master, &force)?;
                master.pass()?;
                if k == next {
                    break;
                }
                master.step()?;
            }
        }
        master.terminate()?;
        Ok(courses)
    }
}

/// Name of the controller's input for a quantity of a rod.
fn reference(quantity: &str, rod: usize) -> String {
    format!("{CONTROLLER}.reference.rod_{quantity}[{rod}]")
}

/// Advances a load emulator, `lag·F' = F_profile − F`, exactly for a profile held at its mean over
/// the step, and returns the mean force over the step.
fn emulate(force: &mut f64, from: f64, to: f64, step: f64, lag: f64) -> f64 {
    let before = *force;
    let reached = if lag > 0.0 {
        -(-step / lag).exp_m1()
    } else {
        1.0
    };
    *force += reached * (0.5 * (from + to) - before);
    0.5 * (before + *force)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step of the profile: after k steps of h the force is 1 − e^(−k h/lag), closed form.
    #[test]
    fn the_emulator_is_a_first_order_lag() {
        let (mut force, h, lag) = (0.0, 1e-3, 0.02);
        for k in 1..=50 {
            let before = force;
            let mean = emulate(&mut force, 1.0, 1.0, h, lag);
            let exact = -(-f64::from(k) * h / lag).exp_m1();
            assert!((force - exact).abs() < 50.0 * f64::EPSILON, "{k}: {force}");
            assert!((mean - 0.5 * (before + force)).abs() < f64::EPSILON);
        }
        let mut ideal = 3.0;
        emulate(&mut ideal, 4.0, 6.0, h, 0.0);
        assert_eq!(ideal, 5.0);
    }
}
