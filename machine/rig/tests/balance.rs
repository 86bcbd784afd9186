//! The power balance of the actuator as built, all extras on.
use rig::{Drive, Extras, Input, Output, Rig, State};

const H: f64 = 1e-3;

fn rig(drive: Drive) -> Rig {
    let p = machine_file::Machine::reference().emla.lift;
    Rig::new(p, Extras::AS_BUILT, drive).expect("valid")
}

/// Inputs at time `t`: voltages that reverse the motor, a load that reverses, in [`Drive::Motion`]
/// a rod that swings.
fn input(t: f64, x: f64, x_dot: f64) -> Input {
    Input {
        v_d: -3.0 + 2.0 * (9.0 * t).sin(),
        v_q: 60.0 * (3.1 * t).sin() + 4.0 * (17.0 * t).cos(),
        v_dc: Some(650.0),
        T_ambient: 293.15,
        x,
        x_dot,
        F_ext: 25e3 * (2.3 * t).cos(),
        F_hold: 20e3,
        ..Input::default()
    }
}

/// Runs `seconds`; outputs after each step, the start first.
fn run(drive: Drive, seconds: f64, mut look: impl FnMut(&Output, &State)) {
    let rig = rig(drive);
    let travel = 0.016 / std::f64::consts::TAU / 6.0;
    let mut x = 0.3;
    let mut s = rig
        .start(&input(0.0, x, 0.0), [293.15, 293.15])
        .expect("finite");
    for k in 0..(seconds / H) as u32 {
        let t = f64::from(k) * H;
        // With a prescribed rod it follows the motor, some 10 % off, so that the connection is
        // worked both ways.
        let x_dot = 0.9 * travel * s.w_m + 0.2 * (travel * s.theta_m - x);
        let u = input(t, x, x_dot);
        look(&rig.output(&s, &u), &s);
        s = rig.step(&s, &u, t, H).expect("finite");
        x += x_dot * H;
    }
}

/// `E_in = E_out + E_loss + ΔE_stored` to 1e-3 of what is turned over, and what is lost outside the
/// inverter is the heat held and given.
#[test]
fn power_and_heat_balance_close() {
    for drive in [Drive::Motion, Drive::Force] {
        let (mut first, mut last): (Option<Output>, _) = (None, Output::default());
        let (mut turned, mut before) = (0.0, [0.0; 2]);
        let (mut engaged, mut slid, mut reversed) = (0, 0, 0);
        let mut sign = 0.0;
        run(drive, 8.0, |y, _| {
            first.get_or_insert(*y);
            turned += (y.E_in - before[0]).abs() + (y.E_out - before[1]).abs();
            before = [y.E_in, y.E_out];
            engaged += u32::from(y.F != 0.0);
            slid += u32::from(y.presliding.abs() > 10e-6);
            reversed += u32::from(sign * y.w_m < 0.0);
            sign = y.w_m;
            last = *y;
        });
        let first = first.expect("ran");
        let gap = last.E_in - last.E_out - last.E_loss - (last.E_stored - first.E_stored);
        assert!(
            gap.abs() < 1e-3 * turned,
            "{drive:?}: {gap} J of {turned} J"
        );
        let warmed = last.E_thermal - first.E_thermal + last.E_heat;
        let heat = last.E_loss - last.E_inverter - warmed;
        assert!(heat.abs() < 1e-9 * last.E_loss, "{drive:?}: {heat} J");
        println!("{drive:?}: gap {gap:.3e} J of {turned:.4e} J, {reversed} reversals");
        assert!(turned > 1e3 && engaged > 1000 && slid > 1000 && reversed > 5);
    }
}

/// The balance of powers at an instant: with the state's change over a short step, which shows the
/// stored energy's rate. Halving the step halves the difference (it is of first order in the step),
/// so the balance holds in the limit.
#[test]
fn halving_the_step_halves_the_gap_of_powers() {
    let rig = rig(Drive::Force);
    let u = input(0.4, 0.3, 0.02);
    let mut s = rig.start(&u, [330.0, 310.0]).expect("finite");
    for k in 0..500 {
        let t = f64::from(k) * H;
        s = rig.step(&s, &input(t, 0.3, 0.0), t, H).expect("finite");
    }
    s = rig.step(&s, &u, 0.5, 50e-6).expect("finite"); // into a switching period, whose voltage changes at its begin
    let gap = |h: f64| {
        let next = rig.step(&s, &u, 0.0, h).expect("finite");
        let (a, b) = (rig.output(&s, &u), rig.output(&next, &u));
        (b.E_stored - a.E_stored) / h - (a.P_in - a.P_out - a.P_loss)
    };
    let (coarse, fine) = (gap(2e-6), gap(1e-6));
    println!("{coarse} W, {fine} W");
    assert!((coarse / fine - 2.0).abs() < 0.1, "{coarse} W, {fine} W");
}
