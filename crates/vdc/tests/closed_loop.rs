//! The controller on the plants' own models, coupled at 1 ms as a co-simulation master would: staged (Gauss–Seidel: measurements reach
//! the commands at once, actuators step first, the manipulator gets their mean force), or by the standard alone (all
//! outputs are read, then all inputs set, then all step).
//!
//! Not an oracle for the plants (they have their own); it shows what the control law does.
#![allow(non_snake_case)]

use emla::{Drive, Emla, Surrogate};
use hdrm::{Hdrm, Options, State};
use machine::{Machine, PerAxis};
use std::collections::VecDeque;
use vdc::{Controller, Input, Level, Mode, Output, Settings, Timing, Trajectory};

/// What differs from the nominal case.
struct Case {
    mode: Mode,
    /// Integral of the tip's error.
    integral: bool,
    inertia_scale: f64,
    /// Of the plant.
    /// Of the plant.
    actuators: PerAxis<machine::Emla>,
    /// What the controller takes them for.
    nominal: PerAxis<machine::Emla>,
    /// (ω_i, ω_d); zero is the paper's law.
    extensions: [f64; 2],
    /// Blending in the plant and as the controller knows it.
    alpha: [f64; 2],
    trajectory: Trajectory,
    schedule: Schedule,
    timing: Timing,
    /// Communication step, s.
    h: f64,
}

/// How the parts exchange values.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Schedule {
    Staged,
    Standard,
}

impl Case {
    fn nominal() -> Self {
        let machine = machine();
        Self {
            mode: Mode::Adaptive,
            integral: false,
            inertia_scale: 1.0,
            actuators: machine.emla,
            nominal: machine.emla,
            extensions: [machine.controller.omega_i, machine.controller.omega_d],
            alpha: [0.0; 2],
            trajectory: Trajectory::Triangular,
            schedule: Schedule::Staged,
            timing: Timing::default(),
            h: 1e-3,
        }
    }

    /// Exchange by the standard alone, with the actuators told that forces act one step late, and the controller that commands act
    /// `delay` steps late; beyond one, a channel delays the commands.
    fn standard(delay: u32, h: f64) -> Self {
        Self {
            schedule: Schedule::Standard,
            timing: Timing {
                delay,
                ..Timing::default()
            },
            h,
            ..Self::nominal()
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
    actuators: [Emla; 3],
    drives: [emla::State; 3],
    settings: Settings,
    controller: Controller,
    /// Inputs of controller and rods as they were last set.
    set: (Input, [emla::Input; 3]),
    /// Commands on their way to the machine, the oldest first.
    channel: VecDeque<Output>,
}

impl Loop {
    fn new(case: &Case) -> Self {
        let mut machine = machine();
        [machine.controller.omega_i, machine.controller.omega_d] = case.extensions;
        machine.emla = case.nominal;
        let options = Options {
            inertia_scale: case.inertia_scale,
            ..Options::of(&machine)
        };
        let plant = Hdrm::new(&machine, &options).expect("valid machine");
        let state = State {
            zeta: machine.start.zeta,
            zeta_dot: [0.0; 6],
            ..State::default()
        };
        let network = Surrogate::reference();
        let actuators = case.actuators.in_order().map(|p| {
            Emla::new(*p, Drive::Motion)
                .expect("valid actuator")
                .with_surrogate(network.clone(), case.alpha[0])
                .with_delay(case.timing.delay.min(1))
        });
        let at_rest = plant.output(&state, &hdrm::Input::default());
        let drives = std::array::from_fn(|i| {
            let start = emla::Input {
                x: at_rest.x[i],
                F_hold: at_rest.f_hold[i],
                ..Default::default()
            };
            actuators[i].start(&start).expect("finite")
        });
        let settings = Settings {
            mode: case.mode,
            integral: case.integral,
            level: Level::Machine,
            gains: machine.controller,
            alpha: case.alpha[1],
            true_inertia_scale: case.inertia_scale,
            derating: None,
        };
        let set = measure(&plant, &state, &actuators, &drives);
        let controller =
            Controller::new(&machine, &network, case.trajectory, &settings, &set.0, 0.0)
                .expect("valid controller")
                .with_timing(case.timing);
        Self {
            plant,
            state,
            actuators,
            drives,
            settings,
            controller,
            set,
            channel: VecDeque::new(),
        }
    }

    /// One communication step; the tip error at its start, m.
    fn step(&mut self, schedule: Schedule, t: f64, h: f64) -> f64 {
        let (mut measured, rods) = measure(&self.plant, &self.state, &self.actuators, &self.drives);
        if schedule == Schedule::Standard && t > 0.0 {
            // The actuators have not been told yet where the rods are now.
            let u = |i: usize| self.set.1[i].moved(h);
            measured.F =
                std::array::from_fn(|i| self.actuators[i].output(&self.drives[i], &u(i)).F);
        }
        let channel = self.controller.timing().delay.saturating_sub(1);
        let (controller, settings) = (&mut self.controller, &self.settings);
        let fresh = controller.evaluate(settings, &measured).expect("finite");
        let command = match schedule {
            Schedule::Staged => fresh.output(&measured.F),
            Schedule::Standard => {
                let old = controller.evaluate(settings, &self.set.0).expect("finite");
                old.output(&self.set.0.F)
            }
        };
        controller
            .step(&fresh, settings, &measured, t, h)
            .expect("finite");
        self.set = (measured, rods);
        self.channel.push_back(command);
        let command = if self.channel.len() > channel as usize {
            self.channel.pop_front().expect("just pushed")
        } else {
            command
        };
        let y = self.plant.output(&self.state, &hdrm::Input::default());
        let error = std::array::from_fn(|i| command.desired_position[i] - y.tip_position[i]);
        let [e_x, e_y, e_z]: [f64; 3] = error;
        let mut f = [0.0; 3];
        for i in 0..3 {
            let u = emla::Input {
                v_d: command.v_d[i],
                v_q: command.v_q[i],
                ..rods[i]
            };
            self.drives[i] = self.actuators[i]
                .step(&self.drives[i], |s| u.moved(s), t, h)
                .expect("finite");
            f[i] = match schedule {
                Schedule::Staged => self.drives[i].F_mean,
                Schedule::Standard => measured.F[i],
            };
        }
        let input = hdrm::Input {
            f,
            tau_wrist: command.tau_wrist,
            wrench_env: [0.0; 6],
            ..hdrm::Input::default()
        };
        self.state = self
            .plant
            .step(&self.state, |_| input, t, h)
            .expect("finite");
        e_x.hypot(e_y).hypot(e_z)
    }
}

fn measure(
    plant: &Hdrm,
    state: &State,
    actuators: &[Emla; 3],
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
        F: std::array::from_fn(|i| actuators[i].output(&drives[i], &rods[i]).F),
        ..Input::default()
    };
    (input, rods)
}

/// Tip RMSE over the first edge of the triangle, mm.
fn rmse(case: &Case) -> f64 {
    let mut machine = Loop::new(case);
    let (mut sum, mut count) = (0.0, 0.0);
    let (settle, end) = (1.0, 4.25);
    for k in 0..(end / case.h) as u32 {
        let t = f64::from(k) * case.h;
        let error = machine.step(case.schedule, t, case.h);
        if t >= settle {
            (sum, count) = (sum + error * error, count + 1.0);
        }
    }
    1e3 * (sum / count).sqrt()
}

/// Holding the start pose is what an independent prototype of the machine found:
/// f = [0, 41143, 32179] N, tau = [−90.2, 147.2, 0] N·m, i_q = [0, 15.34, 12.00] A.
#[test]
fn the_start_is_in_equilibrium() {
    let start = Loop::new(&Case::nominal());
    let (measured, _) = measure(&start.plant, &start.state, &start.actuators, &start.drives);
    let now = start.controller.evaluate(&start.settings, &measured);
    let y = now.expect("finite").output(&measured.F);
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

/// What stands constant beside the reference, an integral removes; gravity compensation removes it only as far as the machine is nominal.
#[test]
fn an_integral_takes_the_sag_of_the_rivals() {
    let run = |mode, integral| {
        rmse(&Case {
            mode,
            integral,
            inertia_scale: 1.4,
            ..Case::nominal()
        })
    };
    let [modular, pd_gravity, pd] = [Mode::Modular, Mode::PdGravity, Mode::Pd].map(|mode| {
        let [without, with] = [run(mode, false), run(mode, true)];
        println!("{mode:?} at inertia x 1.4: {without:.3} mm, with integral {with:.3} mm");
        assert!(with < 0.25 * without, "{mode:?}: {with} vs {without} mm");
        without
    });
    assert!(pd_gravity < 0.5 * pd, "{pd_gravity} vs {pd} mm");
    assert!(modular < 1.1 * pd_gravity, "{modular} vs {pd_gravity} mm");
}

/// What the integral part and the observer are for: motor parameters other than nominal.
#[test]
fn the_extensions_take_up_wrong_motor_parameters() {
    let machine = machine();
    let actuators = PerAxis::all(machine::Emla {
        lambda_m: 0.6 * machine.emla.lift.lambda_m,
        eta_gear: 0.6 * machine.emla.lift.eta_gear,
        ..machine.emla.lift
    });
    let extended = rmse(&Case {
        actuators,
        ..Case::nominal()
    });
    let paper = rmse(&Case {
        actuators,
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

/// With the exchange of the standard, commands and forces act one step later than measured. Controller and actuators that are told
/// predict over that step. Forces held for 2 ms without prediction destabilize the coupling itself (C_b < K_b·h/2).
#[test]
fn told_of_the_delay_the_machine_tracks_with_the_standard_exchange() {
    for trajectory in [Trajectory::Triangular, Trajectory::Cubic] {
        let of = |delay, h| {
            rmse(&Case {
                trajectory,
                ..Case::standard(delay, h)
            })
        };
        let [untold, told, told_2] = [of(0, 1e-3), of(1, 1e-3), of(1, 2e-3)];
        println!("{trajectory:?}: untold {untold:.4}, told {told:.4}, at 2 ms {told_2:.4} mm");
        assert!(untold > 10.0 * told, "{untold} and {told} mm");
        assert!(told < 0.005, "{told} mm");
        assert!(told_2 < 0.006, "{told_2} mm");
    }
}

/// A channel that delays the commands by another step is predicted over as well.
#[test]
fn two_steps_of_delay_are_predicted_over() {
    let told = rmse(&Case::standard(2, 1e-3));
    println!("two steps: {told:.4} mm");
    assert!(told < 0.02, "{told} mm");
}

/// What the controller does not know of the machine it predicts wrongly, but no worse than it controls it.
#[test]
fn the_prediction_stands_another_inertia() {
    for inertia_scale in [0.6, 1.4] {
        let [staged, told] = [Case::nominal(), Case::standard(1, 1e-3)].map(|case| {
            rmse(&Case {
                inertia_scale,
                ..case
            })
        });
        println!("x{inertia_scale}: staged {staged:.4}, standard {told:.4} mm");
        assert!((told / staged - 1.0).abs() < 0.1, "{told} and {staged} mm");
    }
}

/// At rest, where friction locks the motors, the boom swings on the screw's spring; at 2 ms this is what the force's staleness excites
/// first. After the motion has ended the tip error dies away.
#[test]
fn the_machine_rests_at_twice_the_step_with_the_standard_exchange() {
    let case = Case::standard(1, 2e-3);
    let mut machine = Loop::new(&case);
    let mut worst = [0.0_f64; 2];
    for k in 0..8000 {
        let t = f64::from(k) * case.h;
        let error = 1e3 * machine.step(case.schedule, t, case.h);
        let last_second = usize::from(t >= 15.0);
        worst[last_second] = worst[last_second].max(error);
    }
    println!("largest error {:.4}, at rest {:.5} mm", worst[0], worst[1]);
    assert!(worst[0] < 0.02 && worst[1] < 1e-3, "{worst:?} mm");
}

/// The machine whose actuators are sized each for its axis, with the same gains, on both trajectories (the cube's edges move the slew): tracked as
/// the reference machine is, by a controller that knows them. One that takes them for the reference machine's is worse, so the plant does
/// have others.
#[test]
fn actuators_sized_for_their_axes_are_tracked() {
    let emla = Machine::from_json(machine::SIZED_JSON).expect("valid").emla;
    for trajectory in [Trajectory::Triangular, Trajectory::Cubic] {
        let reference = Case {
            trajectory,
            ..Case::nominal()
        };
        let mistaken = Case {
            actuators: emla,
            trajectory,
            ..Case::nominal()
        };
        let sized = Case {
            actuators: emla,
            nominal: emla,
            trajectory,
            ..Case::nominal()
        };
        let [reference, mistaken, sized] = [reference, mistaken, sized].map(|case| rmse(&case));
        println!("{trajectory:?}: {reference}, {mistaken}, {sized} mm");
        assert!(sized < 1.5 * reference, "{sized} mm, {reference} mm");
        assert!(mistaken > 1.05 * sized, "{mistaken} mm, {sized} mm");
    }
}
