//! The actuator forces of the paper, with the corrections, against inverse dynamics.

use crate::paper_angles::{lift_angles, tilt_angles};
use crate::seeded::{Random, plant};
use hdrm::{BODIES, Body, DOF, Hdrm, State};
use machine_file::Machine;
use nalgebra::Vector3;
use spatial::{Pose, Twist, Wrench};

/// The corrected actuator formulas of the paper against inverse dynamics: slew
/// [Eq:Base_Dynamics2], lift [Eq:Actuator_Lift_Dynamics] as printed, tilt
/// [Eq:Actuator_Tilt_Dynamics] replaced by the exact one with massive bars.
#[test]
fn actuator_force_formulas_equal_inverse_dynamics() {
    let (machine, hdrm) = plant();
    let mut random = Random(0x1357_9BDF_0246_8ACE);
    for _ in 0..300 {
        let state = random.state(&machine);
        let zeta_ddot: [f64; DOF] = random.array(2.0);
        let friction = machine.joint_viscous;
        let (f, _) = hdrm.inverse_dynamics(&state, &zeta_ddot, &[0.0; 6]);
        let strokes = hdrm.tree().configuration(&state.zeta).strokes;
        let printed = printed_forces(&machine, &hdrm, &state, &zeta_ddot);
        for i in 0..3 {
            // Friction is not in the paper's formulas.
            let f = f[i] - friction[i] * state.zeta_dot[i] / strokes[i].prime;
            let error = (printed[i] - f).abs() / f.abs().max(1e3);
            assert!(
                error < 1e-12,
                "f_{}: {} vs {f} at {state:?}",
                i + 1,
                printed[i]
            );
        }
    }
}

/// f_1, f_2, f_3 by the paper's wrench transmission with the corrections.
fn printed_forces(
    machine: &Machine,
    hdrm: &Hdrm,
    state: &State,
    zeta_ddot: &[f64; DOF],
) -> [f64; 3] {
    let g = &machine.geometry;
    let tree = hdrm.tree();
    let configuration = tree.configuration(&state.zeta);
    let X = |body: Body| configuration.link(body).pose;

    // Net wrenches F* of all bodies.
    let ground = (
        Twist::zero(),
        Twist::new(machine.gravity * Vector3::y(), Vector3::zeros()),
    );
    let mut motion = [ground; Body::COUNT];
    let mut F = [Wrench::zero(); Body::COUNT];
    for body in BODIES {
        let link = configuration.link(body);
        let (V_p, A_p) = body.parent().map_or(ground, |p| motion[p as usize]);
        let (w, a) = (
            state.zeta_dot[body.coordinate()],
            zeta_ddot[body.coordinate()],
        );
        let s = body.axis();
        let V = link.pose.twist_to_B(&V_p) + s * (link.gear * w);
        let A = link.pose.twist_to_B(&A_p)
            + s * (link.gear * a + link.gear_prime * w * w)
            + V.crm(&(s * (link.gear * w)));
        motion[body as usize] = (V, A);
        F[body as usize] = hdrm.inertias()[body as usize].net_wrench(&V, &A);
    }
    let net = |body: Body| F[body as usize];
    let up = |body: Body, F: Wrench| X(body).wrench_to_A(&F);

    // Wrist [Eq:Wrist_Dynamics]; A3U_B4·B4F is what A4 hands to A3.
    let F_D4 = net(Body::D4) + net(Body::PL);
    let F_C4 = net(Body::C4) + up(Body::D4, F_D4);
    let F_A4 = net(Body::A4) + up(Body::C4, F_C4);
    let wrist_on_A3 = up(Body::A4, F_A4);

    // Tilt, with rocker and coupler.
    let z = |F: Wrench| F.m.z;
    let tilt = tilt_angles(&tree.tilt, state.zeta[2]);
    let x_3_prime = configuration.strokes[2].prime;
    let lever_3 = tilt.c - g.lc_3;
    let chain = net(Body::A3) + wrist_on_A3 + up(Body::CP, net(Body::CP));
    let f_3 = net(Body::D3).f.x
        + (z(chain)
            + tilt.phi_c_prime * z(net(Body::CP))
            + tilt.phi_a_prime * z(net(Body::RK))
            + tilt.q1_prime * (z(net(Body::C3)) + z(net(Body::D3)) + net(Body::D3).f.y * lever_3))
            / x_3_prime;

    // [Eq:Wrist_to_Tilt_Dynamics] with the bars, about B with A2's axes, then lift as printed.
    let to_A2 = Pose::translation(X(Body::A3).r);
    let at_B = |F: Wrench| to_A2.inverse().wrench_to_A(&F);
    let on_C3 = net(Body::C3) + up(Body::D3, net(Body::D3));
    let F_Bc3 =
        at_B(up(Body::A3, chain)) + at_B(up(Body::C3, on_C3)) + at_B(up(Body::RK, net(Body::RK)));
    let lift = lift_angles(&tree.lift, state.zeta[1]);
    let on_A2 = net(Body::A2) + to_A2.wrench_to_A(&F_Bc3);
    let (sin, tan) = (lift.q2.sin(), lift.q2.tan());
    let lever_2 = lift.c - g.lc_2;
    let f_2 = net(Body::D2).f.x
        - z(on_A2) / (g.L1_2 * sin)
        - (z(net(Body::C2)) + z(net(Body::D2)) + net(Body::D2).f.y * lever_2) / (lift.c * tan);

    // [Eq:Tilt_to_Lift_Dynamics], [Eq:Base_Dynamics1], [Eq:Base_Dynamics2].
    let on_C2 = net(Body::C2) + up(Body::D2, net(Body::D2));
    let F_T1 = net(Body::T1) + up(Body::A2, on_A2) + up(Body::C2, on_C2);
    [F_T1.m.y / g.r_B, f_2, f_3]
}
