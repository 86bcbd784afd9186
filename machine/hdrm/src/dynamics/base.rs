//! Effects of a tilted or accelerating base, for `dynamics`, `output` and `sensitivity`: apparent
//! gravity, and the holding forces against it.
//!
//! The fast path of the dynamics ([`crate::dynamics::boom_frame`]) handles gravity along −y, in the
//! boom plane at any slew angle; the general recursion adds the components across y, if any.

use crate::DOF;
use crate::dynamics::gravity::{Gravity, felt_gravity};
use crate::dynamics::recursion;
use crate::geometry::body::Body;
use crate::geometry::tree::Configuration;
use crate::plant::input::Input;
use crate::plant::{Dynamics, Hdrm};
use nalgebra::{Vector3, Vector6};

impl Hdrm {
    /// The apparent gravity on the base. The effects of its rotation are in
    /// [`crate::dynamics::turning`].
    pub(crate) fn felt_gravity(&self, input: &Input) -> Gravity {
        if (input.base_acceleration, input.base_tilt) == ([0.0; 3], [0.0; 2]) {
            return self.gravity;
        }
        let g = (-self.gravity.up()).into();
        Gravity::from_vector(felt_gravity(g, input.base_tilt, input.base_acceleration))
    }

    /// Rate of the apparent gravity, m/s³, for the input rates `input_dot`; None if it is constant.
    pub(crate) fn felt_gravity_rate(
        &self,
        input: &Input,
        input_dot: &Input,
    ) -> Option<Vector3<f64>> {
        let (a_dot, [roll_dot, pitch_dot]) = (input_dot.base_acceleration, input_dot.base_tilt);
        if (a_dot, [roll_dot, pitch_dot]) == ([0.0; 3], [0.0; 2]) {
            return None;
        }
        let g = (-self.gravity.up()).into();
        let g = Vector3::from(felt_gravity(g, input.base_tilt, [0.0; 3]));
        // ġ = −w × g with the base's angular velocity w in its own axes: the roll turns about its x
        // axis before the pitch.
        let (s_p, c_p) = libm::sincos(input.base_tilt[1]);
        let w = Vector3::new(c_p * roll_dot, -s_p * roll_dot, pitch_dot);
        Some(g.cross(&w) - Vector3::from(a_dot))
    }

    /// Rate of the holding forces due to the rate `g_dot` of gravity.
    pub(crate) fn holding_rate(
        &self,
        at: &Dynamics,
        configuration: &Configuration,
        g_dot: Vector3<f64>,
    ) -> Vector6<f64> {
        let rate = Gravity::from_vector(g_dot.into());
        let mut holding = at.momentum_y * rate.along_y;
        if let Some(up) = rate.sideways() {
            let rest = [0.0; DOF];
            holding += recursion::holding_forces(configuration, &self.bodies, &rest, up, 1.0).value;
        }
        holding
    }

    /// Rate of the potential energy due to the rate `g_dot` of gravity, W.
    pub(crate) fn potential_rate(&self, configuration: &Configuration, g_dot: Vector3<f64>) -> f64 {
        self.potential(configuration, -g_dot)
    }

    /// Generalised forces that hold the machine in the pose `zeta` against the components of
    /// `gravity` across the y axis; None if these are zero.
    pub(crate) fn holding_sideways(
        &self,
        gravity: &Gravity,
        zeta: &[f64; DOF],
    ) -> Option<Vector6<f64>> {
        let up = gravity.sideways()?;
        let configuration = self.tree.configuration(zeta);
        let rest = [0.0; DOF];
        Some(recursion::holding_forces(&configuration, &self.bodies, &rest, up, 1.0).value)
    }

    /// Potential energy in the components of `gravity` across the y axis, J.
    pub(crate) fn potential_sideways(&self, gravity: &Gravity, zeta: &[f64; DOF]) -> f64 {
        match gravity.sideways() {
            Some(up) => self.potential(&self.tree.configuration(zeta), up),
            None => 0.0,
        }
    }

    /// Potential energy for the gravity vector −`up`, m/s², in J.
    fn potential(&self, configuration: &Configuration, up: Vector3<f64>) -> f64 {
        let poses = configuration.world_poses();
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
    use machine_file::Machine;

    const G: [f64; 3] = [0.31, -9.7, -0.47];
    const ZETA: [f64; 6] = [0.31, 0.52, -1.13, 0.41, -0.62, 0.37];
    const ZETA_DOT: [f64; 6] = [0.11, -0.07, 0.13, 0.3, -0.2, 0.4];

    fn plant(gravity: [f64; 3]) -> Hdrm {
        let machine = Machine::reference();
        let options = Options {
            gravity,
            ..Options::from_machine(&machine)
        };
        Hdrm::new(&machine, &options).expect("valid")
    }

    /// BrakeState forces are the gradient of the potential energy, slew included. Central difference
    /// over 2e-5 rad: its error is a sixth of the square times the third derivative, below 1e-5
    /// N·m, and rounding of 3e4 J leaves 1e-6 of it.
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
            plant.forward_dynamics(
                &State {
                    zeta,
                    zeta_dot,
                    ..State::default()
                },
                &input,
            )
        };
        let (a, b) = (of(&plant(G), ZETA), of(&plant(turned), slewed));
        for k in 0..6 {
            let bound = 1e-10 * (1.0 + a[k].abs());
            assert!((a[k] - b[k]).abs() < bound, "{k}: {} {}", a[k], b[k]);
        }
        let plumb = of(&plant([0.0, G[1], 0.0]), ZETA);
        assert!((a[0] - plumb[0]).abs() > 1e-3);
    }

    /// The fast path and the general recursion agree, and both with the exact time derivative of
    /// the outputs (difference over 1 µs).
    #[test]
    fn inverse_and_forward_dynamics_agree_off_plumb() {
        let plant = plant(G);
        let state = State {
            zeta: ZETA,
            zeta_dot: ZETA_DOT,
            ..State::default()
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

    /// A base tilted by a roll is a world in which gravity has the other parts; one that
    /// accelerates upwards makes everything heavier, and potential energy follows both.
    #[test]
    fn a_base_that_tilts_and_accelerates_is_felt_as_gravity() {
        let g = 9.7;
        let state = State {
            zeta: ZETA,
            zeta_dot: ZETA_DOT,
            ..State::default()
        };
        let (roll, pitch) = (0.23_f64, -0.31_f64);
        let input = Input {
            base_tilt: [roll, pitch],
            base_acceleration: [0.3, 0.8, -0.4],
            ..Input::default()
        };
        // Up in the base: rolled about x, then pitched about the new z.
        let up = [
            pitch.sin() * roll.cos(),
            pitch.cos() * roll.cos(),
            -roll.sin(),
        ];
        let felt = std::array::from_fn(|i| -g * up[i] - input.base_acceleration[i]);
        let (moving, fixed) = (plant([0.0, -g, 0.0]), plant(felt));
        let found = moving.output(&state, &input);
        let expected = fixed.output(&state, &Input::default());
        for k in 0..6 {
            let (a, b) = (found.zeta_ddot[k], expected.zeta_ddot[k]);
            assert!((a - b).abs() < 1e-11 * (1.0 + b.abs()), "{k}: {a} {b}");
        }
        let (a, b) = (found.energy_potential, expected.energy_potential);
        assert!((a / b - 1.0).abs() < 1e-13, "{a} {b}");
        assert!(found.f_hold[0].abs() > 100.0, "the tilt turns the slew");
    }
}
