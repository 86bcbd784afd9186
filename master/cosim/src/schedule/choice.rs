//! The settings of a run's steps that programs, Python and pages give the master: schedule,
//! communication step, inputs between communication points, jitter.

use serde::{Deserialize, Serialize};

/// When values are exchanged, and in which order components are stepped.
///
/// All but [`Schedule::Standard`] exchange values by stages: they read outputs again after inputs
/// were set at the same communication point, in the order of direct feedthrough. FMI 2.0 (section
/// 4.2.4) does not guarantee that; FMI 3.0 allows it in Event Mode.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
#[cfg_attr(feature = "native", derive(clap::ValueEnum))]
pub enum Schedule {
    /// Get all outputs, set all inputs, step all: asks of an FMU and of an importer what FMI 2.0
    /// promises, nothing more. Nothing is read between a set and the next step, so a value that goes
    /// through a component arrives one step later. An FMU of FMI 3.0 enters Event Mode when a clock
    /// ticks or a discrete input changes
    Standard,
    /// Step one after the other in the order of the system, later ones with the mean effort of the
    /// step over a power bond; asks what jacobi asks, and that inputs can be set between the steps of
    /// two components
    #[default]
    GaussSeidel,
    /// Step all from the values at the communication point; asks that outputs can be read again
    /// after inputs were set at the same communication point
    Jacobi,
    /// As [`Schedule::Jacobi`], and inputs that can use them get the first time derivatives of
    /// continuous outputs.
    #[cfg_attr(feature = "native", value(skip))]
    JacobiDerivatives,
}

impl Schedule {
    /// The schedules that users choose from, by name.
    pub const NAMED: [(&str, Self); 3] = [
        ("standard", Self::Standard),
        ("jacobi", Self::Jacobi),
        ("gauss-seidel", Self::GaussSeidel),
    ];
}

/// Course of a continuous input over a communication step.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
#[cfg_attr(feature = "native", derive(clap::ValueEnum))]
pub enum Between {
    /// Held at its value at the communication point before: first order in the communication step
    #[default]
    Held,
    /// Extrapolated from the last two points to the middle of each component step: second order
    Extrapolated,
    /// With gauss-seidel interpolated to the middle of each component step, if the source was
    /// stepped first and no power bond passes its mean: second order; else held
    Interpolated,
    /// With gauss-seidel the value at the end, if the source was stepped first and no power bond
    /// passes its mean: first order; else held
    End,
    /// Effort and flow of power bonds corrected by what they lacked in the last step: second order;
    /// others held
    Balanced,
}

/// Default communication step, s.
pub const STEP: f64 = 1e-3;

/// Times and schedule of a run.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Stepping {
    /// Start, s.
    pub start: f64,
    /// Communication step, s.
    pub step: f64,
    /// Order of stepping.
    pub schedule: Schedule,
    /// Continuous inputs between communication points.
    pub between: Between,
    /// Deviation of communication points from their grid, if any.
    pub jitter: Option<Jitter>,
    /// Whether all repeat a step that a component ends early, up to where it ended.
    pub repeats: bool,
}

impl Stepping {
    /// Steps of one length, s, from a start, s, on, with held inputs.
    pub fn new(start: f64, step: f64, schedule: Schedule) -> Self {
        let (between, jitter) = (Between::Held, None);
        Self {
            start,
            step,
            schedule,
            between,
            jitter,
            repeats: false,
        }
    }
}

/// Jitter of the communication points: early, late or lost ones.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Jitter {
    /// Equal seeds give equal runs.
    pub seed: u64,
    /// Largest change of a communication step, as a fraction of it. Each point is early or late by
    /// up to half of that, uniformly distributed about its place on the grid.
    pub part: f64,
    /// Fraction of the points that are lost: the step over such a point has twice the length.
    pub lost: f64,
}

impl Jitter {
    /// Lateness of point `k` as a fraction of a step, or `None` if it is lost. The random numbers
    /// are a hash of seed and `k` (SplitMix64: Steele, Lea, Flood 2014).
    pub fn lateness(&self, k: u64) -> Option<f64> {
        let mut state = self.seed ^ k.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let mut uniform = || {
            state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            f64::from(((z ^ (z >> 31)) >> 32) as u32) / f64::from(u32::MAX)
        };
        let late = self.part * (uniform() - 0.5);
        (uniform() >= self.lost).then_some(late)
    }
}

/// Number of communication steps in a time, s; None if it is no multiple of the step.
pub fn steps_in(time: f64, step: f64) -> Option<u64> {
    let steps = time / step;
    let is_whole =
        steps.round() >= 1.0 && steps < 1e12 && (steps - steps.round()).abs() <= 1e-6 * steps;
    is_whole.then_some(steps.round() as u64)
}
