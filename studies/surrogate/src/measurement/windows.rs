//! Averages the samples of a run on the rig over windows of 20 ms: rows of measured values, and the
//! true values; for campaigns, judgement, models and `experiments`.
//!
//! A window averages cogging and noise and is short compared with the motions. Measured speeds
//! decide which windows are used. The torque of a row is that of the measured currents, with the
//! magnets at the measured temperature, less the torque that accelerates the rotor: so rows of
//! transients and of steady motion lie on one map.

use emla::maps;
use machine_file::{Emla, Temperature};
use rig::Output;

use crate::measurement::data::Row;
use crate::measurement::profile::SAMPLE;
use crate::measurement::rig_run::RigSample;

/// Samples of a window.
pub(crate) const SAMPLES: usize = 20;
/// Length of a window, s.
const LENGTH: f64 = SAMPLES as f64 * SAMPLE;
/// Below this rod speed, m/s, presliding and dry friction hold any force inside their band, and the
/// force is no function of the torque.
pub(crate) const SLOWEST: f64 = 1e-3;
/// Number of samples over which speeds are compared with [`SLOWEST`]; over fewer, differences are
/// mostly noise of the encoders.
const QUARTER: usize = SAMPLES / 4;

/// Means of 20 ms.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// Index of its first sample.
    pub first: usize,
    /// Time of its middle, s.
    pub t: f64,
    /// Measured values, with the torque at constant speed by the data sheet's magnets.
    pub row: Row,
    /// Measured acceleration of the motor, rad/s².
    pub w_m_dot: f64,
    /// Rise of the measured quadrature current, A/s.
    pub i_q_dot: f64,
    /// Rate of the measured force, N/s.
    pub F_dot: f64,
    /// True values.
    pub truth: Truth,
    /// Desired rod speed, m/s, and load, N.
    pub desired: [f64; 2],
}

impl Window {
    /// Measured torque at constant speed with the magnets of `p`, N·m.
    pub fn torque(&self, p: &Emla) -> f64 {
        let row = &self.row;
        steady_torque(p, [row.i_d, row.i_q], row.T_housing, self.w_m_dot)
    }
}

/// A motion under a load.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Force on the load, N.
    pub F: f64,
    /// Motor speed, rad/s.
    pub w_m: f64,
    /// Motor acceleration, rad/s².
    pub w_m_dot: f64,
    /// Temperatures of winding and housing, K.
    pub T: [f64; 2],
}

/// True values of a window.
#[derive(Clone, Copy, Debug, Default)]
pub struct Truth {
    /// The motion.
    pub motion: Motion,
    /// Quadrature current, A.
    pub i_q: f64,
    /// Electromagnetic torque, N·m.
    pub tau_e: f64,
    /// Rod speed, m/s.
    pub x_dot: f64,
    /// Power at the nut, W: that to the load, and that which bending stores and returns.
    pub P_out: f64,
    /// All losses, W.
    pub P_loss: f64,
}

/// Names of an actuator's outputs that [`Truth`] is made of.
#[rustfmt::skip]
pub(crate) const ACTUATOR_SIGNALS: [&str; 9] =
    ["i_q", "tau_e", "F_mean", "theta_m", "w_m", "x_rod", "energy.loss", "T_winding", "T_housing"];

/// The same outputs of a rig.
#[rustfmt::skip]
fn actuator_signals(y: &Output) -> [f64; 9] {
    [y.i_q, y.tau_e, y.F_mean, y.theta_m, y.w_m, y.x_rod, y.E_loss, y.T_winding, y.T_housing]
}

impl Truth {
    /// The window of `length`, s, that begins at sample `first`; `signal(s, k)` is the `s`-th of
    /// [`ACTUATOR_SIGNALS`] at sample `k`.
    pub(crate) fn new(
        p: &Emla,
        first: usize,
        length: f64,
        signal: impl Fn(usize, usize) -> f64,
    ) -> Self {
        let [i_q, tau_e, F_mean, theta_m, w_m, x, E_loss] = [0, 1, 2, 3, 4, 5, 6];
        let [T_winding, T_housing] = [7, 8];
        let last = first + SAMPLES;
        let mean = |s: usize| mean(first, |k| signal(s, k));
        let rise = |s: usize| (signal(s, last) - signal(s, first)) / length;
        let F = (first + 1..=last).map(|k| signal(F_mean, k)).sum::<f64>() / SAMPLES as f64;
        let motion = Motion {
            F,
            w_m: rise(theta_m),
            w_m_dot: rise(w_m),
            T: [mean(T_winding), mean(T_housing)],
        };
        Self {
            i_q: mean(i_q),
            tau_e: mean(tau_e),
            x_dot: rise(x),
            P_out: F * maps::travel_per_radian(p) * motion.w_m,
            P_loss: rise(E_loss),
            motion,
        }
    }

    /// `P_out/(P_out + P_loss)` where the motor drives the load (quadrants I and III), `(|P_out| −
    /// P_loss)/|P_out|` where the load drives the motor (II and IV), limited to [0, 1]; none if the
    /// motor stands still or has no torque.
    pub fn efficiency(&self) -> Option<f64> {
        let shaft = self.tau_e * self.motion.w_m;
        (shaft != 0.0).then(|| rig::efficiency(self.P_out, self.P_loss, shaft))
    }
}

/// Temperature coefficients of winding and magnets by the machine's data sheet.
pub fn data_sheet(p: &Emla) -> Temperature {
    p.temperature.unwrap_or(Temperature::TYPICAL)
}

/// Flux of the magnets at the temperature `T` of the housing, Wb.
pub fn magnets(p: &Emla, T: f64) -> f64 {
    let sheet = data_sheet(p);
    p.lambda_m * (1.0 + sheet.magnet * (T - sheet.reference))
}

/// Resistance of the winding at its temperature `T`, Ω.
pub fn resistance(p: &Emla, T: f64) -> f64 {
    let sheet = data_sheet(p);
    p.R_s * (1.0 + sheet.copper * (T - sheet.reference))
}

/// Torque that the currents `i`, A, would give at constant speed, N·m, with the magnets at the
/// temperature `T`, K: less the torque that accelerates the rotor by `w_m_dot`, rad/s².
pub fn steady_torque(p: &Emla, i: [f64; 2], T: f64, w_m_dot: f64) -> f64 {
    let flux = magnets(p, T) + (p.L_d - p.L_q) * i[0];
    1.5 * f64::from(p.p) * flux * i[1] - maps::inertia(p, 1.0) * w_m_dot
}

/// Windows in which the encoders of both rod and motor move one way, in no quarter slower than
/// `SLOWEST`. Both, because a changing load bends the structure and moves the rod while the motor
/// stands still.
pub fn windows(p: &Emla, run: &[RigSample]) -> Vec<Window> {
    let count = run.len().saturating_sub(2) / SAMPLES;
    let travel = maps::travel_per_radian(p);
    let moves = |first: usize| {
        let slowest = |position: &dyn Fn(&RigSample) -> f64, sign: f64| {
            let moved = |k: usize| position(&run[k + QUARTER]) - position(&run[k]);
            let starts = (first..first + SAMPLES).step_by(QUARTER);
            let speeds = starts.map(|k| sign * moved(k) / (QUARTER as f64 * SAMPLE));
            speeds.fold(f64::INFINITY, f64::min)
        };
        let slowest_of_both = |sign: f64| {
            let rod = slowest(&|s| s.measured.x, sign);
            rod.min(slowest(&|s| travel * s.measured.theta_m, sign))
        };
        slowest_of_both(1.0) > SLOWEST || slowest_of_both(-1.0) > SLOWEST
    };
    (0..count)
        .map(|k| 1 + k * SAMPLES)
        .filter(|&first| first + SAMPLES + 1 < run.len() && moves(first))
        .map(|first| window(p, run, first))
        .collect()
}

/// Mean of a quantity over the window from sample `first` to the one `SAMPLES` later, by the
/// trapezoidal rule.
pub fn mean(first: usize, at: impl Fn(usize) -> f64) -> f64 {
    let last = first + SAMPLES;
    let ends = 0.5 * (at(first) + at(last));
    (ends + (first + 1..last).map(at).sum::<f64>()) / SAMPLES as f64
}

/// The window from sample `first` to the one [`SAMPLES`] later.
///
/// Speeds are differences of encoder readings over the window, the acceleration is that of speeds
/// over the two milliseconds around its ends: an evaluation after the run needs no filter with lag.
fn window(p: &Emla, run: &[RigSample], first: usize) -> Window {
    type Value<'a> = &'a dyn Fn(&RigSample) -> f64;
    let last = first + SAMPLES;
    let mean = |value: Value| mean(first, |k| value(&run[k]));
    let rise = |value: Value| (value(&run[last]) - value(&run[first])) / LENGTH;
    let speed =
        |k: usize| (run[k + 1].measured.theta_m - run[k - 1].measured.theta_m) / (2.0 * SAMPLE);
    let w_m_dot = (speed(last) - speed(first)) / LENGTH;
    let signal = |s: usize, k: usize| actuator_signals(&run[k].truth)[s];
    let T = [mean(&|s| s.measured.T[0]), mean(&|s| s.measured.T[1])];
    let i = [mean(&|s| s.measured.i[0]), mean(&|s| s.measured.i[1])];
    let row = Row {
        v_d: mean(&|s| s.v[0]),
        v_q: mean(&|s| s.v[1]),
        i_d: i[0],
        i_q: i[1],
        tau_e: steady_torque(p, i, T[1], w_m_dot),
        w_m: rise(&|s| s.measured.theta_m),
        f_ext: mean(&|s| s.measured.F),
        x_dot: rise(&|s| s.measured.x),
        T_winding: T[0],
        T_housing: T[1],
        x: mean(&|s| s.measured.x),
    };
    Window {
        first,
        t: (first as f64 + 0.5 * SAMPLES as f64) * SAMPLE,
        row,
        w_m_dot,
        i_q_dot: rise(&|s| s.measured.i[1]),
        F_dot: rise(&|s| s.measured.F),
        truth: Truth {
            P_out: maps::travel_per_radian(p) * mean(&|s| s.truth.F * s.truth.w_m),
            ..Truth::new(p, first, LENGTH, signal)
        },
        desired: [mean(&|s| s.desired.x_dot), mean(&|s| s.desired.load)],
    }
}
