//! Energy and charge over long and rough runs.

use dclink::{DcLink, Input, Params, Regime};

const H: f64 = 1e-3;

fn link(change: impl Fn(&mut Params)) -> DcLink {
    let mut p = Params::REFERENCE;
    change(&mut p);
    DcLink::new(p).expect("valid")
}

/// What the energies leave open after `steps` with the loads that `load` gives, J, and what went
/// through the link in either direction.
fn open(link: &DcLink, steps: u32, load: impl Fn(u32) -> f64) -> (f64, f64) {
    let u = |k| Input {
        i_load: [0.25 * load(k), 0.5 * load(k), 0.25 * load(k)],
        T_ambient: 290.0,
    };
    let mut s = link.start(&u(0));
    let stored = link.output(&s).stored;
    let mut turned = 0.0;
    for k in 0..steps {
        let next = link.step(&s, &u(k), f64::from(k) * H, H).expect("finite");
        turned += (next.energy.load - s.energy.load).abs() + (next.energy.brake - s.energy.brake);
        s = next;
        assert!(s.v_c >= 0.0 && s.v_c < 1e4, "step {k}: {s:?}");
    }
    let (y, e) = (link.output(&s), s.energy);
    let left = e.battery - e.load - e.brake - e.loss - (y.stored - stored);
    (left, turned)
}

/// Loads that jump at every step between ±100 A, through limits, chopper and an empty capacitor.
/// The method errs by 3e-7 of a step response at most, and what a step response holds is a fraction
/// of what is turned over.
#[test]
fn energies_close_whatever_happens() {
    let rough = |k: u32| 100.0 * f64::from(k.wrapping_mul(2_654_435_761) >> 16).sin();
    for (name, change) in [
        ("as it is", (|_| ()) as fn(&mut Params)),
        ("full", |p| p.battery.soc_start = 1.0),
        ("empty", |p| p.battery.soc_start = 0.0),
        ("capped", |p| p.battery.discharge_limit = 0.5),
        ("precharged in the run", |p| p.precharge.on = true),
        ("no chopper", |p| p.brake.fitted = false),
    ] {
        let (left, turned) = open(&link(change), 5000, rough);
        println!("{name}: {left:e} of {turned:e}");
        assert!(
            turned > 1e4 && left.abs() < 1e-6 * turned,
            "{name}: {left} of {turned}"
        );
    }
}

/// Drives that ask for more than the pack gives empty the capacitor and then get what the pack
/// gives, at no voltage; it fills again after.
#[test]
fn a_capped_pack_empties_the_capacitor_and_fills_it_again() {
    let link = link(|p| p.battery.discharge_limit = 0.5);
    let u = |i| Input {
        i_load: [i, 0.0, 0.0],
        T_ambient: 290.0,
    };
    let mut s = link.start(&u(0.0));
    for _ in 0..2000 {
        s = link.step(&s, &u(10.0), 0.0, H).expect("finite");
    }
    assert!(s.mode.empty && s.mode.regime == Regime::Discharging);
    assert!(s.v_c == 0.0 && link.output(&s).i_battery == 0.5 && link.output(&s).undervoltage);
    for _ in 0..20_000 {
        s = link.step(&s, &u(0.0), 0.0, H).expect("finite");
    }
    // 0.5 A on 12 mF: 656 V after 15.7 s.
    assert!(
        !s.mode.empty && s.mode.regime == Regime::Free && s.v_c > 650.0,
        "{s:?}"
    );
}

/// A load whose mean is nothing, step after step: what is left open grows with the number of sums,
/// each rounded to 2⁻⁵³ of an energy that stays below some kilojoules; and the charge is where the
/// currents have taken it.
fn drift(steps: u32) {
    let cycle = |k: u32| 12.0 * (f64::from(k % 1000) * std::f64::consts::TAU / 1000.0).sin();
    let (left, turned) = open(&link(|_| ()), steps, cycle);
    println!("{steps} steps: {left:e} J left open of {turned:e} J");
    assert!(left.abs() < 1e-10 * turned, "{left} of {turned}");
}

#[test]
fn a_million_steps_do_not_drift() {
    drift(1_000_000);
}

/// `cargo test --release -p dclink -- --ignored --nocapture`
#[test]
#[ignore = "long"]
fn ten_million_steps_do_not_drift() {
    drift(10_000_000);
}

/// Parameters that do not fit are refused by name.
#[test]
fn parameters_are_checked() {
    let refused = |change: fn(&mut Params)| {
        let mut p = Params::REFERENCE;
        change(&mut p);
        DcLink::new(p).expect_err("refused").to_string()
    };
    assert_eq!(
        refused(|p| p.brake.v_on = 700.0),
        "`brake.v_on` = 700 must be above brake.v_off"
    );
    assert_eq!(
        refused(|p| p.battery.ocv[7] = 3.0),
        "`battery.ocv` = 3 must be positive and nowhere falling"
    );
    assert!(refused(|p| (p.battery.R_0, p.link.R) = (0.0, 0.0)).contains("`link.R` = 0"));
}

/// The rates of Model Exchange, against what moves in a very short step while the chopper works
/// and the pack takes all that it may. The step errs by half of its length times the second
/// derivative: 1e-6 over time constants of 0.1 s and more; rounding of 1e3 over 1e-6 is 1e-7.
#[test]
fn a_short_step_follows_the_rates() {
    let link = link(|p| (p.battery.R[1], p.battery.T_start) = (0.05, 310.0));
    let u = Input {
        i_load: [-40.0, -10.0, 0.0],
        T_ambient: 290.0,
    };
    let mut s = link.start(&u);
    let is_there = |s: &dclink::State| s.mode.braking && s.mode.regime == Regime::Charging;
    for k in 0..500 {
        if !is_there(&s) {
            s = link.step(&s, &u, f64::from(k) * H, H).expect("finite");
        }
    }
    assert!(is_there(&s));
    let (h, rate) = (1e-6, link.derivative(&s, &u));
    let next = link.step(&s, &u, 0.0, h).expect("finite");
    let numbers = |s: &dclink::State| {
        let e = s.energy;
        [
            s.soc, s.v[0], s.v[1], s.v_c, s.T, e.battery, e.load, e.brake, e.loss,
        ]
    };
    let (after, before, rates) = (numbers(&next), numbers(&s), numbers(&rate));
    for k in 0..9 {
        let found = (after[k] - before[k]) / h;
        let tol = 1e-4 * rates[k].abs() + 1e-6;
        assert!(
            rates[k] != 0.0 && (found - rates[k]).abs() < tol,
            "{k}: {found} {}",
            rates[k]
        );
    }
}
