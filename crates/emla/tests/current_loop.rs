//! The drive's own current loop, against the closed form of a sampled PI regulator on a winding.
use emla::{CurrentLoop, Drive, Electric, Emla, Input, State};
use machine::Machine;

const H: f64 = 1e-3;
/// A step of the required current, A.
const MORE: f64 = 5.0;

/// The lift's actuator with these gains; a brake holds its shaft, so its winding is `R_s` and `L`.
fn braked(gains: CurrentLoop) -> (Emla, Input) {
    let p = Machine::reference().emla.lift;
    let emla = Emla::new(p, Drive::Motion).expect("valid");
    let u = Input {
        x: 0.31,
        v_q: 300.0, // not read
        brake: true,
        ..Input::default()
    };
    let electric = Electric {
        current_loop: Some(gains),
        ..Electric::default()
    };
    (emla.with_electric(electric), u)
}

fn after(emla: &Emla, u: &Input, t: f64) -> State {
    let start = emla.start(u).expect("finite");
    let whole = (t / H) as u32;
    let first = (0..whole).fold(start, |s, _| emla.step(&s, |_| *u, 0.0, H).expect("finite"));
    let left = t - f64::from(whole) * H;
    if left < 1e-9 {
        return first;
    }
    emla.step(&first, |_| *u, 0.0, left).expect("finite")
}

/// With K_i = K_p R_s/L the regulator's zero takes the winding's pole away: what is left rises as
/// `1 − e^(−t/τ)` with τ = L/K_p. A voltage that is held for T = 125 µs = τ/5 instead of following
/// at once is half a period late in the mean, so the time constant is missed by T/(2τ) = 10 % of
/// it at most: of the step by 0.1/e = 4 %.
#[test]
fn the_loop_has_the_time_constant_of_its_gain() {
    let p = Machine::reference().emla.lift;
    let tau = 625e-6;
    let K_p = p.L_q / tau;
    let (emla, mut u) = braked(CurrentLoop {
        K_p,
        K_i: K_p * p.R_s / p.L_q,
    });
    u.i_q_required = MORE;
    for times in [1.0_f64, 2.0, 5.0] {
        let found = after(&emla, &u, times * tau).i_q / MORE;
        let expected = 1.0 - (-times).exp();
        assert!(
            (found - expected).abs() < 0.04,
            "{times} τ: {found}, {expected}"
        );
    }
}

/// From sample to sample the winding is exactly `i' = a i + (1 − a)/R v`, a = e^(−R T/L); the
/// regulator adds its own two lines. Runge–Kutta misses that by (R T/L)⁵ ≈ 1e-10 a sample. The steps
/// do not end where samples are.
#[test]
fn the_current_is_that_of_a_sampled_regulator() {
    let (emla, mut u) = braked(CurrentLoop::TYPICAL);
    u.i_q_required = MORE;
    let p = emla.params();
    let T = 1.0 / p.inverter.expect("an inverter").f_sw;
    let a = (-p.R_s * T / p.L_q).exp();
    let (mut i, mut sum) = (0.0, 0.0);
    for k in 1..=40_u32 {
        let e = MORE - i;
        let v = CurrentLoop::TYPICAL.K_p * e + sum;
        sum += T * CurrentLoop::TYPICAL.K_i * e;
        i = a * i + (1.0 - a) / p.R_s * v;
        let found = after(&emla, &u, f64::from(k) * T).i_q;
        assert!((found - i).abs() < 1e-7, "{k}: {found} A, {i} A");
    }
    // The voltages of the inputs are not read, neither in the power.
    let s = after(&emla, &u, 4.3 * H);
    let held = emla.output(&s, &u);
    u.v_q = -70.0;
    assert_eq!(emla.output(&s, &u), held);
    let along = Input {
        v_d: 1.0,
        v_q: 2.0,
        ..Input::default()
    };
    assert_eq!(emla.output_along(&s, &u, &along).P_in, 0.0);
    let energy = held.E_in - held.E_loss - held.E_stored;
    assert!(energy.abs() < 1e-6 * held.E_in, "{energy} J");
}

/// The required current is held to `i_max`: 60 ms after a step to it, ten times as long as the slowest
/// of the poles of `L s² + (R_s + K_p) s + K_i = 0` (−349 1/s) takes to fall to 1/8, nothing is left of
/// the overshoot. Gates that go off empty the loop; in steady motion it goes on with what it starts with.
#[test]
fn limits_gates_and_the_start() {
    let (emla, mut u) = braked(CurrentLoop::TYPICAL);
    u.i_q_required = 1e4;
    let most = after(&emla, &u, 60.0 * H).i_q;
    assert!((most / emla.params().i_max - 1.0).abs() < 1e-6, "{most} A");
    u.enable = false;
    let off = emla
        .step(&after(&emla, &u, H), |_| u, 0.0, H)
        .expect("finite");
    assert_eq!((off.i_q, off.regulator.integral), (0.0, [0.0; 2]));
    let u = Input {
        x: 0.31,
        x_dot: 0.02,
        F_hold: 21e3,
        ..Input::default()
    };
    let start = emla.start(&u).expect("finite");
    let held = Input {
        i_q_required: start.i_q,
        ..u
    };
    let moved = |t| Input {
        x: u.x + 0.02 * t,
        ..held
    };
    let s = emla.step(&start, moved, 0.0, 10.0 * H).expect("finite");
    assert!(
        (s.i_q - start.i_q).abs() < 1e-3 && s.i_d.abs() < 1e-3,
        "{s:?}"
    );
}
