//! Rates instead of paths: a reference made of an operator's commands, of the joints or of the tip.
//!
//! Both end in the joints: there rates and accelerations are limited and smoothed, so that the reference ζ_d, ζ̇_d, ζ̈_d is one that the control
//! law can follow. A command that leads to the end of a joint's range, or of a stroke, is slowed down in time and held there; commands of the tip
//! are held as well before the arm is stretched, where the elbow is singular. Near the wrist's singularity, and about the elbow's if joint commands
//! have led there, the inverse kinematics are damped ([`crate::clik`]): the tip follows in part.
//!
//! A command of the tip is slowed as a whole, so that the tip keeps its direction, and no joint exceeds what it may do. Not in the paper.

use crate::clik::{self, Inverse, Singularities};
use crate::controller::orientation;
use crate::error::ControllerError;
use crate::reference::Desired;
use crate::signals::Input;
use hdrm::{DOF, Tip, Tree};
use machine::Machine;
use nalgebra::Vector6;
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
    /// Joint rates, rad/s, under commands of the tip too.
    pub joint: [f64; DOF],
    /// Joint accelerations, rad/s², under commands of the tip too.
    pub joint_acceleration: [f64; DOF],
    /// Velocity, m/s, and angular velocity of the tip, rad/s.
    pub tip: [f64; 2],
    /// Accelerations under commands of the tip, m/s² and rad/s².
    pub tip_acceleration: [f64; 2],
    /// Time constant τ with which rates follow commands, s.
    pub smoothing: f64,
}

impl Default for RateLimits {
    /// Some 70 mm/s of the reference machine's rods, reached within a second. Smoothed less, the drives lag behind changes of the commands so
    /// far that joints of the wrist exceed their rates by a tenth.
    fn default() -> Self {
        Self {
            joint: [0.15, 0.1, 0.1, 0.5, 0.5, 0.5],
            joint_acceleration: [0.3, 0.2, 0.2, 1.0, 1.0, 1.0],
            tip: [0.25, 0.3],
            tip_acceleration: [0.6, 1.0],
            smoothing: 0.2,
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
    /// By the rate of a joint, counted from 0, of which the tip's command asks so much, rad/s.
    pub rate: Option<(usize, f64)>,
}

/// The joints' reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Motion {
    /// ζ_d, rad, and its derivatives.
    pub zeta: Vector6<f64>,
    pub zeta_dot: Vector6<f64>,
    pub zeta_ddot: Vector6<f64>,
    pub held: Held,
}

/// What holds a command of the tip.
#[derive(Clone, Copy, PartialEq)]
enum Hold {
    /// The end of a joint's range.
    End,
    Elbow,
    /// A joint's rate.
    Rate,
}

/// Rates between which a joint may go, rad/s, and what holds it to each.
#[derive(Clone, Copy)]
struct Allowed {
    low: (f64, Hold),
    high: (f64, Hold),
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
/// Share of a joint's largest rate that its reference takes; the rest is for the feedback on its error, and for the drives' lag.
const REFERENCE_SHARE: f64 = 0.98;
/// Share of an acceleration limit with which commands are slowed down before a limit; the rest is for commands that change meanwhile.
const BRAKE_SHARE: f64 = 0.4;
/// Share of a command below which it counts as held.
const HELD_SHARE: f64 = 0.5;
/// Share of a joint's rate below which a command of the tip is not held for that joint's sake.
const NEGLIGIBLE: f64 = 1e-6;
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

    /// Required joint motion, by the feedback Λ on the joints' error with its integral part as in [`clik::required`]; feedback included, no
    /// joint is asked for more than its largest rate.
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
        let mut required = clik::Required {
            zeta_dot: motion.zeta_dot + Lambda.component_mul(&(errors.e + errors.z)),
            zeta_ddot: motion.zeta_ddot + Lambda.component_mul(&(e_dot + errors.z_dot)),
        };
        for i in 0..DOF {
            let (rate, largest) = (required.zeta_dot[i], self.limits.joint[i]);
            if rate.abs() > largest {
                required.zeta_dot[i] = largest.copysign(rate);
                let inwards = required.zeta_ddot[i] * rate < 0.0;
                required.zeta_ddot[i] *= f64::from(u8::from(inwards));
            }
        }
        required
    }

    /// Reference of a time `age` ago minus the measured joints, rad.
    pub(crate) fn error(&self, zeta: &[f64; DOF], age: f64) -> Vector6<f64> {
        self.motion.zeta - self.motion.zeta_dot * age - Vector6::from(*zeta)
    }

    /// Moves on by `h` s with the commands held.
    pub(crate) fn advance(&mut self, tree: &Tree, command: RateCommand, input: &Input, h: f64) {
        let parts = (h / (PART * self.limits.smoothing))
            .ceil()
            .clamp(1.0, PARTS_MAX);
        let h = h / parts;
        let tau = self.limits.smoothing.max(2.0 * h);
        for _ in 0..parts as u32 {
            let allowed = std::array::from_fn(|i| self.allowed(i, command));
            let (wanted, held) = match command {
                RateCommand::Joint => self.of_joints(&input.rate_joint, &allowed, tau),
                RateCommand::Tip => self.of_tip(tree, &input.rate_tip, &allowed, tau),
            };
            self.motion.held = held;
            self.accelerate(&wanted, &allowed, tau, h);
        }
    }

    /// Between which rates joint `i` may go: within its limit, and so that it stops before the end of its range with a share of its largest
    /// acceleration; under commands of the tip before the arm is stretched, too.
    fn allowed(&self, i: usize, command: RateCommand) -> Allowed {
        let limits = &self.limits;
        let largest = self.largest_rate(i);
        let brake = BRAKE_SHARE * limits.joint_acceleration[i];
        let zeta = self.motion.zeta[i];
        let before = |ahead: f64, hold| (limits.speed_before(ahead, brake), hold);
        let least = |a: (f64, Hold), b: (f64, Hold)| if b.0 < a.0 { b } else { a };
        let [low, high] = self.range[i];
        let free = (largest, Hold::Rate);
        let mut bounds = [zeta - low, high - zeta].map(|s| least(free, before(s, Hold::End)));
        if i == 2 && command == RateCommand::Tip {
            for (bound, direction) in bounds.iter_mut().zip([-1.0, 1.0]) {
                let stretch = self.singularities.stretch_ahead(zeta, direction);
                let elbow = before(stretch - ELBOW_MARGIN, Hold::Elbow);
                *bound = least(*bound, elbow);
            }
        }
        let [(low, by_low), high] = bounds;
        Allowed {
            low: (-low, by_low),
            high,
        }
    }

    /// Accelerations with which the joints go to the commanded rates, each for itself; and what holds them.
    fn of_joints(
        &self,
        commands: &[f64; DOF],
        allowed: &[Allowed; DOF],
        tau: f64,
    ) -> (Vector6<f64>, Held) {
        let mut held = Held::default();
        let acceleration = Vector6::from_fn(|i, _| {
            let largest = self.limits.joint[i];
            let wanted = commands[i].clamp(-largest, largest);
            let Allowed { low, high } = allowed[i];
            held.joint[i] = wanted * HELD_SHARE > high.0 || wanted * HELD_SHARE < low.0;
            (wanted - self.motion.zeta_dot[i]) / tau
        });
        (acceleration, held)
    }

    /// Accelerations with which the tip goes straight to the commanded rates u, as far as the joints allow, by one share σ of the command
    /// and one share s of the acceleration towards it:
    /// ```text
    /// ζ̈ = s·(σ·J⁻¹·u − ζ̇)/τ − J⁻¹·J̇·ζ̇
    /// ```
    /// The last term is what a tip that goes on as it is asks of the joints.
    fn of_tip(
        &self,
        tree: &Tree,
        command: &[f64; DOF],
        allowed: &[Allowed; DOF],
        tau: f64,
    ) -> (Vector6<f64>, Held) {
        let Motion { zeta, zeta_dot, .. } = self.motion;
        let [angles, rates] = [zeta, zeta_dot].map(<[f64; DOF]>::from);
        let tip = Tip::new(tree, &tree.configuration(&angles));
        let J = tip.jacobian();
        let inverse = Inverse::of(J, &self.singularities, &angles);
        let onwards = -inverse.apply(tip.jacobian_dot(&rates) * zeta_dot);
        let u = Vector6::from(*command);
        let u = u * share_within(&u, self.limits.tip);
        let joints = inverse.apply(u);
        let (share, held) = self.share(&joints, &(onwards * tau), allowed);
        let drive = (joints * share - zeta_dot) / tau;
        let of_tip = (u * share - J * zeta_dot) / tau;
        let mut s = share_within(&of_tip, self.limits.tip_acceleration);
        for i in 0..DOF {
            let largest = self.limits.joint_acceleration[i].copysign(drive[i]);
            if drive[i] != 0.0 {
                s = s.min(((largest - onwards[i]) / drive[i]).max(0.0));
            }
        }
        (drive * s + onwards, held)
    }

    /// Share of a command of the tip that the joints may follow, where it asks for the rates `joints` and for `onwards` besides, to stay
    /// straight; and what holds it.
    fn share(
        &self,
        joints: &Vector6<f64>,
        onwards: &Vector6<f64>,
        allowed: &[Allowed; DOF],
    ) -> (f64, Held) {
        let mut held = Held::default();
        let mut share = 1.0_f64;
        let mut end = None;
        for i in 0..DOF {
            let w = joints[i];
            if w.abs() <= NEGLIGIBLE * self.limits.joint[i] {
                continue;
            }
            let Allowed { low, high } = allowed[i];
            let (bound, hold) = if w > 0.0 { high } else { low };
            let room = ((bound - onwards[i]) / w).max(0.0);
            if room < share {
                (share, end) = (room, Some((hold, i)));
            }
        }
        let is_moving = joints.iter().any(|w| *w != 0.0);
        held.wrist = is_moving && self.singularities.is_near_wrist(self.motion.zeta[4]);
        match end.filter(|_| share < HELD_SHARE) {
            Some((Hold::End, i)) => held.joint[i] = true,
            Some((Hold::Elbow, _)) => held.elbow = true,
            Some((Hold::Rate, i)) => held.rate = Some((i, joints[i])),
            None => (),
        }
        (share, held)
    }

    /// Moves on by `h` s with the accelerations `wanted`, within the joints' limits and so that their rates stay within, or return to, what
    /// is `allowed`; smoothed with τ/4, with which a joint comes to its rate critically damped.
    fn accelerate(&mut self, wanted: &Vector6<f64>, allowed: &[Allowed; DOF], tau: f64, h: f64) {
        let motion = &mut self.motion;
        let smoothed = -libm::expm1(-4.0 * h / tau);
        for i in 0..DOF {
            let [low, high] = self.range[i];
            let (zeta, rate, before) = (motion.zeta[i], motion.zeta_dot[i], motion.zeta_ddot[i]);
            let largest = self.limits.joint_acceleration[i];
            let towards = |bound: f64| ((bound - rate) / tau).clamp(-largest, largest);
            let Allowed {
                low: least,
                high: most,
            } = allowed[i];
            let acceleration = wanted[i].clamp(towards(least.0), towards(most.0));
            let after = before + (acceleration - before) * smoothed;
            let moved = h * (rate + h * (before / 3.0 + after / 6.0));
            motion.zeta[i] = zeta + moved;
            motion.zeta_dot[i] = rate + (before + after) * (0.5 * h);
            motion.zeta_ddot[i] = after;
            // Braking ends within the range; limits that make it too short, as a smoothing of seconds does, end here.
            if !(low..=high).contains(&motion.zeta[i]) {
                motion.zeta[i] = motion.zeta[i].clamp(low, high);
                (motion.zeta_dot[i], motion.zeta_ddot[i]) = (0.0, 0.0);
            }
        }
    }

    /// Largest rate of joint `i`, rad/s.
    pub(crate) fn largest_rate(&self, i: usize) -> f64 {
        REFERENCE_SHARE * self.limits.joint[i]
    }

    /// The end of joint `i`'s range that it is nearest to, rad.
    pub(crate) fn nearest_limit(&self, i: usize) -> f64 {
        let [low, high] = self.range[i];
        let is_low = 2.0 * self.motion.zeta[i] < low + high;
        if is_low { low } else { high }
    }
}

impl RateLimits {
    /// Greatest speed from which the way `ahead` suffices to stop with the deceleration `a`: `√((a·T)² + 2·a·ahead) − a·T`. Close to the end
    /// it is `ahead/T`; T = 4τ is the least for which the smoothed rate does not swing there (roots −1, −0.38, −2.6 by 1/τ).
    fn speed_before(&self, ahead: f64, a: f64) -> f64 {
        let lag = 4.0 * self.smoothing * a;
        let ahead = ahead.max(0.0);
        (lag * lag + 2.0 * a * ahead).sqrt() - lag
    }
}

/// Share of the vector for which neither its first nor its last three components are longer than their limit; at most 1.
fn share_within(v: &Vector6<f64>, limits: [f64; 2]) -> f64 {
    let part = |k: usize| v.fixed_rows::<3>(k).norm();
    (part(0) / limits[0])
        .max(part(3) / limits[1])
        .max(1.0)
        .recip()
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

#[cfg(test)]
mod tests;
