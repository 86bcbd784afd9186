//! Commanded rates on the plants' own models: a joystick's half minute, ends of ranges, the elbow,
//! and loads told to the controller.

use crate::coupled::{Case, Loop, Schedule, machine};
use hdrm::Load;
use machine_file::Machine;
use vdc::{Mode, Output, RateCommand, RateLimits, ReportedWarnings, Trajectory, Warning};

const H: f64 = 1e-3;

fn case(machine: Machine, mode: Mode) -> Case {
    Case {
        machine,
        mode,
        trajectory: Trajectory::Rates(RateLimits::default()),
        ..Case::nominal()
    }
}

/// A run in which the operator's hand is a function of time, step and machine.
struct Run {
    machine: Loop,
    k: u32,
    told: ReportedWarnings,
    warnings: Vec<Warning>,
}

impl Run {
    fn new(case: &Case) -> Self {
        Self {
            machine: Loop::new(case),
            k: 0,
            told: ReportedWarnings::default(),
            warnings: Vec::new(),
        }
    }

    fn t(&self) -> f64 {
        f64::from(self.k) * H
    }

    fn zeta(&self) -> [f64; 6] {
        self.machine.state.zeta
    }

    /// `seconds` with these commands of joints or tip; `see` gets the tip's error, m, and the
    /// outputs of each step.
    fn hold(
        &mut self,
        seconds: f64,
        command: RateCommand,
        rates: [f64; 6],
        mut see: impl FnMut(&Self, f64, &Output),
    ) {
        self.machine.settings.rate_command = command;
        self.machine.rates = match command {
            RateCommand::Joint => [rates, [0.0; 6]],
            RateCommand::Tip => [[0.0; 6], rates],
        };
        for _ in 0..(seconds / H) as u32 {
            let t = self.t();
            let error = self.machine.step(Schedule::Staged, t, H);
            let Loop {
                controller,
                settings,
                set,
                ..
            } = &self.machine;
            let now = controller.evaluate(settings, &set.0).expect("finite");
            self.warnings
                .extend(controller.next_warning(&now, settings, &mut self.told, t, H));
            self.k += 1;
            let last = self.machine.last;
            see(self, error, &last);
        }
    }
}

/// Half a minute with a hand that pulls all levers, of the joints and of the tip, often beyond what
/// is allowed: everything is finite, the reference keeps its rates, and the machine follows it as
/// it follows a path.
#[test]
fn half_a_minute_of_joystick_is_followed() {
    let mut run = Run::new(&case(machine(), Mode::Adaptive));
    let (mut worst, mut fastest, mut travel) = (0.0_f64, [0.0_f64; 6], 0.0);
    let (mut before, mut hardest) = ([0.0; 6], [0.0_f64; 6]);
    let limits = RateLimits::default();
    for k in 0..60_u32 {
        // For ten seconds mostly one way, then mostly the other.
        let drift = if k % 40 < 20 { 0.7 } else { -0.7 };
        let lever = |j: u32, size: f64| size * (drift + (2.3 * f64::from(7 * k + 3 * j)).sin());
        let is_tip = k % 4 > 1;
        let (command, rates) = if is_tip {
            let sizes = [0.4, 0.4, 0.4, 0.2, 0.2, 0.2];
            (
                RateCommand::Tip,
                std::array::from_fn(|j| lever(j as u32, sizes[j])),
            )
        } else {
            let sizes = [0.2, 0.15, 0.15, 0.6, 0.6, 0.6];
            (
                RateCommand::Joint,
                std::array::from_fn(|j| lever(j as u32, sizes[j])),
            )
        };
        run.hold(0.5, command, rates, |run, error, y| {
            assert!(y.v_q.iter().chain(&y.tau_wrist).all(|x| x.is_finite()));
            worst = worst.max(error);
            let rates = run.machine.state.zeta_dot.map(f64::abs);
            fastest = std::array::from_fn(|i| fastest[i].max(rates[i]));
            let now = run.machine.state.zeta_dot;
            hardest = std::array::from_fn(|i| hardest[i].max(((now[i] - before[i]) / H).abs()));
            before = now;
            travel += H * run.machine.state.zeta_dot[1].abs();
        });
    }
    println!(
        "largest error {:.3} mm, fastest joints {fastest:.4?} rad/s, largest accelerations {hardest:.3?} rad/s², {:?}",
        1e3 * worst,
        run.warnings
    );
    // A command that turns right before the end of a range is cut off there.
    assert!(worst < 2e-3, "{worst} m");
    for (i, fastest) in fastest.into_iter().enumerate() {
        assert!(
            fastest < 1.01 * limits.joint[i],
            "joint {}: {}",
            i + 1,
            fastest
        );
    }
    assert!(travel > 0.5, "{travel} rad");
    let held = |t: &&Warning| matches!(t, Warning::JointHeld { .. });
    assert!(
        run.warnings.iter().filter(held).count() > 1,
        "ends are reached"
    );
}

/// Each of the six joints is led to both ends of its range, with more than is allowed: it stops
/// there without swinging over by more than 0.1 mrad, 1 % of the margin to the end stop, says so
/// once, and comes back.
#[test]
fn joints_are_held_at_the_ends_of_their_ranges() {
    let margin = 0.01;
    let mut reference = machine();
    reference.ratings.tilt.force_max = 150e3; // holds the machine everywhere
    let ranges = reference.limits.zeta();
    for (joint, sign) in (0..6).flat_map(|joint| [(joint, -1.0), (joint, 1.0)]) {
        let mut run = Run::new(&case(reference.clone(), Mode::Adaptive));
        let mut rates = [0.0; 6];
        rates[joint] = sign * 2.0;
        let way = (ranges[joint][usize::from(sign > 0.0)] - run.zeta()[joint]).abs();
        let seconds = way / RateLimits::default().joint[joint] + 6.0;
        let mut farthest = f64::NEG_INFINITY;
        run.hold(seconds, RateCommand::Joint, rates, |run, _, _| {
            farthest = farthest.max(sign * run.zeta()[joint]);
        });
        let held = sign * run.zeta()[joint];
        let end = sign * ranges[joint][usize::from(sign > 0.0)];
        println!(
            "joint {}: held {:.5} rad before its end, swung over {:.2e} rad",
            joint + 1,
            end - held,
            farthest - held
        );
        // Strokes may end first.
        assert!(
            end - held >= margin - 1e-4 && end - held < 0.3,
            "{held} {end}"
        );
        assert!(farthest - held < 1e-4, "{farthest} {held}");
        assert!(run.machine.state.zeta_dot[joint].abs() < 1e-3);
        let text: Vec<String> = run.warnings.iter().map(ToString::to_string).collect();
        assert_eq!(text.len(), 1, "{text:?}");
        assert!(
            text[0].contains(&format!("joint {}", joint + 1)),
            "{text:?}"
        );
        rates[joint] = -sign * 0.05;
        run.hold(3.0, RateCommand::Joint, rates, |_, _, _| ());
        assert!(held - sign * run.zeta()[joint] > 0.08, "it comes back");
    }
}

/// The tip goes straight where it is told, in the world, and is held where a joint ends.
#[test]
fn the_tip_goes_straight_until_a_joint_ends() {
    let mut run = Run::new(&case(machine(), Mode::Adaptive));
    let tip = |run: &Run| {
        run.machine
            .plant
            .output(&run.machine.state, &hdrm::Input::default())
            .tip_position
    };
    let start = tip(&run);
    let mut aside = 0.0_f64;
    run.hold(
        4.0,
        RateCommand::Tip,
        [0.0, -0.1, 0.0, 0.0, 0.0, 0.0],
        |run, _, _| {
            let [x, _, z] = tip(run);
            aside = aside.max((x - start[0]).hypot(z - start[2]));
        },
    );
    let down = start[1] - tip(&run)[1];
    println!("down {down:.3} m, aside {:.3} mm", 1e3 * aside);
    assert!(
        (0.34..0.4).contains(&down) && aside < 1e-4,
        "{down} {aside}"
    );
    run.hold(
        40.0,
        RateCommand::Tip,
        [0.0, -0.2, 0.0, 0.0, 0.0, 0.0],
        |_, error, _| assert!(error < 1e-3, "{error}"),
    );
    assert!(run.machine.state.zeta_dot.iter().all(|w| w.abs() < 1e-3));
    let text: Vec<String> = run.warnings.iter().map(ToString::to_string).collect();
    assert!(
        text.len() == 1 && text[0].contains("where it stops"),
        "{text:?}"
    );
}

/// The reference machine with its outer boom bent by 40°, so that the arm is in line within the
/// joints' ranges.
fn bent() -> (Machine, f64) {
    let mut machine = machine();
    let (sin, cos) = 40.0_f64.to_radians().sin_cos();
    machine.geometry.r_B_B4 = [1.5 * cos, 1.5 * sin, 0.0];
    let g = &machine.geometry;
    let to_wrist = g.r_B_B4[0] + g.r_B4_A4[0] + g.r_A4_C4[0];
    (machine.clone(), -g.r_B_B4[1].atan2(to_wrist))
}

/// Commands of the tip lead outwards until the arm is nearly stretched, where they are held; joint
/// commands lead through; and from there, where the inverse is damped, commands of the tip lead
/// back.
#[test]
fn the_elbow_is_stretched_and_comes_back() {
    let (machine, stretched) = bent();
    let mut run = Run::new(&case(machine, Mode::Adaptive));
    let mut worst = 0.0_f64;
    let outwards = |run: &Run| {
        let y = run
            .machine
            .plant
            .output(&run.machine.state, &hdrm::Input::default());
        let [x, height, _] = y.tip_position;
        let size = (x - 0.1).hypot(height - 1.5);
        [
            0.2 * (x - 0.1) / size,
            0.2 * (height - 1.5) / size,
            0.0,
            0.0,
            0.0,
            0.0,
        ]
    };
    for _ in 0..80 {
        let rates = outwards(&run);
        run.hold(0.25, RateCommand::Tip, rates, |_, error, _| {
            worst = worst.max(error)
        });
    }
    let held = run.zeta()[2];
    println!(
        "held {:.3} rad before the stretched arm, {:?}",
        stretched - held,
        run.warnings
    );
    assert!(
        (0.1..0.2).contains(&(stretched - held)),
        "{held} {stretched}"
    );
    assert!(run.machine.state.zeta_dot.iter().all(|w| w.abs() < 5e-3));
    let [first @ .., Warning::ElbowHeld { .. }] = &run.warnings[..] else {
        panic!("{:?}", run.warnings);
    };
    let is_slowed = |t: &Warning| matches!(t, Warning::JointRate { joint: 3, .. });
    assert!(first.iter().all(is_slowed), "{first:?}");

    let rates = [0.0, 0.0, 0.1, 0.0, 0.0, 0.0];
    let seconds = (stretched - held) / 0.1;
    run.hold(seconds, RateCommand::Joint, rates, |_, error, _| {
        worst = worst.max(error)
    });
    run.hold(2.0, RateCommand::Joint, [0.0; 6], |_, error, _| {
        worst = worst.max(error)
    });
    assert!(
        (run.zeta()[2] - stretched).abs() < 0.06,
        "{}",
        run.zeta()[2] - stretched
    );
    let tip_x = |run: &Run| {
        run.machine
            .plant
            .output(&run.machine.state, &hdrm::Input::default())
            .tip_position[0]
    };
    let far = tip_x(&run);
    for _ in 0..60 {
        let rates = outwards(&run).map(|v| -v);
        run.hold(0.25, RateCommand::Tip, rates, |_, error, _| {
            worst = worst.max(error)
        });
    }
    println!(
        "back by {:.3} m, largest error {:.3} mm",
        far - tip_x(&run),
        1e3 * worst
    );
    assert!(
        far - tip_x(&run) > 0.3 && worst < 2e-3,
        "{} {worst}",
        far - tip_x(&run)
    );
}

/// 250 kg are picked up and set down again while the tip moves: a controller that is told has an
/// error of the motors' lag alone, one that is not sags and adapts.
#[test]
fn a_controller_that_is_told_of_a_load_is_better() {
    let [told, untold] = [true, false].map(|is_told| {
        let mut run = Run::new(&case(machine(), Mode::Adaptive));
        let mut worst = 0.0_f64;
        let load = vdc::Load {
            mass: 250.0,
            com: [0.05, -0.02, 0.03],
        };
        for load in [load, vdc::Load::default()] {
            let plant = run.machine.plant.clone();
            let now = plant.dynamics(&run.machine.state);
            let picked = Load {
                mass: load.mass,
                com: load.com,
                ..*plant.load()
            };
            let next = plant.change_load(&now, &picked, None, &hdrm::Input::default());
            (run.machine.plant, run.machine.state) = next.expect("valid");
            if is_told {
                run.machine.controller.set_load(&load);
            }
            let mut sum = (0.0, 0.0);
            run.hold(
                3.0,
                RateCommand::Tip,
                [0.0, 0.05, 0.05, 0.0, 0.0, 0.0],
                |run, error, y| {
                    sum = (sum.0 + error * error, sum.1 + 1.0);
                    worst = worst.max(error);
                    let _ = (run, y);
                },
            );
            println!(
                "told {is_told}, {} kg: {:.4} mm, largest {:.3} mm",
                load.mass,
                1e3 * (sum.0 / sum.1).sqrt(),
                1e3 * worst
            );
        }
        worst
    });
    assert!(told < 0.5 * untold, "{told} {untold} m");
}

/// The boom is lowered and stretched to where the tilt rod would carry 79 kN: it stops where the
/// rod holds 95 % of its rated 70 kN at rest, says so, and comes back. Tolerance: 1 % for the
/// gradient of the force, which counts as constant up to there.
#[test]
fn joints_stop_where_a_rod_holds_no_more() {
    let mut run = Run::new(&case(machine(), Mode::Modular));
    let out = [0.0, -0.1, 0.1, 0.0, 0.0, 0.0];
    let mut last = 0.0_f64;
    run.hold(40.0, RateCommand::Joint, out, |_, _, y| {
        last = y.f_required[2].abs()
    });
    println!("{last:.0} N");
    assert!((last / (0.95 * 70e3) - 1.0).abs() < 0.01, "{last} N");
    let text: Vec<String> = run.warnings.iter().map(ToString::to_string).collect();
    let told = |text: &&String| text.contains("actuator 3 must hold almost its rated force");
    assert_eq!(text.iter().filter(told).count(), 1, "{text:?}");
    let before = run.zeta()[2];
    run.hold(2.0, RateCommand::Joint, out.map(|w| -w), |_, _, _| ());
    assert!(before - run.zeta()[2] > 0.1, "it comes back");
}
