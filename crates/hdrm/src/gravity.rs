//! Gravity, also of a machine that does not stand plumb.
//!
//! The fast path of the dynamics ([`crate::boom_frame`]) knows gravity along −y, in the boom plane wherever it is turned. What lies across
//! comes from the general recursion, and costs only where there is some.

use crate::recursion;
use crate::{Body, DOF, Hdrm};
use nalgebra::{Vector3, Vector6};
use serde::{Deserialize, Serialize};

/// Acceleration of gravity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Gravity {
    /// Along −y, m/s².
    pub along_y: f64,
    /// Along x and z, m/s².
    across: [f64; 2],
}

impl Gravity {
    /// Of a vector in world axes, m/s².
    pub(crate) fn of([x, y, z]: [f64; 3]) -> Self {
        Self {
            along_y: -y,
            across: [x, z],
        }
    }

    /// What holds against the part across the y axis, m/s² in world axes, where there is one.
    pub(crate) fn sideways(&self) -> Option<Vector3<f64>> {
        let [x, z] = self.across;
        (self.across != [0.0; 2]).then(|| Vector3::new(-x, 0.0, -z))
    }
}

impl Hdrm {
    /// Generalised forces that hold the machine in the pose `zeta` against the part of gravity across the y axis, where there is one.
    pub(crate) fn holding_sideways(&self, zeta: &[f64; DOF]) -> Option<Vector6<f64>> {
        let up = self.gravity.sideways()?;
        let configuration = self.tree.configuration(zeta);
        let rest = [0.0; DOF];
        Some(recursion::holding_forces(&configuration, &self.bodies, &rest, up, 1.0).value)
    }

    /// Potential energy in the part of gravity across the y axis, J, zero at the world's origin.
    pub(crate) fn potential_sideways(&self, zeta: &[f64; DOF]) -> f64 {
        let Some(up) = self.gravity.sideways() else {
            return 0.0;
        };
        let poses = self.tree.configuration(zeta).world_poses();
        let energies = (0..Body::COUNT).map(|k| {
            let (body, pose) = (&self.bodies[k], &poses[k]);
            up.dot(&(pose.R * body.h + pose.r * body.m))
        });
        energies.sum()
    }
}

#[cfg(test)]
mod tests {
    use crate::{Hdrm, Input, Options, State};
    use machine::Machine;

    const G: [f64; 3] = [0.31, -9.7, -0.47];
    const ZETA: [f64; 6] = [0.31, 0.52, -1.13, 0.41, -0.62, 0.37];
    const ZETA_DOT: [f64; 6] = [0.11, -0.07, 0.13, 0.3, -0.2, 0.4];

    fn plant(gravity: [f64; 3]) -> Hdrm {
        let machine = Machine::reference();
        let options = Options {
            gravity,
            ..Options::of(&machine)
        };
        Hdrm::new(&machine, &options).expect("valid")
    }

    /// Holding forces are the gradient of the potential energy, slew included. Central difference over 2e-5 rad: its error is a sixth of
    /// the square times the third derivative, below 1e-5 N·m, and rounding of 3e4 J leaves 1e-6 of it.
    #[test]
    fn holding_is_the_gradient_of_the_potential() {
        let plant = plant(G);
        let potential = |k: usize, h: f64| {
            let mut zeta = ZETA;
            zeta[k] += h;
            plant.energies(&State::at_rest(zeta)).1
        };
        let holding = plant.dynamics(&State::at_rest(ZETA)).holding;
        for k in 0..6 {
            let h = 1e-5;
            let gradient = (potential(k, h) - potential(k, -h)) / (2.0 * h);
            let found = holding[k];
            assert!((found - gradient).abs() < 1e-4, "{k}: {found} {gradient}");
        }
        assert!(holding[0].abs() > 100.0, "gravity across turns the slew");
    }

    /// Gravity turned about y is a machine slewed with it: the same accelerations.
    #[test]
    fn turning_gravity_about_y_is_slewing_the_machine() {
        let angle = -0.7_f64;
        let (sin, cos) = angle.sin_cos();
        let turned = [cos * G[0] + sin * G[2], G[1], cos * G[2] - sin * G[0]];
        let mut slewed = ZETA;
        slewed[0] += angle;
        let input = Input {
            f: [900.0, 41e3, 31e3],
            ..Input::default()
        };
        let of = |plant: &Hdrm, zeta| {
            let zeta_dot = ZETA_DOT;
            plant.forward_dynamics(&State { zeta, zeta_dot }, &input)
        };
        let (a, b) = (of(&plant(G), ZETA), of(&plant(turned), slewed));
        for k in 0..6 {
            let bound = 1e-10 * (1.0 + a[k].abs());
            assert!((a[k] - b[k]).abs() < bound, "{k}: {} {}", a[k], b[k]);
        }
        let plumb = of(&plant([0.0, G[1], 0.0]), ZETA);
        assert!((a[0] - plumb[0]).abs() > 1e-3);
    }

    /// The fast path and the general recursion agree, and both with the exact time derivative of the outputs (difference over 1 µs).
    #[test]
    fn inverse_and_forward_dynamics_agree_off_plumb() {
        let plant = plant(G);
        let state = State {
            zeta: ZETA,
            zeta_dot: ZETA_DOT,
        };
        let wanted = [0.3, -0.2, 0.5, 0.1, 0.7, -0.4];
        let (f, tau_wrist) = plant.inverse_dynamics(&state, &wanted, &[0.0; 6]);
        let input = Input {
            f,
            tau_wrist,
            ..Input::default()
        };
        let found = plant.forward_dynamics(&state, &input);
        for k in 0..6 {
            assert!((found[k] - wanted[k]).abs() < 1e-9, "{k}: {}", found[k]);
        }
        let rate = plant.output_derivative(&state, &input, &Input::default());
        let h = 1e-6;
        let mut next = state;
        for k in 0..6 {
            next.zeta[k] += h * (ZETA_DOT[k] + 0.5 * h * found[k]);
            next.zeta_dot[k] += h * found[k];
        }
        let (before, after) = (plant.output(&state, &input), plant.output(&next, &input));
        let near = |slope: f64, rate: f64, scale: f64| {
            assert!(
                (slope - rate).abs() < 1e-4 * (scale + slope.abs()),
                "{slope} {rate}"
            );
        };
        for k in 0..3 {
            near(
                (after.f_hold[k] - before.f_hold[k]) / h,
                rate.f_hold[k],
                1e3,
            );
        }
        near(
            (after.zeta_ddot[0] - before.zeta_ddot[0]) / h,
            rate.zeta_ddot[0],
            10.0,
        );
        near(
            (after.energy_potential - before.energy_potential) / h,
            rate.energy_potential,
            1e3,
        );
    }
}
