//! Samples of a rig gathered into windows of 20 ms: what the sensors make of a window, and what is
//! true of it.
//!
//! A window evens out cogging and noise and is short beside the motions. The torque of a row is
//! that of the measured currents with the magnets at the measured temperature, less what
//! accelerates the rotor: so rows of transients and of steady motion lie on one map.

use emla::maps;
use machine::Emla;

use crate::data::Row;
use crate::profile::SAMPLE;
use crate::rig_run::Instant;

/// Samples of a window.
pub const SAMPLES: usize = 20;
/// Length of a window, s.
const LENGTH: f64 = SAMPLES as f64 * SAMPLE;
/// Below this rod speed, m/s, presliding and dry friction hold anything inside their band, and the
/// force is no function of the torque.
pub const SLOWEST: f64 = 1e-3;

/// Means of 20 ms.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// Time of its middle, s.
    pub t: f64,
    /// By the sensors, with the torque at constant speed.
    pub row: Row,
    /// Rate of the measured force, N/s.
    pub F_dot: f64,
    /// What is true of it.
    pub truth: Truth,
    /// What was asked for: rod speed, m/s, and load, N.
    pub desired: [f64; 2],
}

/// What is true of a window.
#[derive(Clone, Copy, Debug, Default)]
pub struct Truth {
    /// Quadrature current, A.
    pub i_q: f64,
    /// Electromagnetic torque, N·m.
    pub tau_e: f64,
    /// Force on the load, N.
    pub F: f64,
    /// Motor speed, rad/s, and acceleration, rad/s².
    pub w_m: f64,
    /// Motor acceleration, rad/s².
    pub w_m_dot: f64,
    /// Rod speed, m/s.
    pub x_dot: f64,
    /// Temperatures of winding and housing, K.
    pub T: [f64; 2],
    /// Power of the force at the nut, W: that to the load but for what goes into bending and comes
    /// back.
    pub P_out: f64,
    /// All losses, W.
    pub P_loss: f64,
}

impl Truth {
    /// `P_out/(P_out + P_loss)` where the rod drives the load, `(|P_out| − P_loss)/|P_out|` where
    /// the load drives it, kept in [0, 1]; none elsewhere.
    #[must_use]
    pub fn efficiency(&self) -> Option<f64> {
        let is_defined = self.tau_e > 0.0 && self.w_m != 0.0;
        is_defined.then(|| rig::efficiency(self.P_out, self.P_loss, self.w_m))
    }
}

/// Flux of the magnets at the temperature `T` of the housing by the catalogue, Wb.
#[must_use]
pub fn magnets(p: &Emla, T: f64) -> f64 {
    let catalogue = rig::Extras::AS_BUILT.temperature;
    p.lambda_m * (1.0 + catalogue.magnet * (T - catalogue.reference))
}

/// Resistance of the winding at its temperature `T` by the catalogue, Ω.
#[must_use]
pub fn resistance(p: &Emla, T: f64) -> f64 {
    let catalogue = rig::Extras::AS_BUILT.temperature;
    p.R_s * (1.0 + catalogue.copper * (T - catalogue.reference))
}

/// Windows in which rod and nut move one way, at no sample slower than [`SLOWEST`]: where a load
/// that changes bends the structure, the rod moves while the motor stands.
#[must_use]
pub fn windows(p: &Emla, run: &[Instant]) -> Vec<Window> {
    let whole = run.len().saturating_sub(2) / SAMPLES;
    let travel = maps::travel_per_radian(p);
    let moves = |first: usize| {
        let samples = &run[first..=first + SAMPLES];
        let slowest = |sign: f64| {
            let slower = |s: &Instant| (sign * s.truth.x_rod_dot).min(sign * travel * s.truth.w_m);
            let speeds = samples.iter().map(slower);
            speeds.fold(f64::INFINITY, f64::min)
        };
        slowest(1.0) > SLOWEST || slowest(-1.0) > SLOWEST
    };
    (0..whole)
        .map(|k| 1 + k * SAMPLES)
        .filter(|&first| first + SAMPLES + 1 < run.len() && moves(first))
        .map(|first| window(p, run, first))
        .collect()
}

/// The window between sample `first` and the one [`SAMPLES`] later.
///
/// Speeds are differences of encoder readings over the window, the acceleration that of speeds over
/// the two milliseconds around its ends: what is evaluated afterwards needs no filter that lags.
fn window(p: &Emla, run: &[Instant], first: usize) -> Window {
    let last = first + SAMPLES;
    let mean = |of: &dyn Fn(&Instant) -> f64| {
        let ends = 0.5 * (of(&run[first]) + of(&run[last]));
        (ends + run[first + 1..last].iter().map(of).sum::<f64>()) / SAMPLES as f64
    };
    let rise = |of: &dyn Fn(&Instant) -> f64| (of(&run[last]) - of(&run[first])) / LENGTH;
    let speed =
        |k: usize| (run[k + 1].measured.theta_m - run[k - 1].measured.theta_m) / (2.0 * SAMPLE);
    let w_m_dot = (speed(last) - speed(first)) / LENGTH;
    let pairs = f64::from(p.p);

    let i = [mean(&|s| s.measured.i[0]), mean(&|s| s.measured.i[1])];
    let flux = magnets(p, mean(&|s| s.measured.T[1])) + (p.L_d - p.L_q) * i[0];
    let row = Row {
        v_d: mean(&|s| s.v[0]),
        v_q: mean(&|s| s.v[1]),
        i_d: i[0],
        i_q: i[1],
        tau_e: 1.5 * pairs * flux * i[1] - maps::inertia(p, 1.0) * w_m_dot,
        w_m: rise(&|s| s.measured.theta_m),
        f_ext: mean(&|s| s.measured.F),
        x_dot: rise(&|s| s.measured.x),
    };
    Window {
        t: (first as f64 + 0.5 * SAMPLES as f64) * SAMPLE,
        row,
        F_dot: rise(&|s| s.measured.F),
        truth: Truth {
            i_q: mean(&|s| s.truth.i_q),
            tau_e: mean(&|s| s.truth.tau_e),
            F: run[first + 1..=last]
                .iter()
                .map(|s| s.truth.F_mean)
                .sum::<f64>()
                / SAMPLES as f64,
            w_m: rise(&|s| s.truth.theta_m),
            w_m_dot: rise(&|s| s.truth.w_m),
            x_dot: rise(&|s| s.truth.x_rod),
            T: [mean(&|s| s.truth.T_winding), mean(&|s| s.truth.T_housing)],
            P_out: maps::travel_per_radian(p) * mean(&|s| s.truth.F * s.truth.w_m),
            P_loss: rise(&|s| s.truth.E_loss),
        },
        desired: [mean(&|s| s.desired.x_dot), mean(&|s| s.desired.load)],
    }
}
