//! The actuator level against the actuator's own model, force-driven, at 1 ms.

use emla::{Drive, Emla, Surrogate};
use machine_file::Machine;
use vdc::{Controller, Input, Level, Mode, Settings, Trajectory};

const H: f64 = 1e-3;
/// Rod that is tested; the others stand still without load.
const ROD: usize = 1;
const X_0: f64 = 0.3;
const F_0: f64 = 21e3;

/// Stroke of 40 mm in 2 s, rest to rest: position, velocity, acceleration.
fn reference(t: f64) -> [f64; 3] {
    let w = std::f64::consts::PI;
    let (s, c) = (w * t).sin_cos();
    [X_0 + 0.02 * (1.0 - c), 0.02 * w * s, 0.02 * w * w * c]
}

/// Largest position error, m, and the last force, N, under a load that grows by `surprise`, N,
/// without the controller being told.
fn run(mode: Mode, surprise: f64) -> (f64, f64) {
    let machine = Machine::reference();
    let actuator = Emla::new(machine.emla.lift, Drive::Force).expect("valid actuator");
    let start = emla::Input {
        x: X_0,
        F_hold: F_0,
        F_ext: F_0,
        ..Default::default()
    };
    let mut state = actuator.start(&start).expect("finite");
    let settings = Settings {
        mode,
        level: Level::Actuator,
        ..Settings::from_gains(&machine.controller)
    };
    let mut controller: Option<Controller> = None;
    let (mut worst, mut force) = (0.0_f64, 0.0);
    for k in 0..2000 {
        let t = H * f64::from(k);
        let load = F_0 + surprise * (t / 0.2).min(1.0);
        let shown = actuator.output(
            &state,
            &emla::Input {
                F_ext: load,
                ..start
            },
        );
        let [x_d, v_d, a_d] = if k == 0 {
            [X_0, 0.0, 0.0]
        } else {
            reference(t)
        };
        let mut u = Input {
            zeta: machine.start.zeta,
            ..Input::default()
        };
        (u.i_d[ROD], u.i_q[ROD], u.w_m[ROD], u.F[ROD]) = (shown.i_d, shown.i_q, shown.w_m, shown.F);
        (u.x[ROD], u.x_dot[ROD]) = (shown.x_rod, shown.x_rod_dot);
        u.reference_rod_position[ROD] = x_d;
        u.reference_rod_velocity[ROD] = v_d;
        u.reference_rod_acceleration[ROD] = a_d;
        u.reference_rod_force[ROD] = F_0;
        let controller = controller.get_or_insert_with(|| {
            let network = Surrogate::reference();
            Controller::new(&machine, &network, Trajectory::Cubic, &settings, &u, 0.0)
                .expect("valid controller")
        });
        let now = controller.evaluate(&settings, &u).expect("finite");
        let y = now.output(&u.F);
        assert_eq!(
            (y.v_q[0], y.tau_wrist, y.tip_error_norm),
            (0.0, [0.0; 3], 0.0),
            "the rest stands still"
        );
        controller.step(&now, &settings, &u, t, H).expect("finite");
        let held = emla::Input {
            v_d: y.v_d[ROD],
            v_q: y.v_q[ROD],
            F_ext: load,
            ..Default::default()
        };
        state = actuator
            .step(&state, |t| held.moved(t), t, H)
            .expect("finite");
        worst = worst.max((x_d - shown.x_rod).abs());
        force = shown.F;
    }
    (worst, force)
}

/// With nominal parameters and the load known: microns. The jump of the acceleration at the start,
/// 0.2 m/s², excites the most.
#[test]
fn a_known_load_is_moved_within_microns() {
    let (worst, _) = run(Mode::Modular, 0.0);
    assert!(worst < 20e-6, "{worst:e} m");
}

/// A load 2 kN larger than told costs less than 0.3 mm, and the actuator ends up delivering it.
#[test]
fn an_unknown_load_is_carried() {
    let (worst, force) = run(Mode::Modular, 2e3);
    assert!(worst < 3e-4, "{worst:e} m");
    assert!((force - F_0 - 2e3).abs() < 50.0, "{force} N");
}

/// Without the model the rod sags, or the model would be of no use here.
#[test]
fn the_model_is_worth_having() {
    let (pd, _) = run(Mode::Pd, 0.0);
    let (modular, _) = run(Mode::Modular, 0.0);
    assert!(pd > 10.0 * modular, "{pd:e} m and {modular:e} m");
}
