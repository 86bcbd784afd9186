//! The controller on the plants' own models, coupled at 1 ms as a co-simulation master would
//! (Gauss–Seidel: actuators first, the manipulator gets their mean force).
//!
//! Not an oracle for the plants (they have their own); it shows what the control law does.
#![allow(non_snake_case)]

use emla::{Drive, Emla, Surrogate};
use hdrm::{Hdrm, Options, State};
use machine::Machine;
use vdc::{Controller, Input, Level, Mode, Settings, Trajectory};

/// What differs from the nominal case.
struct Case {
    mode: Mode,
    inertia_scale: f64,
    /// Of the plant.
    actuator: machine::Emla,
    /// (ω_i, ω_d); zero is the paper's law.
    extensions: [f64; 2],
    /// Blending in the plant and as the controller knows it.
    alpha: [f64; 2],
}

impl Case {
    fn nominal() -> Self {
        let machine = machine();
        Self {
            mode: Mode::Adaptive,
            inertia_scale: 1.0,
            actuator: machine.emla,
            extensions: [machine.controller.omega_i, machine.controller.omega_d],
            alpha: [0.0; 2],
        }
    }
}

/// The reference machine with a short rest before its motion.
fn machine() -> Machine {
    let mut machine = Machine::reference();
    machine.controller.settle_time = 1.0;
    machine
}

/// Manipulator, three actuators, controller.
struct Loop {
    plant: Hdrm,
    state: State,
    actuator: Emla,
    drives: [emla::State; 3],
    settings: Settings,
    controller: Controller,
}

impl Loop {
    fn new(case: &Case) -> Self {
        let mut machine = machine();
        [machine.controller.omega_i, machine.controller.omega_d] = case.extensions;
        let options = Options {
            inertia_scale: case.inertia_scale,
            ..Options::of(&machine)
        };
        let plant = Hdrm::new(&machine, &options).expect("valid machine");
        let state = State {
            zeta: machine.start.zeta,
            zeta_dot: [0.0; 6],
        };
        let network = Surrogate::reference();
        let actuator = Emla::new(case.actuator, Drive::Motion)
            .expect("valid actuator")
            .with_surrogate(network.clone(), case.alpha[0]);
        let at_rest = plant.output(&state, &hdrm::Input::default());
        let drives = std::array::from_fn(|i| {
            let start = emla::Input {
                x: at_rest.x[i],
                F_hold: at_rest.f_hold[i],
                ..Default::default()
            };
            actuator.start(&start).expect("finite")
        });
        let settings = Settings {
            mode: case.mode,
            level: Level::Machine,
            gains: machine.controller,
            alpha: case.alpha[1],
            true_inertia_scale: case.inertia_scale,
        };
        let (measured, _) = measure(&plant, &state, &actuator, &drives);
        let controller = Controller::new(
            &machine,
            &network,
            Trajectory::Triangular,
            &settings,
            &measured,
            0.0,
        )
        .expect("valid controller");
        Self {
            plant,
            state,
            actuator,
            drives,
            settings,
            controller,
        }
    }

    /// One communication step; the tip error at its start, m.
    fn step(&mut self, t: f64, h: f64) -> f64 {
        let (measured, rods) = measure(&self.plant, &self.state, &self.actuator, &self.drives);
        let command = self
            .controller
            .output(&self.settings, &measured)
            .expect("finite");
        self.controller
            .step(&self.settings, &measured, t, h)
            .expect("finite");
        let mut f = [0.0; 3];
        for i in 0..3 {
            let u = emla::Input {
                v_d: command.v_d[i],
                v_q: command.v_q[i],
                ..rods[i]
            };
            self.drives[i] = self
                .actuator
                .step(&self.drives[i], |s| u.moved(s), t, h)
                .expect("finite");
            f[i] = self.drives[i].F_mean;
        }
        let input = hdrm::Input {
            f,
            tau_wrist: command.tau_wrist,
            wrench_env: [0.0; 6],
        };
        self.state = self
            .plant
            .step(&self.state, |_| input, t, h)
            .expect("finite");
        command.tip_error_norm
    }
}

fn measure(
    plant: &Hdrm,
    state: &State,
    actuator: &Emla,
    drives: &[emla::State; 3],
) -> (Input, [emla::Input; 3]) {
    let y = plant.output(state, &hdrm::Input::default());
    let rods = std::array::from_fn(|i| emla::Input {
        x: y.x[i],
        x_dot: y.x_dot[i],
        ..Default::default()
    });
    let input = Input {
        zeta: y.zeta,
        zeta_dot: y.zeta_dot,
        i_d: drives.map(|s| s.i_d),
        i_q: drives.map(|s| s.i_q),
        w_m: drives.map(|s| s.w_m),
        x_dot: y.x_dot,
        F: std::array::from_fn(|i| actuator.output(&drives[i], &rods[i]).F),
        ..Input::default()
    };
    (input, rods)
}

/// Tip RMSE over the first edge of the triangle, mm.
fn rmse(case: &Case) -> f64 {
    let h = 1e-3;
    let mut machine = Loop::new(case);
    let mut sum = 0.0;
    let (settle, end) = (1000, 4250);
    for k in 0..end {
        let error = machine.step(f64::from(k) * h, h);
        if k >= settle {
            sum += error * error;
        }
    }
    1e3 * (sum / f64::from(end - settle)).sqrt()
}

/// Holding the start pose is what an independent prototype of the machine found:
/// f = [0, 41143, 32179] N, tau = [−90.2, 147.2, 0] N·m, i_q = [0, 15.34, 12.00] A.
#[test]
fn the_start_is_in_equilibrium() {
    let start = Loop::new(&Case::nominal());
    let (measured, _) = measure(&start.plant, &start.state, &start.actuator, &start.drives);
    let y = start
        .controller
        .output(&start.settings, &measured)
        .expect("finite");
    let near = |found: [f64; 3], expected: [f64; 3], tolerance: f64| {
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() < tolerance,
                "{found} vs {expected}"
            );
        }
    };
    // Tolerances: the last digit given.
    near(y.f_required, [0.0, 41_143.0, 32_179.0], 1.0);
    near(y.tau_wrist, [-90.2, 147.2, 0.0], 0.06);
    near(y.i_q_required, [0.0, 15.34, 12.00], 0.006);
    near(measured.i_q, [0.0, 15.34, 12.00], 0.006);
    assert!(y.tip_error_norm < 1e-12);
}

#[test]
fn nominal_tracking_is_microns() {
    let error = rmse(&Case::nominal());
    println!("nominal {error:.4} mm");
    assert!(error < 0.02, "{error} mm");
}

#[test]
fn adaptation_beats_the_model_and_the_model_beats_damping() {
    for inertia_scale in [0.6, 1.4] {
        let [adaptive, modular, pd] = [Mode::Adaptive, Mode::Modular, Mode::Pd].map(|mode| {
            rmse(&Case {
                mode,
                inertia_scale,
                ..Case::nominal()
            })
        });
        println!("x{inertia_scale}: adaptive {adaptive:.4}, modular {modular:.4}, pd {pd:.4} mm");
        assert!(adaptive < 0.3, "{adaptive} mm so soon after the start");
        assert!(
            adaptive < 0.2 * modular && modular < pd,
            "{adaptive}, {modular}, {pd} mm"
        );
    }
}

/// What the integral part and the observer are for: motor parameters other than nominal.
#[test]
fn the_extensions_take_up_wrong_motor_parameters() {
    let machine = machine();
    let actuator = machine::Emla {
        lambda_m: 0.6 * machine.emla.lambda_m,
        eta_gear: 0.6 * machine.emla.eta_gear,
        ..machine.emla
    };
    let extended = rmse(&Case {
        actuator,
        ..Case::nominal()
    });
    let paper = rmse(&Case {
        actuator,
        extensions: [0.0; 2],
        ..Case::nominal()
    });
    println!("lambda_m, eta_gear x0.6: extended {extended:.4}, paper's law {paper:.4} mm");
    assert!(extended < 0.5, "{extended} mm");
    assert!(paper > 4.0 * extended, "{paper} vs {extended} mm");
}

#[test]
fn hybrid_actuators_are_tracked_known_or_not() {
    for (alpha, limit) in [([0.2, 0.2], 0.15), ([0.9, 0.9], 0.15), ([0.2, 0.0], 0.3)] {
        let error = rmse(&Case {
            alpha,
            ..Case::nominal()
        });
        println!("alpha {alpha:?}: {error:.4} mm");
        assert!(error < limit, "alpha {alpha:?}: {error} mm");
    }
}

/// At zeta_5 = 0 the Jacobian is singular; the damped inverse keeps the commands finite.
#[test]
fn the_wrist_singularity_is_passed() {
    let start = Loop::new(&Case::nominal());
    let (mut measured, _) = measure(&start.plant, &start.state, &start.actuator, &start.drives);
    measured.zeta_dot = [0.1, -0.2, 0.15, 0.3, 0.5, -0.4];
    for zeta_5 in [-0.06, -0.03, -1e-9, 0.0, 1e-9, 0.03, 0.06] {
        measured.zeta[4] = zeta_5;
        let y = start
            .controller
            .output(&start.settings, &measured)
            .expect("finite");
        assert!(
            y.v_q.iter().chain(&y.f_required).all(|v| v.is_finite()),
            "zeta_5 = {zeta_5}"
        );
    }
}
