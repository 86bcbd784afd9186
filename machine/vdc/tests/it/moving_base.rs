//! The machine on a ship that rolls and pitches, with a controller that is told of it or not.

use crate::coupled::{Case, Loop, Schedule};
use vdc::Mode;

/// Roll and pitch as sines, from level on, with what the machine gets of them at the time t.
fn ship(t: f64) -> hdrm::Input {
    // Angle, rate and acceleration; the swing begins smoothly.
    let swing = |size: f64, w: f64| {
        let (sin, cos) = (w * t).sin_cos();
        [size * (1.0 - cos), size * w * sin, size * w * w * cos]
    };
    let ([r, r1, r2], [p, p1, p2]) = (swing(0.06, 1.1), swing(0.04, 1.7));
    let (s, c) = p.sin_cos();
    hdrm::Input {
        base_tilt: [r, p],
        base_angular_velocity: [c * r1, -s * r1, p1],
        base_angular_acceleration: [c * r2 - s * p1 * r1, -s * r2 - c * p1 * r1, p2],
        ..hdrm::Input::default()
    }
}

/// Largest and root mean square of the tip's error from 1 s on, m.
fn errors(mode: Mode, is_told: bool) -> [f64; 2] {
    let case = Case {
        mode,
        ..Case::nominal()
    };
    let mut run = Loop::new(&case);
    let (mut worst, mut sum, mut count) = (0.0_f64, 0.0, 0.0);
    for k in 0..8000 {
        let t = f64::from(k) * case.h;
        run.base = (ship(t), is_told);
        let error = run.step(Schedule::Staged, t, case.h);
        if k >= 1000 {
            worst = worst.max(error);
            sum += error * error;
            count += 1.0;
        }
    }
    [worst, (sum / count).sqrt()]
}

/// Told, a model-based controller follows as on firm ground, but for the actuators' lag; not told,
/// its model lacks a part of the weight and it sags by millimetres, and adaptation finds what looks
/// like inertia.
#[test]
fn a_controller_that_is_told_of_the_base_follows_as_on_firm_ground() {
    for (mode, bound) in [(Mode::Modular, 1e-4), (Mode::Adaptive, 1e-4)] {
        let [told, untold] = [true, false].map(|is_told| errors(mode, is_told));
        println!(
            "{mode:?}: told {:.4} mm RMS, {:.4} mm at most; not told {:.4} mm, {:.4} mm",
            1e3 * told[1],
            1e3 * told[0],
            1e3 * untold[1],
            1e3 * untold[0]
        );
        assert!(
            told[0] < bound && told[1] < 0.2 * untold[1],
            "{told:?} {untold:?}"
        );
    }
}
