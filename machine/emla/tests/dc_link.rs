//! The DC side: limits, current and power, and what they do to the outputs' derivatives.
use emla::{Drive, Emla, Input, State};
use machine_file::Machine;

const H: f64 = 1e-3;

fn actuator() -> Emla {
    Emla::new(Machine::reference().emla.lift, Drive::Motion).expect("reference")
}

/// Motion under load, with a voltage of the size `v` in the ratio 3 : 4.
fn inputs(v: f64, v_dc: f64) -> Input {
    Input {
        v_d: 0.6 * v,
        v_q: 0.8 * v,
        v_dc: Some(v_dc),
        x: 0.31,
        x_dot: 0.043,
        F_hold: 23e3,
        ..Input::default()
    }
}

fn step(emla: &Emla, s: &State, u: &Input) -> State {
    emla.step(s, |t| u.moved(t), 0.0, H).expect("finite")
}

/// What the inverter cannot give has no effect: any command beyond `v_dc/√3` acts as one of that
/// size, and above `√3·v_max` v_max limits.
#[test]
fn the_link_limits_the_voltage() {
    let emla = actuator();
    let s = emla.start(&inputs(0.0, 650.0)).expect("finite");
    let after = |v: f64, v_dc: f64| step(&emla, &s, &inputs(v, v_dc));
    for (v_dc, largest) in [(110.0, 110.0 / 3.0_f64.sqrt()), (700.0, 375.0)] {
        let (a, b) = (after(1.01 * largest, v_dc), after(9.0 * largest, v_dc));
        assert!((a.i_q - b.i_q).abs() < 1e-12, "{} {}", a.i_q, b.i_q);
        assert!((after(0.99 * largest, v_dc).i_q - b.i_q).abs() > 0.1);
        let limited = after(largest * (1.0 - 1e-15), v_dc);
        assert!((limited.i_q - b.i_q).abs() < 1e-11);
    }
}

/// Without a link the voltage is the machine's; a machine without an inverter has the link that
/// v_max needs.
#[test]
fn without_a_link_the_machine_has_one() {
    let emla = actuator();
    let u = inputs(500.0, 650.0);
    let s = emla.start(&u).expect("finite");
    let unconnected = Input { v_dc: None, ..u };
    assert_eq!(step(&emla, &s, &u), step(&emla, &s, &unconnected));
    let mut p = Machine::reference().emla.lift;
    p.inverter = None;
    assert!((p.largest_voltage(p.link_voltage()) - p.v_max).abs() < 1e-12);
}

/// `v_dc·i_dc = P_in`, both at an instant and in the mean of a step, to two roundings; the mean is
/// the energy taken in the step. A link of more volts costs more in switching: `6/π·f_sw·k_sw·i` a
/// volt.
#[test]
fn the_current_carries_the_power() {
    let emla = actuator();
    let mut s = emla.start(&inputs(120.0, 512.3)).expect("finite");
    for k in 0..50 {
        let u = Input {
            x: 0.31 + f64::from(k) * H * 0.043,
            ..inputs(120.0, 512.3 + f64::from(k))
        };
        let v_dc = 512.3 + f64::from(k);
        let (before, y) = (s.energy.supplied, emla.output(&s, &u));
        assert!((y.i_dc * v_dc - y.P_in).abs() <= 2.0 * f64::EPSILON * y.P_in.abs());
        s = step(&emla, &s, &u);
        let y = emla.output(&s, &u);
        let taken = (s.energy.supplied - before) / H;
        assert_eq!(y.P_in_mean, taken);
        assert!((y.i_dc_mean * v_dc - taken).abs() <= 2.0 * f64::EPSILON * taken.abs());
        let more = emla
            .output(
                &s,
                &Input {
                    v_dc: Some(v_dc + 10.0),
                    ..u
                },
            )
            .P_inverter;
        let i = (y.i_d * y.i_d + y.i_q * y.i_q).sqrt();
        let rise = 6.0 / std::f64::consts::PI * 8000.0 * 1.8e-7 * i * 10.0;
        assert!((more - y.P_inverter - rise).abs() < 1e-10, "{k}");
    }
    assert!(s.energy.supplied > 10.0);
}

/// A dead link gives neither voltage nor current; all stays finite.
#[test]
fn a_dead_link_gives_nothing() {
    let emla = actuator();
    let u = inputs(300.0, 0.0);
    let mut s = emla.start(&u).expect("finite");
    for _ in 0..100 {
        s = step(&emla, &s, &u);
        let y = emla.output(&s, &u);
        assert_eq!((y.i_dc, y.i_dc_mean), (0.0, 0.0));
        assert!(y.i_q.is_finite() && y.P_in.is_finite());
    }
}

/// Derivatives by v_dc against central differences, inside and outside the circle; error of the
/// difference: h²/6 of the third derivative, 2/v_dc³·P·h² of i_dc, below 1e-9 of the derivative,
/// and rounding ε·P/h.
#[test]
fn derivatives_by_the_link_voltage_are_those_of_differences() {
    let emla = actuator();
    for v in [120.0, 330.0] {
        let u = inputs(v, 500.0);
        let s = step(&emla, &emla.start(&u).expect("finite"), &u);
        let du = Input {
            v_d: 2.3,
            v_q: -1.1,
            v_dc: Some(7.0),
            ..Input::default()
        };
        let d = emla.output_along(&s, &u, &du);
        let at = |h: f64| {
            emla.output(
                &s,
                &Input {
                    v_d: u.v_d + h * 2.3,
                    v_q: u.v_q + h * -1.1,
                    v_dc: Some(500.0 + h * 7.0),
                    ..u
                },
            )
        };
        let (a, b) = (at(1e-3), at(-1e-3));
        for (name, exact, difference) in [
            ("P_in", d.P_in, a.P_in - b.P_in),
            ("i_dc", d.i_dc, a.i_dc - b.i_dc),
            ("P_inverter", d.P_inverter, a.P_inverter - b.P_inverter),
            ("efficiency", d.efficiency, a.efficiency - b.efficiency),
        ] {
            let error = difference / 2e-3 - exact;
            assert!(
                error.abs() < 1e-6 * exact.abs() + 1e-8,
                "{v} V, {name}: {exact}, {error}"
            );
            assert!(exact != 0.0, "{name}");
        }
    }
}
