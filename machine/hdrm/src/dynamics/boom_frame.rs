//! The fast path of `dynamics`: mass matrix and bias forces of the whole machine, assembled in one
//! frame P that rotates with the slew joint; contact and load changes map forces with it.
//!
//! P has T1's axes and origin, so it turns with `zeta_1` about y. Lift and tilt move their eight
//! bodies in a plane of P; only the wrist moves in space. With everything expressed in and about P,
//! twists of a chain and composite inertias and wrenches are sums, and most entries of a planar
//! body are zero (`planar_body`).
//!
//! Equations of motion: `M(zeta)·zeta_ddot + h(zeta, zeta_dot) = Q`, with gravity in h.

use crate::geometry::planar::turned;
use crate::geometry::planar_body::{
    PlanarInertia, PlanarJoint, PlanarMotion, PlanarTwist, PlanarWrench,
};
use crate::geometry::tree::LoopSolution;
use crate::{Body, DOF, Tree};
use nalgebra::{Matrix6, Vector2, Vector3, Vector6};
use serde::{Deserialize, Serialize};
use spatial::{Inertia, Pose, Twist, Wrench};

/// Inertias of all bodies about their own frames, in the order of [`Body`]; D4 with the payload.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct MovingParts([Inertia; Body::PL as usize]);

impl MovingParts {
    /// From all bodies by index.
    pub fn new(bodies: &[Inertia; Body::COUNT]) -> Self {
        let mut parts = std::array::from_fn(|k| bodies[k]);
        parts[Body::D4 as usize] += bodies[Body::PL as usize];
        Self(parts)
    }

    fn inertia(&self, body: Body) -> &Inertia {
        &self.0[body as usize]
    }
}

#[derive(Clone, Debug)]
struct PlanarBody {
    joint: PlanarJoint,
    inertia: PlanarInertia,
}

#[derive(Clone, Debug)]
struct WristBody {
    S: Twist,
    inertia: Inertia,
}

/// The machine at one pose, all quantities in and about P.
#[derive(Clone, Debug)]
pub(crate) struct BoomFrame {
    T1: PlanarInertia,
    A2: PlanarBody,
    C2: PlanarBody,
    D2: PlanarBody,
    A3: PlanarBody,
    C3: PlanarBody,
    D3: PlanarBody,
    RK: PlanarBody,
    CP: PlanarBody,
    /// A4, C4, D4.
    wrist: [WristBody; 3],
    /// Pose of T4.
    tip: Pose,
    /// P in the world.
    slew: Pose,
}

impl BoomFrame {
    /// Transforms joints and inertias to P.
    #[rustfmt::skip] // one body a line
    pub fn new(tree: &Tree, parts: &MovingParts, solved: &LoopSolution) -> Self {
        let LoopSolution { e, e_A2, lift, tilt } = solved;
        let e_boom = e[1];
        let in_P = |p| turned(p, e_boom);
        let e_A3 = in_P(e[2]);
        let (e_3, e_RK, e_CP) = (in_P(tilt.actuator.e), in_P(tilt.e_rocker), in_P(tilt.e_coupler));

        // Joint positions.
        let O = tree.r_T1_O;
        let foot = O + tree.lift.foot.push(0.0);
        let B = O + turned(tree.r_A2_B.xy(), *e_A2).push(tree.r_A2_B.z);
        let A = B + in_P(tree.tilt.A).push(0.0);
        let C = B + in_P(tilt.C).push(0.0);
        let E = B + in_P(tree.tilt.E).push(0.0);
        let rod_2 = foot + (lift.e * (lift.length - tree.lift.lc)).push(0.0);
        let rod_3 = E + (e_3 * (tilt.actuator.length - tree.tilt.lc)).push(0.0);

        let turn = |r: Vector3<f64>, d| PlanarJoint::new(PlanarTwist::turn(r.xy()), d);
        let slide = |e, d| PlanarJoint::new(PlanarTwist::slide(e), d);
        let body = |joint, body, e, r| PlanarBody { joint, inertia: PlanarInertia::placed(parts.inertia(body), e, r) };
        let [b1, b2, b3] = tilt.coupler_d;
        let (wrist, tip) = place_wrist(tree, parts, &Pose::turn_z(B, e_A3.x, e_A3.y), e);
        Self {
            T1: PlanarInertia::from(parts.inertia(Body::T1)),
            A2: body(PlanarJoint::turn(O.xy()), Body::A2, *e_A2, O),
            C2: body(turn(foot, lift.angle_d), Body::C2, lift.e, foot),
            D2: body(slide(lift.e, lift.length_d), Body::D2, lift.e, rod_2),
            A3: body(PlanarJoint::turn(B.xy()), Body::A3, e_A3, B),
            C3: body(turn(E, tilt.actuator.angle_d), Body::C3, e_3, E),
            D3: body(slide(e_3, tilt.actuator.length_d), Body::D3, e_3, rod_3),
            RK: body(turn(A, tilt.rocker_d), Body::RK, e_RK, A),
            CP: body(turn(C, [b1 - 1.0, b2, b3]), Body::CP, e_CP, C),
            wrist,
            tip,
            slew: Pose::turn_y(Vector3::zeros(), e[0].x, e[0].y),
        }
    }

    /// Mass matrix `M_ij = Σ_k J_kiᵀ I_k J_kj`, J_ki the twist of body k for `zeta_i_dot = 1`, and
    /// the machine's momentum along y for each, kg·m; times `g` the holding forces.
    pub fn mass_matrix(&self) -> (Matrix6<f64>, Vector6<f64>) {
        let mut M = Matrix6::zeros();
        let mut momentum_y = Vector6::zeros();
        let (S2, S3) = (self.A2.joint.S, self.A3.joint.S);

        // Wrist: a column is the momentum of all that joint i carries, M_ij = S_jᵀ Ic_i S_i.
        let mut carried = Inertia::default();
        for i in (0..3).rev() {
            carried += self.wrist[i].inertia;
            let P = carried.apply(&self.wrist[i].S);
            for j in 0..=i {
                M[(3 + i, 3 + j)] = self.wrist[j].S.power(&P);
            }
            let P = PlanarWrench::from(P);
            momentum_y[3 + i] = P.f.y;
            M[(3 + i, 2)] = S3.power(P);
            M[(3 + i, 1)] = S2.power(P);
            M[(3 + i, 0)] = P.m_y;
        }

        // Tilt: the bodies that zeta_3 moves, each with its own J.
        let boom_3 = self.A3.inertia + PlanarInertia::from(&carried);
        let J_C3 = self.C3.joint.S;
        let tilt = [
            (S3, boom_3),
            (S3 + self.CP.joint.S, self.CP.inertia),
            (J_C3, self.C3.inertia),
            (J_C3 + self.D3.joint.S, self.D3.inertia),
            (self.RK.joint.S, self.RK.inertia),
        ];
        let (P3, M_33) = momentum(&tilt);
        M[(2, 2)] = M_33;
        M[(2, 1)] = S2.power(P3);
        M[(2, 0)] = P3.m_y;
        momentum_y[2] = P3.f.y;

        // Lift: zeta_2 moves the boom with all of the tilt as one body.
        let boom_2 = tilt
            .iter()
            .fold(self.A2.inertia, |sum, (_, inertia)| sum + *inertia);
        let J_C2 = self.C2.joint.S;
        let lift = [
            (S2, boom_2),
            (J_C2, self.C2.inertia),
            (J_C2 + self.D2.joint.S, self.D2.inertia),
        ];
        let (P2, M_22) = momentum(&lift);
        M[(1, 1)] = M_22;
        M[(1, 0)] = P2.m_y;
        momentum_y[1] = P2.f.y;

        M[(0, 0)] = lift
            .iter()
            .fold(self.T1.yy, |sum, (_, inertia)| sum + inertia.yy);
        M.fill_upper_triangle_with_lower_triangle();
        (M, momentum_y)
    }

    /// Bias forces `h`, those for `zeta_ddot = 0`, with gravity `g`, m/s², along −y.
    pub fn bias(&self, zeta_dot: &[f64; DOF], g: f64) -> Vector6<f64> {
        let [w_1, w_2, w_3, ..] = *zeta_dot;
        let rest = PlanarMotion::default();
        let A2 = self.A2.joint.child(&rest, w_2);
        let C2 = self.C2.joint.child(&rest, w_2);
        let D2 = self.D2.joint.child(&C2, w_2);
        let A3 = self.A3.joint.child(&A2, w_3);
        let C3 = self.C3.joint.child(&A2, w_3);
        let D3 = self.D3.joint.child(&C3, w_3);
        let RK = self.RK.joint.child(&A2, w_3);
        let CP = self.CP.joint.child(&A3, w_3);

        let F_wrist = self.wrist_bias(&A3, zeta_dot, g);
        let F = |body: &PlanarBody, motion| body.inertia.net_wrench(motion, w_1, g);
        // Wrenches accumulated from the subtree.
        let F_CP = F(&self.CP, &CP);
        let F_A3 = F(&self.A3, &A3) + F_CP + PlanarWrench::from(F_wrist[0]);
        let F_D3 = F(&self.D3, &D3);
        let F_C3 = F(&self.C3, &C3) + F_D3;
        let F_RK = F(&self.RK, &RK);
        let F_A2 = F(&self.A2, &A2) + F_A3 + F_C3 + F_RK;
        let F_D2 = F(&self.D2, &D2);
        let F_C2 = F(&self.C2, &C2) + F_D2;

        let Q = |body: &PlanarBody, F| body.joint.S.power(F);
        let h_3 = Q(&self.A3, F_A3)
            + Q(&self.CP, F_CP)
            + Q(&self.C3, F_C3)
            + Q(&self.D3, F_D3)
            + Q(&self.RK, F_RK);
        let h_2 = Q(&self.A2, F_A2) + Q(&self.C2, F_C2) + Q(&self.D2, F_D2);
        let h_1 = F_A2.m_y + F_C2.m_y;
        let [h_4, h_5, h_6] = std::array::from_fn(|i| self.wrist[i].S.power(&F_wrist[i]));
        Vector6::new(h_1, h_2, h_3, h_4, h_5, h_6)
    }

    /// Wrenches through the three wrist joints.
    fn wrist_bias(&self, A3: &PlanarMotion, zeta_dot: &[f64; DOF], g: f64) -> [Wrench; 3] {
        let (mut V, mut A) = A3.spatial(zeta_dot[0], g);
        let mut F = [Wrench::zero(); 3];
        for (i, WristBody { S, inertia }) in self.wrist.iter().enumerate() {
            let relative = *S * zeta_dot[3 + i];
            V += relative;
            A += V.crm(&relative);
            F[i] = inertia.net_wrench(&V, &A);
        }
        F[1] += F[2];
        F[0] += F[1];
        F
    }

    /// `J_T4ᵀ W`: generalised forces of a wrench on the end-effector, at T4 in T4 axes.
    pub fn tip_forces(&self, W: &Wrench) -> Vector6<f64> {
        let F = self.tip.wrench_to_A(W);
        let plane = PlanarWrench::from(F);
        let [Q_4, Q_5, Q_6] = std::array::from_fn(|i| self.wrist[i].S.power(&F));
        let Q_2 = self.A2.joint.S.power(plane);
        let Q_3 = self.A3.joint.S.power(plane);
        Vector6::new(plane.m_y, Q_2, Q_3, Q_4, Q_5, Q_6)
    }

    /// `J_T4ᵀ f` of a force f at T4 in world axes.
    pub fn world_force_at_tip(&self, f: &Vector3<f64>) -> Vector6<f64> {
        self.tip_forces(&Wrench::new(self.world_to_tip(f), Vector3::zeros()))
    }

    /// Transforms a vector from world axes to those of T4 and D4.
    pub fn world_to_tip(&self, v: &Vector3<f64>) -> Vector3<f64> {
        self.tip.R.tr_mul(&self.slew.R.tr_mul(v))
    }

    /// Position of T4, m, and its velocity and angular velocity, all in world axes.
    pub fn tip_motion(&self, zeta_dot: &[f64; DOF]) -> (Vector3<f64>, Twist) {
        let plane = self.A2.joint.S * zeta_dot[1] + self.A3.joint.S * zeta_dot[2];
        let mut V = Twist::new(plane.v.push(0.0), Vector3::new(0.0, zeta_dot[0], plane.w));
        for (body, rate) in self.wrist.iter().zip(&zeta_dot[3..]) {
            V += body.S * *rate;
        }
        let (R, r) = (&self.slew.R, self.tip.r);
        let velocity = Twist::new(R * (V.v + V.w.cross(&r)), R * V.w);
        (R * r, velocity)
    }

    /// First moment of mass along y, kg·m; `g` times it is the potential energy.
    pub fn first_moment_y(&self) -> f64 {
        let plane = [
            &self.A2, &self.C2, &self.D2, &self.A3, &self.C3, &self.D3, &self.RK, &self.CP,
        ];
        let wrist: f64 = self.wrist.iter().map(|body| body.inertia.h.y).sum();
        plane
            .iter()
            .fold(self.T1.h.y + wrist, |sum, body| sum + body.inertia.h.y)
    }
}

/// Momentum `Σ I_k J_k` and `Σ J_kᵀ I_k J_k` of bodies with unit twists J_k.
fn momentum(bodies: &[(PlanarTwist, PlanarInertia)]) -> (PlanarWrench, f64) {
    let mut sum = PlanarWrench::default();
    let mut energy = 0.0;
    for (J, inertia) in bodies {
        let P = inertia.apply(*J);
        energy += J.power(P);
        sum = sum + P;
    }
    (sum, energy)
}

fn place_wrist(
    tree: &Tree,
    parts: &MovingParts,
    X_A3: &Pose,
    e: &[Vector2<f64>; DOF],
) -> ([WristBody; 3], Pose) {
    let X_A4 = *X_A3 * Pose::turn_x(tree.r_A3_A4, e[3].x, e[3].y);
    let X_C4 = X_A4 * Pose::turn_z(tree.r_A4_C4, e[4].x, e[4].y);
    let X_D4 = X_C4 * Pose::turn_x(tree.r_C4_D4, e[5].x, e[5].y);
    let placed = |X: &Pose, body: Body| WristBody {
        S: X.twist_to_A(&body.axis()),
        inertia: X.inertia_to_A(parts.inertia(body)),
    };
    let wrist = [
        placed(&X_A4, Body::A4),
        placed(&X_C4, Body::C4),
        placed(&X_D4, Body::D4),
    ];
    (wrist, X_D4 * Pose::translation(tree.r_D4_T4))
}
