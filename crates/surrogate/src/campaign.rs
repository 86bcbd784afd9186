//! The campaign on the virtual testbed, and a motion profile: simulations, not measurements.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use rayon::prelude::*;

use crate::data::Row;
use crate::testbed::{Drive, State, Testbed};

/// Largest load of the campaign, N.
pub const LOAD_MAX: f64 = 70_000.0;
/// Slowest and fastest rod of the campaign, m/s. At rest the force is no function of the torque:
/// friction holds anything inside its band. The campaign therefore starts from creeping.
pub const SPEED: [f64; 2] = [0.001, 0.07];

/// Simulation step and control period, s.
const DT: f64 = 1e-4;
/// Simulation steps from one logged sample to the next.
const LOG_EVERY: u32 = 10;
/// Time to settle, s.
const SETTLE: f64 = 0.25;
/// Shortest averaging window, s; made longer to whole cogging periods.
const WINDOW: f64 = 0.1;

/// Standard deviations of one logged sample.
struct Sensors {
    current: f64,
    voltage: f64,
    speed: f64,
    force: f64,
    rod_speed: f64,
}

/// A current clamp, a resolver, a load cell (0.1 % of full scale) and a rod encoder.
const SENSORS: Sensors = Sensors {
    current: 0.05,
    voltage: 0.5,
    speed: 0.1,
    force: 70.0,
    rod_speed: 1e-4,
};

/// Steady operating points, each simulated, settled and averaged over a window with sensor noise.
///
/// Loads and speeds come from a low-discrepancy sequence with a seeded start; speeds are denser
/// at the slow end, where friction changes.
#[must_use]
pub fn campaign(testbed: &Testbed, points: u32, seed: u64) -> Vec<Row> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let start: [f64; 2] = [rng.random(), rng.random()];
    (0..points)
        .into_par_iter()
        .map(|k| {
            let [a, b] = low_discrepancy(k, start);
            let f_ext = LOAD_MAX * (2.0 * a - 1.0);
            let x_dot = SPEED[0] + (SPEED[1] - SPEED[0]) * b * b;
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(1 + u64::from(k));
            operating_point(testbed, x_dot, f_ext, &mut rng)
        })
        .collect()
}

/// Point `k` of the R₂ sequence (Roberts): steps of 1/g and 1/g², g³ = g + 1, modulo 1.
fn low_discrepancy(k: u32, start: [f64; 2]) -> [f64; 2] {
    const G: f64 = 1.324_717_957_244_746;
    let k = f64::from(k);
    [(start[0] + k / G).fract(), (start[1] + k / (G * G)).fract()]
}

fn operating_point(testbed: &Testbed, x_dot: f64, f_ext: f64, rng: &mut ChaCha8Rng) -> Row {
    let p = testbed.base();
    let mut s = testbed.steady(x_dot, f_ext);
    let mut drive = Drive::steady(&s, p);
    let w_ref = s.w_m;
    let period = std::f64::consts::TAU / (crate::testbed::EXTRA.cogging[1] * w_ref);
    let window = (WINDOW / period).ceil() * period;
    let settle = (SETTLE / DT).round() as u32;
    let logged = (window / DT).round() as u32;
    let mut mean = Row::default();
    let mut count = 0;
    for k in 0..settle + logged {
        let v = drive.command(&s, p, w_ref, 0.0, DT);
        if k >= settle && (k - settle).is_multiple_of(LOG_EVERY) {
            mean = mean.plus(&sample(testbed, &s, v, f_ext, Some(rng)));
            count += 1;
        }
        s = testbed.step(&s, v, f_ext, DT);
        s.x = 0.5 * p.L_s; // the rig repositions: every point is taken in mid-stroke
    }
    mean.divided_by(f64::from(count))
}

/// One logged sample; without `rng` free of noise.
fn sample(
    testbed: &Testbed,
    s: &State,
    v: [f64; 2],
    f_ext: f64,
    rng: Option<&mut ChaCha8Rng>,
) -> Row {
    let mut noise = [0.0; 7];
    if let Some(rng) = rng {
        let normal = Normal::new(0.0, 1.0).expect("a valid distribution");
        noise = std::array::from_fn(|_| normal.sample(rng));
    }
    let n = &SENSORS;
    let i = [s.i[0] + n.current * noise[0], s.i[1] + n.current * noise[1]];
    Row {
        v_d: v[0] + n.voltage * noise[2],
        v_q: v[1] + n.voltage * noise[3],
        i_d: i[0],
        i_q: i[1],
        tau_e: testbed.torque(i),
        w_m: s.w_m + n.speed * noise[4],
        f_ext: f_ext + n.force * noise[5],
        x_dot: s.x_dot + n.rod_speed * noise[6],
    }
}

/// One instant of the motion profile, without noise.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// Time, s.
    pub t: f64,
    /// What the sensors would show without noise; voltages are means until the next instant.
    pub row: Row,
    /// Rod position, m.
    pub x: f64,
    /// Core and inverter losses of the testbed, W.
    pub electrical_losses: f64,
}

/// A working motion: smooth strokes both ways with a load that changes and reverses, `seconds` long.
///
/// Every value is the testbed's own state; nothing of it is used in training.
#[must_use]
pub fn motion_profile(testbed: &Testbed, seconds: f64) -> Vec<Instant> {
    let p = testbed.base();
    let travel = emla::maps::travel_per_radian(p);
    let speed = |t: f64| 0.048 * (0.9 * t).sin() + 0.014 * (2.3 * t).sin();
    let load = |t: f64| 28_000.0 + 24_000.0 * (0.55 * t + 0.4).sin() - 9_000.0 * (1.7 * t).sin();
    let mut s = testbed.steady(speed(0.0), load(0.0));
    let mut drive = Drive::steady(&s, p);
    let mut profile: Vec<Instant> = Vec::new();
    for k in 0..(seconds / DT).round() as u32 {
        let t = f64::from(k) * DT;
        let w_ref = speed(t) / travel;
        let w_ref_dot = (speed(t + DT) - speed(t)) / (DT * travel);
        let v = drive.command(&s, p, w_ref, w_ref_dot, DT);
        let next = testbed.step(&s, v, load(t), DT);
        if k % LOG_EVERY == 0 {
            let row = sample(testbed, &s, [0.0; 2], load(t), None);
            profile.push(Instant {
                t,
                row,
                x: s.x,
                electrical_losses: testbed.electrical_losses(s.i, s.w_m),
            });
        }
        // The voltages of an instant are the means until the next one.
        if let Some(instant) = profile.last_mut() {
            instant.row.v_d += v[0] / f64::from(LOG_EVERY);
            instant.row.v_q += v[1] / f64::from(LOG_EVERY);
        }
        s = next;
    }
    profile
}

#[cfg(test)]
mod tests {
    use super::*;

    fn testbed() -> Testbed {
        Testbed::new(machine::Machine::reference().emla)
    }

    /// Oracle: steady state by the closed form. Cogging and the averaging leave less than the noise
    /// of the mean: 0.05 A·1.14 N·m/A/√100 = 0.0057 N·m, of which four standard deviations.
    #[test]
    fn campaign_points_are_steady_states() {
        let testbed = testbed();
        for (k, row) in campaign(&testbed, 40, 7).iter().enumerate() {
            let steady = testbed.steady(row.x_dot, row.f_ext);
            let error = row.tau_e - testbed.torque(steady.i);
            assert!(error.abs() < 0.03, "point {k}: {error} N·m in {row:?}");
        }
    }

    #[test]
    fn same_seed_same_campaign() {
        let testbed = testbed();
        assert_eq!(campaign(&testbed, 5, 3), campaign(&testbed, 5, 3));
        assert_ne!(campaign(&testbed, 5, 3), campaign(&testbed, 5, 4));
    }
}
