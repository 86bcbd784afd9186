//! The motions and loads along which the rig is driven, by `rig_run` for campaigns and judgement:
//! speed steps, sine sweeps, whole strokes, creeping, and work.
//!
//! The load has both signs, up to the paper's 70 kN against extension and as much along it, and the
//! rod goes both ways: all four quadrants.

use self::Kind::{Creep, Steps, Strokes, Sweep, Work};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Largest load either way, N.
pub const LOAD_MAX: f64 = 70e3;
/// Slowest and fastest rod speed, m/s. At rest the force is no function of the torque: friction
/// holds any force inside its band.
pub const SPEED: [f64; 2] = [0.001, 0.07];
/// Time from one desired value to the next, s.
pub const SAMPLE: f64 = 1e-3;
/// The rod stays between these positions, m.
const STROKE: [f64; 2] = [0.03, 0.67];
/// Position at which a profile starts, m.
pub(crate) const MID_STROKE: f64 = 0.5 * (STROKE[0] + STROKE[1]);
/// Largest acceleration of the desired rod speed, m/s².
const ACCELERATION: f64 = 0.5;
/// Time constant of the load emulator, s.
const LOAD_LAG: f64 = 0.02;
/// Largest rate of its force, N/s.
const LOAD_RATE: f64 = 300e3;

/// The kinds of profiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Steps of speed and load, both ways.
    Steps,
    /// Sines whose frequency rises: speed from 0.2 to 3 Hz, load from 0.1 to 1.5 Hz.
    Sweep,
    /// The whole stroke back and forth, at a speed and load that change from pass to pass.
    Strokes,
    /// Steps of slow speeds, 1.1 to 8 mm/s.
    Creep,
    /// Smooth strokes both ways under a load that changes, as in work.
    Work,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 5] = [Steps, Sweep, Strokes, Creep, Work];
}

/// One run of the rig.
#[derive(Clone, Copy, Debug)]
pub struct Profile {
    /// What kind of motion.
    pub kind: Kind,
    /// Seed of its steps and phases.
    pub seed: u64,
    /// Length, s.
    pub seconds: f64,
    /// Temperature of winding and housing at the start, K.
    pub T: f64,
}

/// Desired values at one sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct Desired {
    /// Rod speed, m/s.
    pub x_dot: f64,
    /// Load against extension, N.
    pub load: f64,
}

/// Speed and load that are approached until a time.
struct Goal {
    x_dot: f64,
    load: f64,
    until: f64,
}

impl Profile {
    /// Desired values from the start to the end, [`SAMPLE`] apart, starting at rest in mid-stroke.
    pub fn desired(&self) -> Vec<Desired> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let phase: [f64; 4] = std::array::from_fn(|_| TAU * rng.random::<f64>());
        let mut x = MID_STROKE;
        let mut goal = Goal {
            x_dot: 0.0,
            load: random_load(&mut rng),
            until: 0.0,
        };
        let mut now = Desired {
            x_dot: 0.0,
            load: goal.load,
        };
        (0..(self.seconds / SAMPLE).round() as u32)
            .map(|k| {
                let t = f64::from(k) * SAMPLE;
                match self.kind {
                    Steps | Creep | Strokes => {
                        self.update_goal(&mut goal, t, x, &mut rng);
                    }
                    Sweep => goal = self.sweep_goal(t, phase),
                    Work => goal = work_goal(t, phase),
                }
                let change =
                    (goal.x_dot - now.x_dot).clamp(-ACCELERATION * SAMPLE, ACCELERATION * SAMPLE);
                now.x_dot += change;
                let rate = ((goal.load - now.load) / LOAD_LAG).clamp(-LOAD_RATE, LOAD_RATE);
                now.load += rate * SAMPLE;
                // Braking distance before the ends of the stroke.
                let brake = now.x_dot * now.x_dot / (2.0 * ACCELERATION) + 2e-3;
                if x > STROKE[1] - brake && now.x_dot > 0.0
                    || x < STROKE[0] + brake && now.x_dot < 0.0
                {
                    goal.x_dot = -goal.x_dot;
                    now.x_dot -= change + ACCELERATION * SAMPLE * now.x_dot.signum();
                }
                x += now.x_dot * SAMPLE;
                now
            })
            .collect()
    }

    /// Draws a new goal if the time of the old one is over.
    fn update_goal(&self, goal: &mut Goal, t: f64, x: f64, rng: &mut ChaCha8Rng) {
        if t < goal.until {
            return;
        }
        let u: f64 = rng.random();
        let (speed, seconds) = match self.kind {
            Creep => (1.1e-3 + 6.9e-3 * u * u, rng.random_range(0.8..2.0)),
            Strokes => (rng.random_range(0.02..SPEED[1]), rng.random_range(2.0..5.0)),
            _ => (
                SPEED[0] + (SPEED[1] - SPEED[0]) * u,
                rng.random_range(0.3..1.2),
            ),
        };
        let offset = x - MID_STROKE;
        let direction = if self.kind == Steps && offset.abs() > 0.2 {
            -offset.signum()
        } else if rng.random::<bool>() {
            1.0
        } else {
            -1.0
        };
        *goal = Goal {
            x_dot: direction * speed,
            load: random_load(rng),
            until: t + seconds,
        };
    }

    /// Frequencies that rise in proportion to time: the phase of a sine from f_0 to f_1 is 2π (f_0
    /// t + (f_1 − f_0) t²/(2T)).
    fn sweep_goal(&self, t: f64, phase: [f64; 4]) -> Goal {
        let angle = |f: [f64; 2]| TAU * (f[0] * t + (f[1] - f[0]) * t * t / (2.0 * self.seconds));
        let frequency = 0.2 + 2.8 * t / self.seconds;
        let amplitude = (0.9 * SPEED[1]).min(0.9 * ACCELERATION / (TAU * frequency));
        Goal {
            x_dot: amplitude * (angle([0.2, 3.0])).sin(),
            load: 0.9 * LOAD_MAX * (angle([0.1, 1.5]) + phase[0]).sin(),
            until: f64::INFINITY,
        }
    }
}

fn random_load(rng: &mut ChaCha8Rng) -> f64 {
    LOAD_MAX * rng.random_range(-1.0..1.0)
}

/// Speed and load as sums of two sines each.
fn work_goal(t: f64, phase: [f64; 4]) -> Goal {
    Goal {
        x_dot: 0.048 * (0.9 * t + phase[0]).sin() + 0.014 * (2.3 * t + phase[1]).sin(),
        load: 45_000.0 * (0.55 * t + phase[2]).sin() - 18_000.0 * (1.7 * t + phase[3]).sin(),
        until: f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every kind keeps to the stroke, to the acceleration and to the load, and goes both ways; the
    /// same seed gives the same.
    #[test]
    fn profiles_keep_their_bounds_and_go_both_ways() {
        for kind in Kind::ALL {
            for seed in 0..20 {
                let profile = Profile {
                    kind,
                    seed,
                    seconds: 12.0,
                    T: 300.0,
                };
                let desired = profile.desired();
                let mut x = MID_STROKE;
                let mut before = 0.0;
                for now in &desired {
                    x += now.x_dot * SAMPLE;
                    assert!(
                        (STROKE[0] - 1e-3..STROKE[1] + 1e-3).contains(&x),
                        "{kind:?} {seed}: {x}"
                    );
                    assert!((now.x_dot - before).abs() <= 2.0 * ACCELERATION * SAMPLE + 1e-12);
                    assert!(now.load.abs() <= LOAD_MAX && now.x_dot.abs() <= SPEED[1] + 1e-9);
                    before = now.x_dot;
                }
                let fastest =
                    |sign: f64| desired.iter().map(|d| sign * d.x_dot).fold(0.0, f64::max);
                assert!(
                    kind == Kind::Strokes || fastest(1.0) > 1e-4 && fastest(-1.0) > 1e-4,
                    "{kind:?} {seed}"
                );
                let again = profile.desired();
                assert!(
                    desired
                        .iter()
                        .zip(&again)
                        .all(|(a, b)| a.x_dot.to_bits() == b.x_dot.to_bits())
                );
            }
        }
    }
}
