//! Rates instead of paths: a reference made of an operator's commands, of the joints or of the tip.
//!
//! Commands are limited in rate and acceleration and smoothed, so that the joints' reference ζ_d, ζ̇_d, ζ̈_d is one that the control law can
//! follow. A command that leads to the end of a joint's range, or of a stroke, is slowed down in time and held there; commands of the tip
//! are held as well before the arm is stretched, where the elbow is singular. Near the wrist's singularity, and about the elbow's if joint commands have led
//! there, the inverse kinematics are damped ([`crate::clik`]): the tip follows in part, and joints stay within their rates.
//!
//! All commands of the tip are slowed together, so the tip keeps its direction. Not in the paper.

use crate::clik::{self, Inverse, Singularities};
use crate::controller::orientation;
use crate::error::ControllerError;
use crate::reference::Desired;
use crate::signals::Input;
use hdrm::{DOF, Tip, Tree};
use machine::Machine;
use nalgebra::{Vector3, Vector6};
use serde::{Deserialize, Serialize};

/// What an operator's commands are rates of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum RateCommand {
    /// The six joints, by the inputs `rate.joint`.
    #[default]
    Joint,
    /// The tip in the world, by the inputs `rate.tip`.
    Tip,
}

/// Limits of the commands. Those of the tip are of the lengths of velocity and angular velocity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RateLimits {
    /// Joint rates, rad/s; commands of the tip keep them too.
    pub joint: [f64; DOF],
    /// Joint accelerations under commands of the joints, rad/s².
    pub joint_acceleration: [f64; DOF],
    /// Velocity, m/s, and angular velocity of the tip, rad/s.
    pub tip: [f64; 2],
    /// Accelerations under commands of the tip, m/s² and rad/s².
    pub tip_acceleration: [f64; 2],
    /// Time constant τ with which rates follow commands, s.
    pub smoothing: f64,
}

impl Default for RateLimits {
    /// Some 70 mm/s of the reference machine's rods, reached within half a second.
    fn default() -> Self {
        Self {
            joint: [0.15, 0.1, 0.1, 0.5, 0.5, 0.5],
            joint_acceleration: [0.3, 0.2, 0.2, 1.0, 1.0, 1.0],
            tip: [0.25, 0.3],
            tip_acceleration: [0.6, 1.0],
            smoothing: 0.1,
        }
    }
}

impl RateLimits {
    fn check(&self) -> Result<(), ControllerError> {
        let [joint, joint_acceleration] = [&self.joint, &self.joint_acceleration];
        let rows: [(&'static str, &[f64]); 5] = [
            ("rate.joint_max", joint),
            ("rate.joint_acceleration_max", joint_acceleration),
            ("rate.tip_max", &self.tip),
            ("rate.tip_acceleration_max", &self.tip_acceleration),
            ("rate.smoothing", std::slice::from_ref(&self.smoothing)),
        ];
        for (name, values) in rows {
            if let Some(&value) = values.iter().find(|x| !(x.is_finite() && **x > 0.0)) {
                return Err(ControllerError::RateLimit { name, value });
            }
        }
        Ok(())
    }
}

/// Where commands are held back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Held {
    /// By the end of a joint's range.
    pub joint: [bool; DOF],
    /// Before the arm is stretched.
    pub elbow: bool,
    /// The wrist is near its singularity, where the tip follows in part.
    pub wrist: bool,
}

/// The joints' reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Motion {
    /// ζ_d, rad, and its derivatives.
    pub zeta: Vector6<f64>,
    pub zeta_dot: Vector6<f64>,
    pub zeta_ddot: Vector6<f64>,
    /// What `rate` is of.
    command: RateCommand,
    /// Smoothed command, and its derivative.
    rate: Vector6<f64>,
    acceleration: Vector6<f64>,
    pub held: Held,
}

/// What a command of the tip leads to.
#[derive(Clone, Copy)]
enum End {
    Joint(usize),
    Elbow,
}

/// Maker of the reference.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Rates {
    limits: RateLimits,
    /// Ranges of the joints, strokes included, less a margin, rad.
    range: [[f64; 2]; DOF],
    singularities: Singularities,
    pub(crate) motion: Motion,
}

/// Distance from the end of a joint's range at which commands are held, rad: the control law's error must not reach the end stop.
const MARGIN: f64 = 0.01;
/// Distance of the elbow from its singularity at which commands of the tip are held, rad: beyond the damped inverse's range.
const ELBOW_MARGIN: f64 = 0.12;
/// Share of an acceleration limit with which commands are slowed down before a limit; the rest is for commands that change meanwhile.
const BRAKE_SHARE: f64 = 0.4;
/// Share of a command below which it counts as held.
const HELD_SHARE: f64 = 0.5;
/// Longest part of a step, by the time constant: the smoothing is integrated in parts.
const PART: f64 = 0.1;
/// Most parts of a step.
const PARTS_MAX: f64 = 1000.0;

impl Rates {
    /// At rest in the pose `start`, rad, with the default limits.
    pub(crate) fn new(machine: &Machine, tree: &Tree, start: &[f64; DOF]) -> Self {
        let ranges = ranges(machine, tree);
        let within = |i: usize| {
            let [low, high]: [f64; 2] = ranges[i];
            [(low + MARGIN).min(start[i]), (high - MARGIN).max(start[i])]
        };
        Self {
            limits: RateLimits::default(),
            range: std::array::from_fn(within),
            singularities: Singularities::of(tree),
            motion: Motion {
                zeta: Vector6::from(*start),
                ..Motion::default()
            },
        }
    }

    pub(crate) fn set_limits(&mut self, limits: &RateLimits) -> Result<(), ControllerError> {
        limits.check()?;
        self.limits = *limits;
        Ok(())
    }

    /// The tip where the joints' reference has it.
    pub(crate) fn desired(&self, tree: &Tree) -> Desired {
        let Motion {
            zeta,
            zeta_dot,
            zeta_ddot,
            ..
        } = &self.motion;
        let [zeta, rates] = [*zeta, *zeta_dot].map(<[f64; DOF]>::from);
        let tip = Tip::new(tree, &tree.configuration(&zeta));
        let J = tip.jacobian();
        let V = J * zeta_dot;
        let A = J * zeta_ddot + tip.jacobian_dot(&rates) * zeta_dot;
        Desired {
            position: tip.position,
            velocity: V.fixed_rows::<3>(0).into(),
            acceleration: A.fixed_rows::<3>(0).into(),
            orientation: orientation(&zeta),
            angular_velocity: V.fixed_rows::<3>(3).into(),
        }
    }

    /// Required joint motion, by the feedback Λ on the joints' error with its integral part as in [`clik::required`].
    pub(crate) fn required(
        &self,
        errors: &crate::integral::Errors,
        zeta_dot: &[f64; DOF],
        age: f64,
        [position, orientation]: [f64; 2],
    ) -> clik::Required {
        let motion = &self.motion;
        let Lambda = Vector6::from_fn(|i, _| if i < 3 { position } else { orientation });
        let seen = motion.zeta_dot - motion.zeta_ddot * age;
        let e_dot = seen - Vector6::from(*zeta_dot);
        clik::Required {
            zeta_dot: motion.zeta_dot + Lambda.component_mul(&(errors.e + errors.z)),
            zeta_ddot: motion.zeta_ddot + Lambda.component_mul(&(e_dot + errors.z_dot)),
        }
    }

    /// Reference of a time `age` ago minus the measured joints, rad.
    pub(crate) fn error(&self, zeta: &[f64; DOF], age: f64) -> Vector6<f64> {
        self.motion.zeta - self.motion.zeta_dot * age - Vector6::from(*zeta)
    }

    /// Moves on by `h` s with the commands held.
    pub(crate) fn advance(&mut self, tree: &Tree, command: RateCommand, input: &Input, h: f64) {
        if self.motion.command != command {
            self.take_command(tree, command);
        }
        let parts = (h / (PART * self.limits.smoothing))
            .ceil()
            .clamp(1.0, PARTS_MAX);
        for _ in 0..parts as u32 {
            match command {
                RateCommand::Joint => self.advance_joints(&input.rate_joint, h / parts),
                RateCommand::Tip => self.advance_tip(tree, &input.rate_tip, h / parts),
            }
        }
    }

    /// What is under way becomes a rate of what is commanded now.
    fn take_command(&mut self, tree: &Tree, command: RateCommand) {
        let motion = &mut self.motion;
        motion.command = command;
        motion.held = Held::default();
        (motion.rate, motion.acceleration) = match command {
            RateCommand::Joint => (motion.zeta_dot, motion.zeta_ddot),
            RateCommand::Tip => {
                let tip = Tip::new(tree, &tree.configuration(&motion.zeta.into()));
                let (J, J_dot) = (tip.jacobian(), tip.jacobian_dot(&motion.zeta_dot.into()));
                let acceleration = J * motion.zeta_ddot + J_dot * motion.zeta_dot;
                (J * motion.zeta_dot, acceleration)
            }
        };
    }

    fn advance_joints(&mut self, commands: &[f64; DOF], h: f64) {
        let RateLimits {
            joint,
            joint_acceleration,
            ..
        } = self.limits;
        let mut target = Vector6::zeros();
        let motion = &mut self.motion;
        for i in 0..DOF {
            let wanted = commands[i].clamp(-joint[i], joint[i]);
            let [low, high] = self.range[i];
            let zeta = motion.zeta[i];
            let ahead = if wanted > 0.0 {
                high - zeta
            } else {
                zeta - low
            };
            let brake = BRAKE_SHARE * joint_acceleration[i];
            let allowed = self.limits.speed_before(ahead, brake);
            target[i] = wanted.clamp(-allowed, allowed);
            motion.held.joint[i] = wanted.abs() > 0.0 && allowed < HELD_SHARE * wanted.abs();
        }
        motion.held.elbow = false;
        motion.held.wrist = false;
        let saturated = |a: Vector6<f64>| {
            Vector6::from_fn(|i, _| a[i].clamp(-joint_acceleration[i], joint_acceleration[i]))
        };
        let [rate, acceleration] = self.limits.smoothed(motion, &target, saturated, h);
        let jerk = (acceleration - motion.acceleration) / h;
        let moved =
            motion.rate * h + motion.acceleration * (0.5 * h * h) + jerk * (h * h * h / 6.0);
        motion.zeta += moved;
        (motion.rate, motion.acceleration) = (rate, acceleration);
        (motion.zeta_dot, motion.zeta_ddot) = (rate, acceleration);
        self.keep_in_range();
    }

    fn advance_tip(&mut self, tree: &Tree, command: &[f64; DOF], h: f64) {
        let limits = self.limits;
        let wanted = parts_within(&Vector6::from(*command), limits.tip);
        let inverse = |zeta: &Vector6<f64>| {
            let zeta = <[f64; DOF]>::from(*zeta);
            let J = Tip::new(tree, &tree.configuration(&zeta)).jacobian();
            Inverse::of(J, &self.singularities, &zeta)
        };
        let motion = self.motion;
        let joints = inverse(&motion.zeta).apply(wanted);
        let (share, held) = self.share(&wanted, &joints);
        let target = wanted * share;
        let saturated = |a: Vector6<f64>| parts_within(&a, limits.tip_acceleration);
        let [rate, acceleration] = limits.smoothed(&motion, &target, saturated, h);

        let middle = inverse(&(motion.zeta + motion.zeta_dot * (0.5 * h)));
        let zeta = motion.zeta + middle.apply((motion.rate + rate) * 0.5) * h;
        let zeta_dot = inverse(&zeta).apply(rate);
        self.motion = Motion {
            zeta,
            zeta_dot,
            zeta_ddot: (zeta_dot - motion.zeta_dot) / h,
            rate,
            acceleration,
            held,
            ..motion
        };
        self.keep_in_range();
    }

    /// Share of a command of the tip that the joints may follow, where it asks for the rates `joints`; and what holds it.
    fn share(&self, wanted: &Vector6<f64>, joints: &Vector6<f64>) -> (f64, Held) {
        let RateLimits {
            joint,
            tip_acceleration,
            ..
        } = self.limits;
        let mut held = Held::default();
        let size = [0, 3].map(|k| wanted.fixed_rows::<3>(k).norm());
        if size == [0.0; 2] {
            return (0.0, held);
        }
        held.wrist = self.singularities.is_near_wrist(self.motion.zeta[4]);
        // Largest deceleration of the command as a whole, shares per s².
        let brake = (tip_acceleration[0] / size[0]).min(tip_acceleration[1] / size[1]);
        let allowed = |ahead: f64| self.limits.speed_before(ahead, BRAKE_SHARE * brake);
        let mut share = 1.0_f64;
        // What leaves the least share.
        let mut end = None;
        for i in 0..DOF {
            let w = joints[i];
            if w == 0.0 {
                continue;
            }
            let [low, high] = self.range[i];
            let zeta = self.motion.zeta[i];
            let ahead = if w > 0.0 { high - zeta } else { zeta - low };
            let before_end = allowed(ahead / w.abs());
            if before_end < share {
                (share, end) = (before_end, Some(End::Joint(i)));
            }
            if joint[i] < share * w.abs() {
                (share, end) = (joint[i] / w.abs(), None);
            }
        }
        if let Some(ahead) = self
            .singularities
            .stretch_ahead(self.motion.zeta[2], joints[2])
        {
            let before_end = allowed((ahead - ELBOW_MARGIN) / joints[2].abs());
            if before_end < share {
                (share, end) = (before_end, Some(End::Elbow));
            }
        }
        match end.filter(|_| share < HELD_SHARE) {
            Some(End::Joint(i)) => held.joint[i] = true,
            Some(End::Elbow) => held.elbow = true,
            None => (),
        }
        (share, held)
    }

    /// Braking ends within the range but for rounding and abrupt commands; what is left is cut off.
    fn keep_in_range(&mut self) {
        for i in 0..DOF {
            let [low, high] = self.range[i];
            let zeta = self.motion.zeta[i].clamp(low, high);
            let rate = self.motion.zeta_dot[i];
            let outwards = (zeta >= high && rate > 0.0) || (zeta <= low && rate < 0.0);
            self.motion.zeta[i] = zeta;
            if outwards {
                (self.motion.zeta_dot[i], self.motion.zeta_ddot[i]) = (0.0, 0.0);
            }
        }
    }

    /// The end of joint `i`'s range that it is nearest to, rad.
    pub(crate) fn nearest_limit(&self, i: usize) -> f64 {
        let [low, high] = self.range[i];
        let is_low = 2.0 * self.motion.zeta[i] < low + high;
        if is_low { low } else { high }
    }
}

impl RateLimits {
    /// Rate and acceleration after `h` s on the way to the rate `target`: `τ·rate_dot = target − rate` with the acceleration saturated and
    /// smoothed with τ/4, which together are critically damped.
    fn smoothed(
        &self,
        motion: &Motion,
        target: &Vector6<f64>,
        saturated: impl Fn(Vector6<f64>) -> Vector6<f64>,
        h: f64,
    ) -> [Vector6<f64>; 2] {
        let tau = self.smoothing.max(2.0 * h);
        let wanted = saturated((target - motion.rate) / tau);
        let share = -libm::expm1(-4.0 * h / tau);
        let acceleration = motion.acceleration + (wanted - motion.acceleration) * share;
        let rate = motion.rate + (motion.acceleration + acceleration) * (0.5 * h);
        [rate, acceleration]
    }

    /// Greatest speed from which the way `ahead` suffices to stop with the deceleration `a`: `√((a·T)² + 2·a·ahead) − a·T`. Close to the end
    /// it is `ahead/T`; T = 4τ is the least for which the smoothed rate does not swing there (roots −1, −0.38, −2.6 by 1/τ).
    fn speed_before(&self, ahead: f64, a: f64) -> f64 {
        let lag = 4.0 * self.smoothing * a;
        let ahead = ahead.max(0.0);
        (lag * lag + 2.0 * a * ahead).sqrt() - lag
    }
}

/// The vector with its first and last three components scaled together, so that neither part is longer than its limit.
fn parts_within(v: &Vector6<f64>, limits: [f64; 2]) -> Vector6<f64> {
    let part = |k: usize| Vector3::new(v[k], v[k + 1], v[k + 2]).norm();
    let excess = (part(0) / limits[0]).max(part(3) / limits[1]).max(1.0);
    v / excess
}

/// Ranges of the joints, rad: those of the machine file, and of the three actuators no farther than the strokes reach.
fn ranges(machine: &Machine, tree: &Tree) -> [[f64; 2]; DOF] {
    let (mut ranges, strokes) = (machine.limits.zeta(), machine.limits.strokes());
    for i in 0..3 {
        let [low, high] = ranges[i];
        let stroke = |zeta: f64| {
            let mut pose = machine.start.zeta;
            pose[i] = zeta;
            tree.configuration(&pose).strokes[i].x
        };
        // Strokes grow with their joint angle.
        let reaching = |x: f64| {
            let (mut a, mut b) = (low, high);
            for _ in 0..60 {
                let middle = 0.5 * (a + b);
                if stroke(middle) < x {
                    a = middle
                } else {
                    b = middle
                }
            }
            0.5 * (a + b)
        };
        ranges[i] = [reaching(strokes[i][0]), reaching(strokes[i][1])];
    }
    ranges
}
