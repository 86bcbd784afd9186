//! Any voltage and motion inside the FMU's bounds leaves the actuator finite; what cannot be
//! computed is refused.
use emla::{Drive, Emla, Input, StepError};
use machine_file::Machine;

use crate::random::Random;

const H: f64 = 1e-3;

fn reference(drive: Drive) -> Emla {
    Emla::new(Machine::reference().emla.lift, drive).expect("reference")
}

/// Runs `ms` milliseconds of inputs drawn anew from ±`bounds` every `hold` milliseconds. In between
/// the rod moves with its velocity; with a bound of zero on `x` it never jumps, and stays in the
/// stroke.
fn random_run(drive: Drive, bounds: Input, ms: u32, hold: u32) {
    let emla = reference(drive);
    let (mut random, mut u) = (Random::new(11), Input::default());
    let mut s = emla.start(&u).expect("finite");
    for k in 0..ms {
        if k % hold == 0 {
            let mut draw = |bound: f64| random.within(-bound, bound);
            u = Input {
                v_d: draw(bounds.v_d),
                v_q: draw(bounds.v_q),
                x: if bounds.x > 0.0 { draw(bounds.x) } else { u.x },
                x_dot: draw(bounds.x_dot),
                F_ext: draw(bounds.F_ext),
                F_hold: draw(bounds.F_hold),
                ..Input::default()
            };
        }
        let t = f64::from(k) * H;
        s = emla.step(&s, |t| u.moved(t), t, H).expect("finite");
        u.x += H * u.x_dot;
        if bounds.x == 0.0 {
            u.x = u.x.clamp(0.0, emla.params().L_s);
        }
        let y = emla.output(&s, &u);
        assert!(y.F.is_finite() && y.P_loss.is_finite(), "{k} ms: {y:?}");
        assert!(
            emla.output_dot(&s, &u, &Input::default()).F.is_finite(),
            "{k} ms"
        );
    }
}

/// 60 s of any voltage, with motion over the whole stroke at up to 14 times the rated speed, whose
/// jumps meet the stroke's ends at full speed.
#[test]
fn a_minute_of_random_voltage_and_motion_stays_finite() {
    let bounds = Input {
        v_d: 1e4,
        v_q: 1e4,
        x: 0.0,
        x_dot: 1.0,
        F_ext: 1e5,
        ..Input::default()
    };
    random_run(Drive::Motion, bounds, 60_000, 7);
    random_run(Drive::Force, bounds, 60_000, 7);
}

/// The FMU's outermost bounds: metres of stretch in the spring, thousands of substeps a
/// millisecond.
#[test]
fn the_outermost_bounds_stay_finite() {
    let bounds = Input {
        v_d: 1e4,
        v_q: 1e4,
        x: 10.0,
        x_dot: 100.0,
        F_ext: 1e7,
        F_hold: 1e7,
        ..Input::default()
    };
    random_run(Drive::Motion, bounds, 200, 1);
    random_run(Drive::Motion, bounds, 200, 25);
    random_run(Drive::Force, bounds, 200, 25);
}

#[test]
fn unusable_steps_and_inputs_are_refused() {
    let emla = reference(Drive::Motion);
    let u = Input::default();
    let s = emla.start(&u).expect("finite");
    for h in [0.0, -1e-3, f64::NAN, f64::INFINITY, 1e9] {
        let refused = emla.step(&s, |t| u.moved(t), 2.5, h);
        assert!(
            matches!(refused, Err(StepError::BadStep { .. })),
            "{h}: {refused:?}"
        );
    }
    let u = Input { x: f64::NAN, ..u };
    let refused = emla.step(&s, |t| u.moved(t), 2.5, H).expect_err("NaN");
    assert!(refused.to_string().contains("t = 2.5 s"), "{refused}");
    assert!(matches!(emla.start(&u), Err(StepError::NotFinite { .. })));
    let p = machine_file::Emla {
        C_m: -1.0,
        ..*emla.params()
    };
    let text = Emla::new(p, Drive::Motion)
        .expect_err("negative")
        .to_string();
    assert!(text.contains("emla.C_m"), "{text}");
}
