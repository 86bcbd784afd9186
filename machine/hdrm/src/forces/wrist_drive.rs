//! Model of the wrist's drives as built, for `step` and `continuous`: first-order lag of torque,
//! saturation, inertia and dry friction of the motor at the joint, elastic gear with backlash.
//!
//! Source: B. Siciliano, L. Sciavicco, L. Villani, G. Oriolo, *Robotics: Modelling, Planning and
//! Control*, chapter on elastic joints; J. J. Moreau's time stepping for dry friction.

use crate::forces::saturate::saturate;
use model_rules::{ParamError, Range, check, check_each};
use serde::{Deserialize, Serialize};

const JOINTS: usize = 3;
/// Longest part of a substep, s: a twentieth of the period of the fastest usual mode.
const PART: f64 = 5e-5;
/// Rate, rad/s, up to which a motor that begins to slip does not count as stopped.
const AT_REST: f64 = 1e-11;
/// Damping ratio of the motor on its gear.
pub(crate) const DAMPING_RATIO: f64 = 0.1;

/// Direction in which each motor slips, 1 or −1; 0 while dry friction holds it. For Model Exchange;
/// [`Hdrm::step`](crate::Hdrm::step) does not need it.
pub type Slips = [f64; JOINTS];

/// Parameters of the wrist's drives, reflected to the joints.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WristDrive {
    /// Whether they are modelled as built; otherwise they are ideal torque sources.
    pub on: bool,
    /// Time constant from command to torque, s; 0: none.
    pub lag: f64,
    /// Dry friction, N·m.
    pub friction: [f64; JOINTS],
    /// a: at positive rates friction is 1 + a times, at negative ones 1 − a times that.
    pub asymmetry: [f64; JOINTS],
    /// Whole backlash of the gears, rad.
    pub play: f64,
    /// Stiffness of the gears, N·m/rad.
    pub stiffness: [f64; JOINTS],
    /// Inertia of the motors, kg·m².
    pub inertia: [f64; JOINTS],
}

/// State of one drive of the wrist.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WristState {
    /// Torque of the motor, N·m.
    pub(crate) motor: f64,
    /// Angle of the motor reflected to the joint, rad.
    pub(crate) angle: f64,
    /// Rate of the angle, rad/s.
    pub(crate) rate: f64,
    /// Mean torque on the joint over the last substep, N·m.
    pub(crate) transmitted: f64,
    /// How long ago the brake was commanded, s, until it acts.
    pub(crate) braked: f64,
    /// Whether the brake acts: on the motor, or from `angle` on the joint of an ideal drive.
    pub(crate) holds: bool,
}

impl WristState {
    /// The continuous states: torque of the motor (N·m), its angle (rad) and rate (rad/s).
    #[must_use]
    pub fn moving(&self) -> [f64; 3] {
        [self.motor, self.angle, self.rate]
    }

    /// The inverse of [`moving`](Self::moving).
    pub fn set_moving(&mut self, moving: [f64; 3]) {
        [self.motor, self.angle, self.rate] = moving;
    }
}

impl WristDrive {
    /// Ideal torque sources. The other values are those of servo motors on slewing drives of 2500
    /// and 800 N·m, with a tenth of the usual torque as dry friction.
    pub const IDEAL: Self = Self {
        on: false,
        lag: 5e-3,
        friction: [80.0, 80.0, 25.0],
        asymmetry: [0.0; JOINTS],
        play: 0.2 * std::f64::consts::PI / 180.0,
        stiffness: [1e6, 1e6, 2e5],
        inertia: [10.0, 10.0, 2.0],
    };

    pub(crate) fn check(&self) -> Result<(), ParamError> {
        let sizes = [("wrist.lag", self.lag), ("wrist.play", self.play)];
        check(Range::NotNegative, sizes)?;
        check_each(Range::NotNegative, "wrist.friction", &self.friction)?;
        check_each(Range::Asymmetry, "wrist.asymmetry", &self.asymmetry)?;
        check_each(Range::Positive, "wrist.stiffness", &self.stiffness)?;
        check_each(Range::Positive, "wrist.inertia", &self.inertia)
    }

    /// Drive `i` at rest with the joint angle `zeta`, rad, transmitting the torque `tau`, N·m.
    pub(crate) fn at_rest(&self, i: usize, zeta: f64, tau: f64) -> WristState {
        let play = if tau == 0.0 {
            0.0
        } else {
            0.5 * self.play.copysign(tau)
        };
        WristState {
            motor: tau,
            angle: zeta + tau / self.stiffness[i] + play,
            transmitted: tau,
            ..WristState::default()
        }
    }

    /// Torque of gear `i` on the joint, N·m, for the motor's lead `s`, rad, and its rate `s_dot`:
    /// zero within the backlash, and never pulling.
    fn gear(&self, i: usize, s: f64, s_dot: f64) -> f64 {
        let half = 0.5 * self.play;
        let bent = s - s.max(-half).min(half);
        if bent == 0.0 && half > 0.0 {
            return 0.0;
        }
        let (K, J) = (self.stiffness[i], self.inertia[i]);
        let torque = K * bent + 2.0 * DAMPING_RATIO * (K * J).sqrt() * s_dot;
        if half > 0.0 && torque * bent <= 0.0 {
            return 0.0;
        }
        torque
    }

    /// Torque of gear `i` on its joint at the angle and rate `joint`, rad and rad/s.
    pub(crate) fn transmitted(&self, i: usize, now: &WristState, joint: [f64; 2]) -> f64 {
        self.gear(i, now.angle - joint[0], now.rate - joint[1])
    }

    /// Torque of the motor, N·m; without lag it is the (saturated) command.
    fn torque(&self, now: &WristState, command: f64) -> f64 {
        if self.lag > 0.0 { now.motor } else { command }
    }

    /// Dry friction of motor `i`, N·m, against the `direction` 1 or −1, with that of a brake of the torque
    /// `brake`.
    fn friction(&self, i: usize, now: &WristState, brake: f64, direction: f64) -> f64 {
        let own = self.friction[i] * (1.0 + self.asymmetry[i] * direction);
        own + if now.holds { brake } else { 0.0 }
    }

    /// Time derivative of drive `i`, for Model Exchange; `brake` is the torque of its brake, N·m.
    pub(crate) fn rates(
        &self,
        i: usize,
        now: &WristState,
        [command, brake]: [f64; 2],
        slip: f64,
    ) -> WristState {
        let friction = self.friction(i, now, brake, slip);
        let left = self.torque(now, command) - now.transmitted - slip * friction;
        let rests = slip == 0.0 && friction > 0.0;
        let lags = self.lag > 0.0;
        WristState {
            motor: if lags {
                (command - now.motor) / self.lag
            } else {
                0.0
            },
            angle: now.rate,
            rate: if rests { 0.0 } else { left / self.inertia[i] },
            ..WristState::default()
        }
    }

    /// How far the motor's lead exceeds the backlash, rad; None without backlash.
    pub(crate) fn beyond_play(&self, now: &WristState, joint: f64) -> Option<f64> {
        (self.play > 0.0).then(|| (now.angle - joint).abs() - 0.5 * self.play)
    }

    /// Event indicator of dry friction: its torque reserve while it holds motor `i`, N·m, or the
    /// speed at which the motor slips, rad/s; None without friction.
    pub(crate) fn friction_reserve(
        &self,
        i: usize,
        now: &WristState,
        [command, brake]: [f64; 2],
        slip: f64,
    ) -> Option<f64> {
        let net = self.torque(now, command) - now.transmitted;
        let direction = if slip == 0.0 { net.signum() } else { slip };
        let friction = self.friction(i, now, brake, direction);
        (friction > 0.0).then(|| match slip {
            0.0 => friction - net.abs(),
            _ => slip * now.rate + AT_REST,
        })
    }

    /// Direction in which motor `i` slips after an event: unchanged while it moves, also where a
    /// brake meets a free motor; from rest, that of the net torque if it exceeds the dry friction,
    /// otherwise 0.
    pub(crate) fn next_slip(
        &self,
        i: usize,
        now: &mut WristState,
        [command, brake]: [f64; 2],
        slip: f64,
    ) -> f64 {
        if self.friction(i, now, brake, 0.0) == 0.0 {
            return 0.0;
        }
        if slip * now.rate > 0.0 || (slip == 0.0 && now.rate != 0.0) {
            return now.rate.signum();
        }
        now.rate = 0.0;
        let net = self.torque(now, command) - now.transmitted;
        if net.abs() >= self.friction(i, now, brake, net.signum()) {
            net.signum()
        } else {
            0.0
        }
    }

    /// Drive `i` a time `dt`, s, after `from`, with `command`, N·m, saturated to `limit`, while its
    /// joint moves from `zeta`, rad, with constant `zeta_dot`, rad/s:
    /// ```text
    /// T τ̇ = sat(τ_command) − τ,   J φ̈ = τ − τ_gear − friction
    /// ```
    /// The lag is exact; dry friction is an impulse that at most stops the motor.
    pub(crate) fn advance(
        &self,
        i: usize,
        from: &WristState,
        [command, limit, brake]: [f64; 3],
        [zeta, zeta_dot]: [f64; 2],
        dt: f64,
    ) -> WristState {
        let n = (dt / PART).ceil().max(1.0);
        let h = dt / n;
        let share = if self.lag > 0.0 {
            -libm::expm1(-h / self.lag)
        } else {
            1.0
        };
        let (target, J) = (saturate(command, limit), self.inertia[i]);
        let [back, out] = [-1.0, 1.0].map(|way| h * self.friction(i, from, brake, way) / J);
        let mut now = *from;
        let mut impulse = 0.0;
        for k in 0..n as u32 {
            now.motor += share * (target - now.motor);
            let joint = zeta + zeta_dot * h * f64::from(k);
            let gear = self.gear(i, now.angle - joint, now.rate - zeta_dot);
            impulse += h * gear;
            let free = now.rate + h * (now.motor - gear) / J;
            now.rate = free - saturate(free, if free < 0.0 { back } else { out });
            now.angle += h * now.rate;
        }
        now.transmitted = impulse / dt;
        now
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive() -> WristDrive {
        WristDrive {
            on: true,
            friction: [250.0; JOINTS],
            ..WristDrive::IDEAL
        }
    }

    /// The motor's torque approaches the command as 1 − e^(−t/T), and stays at the limit.
    #[test]
    fn the_torque_lags_and_saturates() {
        let drive = drive();
        let mut now = WristState::default();
        for k in 1..=40 {
            now = drive.advance(0, &now, [900.0, 2500.0, 0.0], [0.0; 2], 1e-3);
            let exact = 900.0 * -(-f64::from(k) * 1e-3 / 5e-3).exp_m1();
            assert!((now.motor - exact).abs() < 1e-9, "{k}: {}", now.motor);
        }
        let held = drive.advance(0, &now, [9e3, 2500.0, 0.0], [0.0; 2], 1.0);
        assert!((held.motor - 2500.0).abs() < 1e-9);
    }

    /// A joint that is held feels, once the motor has come to rest, the torque of the motor less at
    /// most the friction; the motor leads by half the play and the gear's twist. A torque below the
    /// friction moves nothing, to the last bit.
    #[test]
    fn friction_sticks_and_play_is_crossed() {
        let drive = drive();
        let mut now = drive.at_rest(1, 0.3, 700.0);
        for _ in 0..3000 {
            now = drive.advance(1, &now, [900.0, 2500.0, 0.0], [0.3, 0.0], 1e-3);
        }
        assert_eq!(now.rate, 0.0);
        assert!((now.transmitted - 900.0).abs() <= 250.0 && now.transmitted > 650.0);
        let lead = now.angle - 0.3 - 0.5 * drive.play;
        assert!((lead - now.transmitted / 1e6).abs() < 1e-9, "{lead}");
        let mut idle = WristState::default();
        for _ in 0..1000 {
            idle = drive.advance(1, &idle, [249.0, 2500.0, 0.0], [0.0; 2], 1e-3);
        }
        assert_eq!((idle.angle, idle.transmitted), (0.0, 0.0));
        for _ in 0..3000 {
            now = drive.advance(1, &now, [-900.0, 2500.0, 0.0], [0.3, 0.0], 1e-3);
        }
        let back = now.angle - 0.3 + 0.5 * drive.play;
        assert!(
            now.transmitted < 0.0 && (back - now.transmitted / 1e6).abs() < 1e-9,
            "{back}"
        );
    }

    /// A motor that a torque of 1.1 times the friction moves one way stands against the other, and slips there
    /// with what is left of 1 + a.
    #[test]
    fn friction_may_depend_on_the_direction() {
        let drive = WristDrive {
            asymmetry: [0.2; JOINTS],
            lag: 0.0,
            play: 0.1,
            ..drive()
        };
        let after = |torque: f64| {
            let rest = WristState::default();
            drive
                .advance(0, &rest, [torque, 1e6, 0.0], [0.0; 2], 0.01)
                .rate
        };
        let torque = 1.1 * drive.friction[0];
        assert_eq!(after(torque), 0.0);
        let expected = -0.01 * (1.1 - 0.8) * drive.friction[0] / drive.inertia[0];
        assert!((after(-torque) / expected - 1.0).abs() < 1e-12);
    }

    /// Without friction, play and damping that counts, motor and held joint swing with √(K/J).
    #[test]
    fn motor_and_gear_swing_at_their_frequency() {
        let drive = WristDrive {
            friction: [0.0; 3],
            play: 0.0,
            lag: 0.0,
            ..drive()
        };
        let mut now = WristState {
            angle: 1e-3,
            ..WristState::default()
        };
        let (mut crossings, mut last) = (Vec::new(), now.angle);
        for k in 1..=2000 {
            now = drive.advance(2, &now, [0.0, 800.0, 0.0], [0.0; 2], 1e-4);
            if last > 0.0 && now.angle <= 0.0 {
                crossings.push(1e-4 * (f64::from(k) - now.angle / (now.angle - last)));
            }
            last = now.angle;
        }
        let period = crossings[1] - crossings[0];
        let undamped = (2e5_f64 / 2.0).sqrt();
        let exact = std::f64::consts::TAU / (undamped * (1.0 - 0.1_f64.powi(2)).sqrt());
        // Symplectic Euler with damping is off by some ζ ω h.
        assert!((period / exact - 1.0).abs() < 5e-3, "{period}, {exact}");
    }
}
