//! An operator's commanded joint or tip rates, for `reference` and `warnings`. Not in the paper.
//!
//! Commands are converted to a motion ζ_d, ζ̇_d, ζ̈_d of the joints with limited and smoothed rates
//! and accelerations, which the control law can follow. Before the end of a joint's range or a
//! stroke a command is slowed down and stopped; commands of the tip also before the arm is
//! stretched, where the elbow is singular. Near a singularity of the wrist (or of the elbow, after
//! joint commands) the inverse kinematics are damped ([`Inverse`]), and the tip follows partly.
//!
//! The motion stays by the machine ([`ReferenceBounds`]): it waits for a joint that does not
//! follow, and once the command ends its reference
//! returns to where the joint is; joints that would turn to where a rod cannot hold the machine at
//! rest stop before.
//!
//! A command of the tip is scaled as a whole, so that the tip keeps its direction while no joint
//! exceeds its limits.

use crate::error::ControllerError;
use crate::nominal::{Inverse, Singularities};
use crate::reference::motion::{CommandHolds, Motion};
use crate::reference::rate_limits::{RateCommand, RateLimits};
use crate::signals::Input;
use hdrm::{DOF, Tip, Tree};
use machine_file::{Controller as Gains, Machine};
use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

/// What limits a command.
#[derive(Clone, Copy, PartialEq)]
enum Hold {
    /// The end of a joint's range.
    End,
    Elbow,
    /// A joint's rate.
    Rate,
    /// This rod would not hold the machine at rest.
    Rod(usize),
}

/// Smallest and largest allowed rate of a joint, rad/s, each with what limits it.
#[derive(Clone, Copy)]
struct AllowedRates {
    low: (f64, Hold),
    high: (f64, Hold),
}

/// Angles, rad, by which each joint may turn downwards and upwards until a rod would hold more than
/// it may, and that rod.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Room(pub(crate) [[(f64, usize); 2]; DOF]);

impl Default for Room {
    fn default() -> Self {
        Self([[(f64::INFINITY, 0); 2]; DOF])
    }
}

/// How far the reference may go from the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ReferenceBounds {
    /// Largest angle by which a joint's reference may be ahead of the joint, rad.
    pub(crate) ahead: [f64; DOF],
    pub(crate) room: Room,
}

/// Limits for the conversion of commands to a motion of the joints.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Rates {
    limits: RateLimits,
    /// Ranges of the joints, strokes included, less a margin, rad.
    range: [[f64; 2]; DOF],
    singularities: Singularities,
}

/// Distance from the end of a joint's range at which commands stop, rad, so that tracking errors do
/// not reach the end stop.
const MARGIN: f64 = 0.01;
/// Distance of the elbow from its singularity at which commands of the tip stop, rad: outside the
/// range of the damped inverse.
const ELBOW_MARGIN: f64 = 0.12;
/// Share of a joint's largest rate for its reference; the rest is for feedback and the drives' lag.
const REFERENCE_SHARE: f64 = 0.98;
/// Share of an acceleration limit for braking before a limit; the rest is for changing commands.
const BRAKE_SHARE: f64 = 0.4;
/// Allowed share of a command below which a warning is due.
const HELD_SHARE: f64 = 0.5;
/// Share of a joint's largest rate below which the joint does not limit a command of the tip.
const NEGLIGIBLE: f64 = 1e-6;
/// Longest integration step over the smoothing's time constant.
const PART: f64 = 0.1;
/// Largest number of integration steps.
const PARTS_MAX: f64 = 1000.0;

/// Time constants over the smoothing's with which a reference comes to its largest distance from a
/// joint that stands, and changes its rate: critically damped with a ratio of 4.
const FOLLOWS: f64 = 0.5;
const STOPS: f64 = 0.125;
/// Share of the largest distance above which a joint is blocked if its command is held, and by which
/// its reference passes the joint when it returns.
const BLOCKED: f64 = 0.8;
const RETURNS: f64 = 0.1;
/// Time constant over the smoothing's with which it returns: critically damped, as before an end.
const BACK: f64 = 4.0;

/// Factors on the feedback of positions, and on γ, at rest and under commanded rates.
const FEEDBACK: f64 = 0.5;
const SLOWER: f64 = 4.0;

/// Changes gains that suit a path by `share`, 0 to 1, to those with which the machine rests at any
/// pose, where an operator may leave it, with any payload.
///
/// The feedback Λ on angles at the load side is an integrator in front of the boom's mode ω with
/// the damping ζ, and needs `Λ < 2 ζ ω`. Without weight on it the slew has little damping, and its
/// play makes it swing. The adaptation acts on each body's weight as a spring, whose frequency must
/// stay within the bandwidth of the rods' forces; that falls where a rod has a short lever.
pub(crate) fn at_any_pose(gains: &mut Gains, share: f64) {
    gains.Lambda_position *= feedback_at_rest(share);
    gains.omega_tip *= feedback_at_rest(share);
    gains.gamma *= 1.0 + (SLOWER - 1.0) * share;
}

/// Factor on the feedback of positions with a `share` of these gains.
pub(crate) fn feedback_at_rest(share: f64) -> f64 {
    1.0 - (1.0 - FEEDBACK) * share
}

impl Rates {
    /// For a machine whose joints start at the angles `start`, rad; an error for invalid limits.
    pub(crate) fn new(
        machine: &Machine,
        tree: &Tree,
        start: &[f64; DOF],
        limits: &RateLimits,
    ) -> Result<Self, ControllerError> {
        limits.check()?;
        let ranges = ranges(machine, tree);
        let within = |i: usize| {
            let [low, high]: [f64; 2] = ranges[i];
            [(low + MARGIN).min(start[i]), (high - MARGIN).max(start[i])]
        };
        Ok(Self {
            limits: *limits,
            range: std::array::from_fn(within),
            singularities: Singularities::new(tree),
        })
    }

    /// Advances the joints by `h` s with the commands of `input` held.
    pub(crate) fn advance(
        &self,
        motion: &mut Motion,
        tree: &Tree,
        command: RateCommand,
        input: &Input,
        bounds: &ReferenceBounds,
        h: f64,
    ) {
        let parts = (h / (PART * self.limits.smoothing))
            .ceil()
            .clamp(1.0, PARTS_MAX);
        let h = h / parts;
        let tau = self.limits.smoothing.max(2.0 * h);
        for _ in 0..parts as u32 {
            let followed = std::array::from_fn(|i| self.followed(i, motion, input, bounds));
            let allowed =
                std::array::from_fn(|i| self.allowed(i, motion.zeta[i], command, bounds.room.0[i]));
            let (mut wanted, turns, held) = match command {
                RateCommand::Joint => {
                    self.joint_accelerations(motion, &input.rate_joint, &allowed, tau)
                }
                RateCommand::Tip => {
                    self.tip_accelerations(motion, tree, &input.rate_tip, &allowed, tau)
                }
            };
            motion.held = held;
            for i in 0..DOF {
                let ahead = motion.zeta[i] - input.zeta[i];
                let direction =
                    self.blocked(i, motion, turns[i], &followed[i], [ahead, bounds.ahead[i]]);
                if direction != 0.0 && direction * turns[i] <= 0.0 {
                    let back = (ahead.abs() + RETURNS * bounds.ahead[i]) / (BACK * tau);
                    let back = (-back - direction * motion.zeta_dot[i]) / tau;
                    wanted[i] = direction * back.min(direction * wanted[i]);
                }
                motion.blocked[i] = direction;
            }
            self.accelerate(motion, &wanted, &allowed, &followed, tau, h);
        }
    }

    /// Largest rates of joint `i` downwards and upwards, rad/s, with which its reference stays by
    /// the joint: `±ζ̇ + (b ∓ e)/(τ/2)` with the distance e and the largest one b. A joint that
    /// follows does not feel them.
    fn followed(
        &self,
        i: usize,
        motion: &Motion,
        input: &Input,
        bounds: &ReferenceBounds,
    ) -> [f64; 2] {
        let ahead = motion.zeta[i] - input.zeta[i];
        [-1.0, 1.0].map(|side: f64| {
            let left = (bounds.ahead[i] - side * ahead) / (FOLLOWS * self.limits.smoothing);
            (side * input.zeta_dot[i] + left).max(0.0)
        })
    }

    /// Direction in which joint `i` is blocked, ±1 or 0. It begins where its command is held by what
    /// may be `followed`, and ends when the reference has returned to the joint, which is `ahead` of
    /// it by at most `most`, or the joint follows again.
    fn blocked(
        &self,
        i: usize,
        motion: &Motion,
        command: f64,
        followed: &[f64; 2],
        [ahead, most]: [f64; 2],
    ) -> f64 {
        let before = motion.blocked[i];
        let far = BLOCKED * most;
        if before != 0.0 {
            let returns = before * command <= 0.0;
            let is_near = before * ahead <= if returns { 0.0 } else { BLOCKED * far };
            return if is_near { 0.0 } else { before };
        }
        let wanted = HELD_SHARE * command.abs().min(self.limits.joint[i]);
        let is_held = wanted > followed[usize::from(command > 0.0)];
        let direction = command.signum();
        if is_held && direction * ahead > far {
            direction
        } else {
            0.0
        }
    }

    /// Allowed rates of joint `i` at the angle `zeta`, rad: within its limit, and so that it can
    /// stop before the end of its range; for the tip also before the arm is stretched.
    fn allowed(
        &self,
        i: usize,
        zeta: f64,
        command: RateCommand,
        room: [(f64, usize); 2],
    ) -> AllowedRates {
        let limits = &self.limits;
        let largest = self.largest_rate(i);
        let brake = BRAKE_SHARE * limits.joint_acceleration[i];
        let before = |ahead: f64, hold| (limits.speed_before(ahead, brake), hold);
        let least = |a: (f64, Hold), b: (f64, Hold)| if b.0 < a.0 { b } else { a };
        let [low, high] = self.range[i];
        let free = (largest, Hold::Rate);
        let mut bounds = [zeta - low, high - zeta].map(|s| least(free, before(s, Hold::End)));
        for (bound, (left, rod)) in bounds.iter_mut().zip(room) {
            if left < f64::INFINITY {
                *bound = least(*bound, before(left, Hold::Rod(rod)));
            }
        }
        if i == 2 && command == RateCommand::Tip {
            for (bound, direction) in bounds.iter_mut().zip([-1.0, 1.0]) {
                let stretch = self.singularities.stretch_ahead(zeta, direction);
                let elbow = before(stretch - ELBOW_MARGIN, Hold::Elbow);
                *bound = least(*bound, elbow);
            }
        }
        let [(low, by_low), high] = bounds;
        AllowedRates {
            low: (-low, by_low),
            high,
        }
    }

    /// Joint accelerations towards the commanded joint rates, these, and what limits them.
    fn joint_accelerations(
        &self,
        motion: &Motion,
        commands: &[f64; DOF],
        allowed: &[AllowedRates; DOF],
        tau: f64,
    ) -> (Vector6<f64>, Vector6<f64>, CommandHolds) {
        let mut held = CommandHolds::default();
        let acceleration = Vector6::from_fn(|i, _| {
            let largest = self.limits.joint[i];
            let wanted = commands[i].clamp(-largest, largest);
            let AllowedRates { low, high } = allowed[i];
            for (is_beyond, (_, hold)) in [
                (wanted * HELD_SHARE > high.0, high),
                (wanted * HELD_SHARE < low.0, low),
            ] {
                if is_beyond {
                    note(&mut held, i, hold, wanted);
                }
            }
            (wanted - motion.zeta_dot[i]) / tau
        });
        (acceleration, Vector6::from(*commands), held)
    }

    /// Joint accelerations towards the commanded rates u of the tip, joint rates for u, and what
    /// limits these. One
    /// factor σ on the command and one factor s on the acceleration keep the tip's direction:
    /// ```text
    /// ζ̈ = s·(σ·J⁻¹·u − ζ̇)/τ − J⁻¹·J̇·ζ̇
    /// ```
    /// The last term is the joints' acceleration at constant velocity of the tip.
    fn tip_accelerations(
        &self,
        motion: &Motion,
        tree: &Tree,
        command: &[f64; DOF],
        allowed: &[AllowedRates; DOF],
        tau: f64,
    ) -> (Vector6<f64>, Vector6<f64>, CommandHolds) {
        let Motion { zeta, zeta_dot, .. } = *motion;
        let [angles, rates] = [zeta, zeta_dot].map(<[f64; DOF]>::from);
        let tip = Tip::new(tree, &tree.configuration(&angles));
        let J = tip.jacobian();
        let inverse = Inverse::new(J, &self.singularities, &angles);
        let onwards = -inverse.apply(tip.jacobian_dot(&rates) * zeta_dot);
        let u = Vector6::from(*command);
        let u = u * share_within(&u, self.limits.tip);
        let joints = inverse.apply(u);
        let (share, held) = self.share(motion, &joints, &(onwards * tau), allowed);
        let drive = (joints * share - zeta_dot) / tau;
        let of_tip = (u * share - J * zeta_dot) / tau;
        let mut s = share_within(&of_tip, self.limits.tip_acceleration);
        for i in 0..DOF {
            let largest = self.limits.joint_acceleration[i].copysign(drive[i]);
            if drive[i] != 0.0 {
                s = s.min(((largest - onwards[i]) / drive[i]).max(0.0));
            }
        }
        (drive * s + onwards, joints, held)
    }

    /// Factor σ on a command of the tip that needs the joint rates `joints`, and `onwards` in
    /// addition to keep its velocity; and what limits it.
    fn share(
        &self,
        motion: &Motion,
        joints: &Vector6<f64>,
        onwards: &Vector6<f64>,
        allowed: &[AllowedRates; DOF],
    ) -> (f64, CommandHolds) {
        let mut held = CommandHolds::default();
        let mut share = 1.0_f64;
        let mut end = None;
        for i in 0..DOF {
            let w = joints[i];
            if w.abs() <= NEGLIGIBLE * self.limits.joint[i] {
                continue;
            }
            let AllowedRates { low, high } = allowed[i];
            let (bound, hold) = if w > 0.0 { high } else { low };
            let allowed_share = ((bound - onwards[i]) / w).max(0.0);
            if allowed_share < share {
                (share, end) = (allowed_share, Some((hold, i)));
            }
        }
        // A joint that does not follow stops the tip.
        if (0..DOF).any(|i| motion.blocked[i] * joints[i] > 0.0) {
            (share, end) = (0.0, None);
        }
        let is_moving = joints.iter().any(|w| *w != 0.0);
        held.wrist = is_moving && self.singularities.is_near_wrist(motion.zeta[4]);
        if let Some((hold, i)) = end.filter(|_| share < HELD_SHARE) {
            note(&mut held, i, hold, joints[i]);
        }
        (share, held)
    }

    /// Advances by `h` s with the accelerations `wanted`, limited so that the joints' rates stay
    /// within or return to `allowed`, and smoothed with τ/4, which is critically damped.
    fn accelerate(
        &self,
        motion: &mut Motion,
        wanted: &Vector6<f64>,
        allowed: &[AllowedRates; DOF],
        followed: &[[f64; 2]; DOF],
        tau: f64,
        h: f64,
    ) {
        let smoothed = -libm::expm1(-4.0 * h / tau);
        for i in 0..DOF {
            let [low, high] = self.range[i];
            let (zeta, rate, before) = (motion.zeta[i], motion.zeta_dot[i], motion.zeta_ddot[i]);
            let largest = self.limits.joint_acceleration[i];
            let towards = |bound: f64| ((bound - rate) / tau).clamp(-largest, largest);
            let AllowedRates {
                low: least,
                high: most,
            } = allowed[i];
            let acceleration = wanted[i].clamp(towards(least.0), towards(most.0));
            let after = before + (acceleration - before) * smoothed;
            // Something that stopped the machine has stopped it already: the reference may brake
            // harder than its limit.
            let [down, up] = followed[i];
            let soon = |bound: f64| (bound - rate) / (STOPS * tau);
            let after = after.clamp(soon(-down), soon(up));
            let moved = h * (rate + h * (before / 3.0 + after / 6.0));
            motion.zeta[i] = zeta + moved;
            motion.zeta_dot[i] = rate + (before + after) * (0.5 * h);
            motion.zeta_ddot[i] = after;
            // Braking normally ends within the range; a smoothing of seconds may make it too late.
            if !(low..=high).contains(&motion.zeta[i]) {
                motion.zeta[i] = motion.zeta[i].clamp(low, high);
                (motion.zeta_dot[i], motion.zeta_ddot[i]) = (0.0, 0.0);
            }
        }
    }

    /// Largest rates of the joints, rad/s.
    pub(crate) fn largest(&self) -> &[f64; DOF] {
        &self.limits.joint
    }

    /// Largest rate of joint `i`'s reference, rad/s.
    pub(crate) fn largest_rate(&self, i: usize) -> f64 {
        REFERENCE_SHARE * self.limits.joint[i]
    }

    /// The end of joint `i`'s range nearest to the angle `zeta`, rad.
    pub(crate) fn nearest_limit(&self, i: usize, zeta: f64) -> f64 {
        let [low, high] = self.range[i];
        let is_low = 2.0 * zeta < low + high;
        if is_low { low } else { high }
    }
}

/// Notes in `held` what holds joint `i`, for whose command it would turn at `rate`, rad/s.
fn note(held: &mut CommandHolds, i: usize, hold: Hold, rate: f64) {
    match hold {
        Hold::End => held.joint[i] = true,
        Hold::Elbow => held.elbow = true,
        Hold::Rate => held.rate = Some((i, rate)),
        Hold::Rod(rod) => held.rod = Some(rod),
    }
}

/// Factor ≤ 1 on the vector that keeps its first and its last three components within their limits.
fn share_within(v: &Vector6<f64>, limits: [f64; 2]) -> f64 {
    let part = |k: usize| v.fixed_rows::<3>(k).norm();
    (part(0) / limits[0])
        .max(part(3) / limits[1])
        .max(1.0)
        .recip()
}

/// Ranges of the joints, rad: those of the machine file, limited by the strokes of the actuators.
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
