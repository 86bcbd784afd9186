//! Monitors of plausibility, run by the supervisor in each step: whether the machine follows, and
//! whether what the sensors and drives say agrees. Each compares two ways to one quantity, and
//! alarms when they differ by more than machine and law explain, for longer than a transient.
//!
//! - The tip's error asks, through the feedback Λ, for no more than the largest speed of the tip and
//!   of a joint of the wrist; 0.7 of it does not outlive three time constants of the law's integral;
//!   it does not jump by a quarter.
//! - A joint's angle is the integral of its rate, and rod and motor move together, but for what the
//!   mounting gives way and the play.
//! - A joint or motor that is to move shows other counts, as far as it has shown that it sticks; a
//!   reading with noise never repeats for long.
//! - The torque of a motor carries the measured force, but for friction and a factor, that of
//!   magnets and gear, which is found while the machine runs; its current is the commanded one.
//! - A joint of the wrist does not keep a rate that nobody commands; it may ring.
//!
//! Differences of positions are those of rates, integrated with the forgetting times of [`COMPARED`]: so
//! zero errors and a gain error of the geometry do not count.

mod encoder;
mod lag;
mod repeats;

use super::cause::Cause;
use crate::nominal::Nominal;
use crate::reference::RateLimits;
use crate::settings::Settings;
use crate::signals::Input;
use emla::maps;
use encoder::{Encoder, FORGETS, LONGER, SHOWN, UNMOVED};
use hdrm::DOF;
use lag::share;
use repeats::Repeats;
use serde::{Deserialize, Serialize};

/// Parts of the largest error: that must not come within a step, that must not last, and below which
/// the machine has found its balance.
const SLOW: f64 = 0.25;
const LASTING: f64 = 0.7;
const SETTLED: f64 = 0.08;
/// Time constants of the law's integral within which it removes an error.
const REMOVED: f64 = 3.0;
/// Change of a rod's force over the longest time of [`COMPARED`], over the rated force, by which a
/// wrist that does not follow stands on something.
const PUSHED: f64 = 0.35;
/// Time for which a difference must last, s: readings may be lost or late.
const LASTS: f64 = 0.01;
/// Multiple of a bound beyond which a difference of positions need not last.
const AT_ONCE: f64 = 2.0;
/// Part of a bound below which an alarm that builds up is forgotten.
const RELEASES: f64 = 0.8;
/// Differences of angle and integrated rate over the times of [`COMPARED`], rad: speeds by difference lag
/// by a filter of 5 ms, so by 5 ms times the change of the rate: 2 rad/s² for the shorter time, 0.7 rad/s
/// at all.
const ANGLES: [f64; 2] = [2.5e-3, 3.5e-3];
/// Difference of joint and motor at the rod, m, without a change of force: play of screw and pins.
const PLAY: f64 = 5e-4;
/// Times over which ways of the rods are compared, s, and the errors of the nominal gear from joint
/// to rod that each explains: some per cent of a short lever, more where it is far from its place.
const COMPARED: [(f64, f64); 2] = [(0.25, 0.05), (2.5, 0.15)];
/// Lag of speeds by difference, s, by which a motor's angle and its integrated speed differ, at the rod
/// with its rated speed.
const LAG: f64 = 0.005;
/// Stiffness of the softest mounting, N/m.
const SOFTEST: f64 = 12e6;
/// Motion that a joint is to make, with the forgetting time, while its encoder shows the same count,
/// rad. A joint of the wrist sticks at its turn, the more the less it bears; the second bears the
/// payload, and without its encoder it runs away.
const UNSEEN: [f64; DOF] = [0.02, 0.02, 0.02, 0.04, 0.025, 0.05];
/// Time for which no joint stands while a rod swings, s: two periods of the slowest mode.
const SWUNG: f64 = 0.6;
/// Torque that friction explains: over that of the rated force, and over the motor's Coulomb friction.
/// A slew of little force sticks by motor, gear, screw and seals, in all by 3.2 times the latter.
const UNEXPLAINED: f64 = 0.25;
const STICKS: f64 = 4.0;
/// Factors of torque that motors have, by their magnets and their temperature, and the time in which
/// the factor is found, s, at the start a tenth of it.
const FACTOR: [f64; 2] = [0.55, 1.8];
const FOUND: f64 = 2.0;
/// Time in which it is found by what error of a joint's rate a law that does not adapt carries its load, s.
const CARRIED: f64 = 0.5;
/// Bandwidth of the comparisons of torque, current and rates of the wrist, 1/s: a wrist with an
/// empty hook rings above it.
const SMOOTHED: f64 = 50.0;
/// Current that errors of sensor and regulator explain, over the largest.
const CURRENT: f64 = 0.05;
/// Time for which a reference has stood where a push is no fault, for which a wrist may yield to it and come
/// back, and for which it follows in between, s.
const RESTED: f64 = 0.5;
const YIELDED: f64 = 2.0;
const FOLLOWED: f64 = 0.3;
/// Rate of the wrist joints of an empty hook, over the largest that is commanded, that 300 N at the tip do not
/// give them: in 150 poses up to 1.6 and 1.2 of the first two. A tenth of a drive's largest torque gives more.
const PUSHES: [f64; 3] = [1.9, 1.45, 2.5];
/// Rate, over the largest that is commanded, below which a wrist at rest does not run away, whatever its law
/// wants: near a singularity that is much.
const SLOWLY: f64 = 0.5;
/// Rate of a wrist joint over the largest that is commanded: of one that finds its balance, and
/// later beyond the wanted one: 0.53 for joints that stick at their turn, more for one that yields, as the tip
/// stands on something. The last has the least inertia, and jumps when it no longer sticks.
const UNSETTLED: f64 = 4.0;
const RUNAWAY: [f64; 3] = [0.7, 0.7, 2.5];
const YIELDS: f64 = 1.5;
/// Acceleration of a wrist joint that is faster than any command, rad/s², and the shortest step that
/// shows it, s: the largest torques give an empty hook 500 to 1000.
const JUMPS: f64 = 300.0;
const SHORTEST: f64 = 1e-3;
/// By what a wrist joint's rate from two angles exceeds its filtered one when its drive sets off, rad/s, and
/// the multiple of what it has shown so far: less may be noise or a coarse encoder, more than the last is an
/// encoder that jumps. After a lost reading it is up to 2.4 times the rate, in a longer step, and never turned
/// against it; several may be lost of a joint that creeps, rad/s. A push of 300 N makes 0.16.
const AHEAD: (f64, f64, f64) = (0.2, 2.0, 2.0);
const LOST: f64 = 2.0;
const CREEPS: f64 = 0.05;
/// Acceleration of a rod or its motor that only a sensor tells, over the rated speed, 1/s: machines of
/// the strict world have 40.
const SPEED_JUMPS: f64 = 200.0;

/// What the law makes of the measurements, which the monitors compare them with.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Plausibility {
    /// Desired minus actual tip position, m, and angle between the orientations, rad.
    pub(crate) tip_error: [f64; 3],
    pub(crate) orientation_error: f64,
    /// Whether the reference moves.
    pub(crate) moves: bool,
    /// Whether commanded rates wait for a joint of the boom, and of the wrist, that does not follow: the
    /// error is bounded then.
    pub(crate) waits: [bool; 2],
    /// Rod travel per angle of the first three joints, m/rad.
    pub(crate) primes: [f64; 3],
    /// Required joint rates, rad/s.
    pub(crate) zeta_dot_r: [f64; DOF],
    /// Required quadrature-axis currents, A.
    pub(crate) i_q_required: [f64; 3],
}

/// What is compared in a step of `h` s: the measurements `input`, and what the law makes of them.
pub(crate) struct Moment<'a> {
    pub(crate) now: &'a Plausibility,
    pub(crate) nominal: &'a Nominal,
    pub(crate) settings: &'a Settings,
    pub(crate) input: &'a Input,
    /// Whether nothing hangs on the hook, so that a push turns the wrist.
    pub(crate) is_hook_empty: bool,
    pub(crate) h: f64,
}

impl Moment<'_> {
    /// Speeds of rod `i`, counted from 0, by its joint, its motor and its own encoder, m/s.
    fn rod_speeds(&self, i: usize) -> [f64; 3] {
        let (now, input) = (self.now, self.input);
        let by_motor = maps::travel_per_radian(self.nominal.parameters()[i]) * input.w_m[i];
        [now.primes[i] * input.zeta_dot[i], by_motor, input.x_dot[i]]
    }
}

/// A difference beyond its bound, with hysteresis.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Alarm {
    /// Time for which it has lasted, s.
    lasted: f64,
}

impl Alarm {
    /// Whether `size` has been above `bound` for `time` s; it is forgotten below [`RELEASES`] of it.
    fn add(&mut self, size: f64, bound: f64, time: f64, h: f64) -> bool {
        if size > bound {
            self.lasted += h;
        } else if size < RELEASES * bound {
            self.lasted = 0.0;
        }
        self.lasted > time
    }

    /// As [`add`](Self::add) for a difference of positions, which at [`AT_ONCE`] times its bound need
    /// not last.
    fn add_position(&mut self, size: f64, bound: f64, h: f64) -> bool {
        self.add(size, bound, LASTS, h) || size > AT_ONCE * bound
    }
}

/// Ways of a rod over one of the times of [`COMPARED`].
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Way {
    /// By its joint, m.
    travelled: f64,
    /// That by the joint minus those by the motor's speed and by the rod's encoder, and that by the
    /// motor's angle minus that by its speed, m.
    differences: [f64; 3],
    alarms: [Alarm; 3],
    /// Force with the forgetting time, N.
    force: f64,
}

/// Rates of a wrist joint, rad/s.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct WristRates {
    /// In the step before.
    before: f64,
    smoothed: f64,
    /// What it had more than was wanted, smoothed.
    more: f64,
    /// By what the rate of two angles differed from it at most.
    ahead: f64,
}

/// States of all monitors.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Monitors {
    has_begun: bool,
    /// Of the largest tip error, and of one that lasts.
    following: [Alarm; 2],
    /// Time for which the error has been small, s: while a machine finds its balance after the start,
    /// only jumps count.
    settled: f64,
    /// Errors of the step before, m and rad.
    error: [f64; 3],
    orientation_error: f64,
    /// Angles minus their integrated rates, over the times of [`COMPARED`], rad.
    angles: [[f64; COMPARED.len()]; DOF],
    rates: [[Alarm; COMPARED.len()]; DOF],
    ways: [[Way; COMPARED.len()]; 3],
    /// Speeds of the rods in the step before by joint, motor and encoder, m/s.
    speeds: [[f64; 3]; 3],
    /// Of the joints and the motors; until `stale` adds the new readings they have those of the step before.
    encoders: [Encoder; DOF + 3],
    /// Currents and forces.
    noisy: [[Repeats; 3]; 3],
    /// Torque that force and friction do not explain, as z of the observer `ω (z − J w)`, N·m·s.
    torques: [f64; 3],
    /// Factor of each motor's torque.
    factors: [f64; 3],
    /// Time for which the machine has been watched, and for which its reference moved meanwhile, s.
    looked: f64,
    moved: f64,
    /// Time for which the reference has stood, for which the wrist has yielded, and since it last did, s.
    stood: f64,
    yielded: f64,
    followed: f64,
    /// Errors of the joints' rates by which a law that does not adapt carries its load, rad/s.
    carried: [f64; DOF],
    drags: [Alarm; 3],
    /// Smoothed differences of direct and quadrature current from their commands, A.
    currents: [[f64; 2]; 3],
    disobeys: [Alarm; 3],
    /// Currents commanded in the step before, A.
    commanded: [f64; 3],
    wrist: [WristRates; 3],
    /// Drives of rods and wrist that do not do what they are told.
    pub(super) erring: [bool; DOF],
}

impl Monitors {
    /// Advances by a step; the first cause for alarm. `swings`: a rod does, although gains are lowered.
    pub(crate) fn advance(&mut self, at: &Moment, swings: bool) -> Option<Cause> {
        if !self.has_begun {
            self.begin(at);
        }
        self.looked += at.h;
        let wanted = self.wanted(at);
        let (runs_away, is_far) = (self.wrist_runs_away(at, &wanted), self.following(at));
        let yields = is_far || runs_away.contains(&true);
        let may_yield = self.yields_to_push(yields, at);
        let errs = yields && !may_yield;
        for (errs_already, runs_away) in self.erring[3..].iter_mut().zip(runs_away) {
            *errs_already |= errs && runs_away;
        }
        let alarms = [
            (Cause::Current, self.currents(at)),
            (Cause::JointRate, self.angles(at)),
            (Cause::JointEncoder, self.rods(at)),
            (Cause::WristRate, self.erring[3..].contains(&true)),
            (Cause::Stale, self.stale(at, &wanted, swings)),
            (Cause::Torque, self.torques(at)),
            (Cause::Following, errs && is_far),
        ];
        let first = alarms.into_iter().find(|(_, is_on)| *is_on);
        first.map(|(cause, _)| cause)
    }

    fn begin(&mut self, at: &Moment) {
        let (now, nominal, input) = (at.now, at.nominal, at.input);
        *self = Self {
            has_begun: true,
            error: now.tip_error,
            orientation_error: now.orientation_error,
            // As if it had been compared before: a filter's angle lags by its time times its rate.
            angles: input.zeta_dot.map(|rate| [LAG * rate; COMPARED.len()]),
            speeds: std::array::from_fn(|i| at.rod_speeds(i)),
            ways: input.F.map(|force| {
                [Way {
                    force,
                    ..Way::default()
                }; COMPARED.len()]
            }),
            encoders: std::array::from_fn(|j| {
                let motor = || input.theta_m.map_or(0.0, |angles| angles[j - DOF]);
                Encoder::at(input.zeta.get(j).copied().unwrap_or_else(motor))
            }),
            commanded: now.i_q_required,
            wrist: std::array::from_fn(|j| WristRates {
                before: input.zeta_dot[3 + j],
                ..WristRates::default()
            }),
            factors: [1.0; 3],
            torques: std::array::from_fn(|i| {
                maps::inertia(nominal.parameters()[i], 1.0) * input.w_m[i]
            }),
            ..Self::default()
        };
    }

    /// Errors of the tip's position and orientation, over those at which the feedback asks for the
    /// largest speed of the tip and of a joint of the wrist.
    fn following(&mut self, at: &Moment) -> bool {
        let (now, settings, h) = (at.now, at.settings, at.h);
        let (gains, limits) = (&settings.gains, RateLimits::default());
        let most = limits.tip[0] / gains.Lambda_position;
        let over_most = |distance: f64, angle: f64| {
            (distance / most).max(angle.abs() * gains.Lambda_orientation / limits.joint[DOF - 1])
        };
        let error = over_most(length(now.tip_error), now.orientation_error);
        let jump = length(std::array::from_fn(|k| now.tip_error[k] - self.error[k]));
        let jumps = over_most(jump, now.orientation_error - self.orientation_error) > SLOW;
        (self.error, self.orientation_error) = (now.tip_error, now.orientation_error);
        // Without a model the error is that of the load, and the law has no bound for it.
        let has_model = settings.mode.law().knows_actuators();
        let removes = removes(settings);
        if now.waits[0] || now.waits[1] && self.is_pushed(at) {
            self.settled = 0.0;
        }
        if self.settled < removes {
            self.settled = if error < SETTLED {
                self.settled + h
            } else {
                0.0
            };
            return jumps;
        }
        let lasts = self.following[1].add(error, LASTING, removes, h);
        let is_far = self.following[0].add(error, 1.0, LASTS, h);
        jumps || has_model && (is_far || lasts)
    }

    /// Rates that the law wants of the joints, but for what carries a load that it does not know, rad/s.
    fn wanted(&mut self, at: &Moment) -> [f64; DOF] {
        let required = at.now.zeta_dot_r;
        if at.settings.mode.law().adapts() {
            return required;
        }
        let found = share(at.h / CARRIED);
        std::array::from_fn(|j| {
            let error = required[j] - at.input.zeta_dot[j];
            self.carried[j] += found * (error - self.carried[j]);
            required[j] - self.carried[j]
        })
    }

    /// Whether a rod's force shows that the tip stands on something.
    fn is_pushed(&self, at: &Moment) -> bool {
        let slowest = self.ways.iter().map(|ways| ways[COMPARED.len() - 1].force);
        let mut rods = slowest.zip(at.input.F).zip(&at.nominal.ratings);
        rods.any(|((before, force), rated)| (force - before).abs() > PUSHED * rated[0])
    }

    /// Angles compared with their integrated rates.
    fn angles(&mut self, at: &Moment) -> bool {
        let (input, h) = (at.input, at.h);
        let (mut is_on, forgets) = (false, forgotten(h));
        for j in 0..DOF {
            let more = input.zeta[j] - self.encoders[j].angle - h * input.zeta_dot[j];
            for k in 0..COMPARED.len() {
                let difference = &mut self.angles[j][k];
                *difference += more - forgets[k] * *difference;
                is_on |= self.rates[j][k].add_position(difference.abs(), ANGLES[k], h);
            }
        }
        is_on
    }

    /// Ways of the rods by their joints, by the motors, and by their own encoders.
    fn rods(&mut self, at: &Moment) -> bool {
        let (nominal, input, h) = (at.nominal, at.input, at.h);
        let (mut is_on, forgets) = (false, forgotten(h));
        for (i, ways) in self.ways.iter_mut().enumerate() {
            let speeds = at.rod_speeds(i);
            let [by_joint, by_motor, by_rod] = speeds;
            let turned = input
                .theta_m
                .map(|angles| angles[i] - self.encoders[DOF + i].angle);
            let travel = maps::travel_per_radian(nominal.parameters()[i]);
            let by_angle = turned.map_or(by_motor, |turned| travel * turned / h);
            let most = SPEED_JUMPS * nominal.ratings[i][1] * h.max(SHORTEST);
            for (before, speed) in self.speeds[i].iter_mut().zip(speeds) {
                is_on |= (speed - *before).abs() > most;
                *before = speed;
            }
            for ((way, (_, gear)), forgets) in ways.iter_mut().zip(COMPARED).zip(forgets) {
                way.force += forgets * (input.F[i] - way.force);
                way.travelled += h * by_joint - forgets * way.travelled;
                let geared = PLAY + gear * way.travelled.abs();
                // A rod that pushes is shorter than its motor says, and has its play behind it.
                let bent = (way.force - input.F[i]) / SOFTEST;
                let given = (bent * way.differences[0].signum()).max(-0.5 * PLAY);
                let pairs = [
                    (by_joint, by_motor, geared + given),
                    (by_joint, by_rod, geared),
                    (by_angle, by_motor, LAG * nominal.ratings[i][1]),
                ];
                for (k, (one, other, bound)) in pairs.into_iter().enumerate() {
                    let difference = &mut way.differences[k];
                    *difference += h * (one - other);
                    *difference -= forgets * *difference;
                    is_on |= way.alarms[k].add_position(difference.abs(), bound, h);
                }
            }
        }
        is_on
    }

    /// Encoders that show no motion, and readings without their noise. Where all noise of an axis is gone,
    /// it has none. A rod that swings moves all joints. How a joint sticks is not known before the reference
    /// has moved.
    fn stale(&mut self, at: &Moment, wanted: &[f64; DOF], swings: bool) -> bool {
        let (now, input, h) = (at.now, at.input, at.h);
        let mut is_on = false;
        self.moved += if now.moves { h } else { 0.0 };
        let is_moved = self.moved > 2.0 * FORGETS;
        let motors = input.theta_m.into_iter().flatten();
        let readings = input.zeta.into_iter().chain(motors);
        for (k, (encoder, angle)) in self.encoders.iter_mut().zip(readings).enumerate() {
            let j = k % DOF;
            let bound = if k < DOF { UNSEEN[j] } else { f64::INFINITY };
            let unseen = encoder.add(angle, wanted[j], UNMOVED[j], h);
            let is_stale = is_moved && encoder.is_stale(self.looked, UNMOVED[j]);
            is_on |= unseen > bound || is_stale;
            is_on |= swings && k < DOF && encoder.stands[0] > SWUNG.max(LONGER * encoder.most[0]);
        }
        for (i, noisy) in self.noisy.iter_mut().enumerate() {
            let readings = [input.i_d[i], input.i_q[i], input.F[i]];
            let (mut is_noisy, mut is_stale) = (false, false);
            for (repeats, reading) in noisy.iter_mut().zip(readings) {
                is_noisy |= repeats.add(reading);
                is_stale |= repeats.is_stale();
            }
            is_on |= is_noisy && is_stale;
        }
        is_on
    }

    /// Torques of the motors compared with what the measured forces ask for:
    /// ```text
    /// k' = (τ − k τ_F) τ_F/(T (τ_F² + (b τ_rated)²))
    /// ```
    fn torques(&mut self, at: &Moment) -> bool {
        let (nominal, input, h) = (at.nominal, at.input, at.h);
        let reached = share(h * SMOOTHED);
        let found = share(h / self.looked.clamp(0.1 * FOUND, FOUND));
        let is_found = self.looked > 0.5 * FOUND;
        let mut is_on = false;
        for i in 0..3 {
            let p = nominal.parameters()[i];
            let momentum = maps::inertia(p, 1.0) * input.w_m[i];
            let needed = maps::required_torque(p, input.F[i], input.w_m[i], 0.0);
            let of_force = UNEXPLAINED * nominal.ratings[i][0] * maps::travel_per_radian(p);
            let bound = of_force.max(STICKS * p.tau_C);
            let factor = &mut self.factors[i];
            let more = maps::torque(p, input.i_d[i], input.i_q[i]) - *factor * needed;
            *factor += found * more * needed / (needed * needed + bound * bound);
            let z = &mut self.torques[i];
            *z += reached * (momentum - *z + more / SMOOTHED);
            let unexplained = (SMOOTHED * (*z - momentum)).abs();
            let is_odd = !(FACTOR[0]..FACTOR[1]).contains(factor);
            let size = if is_odd { f64::INFINITY } else { unexplained };
            let drags = self.drags[i].add(size, bound, 5.0 / SMOOTHED, h);
            self.erring[i] |= drags && (is_found || is_odd);
            is_on |= self.erring[i];
        }
        is_on
    }

    /// Currents compared with their commands, where the drives regulate them.
    fn currents(&mut self, at: &Moment) -> bool {
        let (now, nominal, settings, input, h) = (at.now, at.nominal, at.settings, at.input, at.h);
        if !settings.current_loop {
            return false;
        }
        let reached = share(h * SMOOTHED);
        let mut is_on = false;
        for i in 0..3 {
            let differences = [input.i_d[i], input.i_q[i] - self.commanded[i]];
            let [d, q] = &mut self.currents[i];
            *d += reached * (differences[0] - *d);
            *q += reached * (differences[1] - *q);
            let size = (*d * *d + *q * *q).sqrt();
            let bound = CURRENT * nominal.parameters()[i].i_max;
            let disobeys = self.disobeys[i].add(size, bound, 0.0, h);
            self.erring[i] |= disobeys;
            is_on |= disobeys;
        }
        self.commanded = now.i_q_required;
        is_on
    }

    /// Which joints of the wrist are faster than what is wanted of them. Those that are faster than any
    /// command or push, jump or set off, err.
    fn wrist_runs_away(&mut self, at: &Moment, wanted: &[f64; DOF]) -> [bool; 3] {
        let (settings, input, h) = (at.settings, at.input, at.h);
        let (limits, reached) = (RateLimits::default().joint, share(h * SMOOTHED));
        let is_settled = self.settled >= removes(settings);
        let is_looked = self.looked > SHOWN[0];
        let yields = if self.is_pushed(at) { YIELDS } else { 0.0 };
        let mut run_away = [false; 3];
        for ((j, rates), runs_away) in (3..DOF).zip(&mut self.wrist).zip(&mut run_away) {
            let (encoder, rate, limit) = (&self.encoders[j], input.zeta_dot[j], limits[j]);
            let more = rate - wanted[j];
            let step = h.max(SHORTEST);
            let jumps = (rate - rates.before).abs() > JUMPS * step && more.abs() > limit;
            // The angle shows it earlier, unless readings of a moving joint were lost before.
            let is_whole = encoder.stands[0] == 0.0 || rates.before.abs() < CREEPS;
            let by_angles = (input.zeta[j] - encoder.angle) / step;
            let starts = is_whole && is_looked && is_ahead(by_angles, rate, rates.ahead);
            if is_whole && self.looked > h {
                rates.ahead = rates.ahead.max((by_angles - rate).abs());
            }
            rates.before = rate;
            rates.smoothed += reached * (rate - rates.smoothed);
            rates.more += reached * (more - rates.more);
            let rests = self.stood > RESTED;
            let [fast, more] = [rates.smoothed, rates.more].map(|rate| rate.abs() / limit);
            *runs_away =
                is_settled && more > RUNAWAY[j - 3].max(yields) && (!rests || fast > SLOWLY);
            let is_pushed = rests && *runs_away && fast > PUSHES[j - 3];
            let errs = is_settled && (jumps || starts) || is_pushed;
            self.erring[j] |= errs || fast > UNSETTLED;
        }
        run_away
    }

    /// Whether a wrist that `yields` may do so: with an empty hook, pushed while the reference stands.
    fn yields_to_push(&mut self, yields: bool, at: &Moment) -> bool {
        self.stood = if at.now.moves { 0.0 } else { self.stood + at.h };
        self.followed = if yields { 0.0 } else { self.followed + at.h };
        self.yielded = if self.followed < FOLLOWED {
            self.yielded + at.h
        } else {
            0.0
        };
        at.is_hook_empty && self.stood > RESTED && self.yielded < YIELDED
    }
}

/// Time in which the law's integral removes an error, s.
fn removes(settings: &Settings) -> f64 {
    REMOVED / settings.gains.omega_tip.max(1e-3)
}

/// Whether the rate of a wrist joint by two angles says that its drive sets off while the filtered `rate`
/// does not show it yet; `shown` is the largest difference so far, all rad/s.
fn is_ahead(by_angles: f64, rate: f64, shown: f64) -> bool {
    let is_turned = by_angles * rate < 0.0;
    let lost = if is_turned { 0.0 } else { LOST * rate.abs() };
    let (least, multiple, most) = AHEAD;
    (least.max(lost).max(multiple * shown)..most).contains(&(by_angles - rate).abs())
}

fn length(of: [f64; 3]) -> f64 {
    of.iter().map(|part| part * part).sum::<f64>().sqrt()
}

/// Shares of the times of [`COMPARED`] that a step of `h` s forgets.
fn forgotten(h: f64) -> [f64; COMPARED.len()] {
    COMPARED.map(|(time, _)| share(h / time))
}

#[cfg(test)]
mod tests;
