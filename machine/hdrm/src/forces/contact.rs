//! Force law of the tip's contact with a plane, for `contact_force`: Hunt–Crossley normal force and
//! smoothed Coulomb friction, with its time derivative.

use crate::DOF;
use crate::dynamics::boom_frame::BoomFrame;
use crate::dynamics::factor::Factor;
use model_rules::{ParamError, Range, check, require};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// A plane that the tip may touch; stiffness 0: none.
///
/// With the depth `d = offset − n·p` of the tip below the plane and its velocity v, the force is
/// ```text
/// F_n = k·d·max(0, 1 + c·d_dot)        0 for d ≤ 0
/// F_t = −mu·F_n·v_t/√(|v_t|² + v_s²)
/// ```
/// It never pulls, is continuous and passive. Coulomb friction is smoothed below the slip velocity
/// v_s, so a sticking tip creeps. Valid for a point contact without rolling or spinning friction.
///
/// Source: K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440–445, with the exponent 1
/// that the end stops have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Direction out of the plane towards the machine, world axes; its length is ignored.
    pub normal: [f64; 3],
    /// Distance of the plane from the world's origin along the normal, m.
    pub offset: f64,
    /// Stiffness k, N/m; 0: no plane.
    pub stiffness: f64,
    /// Dissipation c, s/m: the tip rebounds with less than 1/c.
    pub damping: f64,
    /// Coefficient of friction mu.
    pub friction: f64,
    /// Slip velocity v_s, m/s, below which friction falls to zero.
    pub slip_velocity: f64,
}

impl Default for Contact {
    /// No plane; with a stiffness it is horizontal through the world's origin.
    fn default() -> Self {
        Self {
            normal: [0.0, 1.0, 0.0],
            offset: 0.0,
            stiffness: 0.0,
            damping: 1.0,
            friction: 0.0,
            slip_velocity: 0.01,
        }
    }
}

impl Contact {
    /// The plane, if there is one, from checked parameters.
    pub(crate) fn plane(&self) -> Result<Option<Plane>, ParamError> {
        check(
            Range::NotNegative,
            [
                ("contact.stiffness", self.stiffness),
                ("contact.damping", self.damping),
                ("contact.friction", self.friction),
            ],
        )?;
        check(Range::Finite, [("contact.offset", self.offset)])?;
        check(
            Range::Positive,
            [("contact.slip_velocity", self.slip_velocity)],
        )?;
        let length = Vector3::from(self.normal).norm();
        let rule = "a direction: its length finite and > 0";
        require("contact.normal", length, rule, length > 0.0)?;
        Ok((self.stiffness > 0.0).then(|| Plane {
            n: Vector3::from(self.normal) / length,
            contact: *self,
        }))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Plane {
    n: Vector3<f64>,
    contact: Contact,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ContactForce {
    /// Force on the tip in world axes, N.
    pub force: Vector3<f64>,
    /// Depth below the plane, m; 0 above it.
    pub depth: f64,
    /// Elastic energy `½·k·d²`, J.
    pub energy: f64,
    /// Dissipated power, W.
    pub dissipation: f64,
}

/// Terms that the force and its rate share.
pub(crate) struct Penetration {
    d: f64,
    pub d_dot: f64,
    /// `1 + c·d_dot`, not below 0.
    pressure: f64,
    v_t: Vector3<f64>,
    /// `√(|v_t|² + v_s²)`.
    slip: f64,
}

impl Plane {
    /// Distance of the tip at `p`, m, from the plane, negative below it.
    pub(crate) fn height(&self, p: &Vector3<f64>) -> f64 {
        self.n.dot(p) - self.contact.offset
    }

    pub(crate) fn penetration(&self, p: &Vector3<f64>, v: &Vector3<f64>) -> Option<Penetration> {
        let Self { n, contact } = self;
        let d = contact.offset - n.dot(p);
        if d <= 0.0 {
            return None;
        }
        let d_dot = -n.dot(v);
        let v_t = v + n * d_dot;
        let v_s = contact.slip_velocity;
        Some(Penetration {
            d,
            d_dot,
            pressure: (1.0 + contact.damping * d_dot).max(0.0),
            v_t,
            slip: (v_t.norm_squared() + v_s * v_s).sqrt(),
        })
    }

    /// The contact force on the tip at `p`, m, with the velocity `v`, m/s, in world axes.
    pub(crate) fn contact_force(&self, p: &Vector3<f64>, v: &Vector3<f64>) -> ContactForce {
        let Some(at) = self.penetration(p, v) else {
            return ContactForce::default();
        };
        let spring = self.contact.stiffness * at.d;
        let F_n = spring * at.pressure;
        let drag = self.contact.friction * F_n / at.slip;
        ContactForce {
            force: self.n * F_n - at.v_t * drag,
            depth: at.d,
            energy: 0.5 * spring * at.d,
            dissipation: (F_n - spring) * at.d_dot + drag * at.v_t.norm_squared(),
        }
    }

    /// Rate of the force for the tip's acceleration `a`, m/s².
    pub(crate) fn force_rate(
        &self,
        p: &Vector3<f64>,
        v: &Vector3<f64>,
        a: &Vector3<f64>,
    ) -> Vector3<f64> {
        let Some(at) = self.penetration(p, v).filter(|at| at.pressure > 0.0) else {
            return Vector3::zeros();
        };
        let (k, c) = (self.contact.stiffness, self.contact.damping);
        let (slip, v_t) = (at.slip, at.v_t);
        let d_ddot = -self.n.dot(a);
        let a_t = a + self.n * d_ddot;
        let F_n = k * at.d * at.pressure;
        let F_n_dot = k * (at.d_dot * at.pressure + at.d * c * d_ddot);
        let slip_dot = v_t.dot(&a_t) / slip;
        let drag_rate = v_t * F_n_dot + a_t * F_n - v_t * (F_n * slip_dot / slip);
        self.n * F_n_dot - drag_rate * (self.contact.friction / slip)
    }

    /// Fastest rate, 1/s, of the contact within the time `dt`, for the choice of substeps:
    /// `√(k·m_n) + k·m_n·c·d` along the normal as for an end stop, and friction as a damper at half
    /// the present slip; m_n and m_t are the tip's mobilities. 0 if the plane is out of reach.
    pub(crate) fn rate_ahead(
        &self,
        frame: &BoomFrame,
        factor: &Factor,
        zeta_dot: &[f64; DOF],
        dt: f64,
    ) -> f64 {
        let (p, V) = frame.tip_motion(zeta_dot);
        let c = &self.contact;
        let approach = (-self.n.dot(&V.v)).max(0.0);
        let ahead = c.offset - self.n.dot(&p) + approach * dt;
        if ahead <= 0.0 {
            return 0.0;
        }
        let mobility = |direction: &Vector3<f64>| {
            let Q = frame.world_force_at_tip(direction);
            Q.dot(&factor.solve(&Q))
        };
        let m_n = mobility(&self.n);
        let m_all: f64 = [Vector3::x(), Vector3::y(), Vector3::z()]
            .iter()
            .map(mobility)
            .sum();
        let half_slip = 0.5 * (V.v - self.n * self.n.dot(&V.v)).norm();
        let F_n = c.stiffness * ahead * (1.0 + c.damping * approach);
        let k = c.stiffness * m_n;
        k.sqrt()
            + k * c.damping * ahead
            + c.friction * F_n * (m_all - m_n)
                / (half_slip * half_slip + c.slip_velocity * c.slip_velocity).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_normal_without_direction_is_refused() {
        let contact = Contact {
            normal: [0.0; 3],
            ..Contact::default()
        };
        let Err(refused) = contact.plane() else {
            panic!("no error");
        };
        let text = refused.to_string();
        assert!(text.contains("contact.normal"), "{text}");
    }
}
