//! The controller on the plants' own models, coupled as a co-simulation master would: staged
//! (Gauss–Seidel: measurements reach the commands at once, actuators step first, the manipulator
//! gets their mean force), or by the standard alone (all outputs are read, then all inputs set,
//! then all step).

use emla::{Drive, Emla, Surrogate};
use hdrm::{Hdrm, Options, State};
use machine_file::{Machine, PerAxis};
use std::collections::VecDeque;
use vdc::{Controller, Input, Mode, Output, Settings, Timing, Trajectory};

/// What differs from the nominal case.
pub struct Case {
    /// Of the controller; plant and actuators follow it but for what is below.
    pub machine: Machine,
    pub mode: Mode,
    /// Integral of the tip's error.
    pub integral: bool,
    pub inertia_scale: f64,
    /// Of the plant.
    pub actuators: PerAxis<machine_file::Emla>,
    /// What the controller takes them for.
    pub nominal: PerAxis<machine_file::Emla>,
    /// (ω_i, ω_d); zero is the paper's law.
    pub extensions: [f64; 2],
    /// Blending in the plant and as the controller knows it.
    pub alpha: [f64; 2],
    pub trajectory: Trajectory<'static>,
    pub schedule: Schedule,
    pub timing: Timing,
    /// Communication step, s.
    pub h: f64,
}

/// How the parts exchange values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Schedule {
    Staged,
    Standard,
}

impl Case {
    pub fn nominal() -> Self {
        let machine = machine();
        Self {
            machine: machine.clone(),
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

    /// Exchange by the standard alone, with the actuators told that forces act one step late, and
    /// the controller that commands act `delay` steps late; beyond one, a channel delays the
    /// commands.
    pub fn standard(delay: u32, h: f64) -> Self {
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
pub fn machine() -> Machine {
    let mut machine = Machine::reference();
    machine.controller.settle_time = 1.0;
    machine
}

/// Manipulator, three actuators, controller.
pub struct Loop {
    pub plant: Hdrm,
    pub state: State,
    pub actuators: [Emla; 3],
    pub drives: [emla::State; 3],
    pub settings: Settings,
    pub controller: Controller,
    /// Inputs of controller and rods as they were last set.
    pub set: (Input, [emla::Input; 3]),
    /// Commanded rates of the joints and of the tip.
    pub rates: [[f64; 6]; 2],
    /// How the base moves (what else it holds does not count), and whether the controller is told.
    pub base: (hdrm::Input, bool),
    /// Outputs of the controller at the start of the last step.
    pub last: Output,
    /// Commands on their way to the machine, the oldest first.
    pub channel: VecDeque<Output>,
}

impl Loop {
    pub fn new(case: &Case) -> Self {
        let mut machine = case.machine.clone();
        [machine.controller.omega_i, machine.controller.omega_d] = case.extensions;
        machine.emla = case.nominal;
        let options = Options {
            inertia_scale: case.inertia_scale,
            ..Options::from_machine(&machine)
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
            alpha: case.alpha[1],
            true_inertia_scale: case.inertia_scale,
            ..Settings::from_gains(&machine.controller)
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
            rates: [[0.0; 6]; 2],
            base: (hdrm::Input::default(), false),
            last: Output::default(),
        }
    }

    /// One communication step; the tip error at its start, m.
    pub fn step(&mut self, schedule: Schedule, t: f64, h: f64) -> f64 {
        let (mut measured, rods) = measure(&self.plant, &self.state, &self.actuators, &self.drives);
        if schedule == Schedule::Standard && t > 0.0 {
            // The actuators have not been told yet where the rods are now.
            let u = |i: usize| self.set.1[i].moved(h);
            measured.F =
                std::array::from_fn(|i| self.actuators[i].output(&self.drives[i], &u(i)).F);
        }
        let channel = self.controller.timing().delay.saturating_sub(1);
        [measured.rate_joint, measured.rate_tip] = self.rates;
        let (base, is_told) = self.base;
        if is_told {
            measured.base_tilt = base.base_tilt;
            measured.base_acceleration = base.base_acceleration;
            measured.base_angular_velocity = base.base_angular_velocity;
            measured.base_angular_acceleration = base.base_angular_acceleration;
        }
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
        self.last = command;
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
            ..base
        };
        self.state = self
            .plant
            .step(&self.state, |_| input, t, h)
            .expect("finite");
        e_x.hypot(e_y).hypot(e_z)
    }
}

pub fn measure(
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
