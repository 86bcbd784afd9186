//! Scales a machine's booms, keeping shape and material (`hdrm-fmu machine scale`).
#![allow(non_snake_case)] // symbols of the machine file

use machine_file::{Body, Machine};

/// `nominal` with everything that belongs to its booms `s` times as large.
///
/// ```text
/// lengths, centres of mass, strokes    ∝ s        closed chains stay similar, so they stay closed
/// masses                               ∝ s³       the same material
/// inertias                             ∝ s⁵
/// edges of the trajectories, and the time for them ∝ s, so the tip's speed stays
/// ```
/// Scaled are both booms with their cylinders, rods, rocker and coupler, the length of the screws
/// of lift and tilt, and the mass that moves with them. Column and slew, wrist and tool, payload,
/// joint ranges, motors, ratings, friction and gains stay.
pub fn booms(nominal: &Machine, s: f64) -> Machine {
    let mut machine = nominal.clone();
    let g = &mut machine.geometry;
    let lengths = [
        &mut g.L1_2,
        &mut g.L2_2,
        &mut g.x0_2,
        &mut g.lc_2,
        &mut g.d4,
        &mut g.d5,
        &mut g.x0_3,
        &mut g.lc_3,
    ];
    let points = [
        &mut g.r_O_B[..],
        &mut g.A_in_boom,
        &mut g.E_in_boom,
        &mut g.C_in_tilt,
        &mut g.r_B_B4,
    ];
    let strokes = [&mut machine.limits.stroke_2, &mut machine.limits.stroke_3];
    let in_points = points.into_iter().flatten();
    for length in lengths
        .into_iter()
        .chain(in_points)
        .chain(strokes.into_iter().flatten())
    {
        *length *= s;
    }
    let b = &mut machine.bodies;
    for body in [
        &mut b.A2, &mut b.C2, &mut b.D2, &mut b.A3, &mut b.C3, &mut b.D3, &mut b.RK, &mut b.CP,
    ] {
        scale(body, s);
    }
    for emla in [&mut machine.emla.lift, &mut machine.emla.tilt] {
        emla.L_s *= s;
        emla.M_act *= s.powi(3);
    }
    let cubic = &mut machine.trajectories.cubic;
    cubic.edge *= s;
    cubic.edge_time *= s;
    let triangular = &mut machine.trajectories.triangular;
    triangular.edge_time *= s;
    for coordinate in triangular.vertices.as_flattened_mut() {
        *coordinate *= s;
    }
    machine
}

fn scale(body: &mut Body, s: f64) {
    body.mass *= s.powi(3);
    for com in &mut body.com {
        *com *= s;
    }
    let I = &mut body.inertia_com;
    for moment in [
        &mut I.xx, &mut I.yy, &mut I.zz, &mut I.xy, &mut I.xz, &mut I.yz,
    ] {
        *moment *= s.powi(5);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hdrm::{Hdrm, Options};

    /// Oracle: similarity. At the same joint angles the strokes of lift and tilt are `s` times as
    /// long; without wrist and payload so are all distances from the lift joint O, and the holding
    /// forces are `s³` times as large (moments of weight ∝ s⁴, levers ∝ s).
    #[test]
    fn forces_of_a_similar_machine_follow_the_cube() {
        let s = 1.3;
        let mut light = Machine::reference();
        let b = &mut light.bodies;
        for body in [&mut b.A4, &mut b.C4, &mut b.D4, &mut b.PL] {
            scale(body, 1e-4);
        }
        let large = booms(&light, s);
        large.check().expect("valid");
        let [plant, scaled] =
            [&light, &large].map(|m| Hdrm::new(m, &Options::from_machine(m)).expect("closed"));
        for (lift, tilt) in [(-0.05, -2.1), (0.3, -0.4), (0.7, -1.4), (1.1, -2.0)] {
            let zeta = [0.2, lift, tilt, 0.0, -0.9, 0.0];
            let strokes = [&plant, &scaled].map(|p| p.tree().configuration(&zeta).strokes);
            let [(f, _), (f_scaled, _)] = [&plant, &scaled].map(|p| p.holding(&zeta));
            for i in [1, 2] {
                let (x, x_scaled) = (strokes[0][i].x, strokes[1][i].x);
                assert!((x_scaled - s * x).abs() < 1e-12, "{x} {x_scaled}");
                let expected = s.powi(3) * f[i];
                assert!(
                    (f_scaled[i] / expected - 1.0).abs() < 1e-6,
                    "{expected} {}",
                    f_scaled[i]
                );
            }
        }
    }

    #[test]
    fn a_factor_of_one_changes_nothing() {
        for (name, _) in machine_file::PRESETS {
            let machine = Machine::preset(name).expect("shipped");
            assert_eq!(booms(&machine, 1.0), machine);
        }
    }
}
