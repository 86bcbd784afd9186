//! The contact law applied to the manipulator, for `dynamics`, `output` and `step`: force on the
//! tip, its rate, the resulting joint forces, and the rate that substeps must resolve.

use crate::DOF;
use crate::forces::contact::ContactForce;
use crate::geometry::tip::Tip;
use crate::geometry::tree::Configuration;
use crate::plant::{Dynamics, Hdrm};
use nalgebra::{Vector3, Vector6};

impl Hdrm {
    /// Contact of the tip; zero without a plane.
    pub(crate) fn contact_force(&self, at: &Dynamics) -> ContactForce {
        let Some(plane) = &self.plane else {
            return ContactForce::default();
        };
        let (p, V) = at.frame.tip_motion(&at.state.zeta_dot);
        plane.contact_force(&p, &V.v)
    }

    /// [`Plane::rate_ahead`] at `start`, 0 without a plane.
    pub(crate) fn plane_rate(&self, start: &Dynamics, dt: f64) -> f64 {
        self.plane.as_ref().map_or(0.0, |plane| {
            plane.rate_ahead(&start.frame, &start.factor, &start.state.zeta_dot, dt)
        })
    }

    /// Rate of the depth, m/s; 0 above the plane.
    pub(crate) fn depth_rate(&self, at: &Dynamics) -> f64 {
        let (p, V) = at.frame.tip_motion(&at.state.zeta_dot);
        let penetration = (self.plane.as_ref()).and_then(|plane| plane.penetration(&p, &V.v));
        penetration.map_or(0.0, |penetration| penetration.d_dot)
    }

    /// Rates of the contact force, N/s, and of its generalised forces; None without contact.
    pub(crate) fn contact_rate(
        &self,
        at: &Dynamics,
        configuration: &Configuration,
        zeta_ddot: &[f64; DOF],
    ) -> Option<(Vector3<f64>, Vector6<f64>)> {
        let plane = self.plane.as_ref()?;
        let zeta_dot = &at.state.zeta_dot;
        let (p, V) = at.frame.tip_motion(zeta_dot);
        plane.penetration(&p, &V.v)?;
        let tip = Tip::new(&self.tree, configuration);
        let (J, J_dot) = (tip.jacobian(), tip.jacobian_dot(zeta_dot));
        let a = J * Vector6::from(*zeta_ddot) + J_dot * Vector6::from(*zeta_dot);
        let rate = plane.force_rate(&p, &V.v, &a.fixed_rows::<3>(0).into());
        let force = plane.contact_force(&p, &V.v).force;
        let joints = |J: &nalgebra::Matrix6<f64>, f: &Vector3<f64>| J.fixed_rows::<3>(0).tr_mul(f);
        Some((rate, joints(&J, &rate) + joints(&J_dot, &force)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Contact, Options, State};
    use machine_file::Machine;

    /// The doc's formula with the mobilities `J·M⁻¹·Jᵀ` of the tip by its Jacobian and a plain
    /// inverse. Tolerance: the condition of M, some 1e4.
    #[test]
    fn the_fastest_rate_is_that_of_the_deepest_contact_ahead() {
        let machine = Machine::reference();
        let normal = Vector3::new(0.2, 0.9, -0.4).normalize();
        let contact = Contact {
            normal: (normal * 3.0).into(),
            stiffness: 2e6,
            damping: 0.7,
            friction: 0.4,
            slip_velocity: 0.02,
            ..Contact::default()
        };
        let state = State {
            zeta: machine.start.zeta,
            zeta_dot: [0.1, -0.2, -0.15, 0.3, -0.2, 0.1],
            ..State::default()
        };
        let at = |offset: f64, dt: f64| {
            let options = Options {
                contact: Contact { offset, ..contact },
                ..Options::from_machine(&machine)
            };
            let plant = Hdrm::new(&machine, &options).expect("valid");
            plant.plane_rate(&plant.dynamics(&state), dt)
        };
        let plant = Hdrm::new(&machine, &Options::from_machine(&machine)).expect("valid");
        let tip = Tip::new(&plant.tree, &plant.tree.configuration(&state.zeta));
        let (M, _) = plant.equations_of_motion(&state);
        let J = tip.jacobian().fixed_rows::<3>(0).into_owned();
        let mobility = J * M.try_inverse().expect("regular") * J.transpose();
        let v = J * Vector6::from(state.zeta_dot);
        let (v_n, height) = (normal.dot(&v), normal.dot(&tip.position));
        let v_t = (v - normal * v_n).norm();
        let m_n = normal.dot(&(mobility * normal));
        assert!(v_n < -0.05 && v_t > 0.1, "{v_n} {v_t}");

        for (above, dt) in [(-0.02, 0.0), (-0.01, 0.1), (0.001, 0.1)] {
            let ahead = -above - v_n * dt;
            let push = 2e6 * ahead * (1.0 - 0.7 * v_n);
            let expected = (2e6 * m_n).sqrt()
                + 2e6 * m_n * 0.7 * ahead
                + 0.4 * push * (mobility.trace() - m_n) / (0.5 * v_t).hypot(0.02);
            let found = at(height - above, dt);
            assert!((found / expected - 1.0).abs() < 1e-11, "{found} {expected}");
        }
        assert_eq!(at(height - 0.001, 0.0), 0.0, "out of reach");
    }
}
