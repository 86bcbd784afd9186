//! Trips, gates, brake and heat: what holds, what falls, and where the energy goes.
use emla::{Drive, Electric, Emla, Input, Output, State};
use machine_file::{Brake, Machine};

const H: f64 = 1e-3;
/// Load of the lift actuator at the start pose, N.
const LOAD: f64 = 41143.0;
/// 20 °C, K.
const ROOM: f64 = 293.15;

const ALL: Electric = Electric {
    undervoltage: 450.0,
    heat: true,
    temperature: true,
};

/// An actuator with a boom of 12 t on its rod, which the load presses down.
fn boom(electric: Electric) -> Emla {
    let mut p = Machine::reference().emla.lift;
    p.M_act = 12e3;
    Emla::new(p, Drive::Force)
        .expect("valid")
        .with_electric(electric)
}

/// The boom at rest or in motion at `x_dot`, m/s, held by the voltage that keeps its current.
fn start(emla: &Emla, x_dot: f64) -> (State, Input) {
    let mut u = Input {
        v_dc: Some(600.0),
        T_ambient: ROOM,
        x: 0.31,
        x_dot,
        F_ext: LOAD,
        F_hold: LOAD,
        ..Input::default()
    };
    let s = emla.start(&u).expect("finite");
    let p = emla.params();
    u.v_q = p.R_s * s.i_q + 4.0 * s.w_m * p.lambda_m;
    u.v_d = -4.0 * s.w_m * p.L_q * s.i_q;
    (s, u)
}

fn run(emla: &Emla, mut s: State, u: &Input, steps: u32) -> State {
    for _ in 0..steps {
        s = emla.step(&s, |_| *u, 0.0, H).expect("finite");
    }
    s
}

/// `E_in = E_out + E_loss + ΔE_stored` to 1e-6 of what was turned over, and, with heat on,
/// `E_loss − E_inverter = E_heat + ΔE_thermal`.
fn assert_balanced(emla: &Emla, first: &Output, s: &State, u: &Input) {
    let y = emla.output(s, u);
    let stored = y.E_stored - first.E_stored;
    let turnover = y.E_in.abs() + y.E_out.abs() + y.E_loss.abs() + stored.abs();
    let power = y.E_in - y.E_out - y.E_loss - stored;
    assert!(power.abs() < 1e-6 * turnover, "{power} of {turnover} J");
    if emla.electric().heat {
        let heat = y.E_loss - y.E_inverter - y.E_heat - (y.E_thermal - first.E_thermal);
        assert!(heat.abs() < 1e-6 * turnover, "{heat} of {turnover} J");
    }
}

/// The link breaks down while the boom is lifted and lowered at 40 mm/s under 41 kN: it stops
/// within 2 mm, and from then on neither falls nor creeps: motor and rod have the same position
/// after a minute, to the bit and to 1 nm (the spring rings out).
#[test]
fn a_boom_without_voltage_stays_where_it_is() {
    let emla = boom(ALL);
    for x_dot in [0.04, -0.04, 0.0] {
        let (s, u) = start(&emla, x_dot);
        let first = emla.output(&s, &u);
        let s = run(&emla, s, &u, 100);
        assert!(!s.tripped && s.i_q > 10.0);
        let low = Input {
            v_dc: Some(449.9),
            ..u
        };
        let begun = run(&emla, s, &low, 1);
        assert!(begun.tripped && begun.i_q == 0.0 && begun.i_d == 0.0);
        let stopped = run(&emla, begun, &low, 2000);
        assert!((stopped.x - s.x).abs() < 2e-3, "{} m", stopped.x - s.x);
        let later = run(&emla, stopped, &low, 60_000);
        assert_eq!((later.theta_m, later.w_m), (stopped.theta_m, 0.0));
        assert!(
            (later.x - stopped.x).abs() < 1e-9,
            "{}",
            later.x - stopped.x
        );
        let y = emla.output(&later, &low);
        assert_eq!((y.P_in, y.i_dc, y.tau_e), (0.0, 0.0, 0.0));
        assert_balanced(&emla, &first, &later, &low);
    }
}

/// With the gates off and the brake released the boom falls, faster than a shorted motor would let
/// it (whose largest torque `3/4·p·λ_m²/L` = 42 N·m is reached at `R/(p·L)` = 19 rad/s), no current
/// flows, and the balance closes.
#[test]
fn a_disabled_drive_is_not_a_shorted_motor() {
    let emla = boom(Electric::default());
    let (s, u) = start(&emla, 0.0);
    let first = emla.output(&s, &u);
    let off = Input { enable: false, ..u };
    let s = run(&emla, s, &off, 150);
    assert_eq!((s.i_d, s.i_q), (0.0, 0.0));
    assert!(s.w_m < -100.0, "{}", s.w_m);
    assert_balanced(&emla, &first, &s, &off);
    assert!(!s.tripped);
    // Braked at speed, it stops, and holds.
    let braked = Input { brake: true, ..off };
    let held = run(&emla, s, &braked, 3000);
    assert_eq!(run(&emla, held, &braked, 1000).theta_m, held.theta_m);
    assert_balanced(&emla, &first, &held, &braked);
}

/// The field's energy goes back into the link when the gates go off: `3/4·L·i²`.
#[test]
fn currents_return_to_the_link() {
    let emla = boom(Electric::default());
    let (s, u) = start(&emla, 0.0);
    let off = Input {
        enable: false,
        brake: true,
        ..u
    };
    let next = run(&emla, s, &off, 1);
    let field = 0.75 * 0.0026 * s.i_q * s.i_q;
    assert!((next.energy.supplied + field).abs() < 1e-12);
    assert!((next.P_in_mean * H + field).abs() < 1e-12);
    assert!((next.i_dc_mean * 600.0 - next.P_in_mean).abs() < 1e-9);
}

/// The brake of 50 N·m holds what the nut turns back with: `F·ρ/(2πN)·k`, k = (1/η + η)/2 at rest:
/// 117.7 kN.
#[test]
fn the_brake_holds_up_to_its_torque() {
    let emla = boom(Electric::default());
    let per_newton = 0.016 / std::f64::consts::TAU / 6.0 * 0.5 * (1.0 / 0.95 + 0.95);
    for (F_ext, holds) in [
        (0.99 * 50.0 / per_newton, true),
        (1.02 * 50.0 / per_newton, false),
    ] {
        let u = Input {
            x: 0.31,
            F_ext,
            F_hold: F_ext,
            enable: false,
            brake: true,
            ..Input::default()
        };
        let s = emla.start(&u).expect("finite");
        let next = run(&emla, s, &u, 200);
        assert_eq!(next.theta_m == s.theta_m, holds, "{F_ext} N");
        assert!(holds || next.w_m < -0.1, "{}", next.w_m);
    }
}

/// A trip stays when the voltage comes back, and while it is low; disabled with the voltage back,
/// the drive is ready again. A disabled drive does not trip, so a link may be charged.
#[test]
fn a_trip_is_reset_by_disabling() {
    let emla = boom(ALL);
    let (s, u) = start(&emla, 0.0);
    let with = |enable: bool, v_dc: f64| Input {
        enable,
        v_dc: Some(v_dc),
        brake: true,
        ..u
    };
    let tripped = |s: State, enable: bool, v_dc: f64| run(&emla, s, &with(enable, v_dc), 1);
    let charging = tripped(tripped(s, false, 3.0), false, 440.0);
    assert!(!charging.tripped);
    assert!(!tripped(charging, true, 600.0).tripped);
    let low = tripped(charging, true, 449.0);
    assert!(low.tripped);
    assert!(
        tripped(low, true, 600.0).tripped,
        "voltage back, still enabled"
    );
    assert!(tripped(low, false, 449.0).tripped, "disabled, still low");
    let ready = tripped(low, false, 600.0);
    assert!(!ready.tripped);
    assert!(tripped(ready, true, 600.0).i_q != 0.0);
}

/// Heat alone changes nothing but temperatures: the same bits in every other state. With
/// temperature, resistance and flux follow.
#[test]
fn heat_alone_changes_no_motion() {
    let plain = boom(Electric::default());
    let warm = boom(Electric {
        heat: true,
        ..Electric::default()
    });
    let (s, u) = start(&plain, 0.02);
    let (a, b) = (run(&plain, s, &u, 500), run(&warm, s, &u, 500));
    assert_eq!(
        (a.i_d, a.i_q, a.theta_m, a.w_m, a.x),
        (b.i_d, b.i_q, b.theta_m, b.w_m, b.x)
    );
    assert_eq!(a.energy, b.energy);
    assert!(b.thermal.T_winding > a.thermal.T_winding);
    let hot = [ROOM + 60.0, ROOM + 60.0];
    let at = |emla: &Emla| emla.output(&emla.start_at(&u, hot).expect("finite"), &u);
    let (cold, hot) = (at(&plain), at(&boom(ALL)));
    assert!((cold.tau_e - hot.tau_e).abs() < 1e-9);
    assert!(
        (cold.i_q / hot.i_q - (1.0 - 0.066)).abs() < 1e-9,
        "flux −6.6 %"
    );
    let ratio = hot.P_copper / cold.P_copper * (cold.i_q / hot.i_q).powi(2);
    assert!(
        (ratio - 1.2358).abs() < 1e-9,
        "resistance +23.58 %: {ratio}"
    );
}

/// A current that is held: the winding settles at `T_a + 0.21 K/W·P`, `P = P_20·(1 + α ΔT)`, hence
/// `ΔT = 0.21·P_20/(1 − 0.21·α·P_20)`; without speed there are no other losses, and the brake keeps
/// the rod while the magnets weaken. Capacities are a thousandth, so that the slowest time constant
/// is 2.6 s; the temperature feedback makes it 2.8 s; what is left after 14 of them is 6e-7.
#[test]
fn a_held_current_settles_where_it_must() {
    let mut p = Machine::reference().emla.lift;
    p.M_act = 12e3;
    p.heat = Some(machine_file::Heat {
        C_w: 2.0,
        C_h: 15.0,
        ..machine_file::Heat::TYPICAL
    });
    let emla = Emla::new(p, Drive::Force)
        .expect("valid")
        .with_electric(ALL);
    let (mut s, mut u) = start(&emla, 0.0);
    u.brake = true;
    let i = s.i_q;
    for _ in 0..40_000 {
        u.v_q = 0.2 * (1.0 + 0.00393 * (s.thermal.T_winding - ROOM)) * i;
        s = run(&emla, s, &u, 1);
    }
    let P_20 = 1.5 * 0.2 * i * i;
    let rise = 0.21 * P_20 / (1.0 - 0.21 * 0.00393 * P_20);
    let found = s.thermal.T_winding - ROOM;
    assert!((found / rise - 1.0).abs() < 1e-5, "{found} K, {rise} K");
    assert!((emla.output(&s, &u).P_heat * 0.21 / rise - 1.0).abs() < 1e-5);
}

/// A housing of 0.1 J/K that gives its heat to the air through 1e-4 K/W (10 µs): a step of 0.1 s is
/// ten thousand time constants, so at its end the housing stands above the air by what flows
/// through it, times 1e-4 K/W, but for the 10 µs by which it lags behind the winding, whose time
/// constant is minutes: less than 1e-6.
#[test]
fn a_housing_faster_than_the_step_is_resolved() {
    let mut p = Machine::reference().emla.lift;
    p.heat = Some(machine_file::Heat {
        C_h: 0.1,
        R_ha: 1e-4,
        ..machine_file::Heat::TYPICAL
    });
    let emla = Emla::new(p, Drive::Force)
        .expect("valid")
        .with_electric(ALL);
    let (_, mut u) = start(&emla, 0.0);
    u.brake = true;
    let hot = [ROOM + 60.0, ROOM + 60.0];
    let s = emla.start_at(&u, hot).expect("finite");
    let s = emla.step(&s, |_| u, 0.0, 0.1).expect("finite").thermal;
    let flow = (s.T_winding - s.T_housing) / machine_file::Heat::TYPICAL.R_wh;
    let rise = s.T_housing - ROOM;
    assert!((rise / (flow * 1e-4) - 1.0).abs() < 1e-6, "{rise} K");
}

/// `P_heat = (T_h − T_a)/R_ha`: a kelvin more of the air takes 1/R_ha away, and nothing while heat
/// is off.
#[test]
fn the_air_acts_on_the_heat_that_it_takes() {
    for electric in [ALL, Electric::default()] {
        let emla = boom(electric);
        let (s, u) = start(&emla, 0.0);
        let du = Input {
            T_ambient: 1.0,
            ..Input::default()
        };
        let slope = emla.output_along(&s, &u, &du).P_heat;
        let expected = if electric.heat {
            -1.0 / machine_file::Heat::TYPICAL.R_ha
        } else {
            0.0
        };
        assert!((slope - expected).abs() < 1e-12, "{slope} W/K");
    }
}

/// A brake that takes 20 ms to close stops the falling boom as one that acts at once and is commanded
/// 20 ms later, to the last bit; and within a step, at 20.5 ms, between the two of 20 and 21 ms.
#[test]
fn a_brake_acts_after_its_closing_time() {
    let closing = |closing_time: f64| {
        let mut p = Machine::reference().emla.lift;
        p.M_act = 12e3;
        p.brake = Some(Brake {
            closing_time,
            ..Brake::TYPICAL
        });
        Emla::new(p, Drive::Force).expect("valid")
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
