//! How far the reference under commanded rates may go, by what the machine and the law let it: ahead
//! of joints that something stops, and to where the rods can hold the machine at rest.

use crate::bodies::Bodies;
use crate::law::decomposition::{ground, holding_forces, whole_inertia};
use crate::nominal::Nominal;
use crate::reference::{ReferenceBounds, Room};
use crate::signals::Input;
use emla::maps;
use hdrm::{Configuration, DOF};
use machine_file::Controller as Gains;

/// Share of a rated force or torque with which the law's feedback may push against what stops the
/// machine. Laws without a model need most of a half to hold its weight.
const PUSH: f64 = 0.8;
/// Largest force at rest over the rated one; the rest is for moving, and for errors of the masses.
const HELD: f64 = 0.95;
/// Share of the rated force below which a joint that moves as fast as it may has room.
const NEAR: f64 = 0.6;
/// Turn of a joint for the slope of the forces, rad.
const TURN: f64 = 1e-4;
/// Slope of a rod's force over its rated force that counts, 1/rad: a slew or a wrist joint that
/// carries nothing does not load the rods.
const SLOPE: f64 = 0.03;

/// Bounds for a reference at the angles `zeta`, rad, whose joints turn at `largest` rates, rad/s.
pub(crate) fn reference_bounds(
    nominal: &Nominal,
    bodies: &Bodies,
    gains: &Gains,
    input: &Input,
    zeta: &[f64; DOF],
    largest: &[f64; DOF],
) -> ReferenceBounds {
    let configuration = nominal.tree.configuration(zeta);
    ReferenceBounds {
        ahead: farthest_ahead(nominal, bodies, gains, &configuration, largest),
        room: room_to_hold(nominal, bodies, input, zeta, &configuration),
    }
}

/// Largest angles by which the reference may be ahead of the joints, rad. There the feedback pushes
/// a joint that stands by a share of what its drive may, or asks for its largest rate:
/// ```text
/// (κ M/x' + K_v/K_f x') Λ e = 0.8 f_max,   κ M Λ e = 0.8 τ_max   or   Λ e = ω_max
/// ```
fn farthest_ahead(
    nominal: &Nominal,
    bodies: &Bodies,
    gains: &Gains,
    configuration: &Configuration,
    largest: &[f64; DOF],
) -> [f64; DOF] {
    std::array::from_fn(|i| {
        let damping = gains.kappa_KA * whole_inertia(configuration, &bodies.nominal, i);
        let (Lambda, damping, most) = if i < 3 {
            let lever = configuration.strokes[i].prime.abs();
            let per_ampere = maps::beta_1(nominal.parameters()[i], 0.0);
            let motor = gains.K_v / gains.K_i * per_ampere;
            let damping = damping + motor * lever * lever;
            (
                gains.Lambda_position,
                damping,
                lever * nominal.ratings[i][0],
            )
        } else {
            let most = nominal.tau_wrist_max[i - 3];
            (gains.Lambda_orientation, damping, most)
        };
        (PUSH * most / damping).min(largest[i]) / Lambda
    })
}

/// Room of the joints, by the masses that the law believes:
/// ```text
/// (0.95 f_max − |f|)/|∂|f|/∂ζ_j|   in the direction in which |f| grows,   f = Q/x'
/// ```
fn room_to_hold(
    nominal: &Nominal,
    bodies: &Bodies,
    input: &Input,
    zeta: &[f64; DOF],
    configuration: &Configuration,
) -> Room {
    let ground = ground(nominal.gravity, input);
    let loads = |configuration: &Configuration| -> [f64; 3] {
        let Q = holding_forces(configuration, &bodies.estimates, &ground);
        let force = |i: usize| (Q[i] / configuration.strokes[i].prime).abs();
        std::array::from_fn(|i| force(i) / nominal.ratings[i][0])
    };
    let mut room = Room::default();
    let now = loads(configuration);
    if now.iter().all(|load| *load < NEAR) {
        return room;
    }
    for j in 0..DOF {
        let mut turned = *zeta;
        turned[j] += TURN;
        let after = loads(&nominal.tree.configuration(&turned));
        for (i, load) in after.into_iter().enumerate() {
            let slope = (load - now[i]) / TURN;
            let left = (HELD - now[i]).max(0.0) / slope.abs();
            let side = &mut room.0[j][usize::from(slope > 0.0)];
            if slope.abs() > SLOPE && left < side.0 {
                *side = (left, i);
            }
        }
    }
    room
}
