//! Hybrid blending, with a network that says the same force everywhere.
use emla::{Drive, EfficiencyBound, Emla, Input, NoErrorBound, State, Surrogate, maps};
use machine_file::Machine;

const H: f64 = 1e-3;

/// The shipped network with all weights zero and these outputs (inside its ranges) as last biases.
fn constant_network(F: f64, x_dot: f64) -> Surrogate {
    let mut file = Surrogate::reference().file();
    for layer in &mut file.layers {
        layer.weights.iter_mut().flatten().for_each(|w| *w = 0.0);
        layer.bias.fill(0.0);
    }
    let last = file.layers.last_mut().expect("six layers");
    last.bias = vec![file.ranges.f_ext.scale(F), file.ranges.x_dot.scale(x_dot)];
    Surrogate::new(file).expect("valid")
}

fn physics() -> Emla {
    Emla::new(Machine::reference().emla.lift, Drive::Motion).expect("reference")
}

/// One second at constant rod speed, voltage held at what the start needs.
fn steady_run(emla: &Emla, mut u: Input) -> (State, Input) {
    let p = *emla.params();
    let mut s = emla.start(&u).expect("finite");
    let w_e = f64::from(p.p) * s.w_m;
    u.v_d = -w_e * p.L_q * s.i_q;
    u.v_q = p.R_s * s.i_q + w_e * p.lambda_m;
    for k in 0..1000 {
        s = emla
            .step(&s, |t| u.moved(t), f64::from(k) * H, H)
            .expect("finite");
        u.x += H * u.x_dot;
    }
    (s, u)
}

/// In steady motion the delivered force is F_hyb = F_qs + α(F_net − F_qs): with a constant network
/// of 30 kN and half of each, F_qs must be 2·F − 30 kN. A newton or two come from K_b(x), as
/// without a network.
#[test]
fn steady_force_is_the_hybrid_force() {
    for (alpha, x_dot) in [(0.2, 0.03), (0.5, 0.03), (0.9, 0.03), (0.5, -0.03)] {
        let net = 30e3_f64.copysign(x_dot);
        let emla = physics().with_surrogate(constant_network(30e3, 0.05), alpha);
        let u = Input {
            x: 0.3,
            x_dot,
            F_hold: 26e3_f64.copysign(x_dot),
            ..Input::default()
        };
        let start = emla.output(&emla.start(&u).expect("finite"), &u);
        assert!((start.F - u.F_hold).abs() < 1e-6, "{}", start.F);
        assert!((start.F_hyb - u.F_hold).abs() < 1e-6, "{}", start.F_hyb);
        let (s, u) = steady_run(&emla, u);
        let y = emla.output(&s, &u);
        let expected = (1.0 - alpha) * y.F_phys + alpha * net;
        assert!((y.F_hyb - expected).abs() < 1e-6 * expected.abs(), "{y:?}");
        assert!(
            (y.F - y.F_hyb).abs() < 5.0,
            "α {alpha}: {} {}",
            y.F,
            y.F_hyb
        );
        assert!((y.F_net - net).abs() < 1e-6 && (y.F_phys - y.F).abs() > 400.0);
        assert!((y.x_dot_net - 0.05_f64.copysign(x_dot)).abs() < 1e-12);
        let x_dot_phys = maps::travel_per_radian(emla.params()) * y.w_m;
        let blended = x_dot_phys + alpha * (y.x_dot_net - x_dot_phys);
        assert!((y.x_dot_hyb - blended).abs() < 1e-15);
        assert!(y.in_trained_range);
    }
}

/// At α = 0 the network shows, but the motion is that of the physics, bit for bit.
#[test]
fn without_blending_the_network_only_shows() {
    let u = Input {
        x: 0.3,
        x_dot: 0.03,
        F_hold: 26e3,
        ..Input::default()
    };
    let (plain, u_plain) = steady_run(&physics(), u);
    let watched = physics().with_surrogate(constant_network(30e3, 0.05), 0.0);
    let (s, u) = steady_run(&watched, u);
    assert_eq!(
        physics().output(&plain, &u_plain).F,
        watched.output(&s, &u).F
    );
    assert_eq!(s.energy, plain.energy);
    assert_eq!(watched.output(&s, &u).F_hyb, watched.output(&s, &u).F_phys);
    assert!((watched.output(&s, &u).F_net - 30e3).abs() < 1e-6);
}

/// The residual's power counts among the losses, so the balance closes with blending too.
#[test]
fn power_balance_closes_with_blending() {
    let emla = physics().with_surrogate(constant_network(30e3, 0.05), 0.4);
    let u = Input {
        x: 0.3,
        x_dot: 0.03,
        F_hold: 26e3,
        ..Input::default()
    };
    let stored = emla.output(&emla.start(&u).expect("finite"), &u).E_stored;
    let (s, u) = steady_run(&emla, u);
    let y = emla.output(&s, &u);
    let gap = y.E_in - y.E_out - y.E_loss - (y.E_stored - stored);
    assert!(
        y.E_in > 800.0 && gap.abs() < 1e-8 * y.E_in,
        "{gap:e} of {}",
        y.E_in
    );
    assert!((0.4 * s.residual.dF * y.x_rod_dot).abs() > 10.0);
}

/// The network's use where it was not trained is told with the numbers, standstill apart, and only
/// where the network counts.
#[test]
fn use_beyond_the_training_is_named() {
    let with = |alpha: f64| {
        Emla::new(Machine::reference().emla.lift, Drive::Motion)
            .expect("reference")
            .with_surrogate(Surrogate::reference(), alpha)
    };
    let at = |i_q: f64, w_m: f64| emla::State {
        i_q,
        w_m,
        ..emla::State::default()
    };
    let ranges = *Surrogate::reference().ranges();
    let (half, beyond) = (0.5 * ranges.w_m.max, 1.1 * ranges.w_m.max);
    assert_eq!(with(0.5).untrained(&at(5.0, half)), None);
    assert_eq!(with(0.5).untrained(&at(5.0, 0.0)), None, "standstill");
    assert_eq!(
        with(0.0).untrained(&at(5.0, beyond)),
        None,
        "it does not count"
    );
    let fast = with(0.5).untrained(&at(5.0, -beyond)).expect("too fast");
    assert_eq!((fast.w_m, fast.w_m_max), (-beyond, ranges.w_m.max));
    let loaded = with(0.5)
        .untrained(&at(90.0, half))
        .expect("too much torque");
    assert!(loaded.to_string().contains("trained for"), "{loaded}");
    let slowest = at(90.0, ranges.w_m.min);
    assert!(with(0.5).untrained(&slowest).is_some(), "trained from here");
}

/// The interval is about the network's efficiency, half as wide as the bound says, by hand: factor
/// 0.1, 200 W, floor 0.2, and the network's power of 30 kN at 50 mm/s, 1500 W. Beyond the trained
/// torque it widens by the physics' power that the guard holds back. Off, it says nothing, and no
/// other output changes a bit; a network without a bound is refused.
#[test]
fn the_interval_widens_outside_the_trained_box() {
    let mut file = constant_network(30e3, 0.05).file();
    file.efficiency_bound = None;
    let unbounded = physics().with_surrogate(Surrogate::new(file.clone()).expect("valid"), 0.9);
    assert_eq!(unbounded.clone().with_interval().err(), Some(NoErrorBound));
    file.efficiency_bound = Some(EfficiencyBound {
        share: 0.9,
        factor: 0.1,
        power: 200.0,
        floor: 0.2,
        profiles: 1000,
    });
    let network = Surrogate::new(file).expect("valid");
    let off = physics().with_surrogate(network.clone(), 0.9);
    let on = off.clone().with_interval().expect("a bound");
    let (p, w_m) = (*on.params(), 100.0);
    let at = |emla: &Emla, tau_e: f64| {
        let i_q = tau_e / (1.5 * f64::from(p.p) * p.lambda_m);
        let s = State {
            i_q,
            w_m,
            residual: emla.residual(tau_e, w_m),
            ..State::default()
        };
        emla.output(&s, &Input::default())
    };
    let inside = at(&on, 25.0);
    let half = 0.1 * (200.0 + 0.2 * 1500.0) / (200.0 + 1500.0);
    let [low, high] = inside.efficiency_interval;
    assert!(inside.in_trained_range && (high - low - 2.0 * half).abs() < 1e-12);
    assert!(
        (low + half - inside.efficiency_net).abs() < 1e-12,
        "{inside:?}"
    );

    let largest = network.ranges().tau_e.max;
    let beyond = at(&on, largest + 20.0);
    let cut = maps::quasi_static_force(&p, largest + 20.0, w_m)
        - maps::quasi_static_force(&p, largest, w_m);
    let more = cut * maps::travel_per_radian(&p) * w_m / 1700.0;
    let expected = beyond.efficiency_net - half - more;
    assert!(!beyond.in_trained_range && more > 0.1);
    let low = beyond.efficiency_interval[0];
    assert!((low - expected.max(0.0)).abs() < 1e-9, "{low} {expected}");

    for tau_e in [25.0, -25.0, largest + 20.0] {
        let (with, without) = (at(&on, tau_e), at(&off, tau_e));
        assert_eq!(without.efficiency_interval, [0.0, 1.0]);
        let same = emla::Output {
            efficiency_interval: [0.0, 1.0],
            ..with
        };
        assert_eq!(same, without);
    }
}
