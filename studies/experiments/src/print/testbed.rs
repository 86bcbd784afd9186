//! The one-axis experiment (`hdrm-fmu testbed`) as tables.

use crate::analyses::testbed::{Axis, AxisError, FORCE_TARGET, Load, LoadedAxis, POSITION_TARGET};

/// Root mean square and maximum.
fn error(e: &AxisError, scale: f64, digits: usize) -> String {
    format!("{:.digits$} ({:.digits$})", scale * e.rmse, scale * e.max)
}

/// The controllers that do not know the load beforehand.
pub fn unknown_load_text(axes: &[Axis]) -> String {
    let mut text = "load not known to the controller beforehand\n\
        trajectory  axis  controller            position, mm (max)  velocity, mm/s (max)\n"
        .to_owned();
    for a in axes {
        let [position, velocity] = [&a.position, &a.velocity].map(|e| error(e, 1e3, 4));
        text += &format!(
            "{:<12}{:<6}{:<18}{position:>22}{velocity:>22}\n",
            a.trajectory, a.axis, a.law.mode
        );
    }
    text + "RMSE and maximum over the motion; at the level of the actuators there are no inertias to adapt, so adaptive and modular are one\n"
}

/// The controller that knows the load, with the targets.
pub fn text(axes: &[Axis]) -> String {
    let mut text = "trajectory  axis      position, mm (max)  velocity, mm/s (max)        force, N (max)  peak, kN   % of peak\n"
        .to_owned();
    for a in axes {
        text += &format!(
            "{:<12}{:<6}{:>22}{:>22}{:>22}{:>10.1}{:>12.3}\n",
            a.trajectory,
            a.axis,
            error(&a.position, 1e3, 4),
            error(&a.velocity, 1e3, 3),
            error(&a.force, 1.0, 1),
            1e-3 * a.force.peak,
            100.0 * a.force.rmse / a.force.peak
        );
    }
    let met = |yes: bool| if yes { "met" } else { "NOT met" };
    text + &format!(
        "RMSE and maximum over the motion; targets: position {:.2} mm {}, force {:.0} % of peak {}\n",
        1e3 * POSITION_TARGET,
        met(axes.iter().all(Axis::meets_position_target)),
        100.0 * FORCE_TARGET,
        met(axes.iter().all(Axis::meets_force_target))
    )
}

/// Actuators as built under both kinds of load.
pub fn rigs_text(axes: &[LoadedAxis]) -> String {
    let mut text = "actuators as built, load not known to the controller beforehand\n\
        trajectory  axis  load      controller          position, mm (max)  velocity, mm/s (max)   load's force, N (max)  % of peak\n"
        .to_owned();
    for LoadedAxis { load, axis: a } in axes {
        let load = match load {
            Load::Emulator => "emulator",
            Load::Rig => "rig",
        };
        text += &format!(
            "{:<12}{:<6}{load:<10}{:<18}{:>20}{:>22}{:>24}{:>11.2}\n",
            a.trajectory,
            a.axis,
            a.law.mode,
            error(&a.position, 1e3, 3),
            error(&a.velocity, 1e3, 2),
            error(&a.force, 1.0, 0),
            100.0 * a.force.rmse / a.force.peak
        );
    }
    text
}
