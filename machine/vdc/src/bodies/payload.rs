//! Detects an empty hook while the machine rests after the start ("weighing"), for `Bodies::weigh`.
//! Not in the paper, whose controller knows its payload.
//!
//! Without payload the inertia at the wrist is a twentieth: gains for the payload, sampled and
//! delayed, then make the wrist oscillate, and gains for the empty hook let a payload sway. If the
//! wrist begins to oscillate, torque and acceleration show its inertia. If that is the wrist's own,
//! and the load cells of lift and tilt find no mass, and the wrist no moment but its own, the nominal
//! payload is removed, and with it the gains based on its inertia. At rest the payload is kept.
//!
//! None of the three is enough by itself. A payload whose centre is not where the controller has it
//! sets off on its own, which looks like little inertia; one close to the joint has little inertia;
//! a hanging one has no moment; and the load cells feel the booms' errors, too.

use hdrm::DOF;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// Time constants of the band-pass, s: the slow one removes weight and drift, the fast one noise.
/// Higher frequencies are damped equally in torque and acceleration.
const BAND: [f64; 2] = [0.15, 0.03];
/// Forgetting time of the least squares, s.
const MEMORY: f64 = 0.1;
/// Smallest inertial moment of the payload above noise, over the largest of its weight.
const LEAST_MOMENT: f64 = 0.2;
/// Share of the nominal payload below which the hook counts as empty; above it the gains for the
/// payload have a phase margin, even with a delay of three steps.
const EMPTY: f64 = 0.33;
/// Factor on it for a hook that has been found empty, or a doubt would make it set off again.
const STAYS: f64 = 1.5;
/// Share of an empty hook: negligible compared with the wrist's own inertia.
const NOTHING: f64 = 0.02;
/// Moment that an empty hook may seem to hold, over the largest of the payload's weight: that of 15
/// kg half a metre off, which gains for the empty hook still hold.
const MOMENT: f64 = 0.033;
/// Time in which the moment becomes certain, s: before, a late rate and a torque that jumps between
/// its limits look like one.
const UNCERTAIN: f64 = 0.1;
/// Smallest sine of the angle between the booms' and the payload's moments at lift and tilt with
/// which both are told apart; below it the booms count as known.
const APART: f64 = 0.1;

/// What the controller expects to feel of the hook in the present pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct HookModel {
    /// Inertia of the machine's own bodies about each wrist joint, kg·m².
    pub(crate) own: [f64; 3],
    /// Inertia of the nominal payload about the second wrist joint, kg·m².
    pub(crate) payload: f64,
    /// `g √(m I)` of the nominal payload, its largest moment, N·m.
    pub(crate) weight: f64,
    /// Generalised forces that hold the machine's own bodies at rest, N·m.
    pub(crate) own_moments: [f64; DOF],
    /// The same for the nominal payload.
    pub(crate) payload_moments: [f64; DOF],
}

/// What is felt of the hook: torques and rates of the wrist joints, N·m and rad/s, and moments of
/// the rods about lift and tilt joint, N·m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct HookReadings {
    pub(crate) torque: [f64; 3],
    pub(crate) rate: [f64; 3],
    pub(crate) booms: [f64; 2],
}

/// The second wrist joint, counted from the first, about which the payload has its largest inertia.
const SECOND: usize = 1;

/// Whether the hook is empty, by its inertia, its mass and its moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Weighing {
    inertia: PayloadShare,
    /// Time so far, s, and the integral of the booms' moments, N·m·s.
    time: f64,
    booms: [f64; 2],
    /// Rates of the wrist joints at the start, rad/s.
    rates: [f64; 3],
    /// Impulse of the payload's weight about each wrist joint, `∫ τ − τ_own dt − I_0 (ω − ω(0))`,
    /// without the last term, N·m·s.
    impulse: [f64; 3],
    /// Integral over the time t of t times that impulse, N·m·s³.
    slope: [f64; 3],
    /// Whether load cells and wrist feel nothing on the hook.
    feels_empty: bool,
    is_empty: bool,
}

impl Weighing {
    /// Whether the hook is empty by what was felt so far.
    pub(crate) fn is_empty(&self) -> bool {
        self.is_empty
    }

    /// Whether load cells and wrist feel nothing on the hook, whatever its inertia.
    pub(crate) fn feels_empty(&self) -> bool {
        self.feels_empty
    }

    /// Advances by `h` s and returns the share of the nominal payload to use: 1, or that of an
    /// empty hook.
    pub(crate) fn advance(&mut self, felt: &HookReadings, hook: &HookModel, h: f64) -> f64 {
        let (torque, rate) = (felt.torque[SECOND], felt.rate[SECOND]);
        let share = self.inertia.advance(torque, rate, hook, h);
        if self.time == 0.0 {
            self.rates = felt.rate;
        }
        for (sum, moment) in self.booms.iter_mut().zip(felt.booms) {
            *sum += h * moment;
        }
        self.time += h;
        for j in 0..3 {
            self.impulse[j] += h * (felt.torque[j] - hook.own_moments[3 + j]);
            let momentum = hook.own[j] * (felt.rate[j] - self.rates[j]);
            self.slope[j] += h * self.time * (self.impulse[j] - momentum);
        }
        let part = if self.is_empty { STAYS } else { 1.0 } * EMPTY;
        let [own, mass] = self.masses(hook);
        self.feels_empty = mass < part && !self.holds_moment(hook, own);
        self.is_empty = share < part && self.feels_empty;
        if self.is_empty { NOTHING } else { 1.0 }
    }

    /// Masses of the machine's own bodies and on the hook over their nominal ones, s and m, from the
    /// mean moments Q of lift and tilt joint: `Q = s·own + m·payload`.
    fn masses(&self, hook: &HookModel) -> [f64; 2] {
        let at_booms = |Q: &[f64; DOF]| Vector2::new(Q[1], Q[2]);
        let own = at_booms(&hook.own_moments);
        let payload = at_booms(&hook.payload_moments);
        let Q = Vector2::from(self.booms) / self.time;
        let apart = own.perp(&payload);
        if apart.abs() > APART * own.norm() * payload.norm() {
            [Q.perp(&payload) / apart, own.perp(&Q) / apart]
        } else if payload.norm_squared() > 0.0 {
            [1.0, payload.dot(&(Q - own)) / payload.norm_squared()]
        } else {
            [1.0, 0.0]
        }
    }

    /// Whether a wrist joint holds a moment: the slope of the impulse over time by least squares,
    /// `3/t³ ∫ t J dt`, in which an oscillation leaves little. Bodies that have `own` times their
    /// nominal mass at the booms may have it at the wrist, too: what they explain does not count.
    fn holds_moment(&self, hook: &HookModel, own: f64) -> bool {
        let most = MOMENT * hook.weight * (1.0 + UNCERTAIN / self.time);
        let holds = |(slope, nominal): (&f64, &f64)| {
            let moment = 3.0 * slope / self.time.powi(3);
            let explained = (own - 1.0) * nominal;
            let rest = moment - moment.clamp(explained.min(0.0), explained.max(0.0));
            rest.abs() > most
        };
        self.slope.iter().zip(&hook.own_moments[3..]).any(holds)
    }
}

/// Recursive least squares for the share of the nominal payload's inertia.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct PayloadShare {
    /// The estimate.
    share: f64,
    begun: bool,
    /// Torque, N·m, and rate, rad/s, after the fast lag; `slow` after the slow one.
    torque: f64,
    rate: f64,
    slow: [f64; 2],
    /// Exponentially forgotten ∫ φ² dt, N²·m²·s.
    square: f64,
}

impl Default for PayloadShare {
    fn default() -> Self {
        Self {
            share: 1.0,
            begun: false,
            torque: 0.0,
            rate: 0.0,
            slow: [0.0; 2],
            square: 0.0,
        }
    }
}

impl PayloadShare {
    /// Advances by `h` s with `rate`, rad/s, and `torque`, N·m, of the joint; returns the estimate.
    /// ```text
    /// τ_b − I_0 a_b = share·φ,   φ = I a_b,   a = (ω − ω_f)/T
    /// share' = φ (τ_b − I_0 a_b − share·φ)/(ρ + ∫ φ² dt)
    /// ```
    /// Torque and acceleration pass the same band-pass (index b), so no rate is differentiated. An
    /// oscillation too fast for the readings' delay lowers the correlation, and the share with it.
    fn advance(&mut self, torque: f64, rate: f64, hook: &HookModel, h: f64) -> f64 {
        let [slow, fast] = BAND;
        if !self.begun {
            (self.begun, self.torque, self.rate) = (true, torque, rate);
            self.slow = [torque, 0.0];
        }
        let acceleration = (rate - self.rate) / fast;
        let [torque_b, a_b] = [self.torque - self.slow[0], acceleration - self.slow[1]];
        let expected = hook.payload * a_b;
        let least = LEAST_MOMENT * hook.weight;
        self.square = libm::exp(-h / MEMORY) * self.square + h * expected * expected;
        let error = torque_b - hook.own[SECOND] * a_b - self.share * expected;
        let weight = MEMORY * least * least + self.square;
        if weight > 0.0 {
            self.share = (self.share + h * expected * error / weight).clamp(NOTHING, 1.0);
        }
        let reached = |time: f64| -libm::expm1(-h / time);
        self.slow[0] += reached(slow) * (self.torque - self.slow[0]);
        self.slow[1] += reached(slow) * (acceleration - self.slow[1]);
        self.torque += reached(fast) * (torque - self.torque);
        self.rate += reached(fast) * (rate - self.rate);
        self.share
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOOK: HookModel = HookModel {
        own: [6.0; 3],
        payload: 100.0,
        weight: 1700.0,
        own_moments: [0.0, 11e3, 6e3, 0.0, 100.0, 0.0],
        payload_moments: [0.0, 9e3, 9.5e3, 0.0, 0.0, 0.0],
    };

    /// A payload with the shares `mass` and `inertia` of the nominal one, whose weight turns the
    /// second wrist joint with `moment`, N·m, on a machine that is `own` times as heavy as believed.
    struct Payload {
        mass: f64,
        inertia: f64,
        moment: f64,
        own: f64,
    }

    /// The joint under gains for the payload that is believed, integrated here with readings three
    /// steps old. The share at the end, the share of the time with an empty hook, and the largest
    /// rate in the last tenth of the time, rad/s.
    fn weighed(payload: &Payload) -> (f64, f64, f64) {
        let moved = HOOK.own[1] + payload.inertia * HOOK.payload;
        let mut found = Weighing::default();
        let (h, mut last) = (1e-3, 1.0);
        let (mut angle, mut rate) = (0.0, 0.01);
        let (mut late, mut end, mut empty) = ([[0.0; 2]; 3], 0.0_f64, 0.0);
        let booms =
            |i: usize| payload.own * HOOK.own_moments[i] + payload.mass * HOOK.payload_moments[i];
        let moment = payload.moment + payload.own * HOOK.own_moments[4];
        for k in 0..500 {
            let I = HOOK.own[1] + last * HOOK.payload;
            let [seen, turned] = late[2];
            let torque = (-I * (45.0 * seen + 450.0 * turned)).clamp(-2500.0, 2500.0);
            let felt = HookReadings {
                torque: [0.0, torque, 0.0],
                rate: [0.0, seen, 0.0],
                booms: [booms(1), booms(2)],
            };
            last = found.advance(&felt, &HOOK, h);
            empty += f64::from(u8::from(last < 1.0)) / 500.0;
            late = [[rate, angle], late[0], late[1]];
            rate += h * (torque - moment) / moved;
            angle += h * rate;
            if k > 450 {
                end = end.max(rate.abs());
            }
        }
        (last, empty, end)
    }

    /// A hook without a payload begins to swing, is taken for empty, and is calm then, on a machine
    /// heavier or lighter than believed, too; what does not swing is not.
    #[test]
    fn a_hook_that_swings_is_found_empty() {
        for (share, own, expected) in [
            (0.003, 1.0, NOTHING),
            (0.003, 2.2, NOTHING),
            (0.003, 1.4, NOTHING),
            (0.003, 0.6, NOTHING),
            (0.4, 1.0, 1.0),
            (1.0, 1.0, 1.0),
            (1.4, 1.0, 1.0),
        ] {
            let (mass, inertia, moment) = (share, share, -30.0);
            let payload = Payload {
                mass,
                inertia,
                moment,
                own,
            };
            let (last, _, end) = weighed(&payload);
            assert_eq!(last, expected, "{share} {own}");
            assert!(end < 0.1, "{share}: {end} rad/s at the end");
        }
    }

    /// What the load cells or the wrist's moment contradict is never called empty, however small
    /// its inertia or however it sets off: a full load that sags, one close to the joint, and a
    /// light one far off.
    #[test]
    fn a_payload_with_a_shifted_centre_is_not_called_empty() {
        for (mass, inertia, moment) in [
            (1.0, 1.0, 1300.0),
            (1.0, 1.2, -900.0),
            (0.5, 0.01, 20.0),
            (0.1, 0.05, 200.0),
        ] {
            let payload = Payload {
                mass,
                inertia,
                moment,
                own: 1.0,
            };
            let (last, empty, _) = weighed(&payload);
            assert_eq!((last, empty), (1.0, 0.0), "{mass} {inertia} {moment}");
        }
    }

    /// Load cells that doubt a little what has been found, as shaken by the hook that sets off, do
    /// not bring the payload back; with as much from the start the hook is not empty.
    #[test]
    fn a_doubt_does_not_fill_an_empty_hook() {
        for (first, then, is_empty) in [(0.0, 0.4, true), (0.4, 0.4, false), (0.0, 0.6, false)] {
            let mut weighing = Weighing::default();
            for k in 0..100 {
                // A swing without an inertia of a payload.
                let swing = (0.1 * f64::from(k)).sin();
                let mass = if k < 50 { first } else { 2.0 * then - first };
                let felt = HookReadings {
                    torque: [0.0, HOOK.own[1] * 100.0 * swing, 0.0],
                    rate: [0.0, 1.0 - (0.1 * f64::from(k)).cos(), 0.0],
                    booms: [1, 2].map(|i| HOOK.own_moments[i] + mass * HOOK.payload_moments[i]),
                };
                weighing.advance(&felt, &HOOK, 1e-3);
            }
            assert_eq!(weighing.is_empty(), is_empty, "{first} {then} {weighing:?}");
        }
    }

    /// Mass and an error of all booms by two equations; where the moments of booms and payload are
    /// alike, the booms count as known.
    #[test]
    fn load_cells_tell_the_payload_from_heavier_booms() {
        let found = |Q: [f64; 2], hook: &HookModel| {
            let mut weighing = Weighing::default();
            let felt = HookReadings {
                booms: Q,
                ..HookReadings::default()
            };
            weighing.advance(&felt, hook, 0.1);
            weighing.masses(hook)
        };
        let Q = |s: f64, m: f64| [s * 11e3 + m * 9e3, s * 6e3 + m * 9.5e3];
        let [own, mass] = found(Q(1.4, 0.2), &HOOK);
        assert!((own - 1.4).abs() < 1e-12 && (mass - 0.2).abs() < 1e-12);
        let mut alike = HOOK;
        alike.payload_moments[2] = 9e3 * 6.0 / 11.0;
        let felt = [11e3 + 0.7 * 9e3, 6e3 + 0.7 * 9e3 * 6.0 / 11.0];
        let [own, mass] = found(felt, &alike);
        assert!(own == 1.0 && (mass - 0.7).abs() < 1e-12);
    }
}
