//! How fast the tip may be fed back with the loop of the drives damped, for [`super::ideal`].

use super::ruled_gain::two_digits;
use crate::drive_loop::{DriveLoop, Mode};
use crate::kinematics::{Kinematics, Pose};
use hdrm::HdrmError;
use machine_file::{Controller, Machine};
use nalgebra::Vector3;

/// Damping ratio that the loop of known actuators keeps at every pose of the two trajectories; the
/// reference machine's least is 12.8 %. With less, a fast feedback swings once the adaptation has to
/// find an inertia that is off by 20 %.
const DAMPING: f64 = 0.1;
/// Feedback on the tip up to which the damping ratio below is enough, 1/s: so slow, it does not swing
/// with an inertia that is off by 40 %.
const SLOW: f64 = 5.0;
pub(super) const SLOW_DAMPING: f64 = 0.05;
/// Least feedback on the tip, 1/s: with less, an error outlasts the motion.
pub(super) const LEAST_FEEDBACK: f64 = 1.0;
/// Halvings of the interval in which `Lambda_position` is searched.
const HALVINGS: u32 = 12;

/// The largest `Lambda_position` up to that of `gains` with which the loop is damped, and its least
/// damped mode.
pub(super) fn largest_feedback(
    machine: &Machine,
    gains: &Controller,
) -> Result<(f64, Mode), HdrmError> {
    let loops = loops(machine)?;
    let largest = damped_feedback(&loops, gains, DAMPING);
    if largest.0 >= SLOW {
        return Ok(largest);
    }
    let slow = Controller {
        Lambda_position: gains.Lambda_position.min(SLOW),
        ..*gains
    };
    Ok(damped_feedback(&loops, &slow, SLOW_DAMPING))
}

/// As [`largest_feedback`], with this damping ratio.
fn damped_feedback(loops: &[DriveLoop], gains: &Controller, damping: f64) -> (f64, Mode) {
    let mut largest = gains.Lambda_position;
    let mut least = None::<Mode>;
    for each in loops {
        let mode = |L: f64| {
            each.least_damped(&Controller {
                Lambda_position: L,
                ..*gains
            })
        };
        let mut now = mode(largest);
        if now.damping < damping {
            let (mut low, mut high) = (0.0, largest);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                match mode(middle).damping < damping {
                    true => high = middle,
                    false => low = middle,
                }
            }
            largest = two_digits(low);
            now = mode(largest);
        }
        if least.is_none_or(|least| now.damping < least.damping) {
            least = Some(now);
        }
    }
    (largest, least.expect("the start pose"))
}

/// The least damped mode of a machine's loop under its own gains, at every pose of
/// `ideal_gains`, and the largest inertia of a motor as its boom feels it, over the boom's.
pub fn least_damped(machine: &Machine) -> Result<(Mode, f64), HdrmError> {
    let loops = loops(machine)?;
    let modes = loops
        .iter()
        .map(|each| each.least_damped(&machine.controller));
    let least = modes.min_by(|a, b| a.damping.total_cmp(&b.damping));
    let heaviest = loops.iter().map(DriveLoop::heaviest_motor);
    Ok((least.expect("the start pose"), heaviest.fold(0.0, f64::max)))
}

/// The loops at the start pose and at the corners of both trajectories that can be reached.
fn loops(machine: &Machine) -> Result<Vec<DriveLoop>, HdrmError> {
    let kinematics = Kinematics::new(machine)?;
    let start = machine.start.zeta;
    let Pose {
        position,
        orientation,
    } = kinematics.pose(&start);
    let mut corners = machine.trajectories.cubic.world_vertices();
    corners.extend(&machine.trajectories.triangular.vertices);
    corners.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    corners.dedup();
    let poses = corners.into_iter().filter_map(|corner| {
        let position = position + Vector3::from(corner);
        let pose = Pose {
            position,
            orientation,
        };
        let zeta = kinematics.inverse(&pose, &start).ok()?;
        let ranges = machine.limits.zeta();
        let mut each = zeta.iter().zip(ranges);
        each.all(|(zeta, [min, max])| (min..=max).contains(zeta))
            .then_some(zeta)
    });
    let mut loops = Vec::new();
    for zeta in std::iter::once(start).chain(poses) {
        loops.extend(DriveLoop::new(machine, zeta)?);
    }
    Ok(loops)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gain_rule::tests::geared;
    use emla::maps;

    /// The loops that diverged in runs of the ideal world with the reference machine's gains and
    /// those that did not (N = 10 with K_f for its gear, N = 6 with 8 mm, N = 14, N = 10 with 10
    /// mm): the linear model tells them apart.
    #[test]
    fn the_linear_model_knows_which_runs_diverged() {
        for (N, rho, K_v, Lambda, is_stable) in [
            (10.0, 0.016, 1.0, 20.0, true),
            (12.0, 0.016, 0.5, 20.0, false),
            (14.0, 0.016, 1.0, 20.0, false),
            (14.0, 0.016, 1.0, 10.0, true),
            (6.0, 0.008, 0.5, 20.0, false),
            (10.0, 0.010, 1.0, 20.0, false),
            (10.0, 0.010, 1.0, 10.0, true),
            (14.0, 0.010, 1.0, 15.0, false),
        ] {
            let machine = geared(N, rho);
            let mut gains = machine.controller;
            let known = Machine::reference();
            let [new, old] = [&machine, &known].map(|m| maps::beta_1(&m.emla.lift, 0.0));
            gains.K_f *= old / new;
            let inertia = |m: &Machine| maps::inertia(&m.emla.lift, 1.0);
            gains.K_v *= K_v * inertia(&machine) / inertia(&known) * new / old;
            gains.Lambda_position = Lambda;
            let loops = loops(&machine).expect("loops");
            let least = loops.iter().map(|each| each.least_damped(&gains).damping);
            let least = least.fold(1.0, f64::min);
            assert_eq!(least > 0.0, is_stable, "{N} {rho} {K_v} {Lambda}: {least}");
        }
    }

    /// With less of kappa_KA at the rods a mode of the reference machine has another damping; the
    /// shares of wholes are the paper's law to the last bit.
    #[test]
    fn shares_of_the_feedback_count() {
        let mut machine = Machine::reference();
        let (whole, _) = least_damped(&machine).expect("a mode");
        machine.controller.kappa_share = [0.3; 3];
        let (part, _) = least_damped(&machine).expect("a mode");
        machine.controller.kappa_share = [1.0; 3];
        machine.controller.kappa_KA *= 0.3;
        let (less, _) = least_damped(&machine).expect("a mode");
        assert!((part.damping - whole.damping).abs() > 1e-3, "{part:?}");
        assert!((part.damping / less.damping - 1.0).abs() < 1e-9, "{less:?}");
    }
}
