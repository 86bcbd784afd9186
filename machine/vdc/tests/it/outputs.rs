//! What one evaluation says of itself: flows, errors, voltages, times, and whose measurements
//! count.

use emla::Surrogate;
use machine_file::Machine;
use motion_check::Kinematics;
use tip_path::{PathFile, TipPath};
use vdc::{Controller, Input, Level, RateLimits, Settings, Trajectory};

const H: f64 = 1e-3;

fn measured(machine: &Machine) -> Input {
    Input {
        zeta: machine.start.zeta,
        zeta_dot: [0.011, -0.007, 0.013, 0.031, -0.023, 0.017],
        i_d: [0.3, -0.2, 0.1],
        i_q: [2.0, 9.0, 8.0],
        w_m: [5.0, 40.0, 60.0],
        x_dot: [1e-3, 8e-3, 12e-3],
        F: [100.0, 41_143.0, 32_179.0],
        ..Input::default()
    }
}

fn controller(machine: &Machine, settings: &Settings, u: &Input) -> Controller {
    let network = Surrogate::reference();
    Controller::new(machine, &network, Trajectory::Cubic, settings, u, 0.0).expect("works")
}

/// The virtual power flow of each rod is `(ẋ_r − ẋ)(f_r − F)` of the very outputs and inputs.
#[test]
fn virtual_power_flows_are_made_of_outputs_and_inputs() {
    let machine = Machine::reference();
    let (settings, u) = (
        Settings::from_gains(&machine.controller),
        measured(&machine),
    );
    let controller = controller(&machine, &settings, &u);
    let y = controller.evaluate(&settings, &u).expect("finite");
    let y = y.output(&u.F);
    for i in 0..3 {
        let expected = (y.x_dot_required[i] - u.x_dot[i]) * (y.f_required[i] - u.F[i]);
        assert_eq!(y.vpf[i], expected, "rod {}", i + 1);
        assert!(expected.abs() > 1e-6, "{expected}");
    }
    // The machine stands in its start pose, where the reference rests.
    assert_eq!(y.tip_error_norm, 0.0);
}

/// The voltage law at its first evaluation, where integrals and filters have their start values,
/// from the outputs and the paper's equations: `v_d = R_s i_d + L_d di_dr − p w L_q i_q + e_d`,
/// `v_q = R_s i_q + p w (L_d i_d + λ_m) + K_f ΔF + K_v (ẋ_r − lead w/N)`.
#[test]
fn voltages_are_those_of_the_law() {
    let machine = Machine::reference();
    let (settings, u) = (
        Settings::from_gains(&machine.controller),
        measured(&machine),
    );
    let controller = controller(&machine, &settings, &u);
    let y = controller.evaluate(&settings, &u).expect("finite");
    let y = y.output(&u.F);
    let gains = &machine.controller;
    for (i, p) in machine.emla.in_order().into_iter().enumerate() {
        let (i_d, i_q, w_e) = (u.i_d[i], u.i_q[i], f64::from(p.p) * u.w_m[i]);
        let v_d = p.R_s * i_d - p.L_d * gains.lambda_i * i_d - w_e * p.L_q * i_q - gains.K_i * i_d;
        assert!((y.v_d[i] - v_d).abs() < 1e-12, "{} {v_d} V", y.v_d[i]);
        let travel = p.rho / std::f64::consts::TAU / p.N_gear;
        let per_flux = 1.5 * f64::from(p.p) / travel;
        let force_error =
            per_flux * ((p.L_d * i_d + p.lambda_m) * (y.i_q_required[i] - i_q) + p.L_q * i_q * i_d);
        let error = (y.force_error[i] - force_error).abs();
        assert!(
            error < 1e-12 * force_error.abs(),
            "{force_error} N: {error:e}"
        );
        let v_q = p.R_s * i_q
            + w_e * (p.L_d * i_d + p.lambda_m)
            + gains.K_f * y.force_error[i]
            + gains.K_v * (y.x_dot_required[i] - travel * u.w_m[i]);
        assert!((y.v_q[i] - v_q).abs() < 1e-9, "{} {v_q} V", y.v_q[i]);
    }
}

/// With the observer the measured joint rates count until the first step, and not after it.
#[test]
fn the_observer_replaces_the_measured_joint_rates() {
    let machine = Machine::reference();
    let mut settings = Settings::from_gains(&machine.controller);
    settings.gains.omega_speed = 80.0;
    let u = measured(&machine);
    let other = Input {
        zeta_dot: [0.4, 0.3, -0.2, 0.1, 0.6, -0.5],
        ..u
    };
    let mut controller = controller(&machine, &settings, &u);
    let v_q = |controller: &Controller, u: &Input| {
        let now = controller.evaluate(&settings, u).expect("finite");
        now.output(&u.F).v_q
    };
    assert_ne!(v_q(&controller, &u), v_q(&controller, &other));
    let now = controller.evaluate(&settings, &u).expect("finite");
    controller
        .step(&now, &settings, &u, 0.0, H)
        .expect("finite");
    assert_eq!(v_q(&controller, &u), v_q(&controller, &other));
    let turned = Input {
        zeta: u.zeta.map(|zeta| zeta + 1e-4),
        ..u
    };
    assert_ne!(v_q(&controller, &u), v_q(&controller, &turned));
}

/// The end of the motion counts from the start, after the rest that comes first; an external
/// reference has none.
#[test]
fn the_end_of_the_motion_is_told() {
    let machine = Machine::reference();
    let (settings, u) = (
        Settings::from_gains(&machine.controller),
        measured(&machine),
    );
    let network = Surrogate::reference();
    let end = |trajectory, settings: &Settings| {
        let start = 40.0;
        let controller = Controller::new(&machine, &network, trajectory, settings, &u, start);
        let now = controller.expect("works").evaluate(settings, &u);
        now.expect("finite").output(&u.F).motion_end
    };
    let settle = machine.controller.settle_time;
    assert!(settle > 0.0);
    let cubic = 40.0 + settle + 9.0 * 2.25;
    assert!((end(Trajectory::Cubic, &settings) - cubic).abs() < 1e-12);
    assert_eq!(
        end(Trajectory::Rates(RateLimits::default()), &settings),
        40.0
    );
    let alone = Settings {
        level: Level::Actuator,
        ..settings
    };
    assert_eq!(end(Trajectory::Cubic, &alone), 40.0);
}

/// Turned about its last axis by an angle the tip's orientation is off by that angle, large or
/// small.
#[test]
fn the_orientation_error_is_an_angle() {
    let machine = Machine::reference();
    let (settings, u) = (
        Settings::from_gains(&machine.controller),
        measured(&machine),
    );
    let controller = controller(&machine, &settings, &u);
    for angle in [1e-3, 0.3, -1.2] {
        let mut turned = u;
        turned.zeta[5] += angle;
        let y = controller.evaluate(&settings, &turned).expect("finite");
        let found = y.output(&u.F).orientation_error_norm;
        assert!(
            (found - angle.abs()).abs() < 1e-12,
            "{found} for {angle} rad"
        );
    }
}

/// At the start nothing is unexplained, at whatever speed the motors turn: the disturbance observer
/// asks for no current.
#[test]
fn the_disturbance_observer_begins_with_nothing() {
    let machine = Machine::reference();
    let (settings, u) = (
        Settings::from_gains(&machine.controller),
        measured(&machine),
    );
    let mut without = settings;
    without.gains.omega_d = 0.0;
    assert!(settings.gains.omega_d > 0.0);
    let i_q = |settings: &Settings| {
        let controller = controller(&machine, settings, &u);
        let now = controller.evaluate(settings, &u).expect("finite");
        now.output(&u.F).i_q_required
    };
    assert_eq!(i_q(&settings), i_q(&without));
}

/// A path of a file is the reference from the end of the first rest on, from where the tip stood;
/// its end is told.
#[test]
fn the_reference_is_the_path_of_the_file() {
    let mut machine = Machine::reference();
    machine.controller.settle_time = 1.0;
    let (settings, u) = (
        Settings::from_gains(&machine.controller),
        measured(&machine),
    );
    let text = r#"{"relative": true, "limits": {"speed": 0.1, "acceleration": 0.2, "jerk": 1.0},
        "waypoints": [{"position": [0, 0, 0]}, {"position": [0.05, 0.1, -0.1], "dwell": 0.5}]}"#;
    let file = PathFile::parse(text).expect("valid");
    let start = Kinematics::new(&machine).expect("works").pose(&u.zeta);
    let path = TipPath::new(&file, start).expect("valid");
    let network = Surrogate::reference();
    let t_start = 3.0;
    let trajectory = Trajectory::Path {
        file: &file,
        is_checked: true,
    };
    let mut controller = Controller::new(&machine, &network, trajectory, &settings, &u, t_start)
        .expect("the machine can do it");
    let settle = machine.controller.settle_time;
    let mut largest = 0.0_f64;
    for k in 0..80 {
        let t = t_start + 0.05 * f64::from(k);
        let now = controller.evaluate(&settings, &u).expect("finite");
        let y = now.output(&u.F);
        let expected = path.at(t - t_start - settle).pose;
        for (found, expected) in y.desired_position.iter().zip(&expected.position) {
            assert!((found - expected).abs() < 1e-12, "{t}: {found} {expected}");
        }
        let end = t_start + settle + path.duration();
        assert!((y.motion_end - end).abs() < 1e-12);
        largest = largest.max(y.tip_error_norm);
        controller
            .step(&now, &settings, &u, t, 0.05)
            .expect("finite");
    }
    assert!((largest - 0.15).abs() < 1e-6, "the tip stands: {largest} m");
}
