//! The controller on the plants' own models, coupled at 1 ms.
//!
//! Not an oracle for the plants (they have their own); it shows what the control law does.

use crate::coupled::{Case, Loop, machine, measure};
use machine_file::{Machine, PerAxis};
use vdc::{Mode, Trajectory};

/// Tip RMSE over the first edge of the triangle, mm.
fn rmse(case: &Case) -> f64 {
    let mut machine = Loop::new(case);
    let (mut sum, mut count) = (0.0, 0.0);
    let (settle, end) = (1.0, 4.25);
    for k in 0..(end / case.h) as u32 {
        let t = f64::from(k) * case.h;
        let error = machine.step(case.schedule, t, case.h);
        if t >= settle {
            (sum, count) = (sum + error * error, count + 1.0);
        }
    }
    1e3 * (sum / count).sqrt()
}

/// Holding the start pose is what an independent prototype of the machine found:
/// f = [0, 41143, 32179] N, tau = [−90.2, 147.2, 0] N·m, i_q = [0, 15.34, 12.00] A.
#[test]
fn the_start_is_in_equilibrium() {
    let start = Loop::new(&Case::nominal());
    let (measured, _) = measure(&start.plant, &start.state, &start.actuators, &start.drives);
    let now = start.controller.evaluate(&start.settings, &measured);
    let y = now.expect("finite").output(&measured.F);
    let near = |found: [f64; 3], expected: [f64; 3], tolerance: f64| {
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() < tolerance,
                "{found} vs {expected}"
            );
        }
    };
    // Tolerances: the last digit given.
    near(y.f_required, [0.0, 41_143.0, 32_179.0], 1.0);
    near(y.tau_wrist, [-90.2, 147.2, 0.0], 0.06);
    near(y.i_q_required, [0.0, 15.34, 12.00], 0.006);
    near(measured.i_q, [0.0, 15.34, 12.00], 0.006);
    assert!(y.tip_error_norm < 1e-12);
}

#[test]
fn nominal_tracking_is_microns() {
    let error = rmse(&Case::nominal());
    println!("nominal {error:.4} mm");
    assert!(error < 0.02, "{error} mm");
}

#[test]
fn adaptation_beats_the_model_and_the_model_beats_damping() {
    for inertia_scale in [0.6, 1.4] {
        let [adaptive, modular, pd] = [Mode::Adaptive, Mode::Modular, Mode::Pd].map(|mode| {
            rmse(&Case {
                mode,
                inertia_scale,
                ..Case::nominal()
            })
        });
        println!("x{inertia_scale}: adaptive {adaptive:.4}, modular {modular:.4}, pd {pd:.4} mm");
        assert!(adaptive < 0.3, "{adaptive} mm so soon after the start");
        assert!(
            adaptive < 0.2 * modular && modular < pd,
            "{adaptive}, {modular}, {pd} mm"
        );
    }
}

/// What stands constant beside the reference, an integral removes; gravity compensation removes it
/// only as far as the machine is nominal.
#[test]
fn an_integral_takes_the_sag_of_the_rivals() {
    let run = |mode, integral| {
        rmse(&Case {
            mode,
            integral,
            inertia_scale: 1.4,
            ..Case::nominal()
        })
    };
    let [modular, pd_gravity, pd] = [Mode::Modular, Mode::PdGravity, Mode::Pd].map(|mode| {
        let [without, with] = [run(mode, false), run(mode, true)];
        println!("{mode:?} at inertia x 1.4: {without:.3} mm, with integral {with:.3} mm");
        assert!(with < 0.25 * without, "{mode:?}: {with} vs {without} mm");
        without
    });
    assert!(pd_gravity < 0.5 * pd, "{pd_gravity} vs {pd} mm");
    assert!(modular < 1.1 * pd_gravity, "{modular} vs {pd_gravity} mm");
}

/// What the integral part and the observer are for: motor parameters other than nominal.
#[test]
fn the_extensions_take_up_wrong_motor_parameters() {
    let machine = machine();
    let actuators = PerAxis::all(machine_file::Emla {
        lambda_m: 0.6 * machine.emla.lift.lambda_m,
        eta_gear: 0.6 * machine.emla.lift.eta_gear,
        ..machine.emla.lift
    });
    let extended = rmse(&Case {
        actuators,
        ..Case::nominal()
    });
    let paper = rmse(&Case {
        actuators,
        extensions: [0.0; 2],
        ..Case::nominal()
    });
    println!("lambda_m, eta_gear x0.6: extended {extended:.4}, paper's law {paper:.4} mm");
    assert!(extended < 0.5, "{extended} mm");
    assert!(paper > 4.0 * extended, "{paper} vs {extended} mm");
}

#[test]
fn hybrid_actuators_are_tracked_known_or_not() {
    for (alpha, limit) in [([0.2, 0.2], 0.15), ([0.9, 0.9], 0.15), ([0.2, 0.0], 0.3)] {
        let error = rmse(&Case {
            alpha,
            ..Case::nominal()
        });
        println!("alpha {alpha:?}: {error:.4} mm");
        assert!(error < limit, "alpha {alpha:?}: {error} mm");
    }
}

/// With the exchange of the standard, commands and forces act one step later than measured.
/// Controller and actuators that are told predict over that step. Forces held for 2 ms without
/// prediction destabilize the coupling itself (C_b < K_b·h/2).
#[test]
fn told_of_the_delay_the_machine_tracks_with_the_standard_exchange() {
    for trajectory in [Trajectory::Triangular, Trajectory::Cubic] {
        let of = |delay, h| {
            rmse(&Case {
                trajectory,
                ..Case::standard(delay, h)
            })
        };
        let [untold, told, told_2] = [of(0, 1e-3), of(1, 1e-3), of(1, 2e-3)];
        println!("{trajectory:?}: untold {untold:.4}, told {told:.4}, at 2 ms {told_2:.4} mm");
        assert!(untold > 10.0 * told, "{untold} and {told} mm");
        assert!(told < 0.005, "{told} mm");
        assert!(told_2 < 0.006, "{told_2} mm");
    }
}

/// A channel that delays the commands by another step is predicted over as well.
#[test]
fn two_steps_of_delay_are_predicted_over() {
    let told = rmse(&Case::standard(2, 1e-3));
    println!("two steps: {told:.4} mm");
    assert!(told < 0.02, "{told} mm");
}

/// What the controller does not know of the machine it predicts wrongly, but no worse than it
/// controls it.
#[test]
fn the_prediction_stands_another_inertia() {
    for inertia_scale in [0.6, 1.4] {
        let [staged, told] = [Case::nominal(), Case::standard(1, 1e-3)].map(|case| {
            rmse(&Case {
                inertia_scale,
                ..case
            })
        });
        println!("x{inertia_scale}: staged {staged:.4}, standard {told:.4} mm");
        assert!((told / staged - 1.0).abs() < 0.1, "{told} and {staged} mm");
    }
}

/// At rest, where friction locks the motors, the boom swings on the screw's spring; at 2 ms this is
/// what the force's staleness excites first. After the motion has ended the tip error dies away.
#[test]
fn the_machine_rests_at_twice_the_step_with_the_standard_exchange() {
    let case = Case::standard(1, 2e-3);
    let mut machine = Loop::new(&case);
    let mut worst = [0.0_f64; 2];
    for k in 0..8000 {
        let t = f64::from(k) * case.h;
        let error = 1e3 * machine.step(case.schedule, t, case.h);
        let last_second = usize::from(t >= 15.0);
        worst[last_second] = worst[last_second].max(error);
    }
    println!("largest error {:.4}, at rest {:.5} mm", worst[0], worst[1]);
    assert!(worst[0] < 0.02 && worst[1] < 1e-3, "{worst:?} mm");
}

/// The machine whose actuators are sized each for its axis, with the same gains, on both
/// trajectories (the cube's edges move the slew): tracked as the reference machine is, by a
/// controller that knows them. One that takes them for the reference machine's is worse, so the
/// plant does have others.
#[test]
fn actuators_sized_for_their_axes_are_tracked() {
    let emla = Machine::from_json(machine_file::SIZED_JSON)
        .expect("valid")
        .emla;
    for trajectory in [Trajectory::Triangular, Trajectory::Cubic] {
        let reference = Case {
            trajectory,
            ..Case::nominal()
        };
        let mistaken = Case {
            actuators: emla,
            trajectory,
            ..Case::nominal()
        };
        let sized = Case {
            actuators: emla,
            nominal: emla,
            trajectory,
            ..Case::nominal()
        };
        let [reference, mistaken, sized] = [reference, mistaken, sized].map(|case| rmse(&case));
        println!("{trajectory:?}: {reference}, {mistaken}, {sized} mm");
        assert!(sized < 1.5 * reference, "{sized} mm, {reference} mm");
        assert!(mistaken > 1.05 * sized, "{mistaken} mm, {sized} mm");
    }
}
