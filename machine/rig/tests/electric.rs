//! Trips, gates and brake of the actuator as built: what holds, what falls, and where the energy
//! goes.
use rig::{CurrentLoop, Drive, Extras, Input, Output, Rig, State};

const H: f64 = 1e-3;
/// Load of the lift actuator at the start pose, N.
const LOAD: f64 = 41143.0;
/// 20 °C, K.
const ROOM: f64 = 293.15;

/// An actuator with a boom of 12 t on its rod, which the load presses down.
fn boom(extras: Extras) -> Rig {
    let mut p = machine_file::Machine::reference().emla.lift;
    p.M_act = 12e3;
    let rig = Rig::new(p, extras, Drive::Force).expect("valid");
    rig.with_undervoltage(450.0)
}

/// The boom at rest or in motion at `x_dot`, m/s, held by the voltage that keeps its current but
/// for the dead time.
fn start(rig: &Rig, x_dot: f64) -> (State, Input) {
    let mut u = Input {
        v_dc: Some(600.0),
        T_ambient: ROOM,
        x: 0.31,
        x_dot,
        F_ext: LOAD,
        F_hold: LOAD,
        ..Input::default()
    };
    let s = rig.start(&u, [ROOM; 2]).expect("finite");
    let p = rig.params();
    u.v_q = p.R_s * s.i_q + 4.0 * s.w_m * p.lambda_m;
    (s, u)
}

fn run(rig: &Rig, mut s: State, u: &Input, steps: u32) -> State {
    for _ in 0..steps {
        s = rig.step(&s, u, 0.0, H).expect("finite");
    }
    s
}

/// `E_in = E_out + E_loss + ΔE_stored` and `E_loss − E_inverter = E_heat + ΔE_thermal`. The
/// bristles are composed with the rest to second order, which leaves 1e-4 of what was turned over;
/// heat is counted from the same losses, to the rounding of half a million temperatures.
fn assert_balanced(rig: &Rig, first: &Output, s: &State, u: &Input) {
    let y = rig.output(s, u);
    let stored = y.E_stored - first.E_stored;
    let turnover = y.E_in.abs() + y.E_out.abs() + y.E_loss.abs() + stored.abs();
    let power = y.E_in - y.E_out - y.E_loss - stored;
    assert!(power.abs() < 1e-4 * turnover, "{power} of {turnover} J");
    let heat = y.E_loss - y.E_inverter - y.E_heat - (y.E_thermal - first.E_thermal);
    assert!(
        heat.abs() < 1e-6 * turnover + 2e-5,
        "{heat} of {turnover} J"
    );
}

/// The link breaks down at rest and while the boom moves at 40 mm/s: it stops within 2 mm, and then
/// motor and rod stay, to the bit and to 1 nm.
#[test]
fn a_boom_without_voltage_stays_where_it_is() {
    let rig = boom(Extras::AS_BUILT);
    for x_dot in [0.04, -0.04, 0.0] {
        let (s, u) = start(&rig, x_dot);
        let first = rig.output(&s, &u);
        let s = run(&rig, s, &u, 10);
        assert!(!s.tripped && s.i_q.abs() > 1.0);
        let low = Input {
            v_dc: Some(449.9),
            ..u
        };
        let begun = run(&rig, s, &low, 1);
        assert!(begun.tripped && begun.i_q == 0.0 && begun.i_d == 0.0);
        let stopped = run(&rig, begun, &low, 2000);
        assert!((stopped.x - s.x).abs() < 2e-3, "{} m", stopped.x - s.x);
        let later = run(&rig, stopped, &low, 5000);
        assert_eq!((later.theta_m, later.w_m), (stopped.theta_m, 0.0));
        assert!((later.x - stopped.x).abs() < 1e-9);
        let y = rig.output(&later, &low);
        assert_eq!((y.P_in, y.i_dc, y.i_dc_mean, y.tau_e), (0.0, 0.0, 0.0, 0.0));
        assert_balanced(&rig, &first, &later, &low);
        // The trip is taken back while the drive is disabled with the voltage back; enabled, it
        // works again.
        let off = Input {
            enable: false,
            brake: true,
            ..u
        };
        assert!(run(&rig, later, &Input { brake: true, ..u }, 1).tripped);
        let back = run(&rig, later, &off, 1);
        assert!(!back.tripped && run(&rig, back, &u, 3).i_q != 0.0);
    }
}

/// With the gates off and the brake released the boom falls and no current flows, whatever voltage
/// is asked for.
#[test]
fn a_disabled_drive_is_not_a_shorted_motor() {
    let rig = boom(Extras::AS_BUILT);
    let (s, u) = start(&rig, 0.0);
    let first = rig.output(&s, &u);
    let off = Input {
        enable: false,
        v_q: 200.0,
        ..u
    };
    let s = run(&rig, s, &off, 150);
    assert_eq!((s.i_d, s.i_q), (0.0, 0.0));
    assert!(s.w_m < -100.0 && !s.tripped, "{}", s.w_m);
    assert_balanced(&rig, &first, &s, &off);
    let braked = Input { brake: true, ..off };
    let held = run(&rig, s, &braked, 3000);
    assert_eq!(run(&rig, held, &braked, 1000).theta_m, held.theta_m);
    assert_balanced(&rig, &first, &held, &braked);
}

/// The field's energy goes back into the link when the gates go off, and burns in the diodes of a
/// dead one: `3/2·∫ i dλ_q`, here by Simpson's rule over the saturated inductance `L_q/(1 + a i)²`,
/// `a` such that λ_q/i_q is a fifth less at 100 A.
#[test]
fn currents_return_to_the_link() {
    let rig = boom(Extras::AS_BUILT);
    let (s, u) = start(&rig, 0.0);
    let (a, L_q, n) = (0.2 / (0.8 * rig.params().i_max), rig.params().L_q, 1000);
    let slope = |i: f64| i * L_q / (1.0 + a * i).powi(2);
    let field: f64 = (0..=n)
        .map(|k| {
            let weight = match k {
                0 => 1.0,
                k if k == n => 1.0,
                k if k % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let i = s.i_q * f64::from(k) / f64::from(n);
            1.5 * weight * slope(i) * s.i_q / f64::from(n) / 3.0
        })
        .sum();
    assert!(field > 0.4, "{field}");
    let off = Input {
        enable: false,
        brake: true,
        ..u
    };
    let next = run(&rig, s, &off, 1);
    assert!(
        (next.energy.supplied + field).abs() < 1e-10,
        "{field} {}",
        next.energy.supplied
    );
    assert!(
        (next.i_dc_mean * 600.0 * H + field).abs() < 1e-10,
        "{next:?}"
    );
    let dead = run(
        &rig,
        s,
        &Input {
            v_dc: Some(0.5),
            ..off
        },
        1,
    );
    assert_eq!((dead.energy.supplied, dead.i_dc_mean), (0.0, 0.0));
    assert!((dead.energy.inverter - field).abs() < 1e-10, "{dead:?}");
}

/// The brake of 50 N·m holds what the nut turns back with, `F·ρ/(2πN)`, without help of friction:
/// 117.8 kN.
#[test]
fn the_brake_holds_up_to_its_torque() {
    let mut extras = Extras::AS_BUILT;
    extras.friction.on = false;
    extras.cogging.on = false;
    extras.backlash.on = false;
    let rig = boom(extras);
    let eta = rig.params().eta_gear;
    let per_newton = 0.016 / std::f64::consts::TAU / 6.0 * 0.5 * (1.0 / eta + eta);
    for (share, holds) in [(0.99, true), (1.02, false)] {
        let F = share * 50.0 / per_newton;
        let u = Input {
            v_dc: Some(600.0),
            x: 0.31,
            F_ext: F,
            F_hold: F,
            enable: false,
            brake: true,
            ..Input::default()
        };
        let s = rig.start(&u, [ROOM; 2]).expect("finite");
        let later = run(&rig, s, &u, 500);
        assert_eq!(later.theta_m == s.theta_m, holds, "{share}");
    }
}

/// What a rod that is set elsewhere between two steps takes from the springs or gives them: the
/// energy of a spring of 1/K in series is `F²/(2K)`, and `F = K·stretch` beyond the play.
#[test]
fn a_shift_of_the_rod_is_work_of_the_springs() {
    let p = machine_file::Machine::reference().emla.lift;
    let rig = Rig::new(p, Extras::AS_BUILT, Drive::Motion).expect("valid");
    let u = Input {
        v_dc: Some(600.0),
        x: 0.31,
        F_hold: LOAD,
        ..Input::default()
    };
    let s = rig.start(&u, [ROOM; 2]).expect("finite");
    let stored = |x: f64| rig.output(&s, &Input { x, ..u }).E_stored;
    for to in [0.31 + 3e-5, 0.31 - 2e-5, 0.31] {
        let work = rig.work_of_shift(&s, 0.31, to);
        assert!((work - (stored(0.31) - stored(to))).abs() < 1e-11 * stored(0.31));
        assert!((work - LOAD * (to - 0.31)).abs() <= 0.4 * LOAD * (to - 0.31).abs());
    }
}

/// The drive's own loop takes the current to where it is asked, whatever the motor's inductance, in
/// the time of its bandwidth: 63 % of the step after some L/K_p and two periods of 125 µs, no further
/// than the overshoot of 25 % that a phase margin of 43° has, less than 10 % beside it after 6 ms
/// (the slowest of its poles, `L s² + (R_s + K_p) s + K_i = 0`, lies at −349 1/s), no more than the
/// largest current. Gates that go off empty it.
#[test]
fn the_current_loop_follows_the_required_current() {
    for factor in [0.6, 1.0, 1.4] {
        let mut p = machine_file::Machine::reference().emla.lift;
        (p.L_d, p.L_q) = (factor * p.L_d, factor * p.L_q);
        // A rotor so heavy that its voltage stays as it is, and no dead time: near the zero of a
        // phase's current that acts as a resistance of some 10 Ω.
        p.J_m *= 1e3;
        let mut extras = Extras::AS_BUILT;
        extras.switching.dead_time = 0.0;
        let rig = Rig::new(p, extras, Drive::Motion).expect("valid");
        let rig = rig.with_current_loop(Some(CurrentLoop::TYPICAL));
        let mut u = Input {
            x: 0.31,
            F_hold: LOAD,
            T_ambient: ROOM,
            v_q: 300.0, // not read
            ..Input::default()
        };
        let start = rig.start(&u, [ROOM; 2]).expect("finite");
        u.i_q_required = start.i_q + 5.0;
        let rise = p.L_q / CurrentLoop::TYPICAL.K_p + 250e-6;
        let early = rig.step(&start, &u, 0.0, rise).expect("finite");
        let part = (early.i_q - start.i_q) / 5.0;
        assert!((0.35..1.25).contains(&part), "{factor}: {part}");
        let later = rig.step(&start, &u, 0.0, 6e-3).expect("finite");
        let beside = (later.i_q - u.i_q_required).abs().max(later.i_d.abs());
        assert!(beside < 0.5, "{factor}: {beside} A");
        u.i_q_required = 1e4;
        let most = rig.step(&start, &u, 0.0, 20e-3).expect("finite").i_q;
        assert!(most < 1.35 * p.i_max, "{factor}: {most} A");
        u.enable = false;
        let off = rig.step(&later, &u, 0.0, H).expect("finite");
        assert_eq!((off.i_q, off.regulator), (0.0, [0.0; 2]));
    }
}

/// A brake that takes 20 ms to close stops the falling boom as one that acts at once and is commanded
/// 20 ms later, to the last bit; and within a step, at 20.5 ms, between the two of 20 and 21 ms.
#[test]
fn a_brake_acts_after_its_closing_time() {
    let closing = |closing_time: f64| {
        let mut p = machine_file::Machine::reference().emla.lift;
        p.M_act = 12e3;
        p.brake = Some(machine_file::Brake {
            closing_time,
            ..machine_file::Brake::TYPICAL
        });
        Rig::new(p, Extras::AS_BUILT, Drive::Force).expect("valid")
    };
    let (at_once, slow) = (closing(0.0), closing(0.02));
    let (s, u) = start(&at_once, 0.0);
    let off = Input { enable: false, ..u };
    let braked = Input { brake: true, ..off };
    let falling = run(&at_once, s, &off, 40);
    let later = |steps: u32| {
        run(
            &at_once,
            run(&at_once, falling, &off, steps),
            &braked,
            60 - steps,
        )
    };
    let found = run(&slow, falling, &braked, 60);
    assert_eq!(found.theta_m, later(20).theta_m);
    assert_ne!(found.theta_m, later(19).theta_m);
    let between = run(&closing(0.0205), falling, &braked, 60).theta_m;
    let ends = [later(20).theta_m, later(21).theta_m];
    assert!(
        ends[1] < between && between < ends[0],
        "{between} in {ends:?}"
    );
    // Released and commanded again it takes its time anew.
    let again = run(&slow, run(&slow, falling, &braked, 15), &off, 1);
    let again = run(&slow, again, &braked, 10);
    assert_eq!(again.theta_m, run(&at_once, falling, &off, 26).theta_m);
}
