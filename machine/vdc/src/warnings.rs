//! Warnings in the FMU's log about conditions that lead to loss of control: a step too long, a
//! reference out of reach, saturated forces or voltages, commands that are limited, and actions of
//! the supervisor. Each is reported once, when it begins.

use crate::evaluation::Evaluation;
use crate::nominal::Nominal;
use crate::reference::{Motion, Rates};
use crate::settings::{Level, Settings};
use crate::supervisor::{Cause, Stage, Supervisor};
use machine_file::Seconds;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A condition that begins at time `t`.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum Warning {
    /// The voltage law samples too slowly for its current feedback.
    #[error(
        "t = {t} s: step h = {h} s is too long for the voltage law: its current feedback K_i needs h ≤ L/K_i = {longest:.6} s"
    )]
    StepTooLong {
        /// Time, s.
        t: Seconds,
        /// Interval between two samples, s.
        h: Seconds,
        /// Longest that damps the currents without overshoot, s.
        longest: f64,
    },
    /// The reference lies where the stretched arm does not reach.
    #[error(
        "t = {t} s: the reference position is {distance:.3} m from the lift joint, out of reach: it must be within {reach:.3} m"
    )]
    OutOfReach {
        /// Time, s.
        t: Seconds,
        /// Least distance of the reference from the lift joint, however the machine is slewed, m.
        distance: f64,
        /// Length of the stretched arm, m.
        reach: f64,
    },
    /// Commanded rates lead a joint to the end of its range.
    #[error(
        "t = {t} s: the commanded rates lead joint {joint} to the end of its range at {limit:.4} rad, where it stops; its reference is {zeta:.4} rad"
    )]
    JointHeld {
        /// Time, s.
        t: Seconds,
        /// Joint, counted from 1.
        joint: usize,
        /// Reference of the joint, rad.
        zeta: f64,
        /// The end of its range, less a margin, rad.
        limit: f64,
    },
    /// Commanded rates of the tip stretch the arm.
    #[error(
        "t = {t} s: the commanded rates of the tip stretch the arm, which stops before its elbow becomes singular: zeta[3] = {zeta:.4} rad; rate.command = joint leads beyond"
    )]
    ElbowHeld {
        /// Time, s.
        t: Seconds,
        /// Reference of the tilt joint, rad.
        zeta: f64,
    },
    /// Commanded rates of the tip ask for more than twice what a joint may do, as near a
    /// singularity.
    #[error(
        "t = {t} s: the commanded rates of the tip ask joint {joint} for {required:.3} rad/s, its reference must be within {limit:.3} rad/s: the tip is slowed as a whole"
    )]
    JointRate {
        /// Time, s.
        t: Seconds,
        /// Joint, counted from 1.
        joint: usize,
        /// Rate of the joint for the whole command, rad/s.
        required: f64,
        /// Largest rate of its reference, rad/s.
        limit: f64,
    },
    /// Commanded rates of the tip near the wrist's singularity.
    #[error(
        "t = {t} s: the wrist is near its singularity, zeta[5] = {zeta:.4} rad: the tip follows the commanded rates only partly"
    )]
    WristSingular {
        /// Time, s.
        t: Seconds,
        /// Reference of the joint, rad.
        zeta: f64,
    },
    /// A joint does not follow the commanded rates.
    #[error(
        "t = {t} s: joint {joint} does not follow the commanded rates: its reference waits at {zeta:.4} rad, and nothing adapts meanwhile; is something in the \
         way, the load too large, or a drive off?"
    )]
    Blocked {
        /// Time, s.
        t: Seconds,
        /// Joint, counted from 1.
        joint: usize,
        /// Reference of the joint, rad.
        zeta: f64,
    },
    /// Commanded rates lead to where a rod cannot hold the machine.
    #[error(
        "t = {t} s: the commanded rates lead to where actuator {actuator} must hold almost its rated force of {f_max:.0} N at rest: the joints that load it \
         stop; back is possible"
    )]
    RodHeld {
        /// Time, s.
        t: Seconds,
        /// Actuator, counted from 1.
        actuator: usize,
        /// Rated force, N.
        f_max: f64,
    },
    /// The required force of a rod exceeds its limit.
    #[error(
        "t = {t} s: the law requires {required:.0} N of actuator {actuator}, whose force is limited to {f_max:.0} N (force_limit times force_max of the machine \
         file): the load is too large, the reference too fast, or control has become unstable; meanwhile nothing adapts"
    )]
    Force {
        /// Time, s.
        t: Seconds,
        /// Actuator, counted from 1.
        actuator: usize,
        /// Required force, N.
        required: f64,
        /// Limit of the force, N.
        f_max: f64,
    },
    /// The supervisor acts.
    #[error(
        "t = {t} s: supervisor: {}: {} (oscillation power: up to {power:.1} W at actuator {actuator})",
        .stage.does(), .cause.says()
    )]
    Supervisor {
        /// Time, s.
        t: Seconds,
        /// The new stage.
        stage: Stage,
        /// Why it acts.
        cause: Cause,
        /// Actuator, counted from 1.
        actuator: usize,
        /// Oscillation power: root mean square of force error times that of velocity error, W.
        power: f64,
    },
    /// The required voltage exceeds that of the drive.
    #[error(
        "t = {t} s: the voltage law requires {required:.0} V at actuator {actuator}, whose drive gives at most {v_max:.0} V (v_max and v_dc/sqrt(3)): the reference \
         is too fast, the load too large, or control has become unstable"
    )]
    Voltage {
        /// Time, s.
        t: Seconds,
        /// Actuator, counted from 1.
        actuator: usize,
        /// Required voltage, V.
        required: f64,
        /// Largest voltage of the drive, V.
        v_max: f64,
    },
}

impl Stage {
    /// The stage in words, for the warning.
    fn does(self) -> &'static str {
        match self {
            Self::Off | Self::Watching => "it watches",
            Self::Frozen => "it freezes the adaptation",
            Self::Lowered => "it lowers the gains",
            Self::Stopping => "it brings the joints to rest",
            Self::Braking => "it applies the brakes",
            Self::Stopped => "the gates are off, and the brakes hold rods and wrist",
        }
    }
}

impl Cause {
    /// The cause in words, for the warning.
    fn says(self) -> &'static str {
        match self {
            Self::None => "a reset; the gates come on, and the brakes are released next",
            Self::Swinging => "a rod swings",
            Self::Overload => "the force of a rod stays at its limit and above its rating",
            Self::Tripped => "a drive has tripped",
            Self::Following => "the tip does not follow its reference, or its error jumps",
            Self::JointEncoder => "a joint's encoder, its motor and its rod tell different motions",
            Self::JointRate => "a joint's angle is not the integral of its rate",
            Self::Stale => "a reading no longer changes",
            Self::Torque => "a motor's torque does not fit the force of its rod",
            Self::Current => "a drive does not give the commanded current",
            Self::WristRate => "a joint of the wrist runs away",
        }
    }
}

/// Conditions that were reported and still last, so that each is reported only once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReportedWarnings {
    step: bool,
    reach: bool,
    voltage: [bool; 3],
    force: [bool; 3],
    joint: [bool; 6],
    elbow: bool,
    wrist: bool,
    rate: bool,
    blocked: [bool; 6],
    rod: bool,
    supervisor: Option<Stage>,
}

impl ReportedWarnings {
    /// Whether the supervisor acts at this stage, but was not reported to. One that watches again
    /// and then acts as before is reported again.
    fn begins_to_act(&mut self, stage: Stage) -> bool {
        let acts = (stage >= Stage::Frozen).then_some(stage);
        let is_new = acts.is_some() && acts != self.supervisor;
        self.supervisor = acts;
        is_new
    }
}

/// The first condition that lasts at time `t` and is not in `reported`; `h` is the interval between
/// samples, both s. `rates`: the commanded rates with the joints' motion, if an operator commands.
pub(crate) fn first_warning(
    now: &Evaluation,
    nominal: &Nominal,
    rates: Option<(&Rates, &Motion)>,
    supervisor: &Supervisor,
    settings: &Settings,
    reported: &mut ReportedWarnings,
    [t, h]: [f64; 2],
) -> Option<Warning> {
    let (mut first, t) = (None, Seconds(t));
    let stage = supervisor.stage();
    if reported.begins_to_act(stage) {
        let (rod, power) = supervisor.largest(&nominal.ratings);
        first = Some(Warning::Supervisor {
            t,
            stage,
            cause: supervisor.cause(),
            actuator: rod + 1,
            power,
        });
    }
    let mut begins = |reported: &mut bool, lasts: bool, warning: Warning| {
        // One at a time: another condition that begins now is reported at the next step.
        if lasts && !*reported && first.is_some() {
            return;
        }
        if lasts && !*reported {
            first = Some(warning);
        }
        *reported = lasts;
    };
    let least = nominal.parameters().map(|p| p.L_d.min(p.L_q));
    let longest = least.into_iter().fold(f64::INFINITY, f64::min) / settings.gains.K_i;
    let too_long = Warning::StepTooLong {
        t,
        h: Seconds(h),
        longest,
    };
    begins(&mut reported.step, h > longest, too_long);
    if settings.level == Level::Machine {
        let reach = nominal.reach.length();
        let distance = nominal.reach.distance(now.output.desired_position);
        let out_of_reach = Warning::OutOfReach { t, distance, reach };
        begins(&mut reported.reach, distance > reach, out_of_reach);
    }
    if let Some((rates, motion)) = rates {
        let (zeta, held) = (motion.zeta, &motion.held);
        for (i, reported) in reported.joint.iter_mut().enumerate() {
            let at_end = Warning::JointHeld {
                t,
                joint: i + 1,
                zeta: zeta[i],
                limit: rates.nearest_limit(i, zeta[i]),
            };
            begins(reported, held.joint[i], at_end);
        }
        let stretched = Warning::ElbowHeld { t, zeta: zeta[2] };
        begins(&mut reported.elbow, held.elbow, stretched);
        let singular = Warning::WristSingular { t, zeta: zeta[4] };
        begins(&mut reported.wrist, held.wrist, singular);
        let (joint, required) = held.rate.unwrap_or_default();
        let slowed = Warning::JointRate {
            t,
            joint: joint + 1,
            required,
            limit: rates.largest_rate(joint),
        };
        begins(&mut reported.rate, held.rate.is_some(), slowed);
        for (i, reported) in reported.blocked.iter_mut().enumerate() {
            let blocked = Warning::Blocked {
                t,
                joint: i + 1,
                zeta: zeta[i],
            };
            let is_driven = stage < Stage::Stopping;
            begins(reported, is_driven && motion.blocked[i] != 0.0, blocked);
        }
        let rod = held.rod.unwrap_or_default();
        let loaded = Warning::RodHeld {
            t,
            actuator: rod + 1,
            f_max: nominal.ratings[rod][0],
        };
        begins(&mut reported.rod, held.rod.is_some(), loaded);
    }
    for (i, reported) in reported.force.iter_mut().enumerate() {
        let demand = &now.demands[i];
        let force = Warning::Force {
            t,
            actuator: i + 1,
            required: demand.f_unlimited,
            f_max: demand.f_max.unwrap_or(f64::INFINITY),
        };
        begins(reported, demand.f_unlimited != demand.f_r, force);
    }
    for (i, reported) in reported.voltage.iter_mut().enumerate() {
        let (required, v_max) = (now.commands[i].voltage(), now.commands[i].v_max);
        let voltage = Warning::Voltage {
            t,
            actuator: i + 1,
            required,
            v_max,
        };
        begins(reported, required > v_max, voltage);
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_action_of_the_supervisor_is_reported_once_each_time_that_it_begins() {
        use Stage::{Frozen, Lowered, Off, Stopped, Watching};
        let mut reported = ReportedWarnings::default();
        let stages = [
            Off, Watching, Frozen, Frozen, Watching, Frozen, Lowered, Lowered, Stopped, Watching,
            Watching, Lowered,
        ];
        let begun = stages.map(|stage| reported.begins_to_act(stage));
        let expected = [2, 5, 6, 8, 11];
        assert_eq!(begun, std::array::from_fn(|k| expected.contains(&k)));
    }
}
