//! The quantities that bound a machine's gains.

use emla::maps;
use hdrm::{Hdrm, HdrmError, Options, State};
use machine_file::Machine;
use nalgebra::Matrix2;

/// Assumed stiffness of mounting and pins, N/m: that of the actuators as built.
const MOUNTING: f64 = 6e7;

/// The quantities that bound the gains of a machine, at its start pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lowest mode of the booms on compliant actuators with locked motors, rad/s.
    pub mode: f64,
    /// Root of the sum of the bodies' squared moments of gravity about the lift joint, N·m.
    pub moment: f64,
    /// Inertia about the lift joint, kg·m².
    pub inertia: f64,
    /// Bandwidth of the fastest motor's velocity for a `K_v` of 1 V·s/m, 1/s.
    pub motor: f64,
}

/// The bounds of a machine's gains, with actuators as built.
pub fn bounds(machine: &Machine) -> Result<Bounds, HdrmError> {
    bounds_on(machine, MOUNTING)
}

/// The bounds with this stiffness of mountings and pins, N/m.
pub(super) fn bounds_on(machine: &Machine, mounting: f64) -> Result<Bounds, HdrmError> {
    let plant = Hdrm::new(machine, &Options::from_machine(machine))?;
    let zeta = machine.start.zeta;
    let strokes = plant.tree().configuration(&zeta).strokes;
    let rest = State {
        zeta,
        ..State::default()
    };
    let (M, _) = plant.equations_of_motion(&rest);
    let booms: Matrix2<f64> = M.fixed_view::<2, 2>(1, 1).into();
    let springs = [1, 2].map(|k| {
        let inside = 1.0 / maps::stiffness(machine.emla.in_order()[k], strokes[k].x);
        strokes[k].prime.powi(2) / (inside + 1.0 / mounting)
    });
    // ω² of K q = ω² M q are the inverses of the eigenvalues of K^(−1/2) M K^(−1/2).
    let root = Matrix2::from_diagonal(&springs.map(|k| 1.0 / k.sqrt()).into());
    let slowest = (root * booms * root).symmetric_eigenvalues().max();
    let lift = |plant: &Hdrm| plant.holding(&zeta).0[1] * strokes[1].prime;
    let mut square = 0.0;
    for k in 0..machine.bodies.in_order().len() {
        let mut half = machine.clone();
        half.bodies.in_order_mut()[k].mass *= 0.5;
        let without = Hdrm::new(&half, &Options::from_machine(&half))?;
        square += (2.0 * (lift(&plant) - lift(&without))).powi(2);
    }
    let motors = machine.emla.in_order().map(|p| {
        let per_ampere = 1.5 * f64::from(p.p) * p.lambda_m;
        let load = maps::gear_factor(p, 1.0, 0.0);
        per_ampere / machine.controller.K_i * maps::travel_per_radian(p) / maps::inertia(p, load)
    });
    Ok(Bounds {
        mode: slowest.sqrt().recip(),
        moment: square.sqrt(),
        inertia: booms[(0, 0)],
        motor: motors.into_iter().fold(0.0, f64::max),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A load on one spring has ω² = k/M: with the tilt boom and all that it carries made light,
    /// the lower mode is that of the lift boom on its rod, to the part that the light boom weighs.
    #[test]
    fn the_mode_is_that_of_a_load_on_a_spring() {
        let mut machine = Machine::reference();
        for body in machine.bodies.in_order_mut().into_iter().skip(4) {
            body.mass *= 1e-5;
            let I = &mut body.inertia_com;
            for moment in [
                &mut I.xx, &mut I.yy, &mut I.zz, &mut I.xy, &mut I.xz, &mut I.yz,
            ] {
                *moment *= 1e-5;
            }
        }
        let bounds = bounds(&machine).expect("bounds");
        let plant = Hdrm::new(&machine, &Options::from_machine(&machine)).expect("a plant");
        let stroke = plant.tree().configuration(&machine.start.zeta).strokes[1];
        let screw = maps::stiffness(&machine.emla.lift, stroke.x);
        let spring = stroke.prime.powi(2) / (1.0 / screw + 1.0 / MOUNTING);
        let expected = (spring / bounds.inertia).sqrt();
        let found = bounds.mode / expected;
        assert!((found - 1.0).abs() < 1e-3, "{found}");
    }
}
