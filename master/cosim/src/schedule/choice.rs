//! The schedules to choose from, and the times of a run.

use serde::{Deserialize, Serialize};

/// What is exchanged when, and in which order the components are stepped.
///
/// The staged exchange of all but [`Schedule::Standard`] reads outputs again after inputs were set
/// at the same communication point, in the order of direct feedthrough. FMI 2.0 (section 4.2.4)
/// does not promise that: it asks an FMU for it. FMI 3.0 allows it in Event Mode, which the
/// instances of that version are in during the exchange; one that has none is refused.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
pub enum Schedule {
    /// All that FMI 2.0 promises between masters and FMUs. In initialization mode values are passed
    /// in the order of the initial dependencies, as by every schedule. Then, at every communication
    /// point t_k: all connected outputs of all components are read, once; all connected inputs of
    /// all components are set from them, once; all components are stepped to t_(k+1). Nothing is
    /// read between a set and the step that follows it, so a value that goes through a component
    /// arrives one step later. An FMU of FMI 3.0 with clocks or discrete inputs goes through Event
    /// Mode where a clock ticks or such an input changes.
    Standard,
    /// One after the other in the order of the system structure; a component stepped later than the
    /// one that exerts an effort on it gets the mean of that effort over the step.
    #[default]
    GaussSeidel,
    /// All from the values at the communication point, held over the step.
    Jacobi,
    /// As [`Schedule::Jacobi`], with the first time derivatives of continuous outputs passed on to
    /// the inputs that can use them.
    JacobiDerivatives,
}

impl Schedule {
    /// Those to choose from, by name.
    pub const NAMED: [(&str, Self); 3] = [
        ("standard", Self::Standard),
        ("jacobi", Self::Jacobi),
        ("gauss-seidel", Self::GaussSeidel),
    ];
}

/// What a continuous input is over a communication step.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
pub enum Between {
    /// Its value at the communication point before: an error of first order in the communication
    /// step.
    #[default]
    Held,
    /// On the line through the last two communication points, in the middle of each step of the
    /// component: second order.
    Extrapolated,
    /// On the line to the value at the end, where the giver was stepped before (Gauss–Seidel), in
    /// the middle of each step of the component: second order; else held.
    Interpolated,
    /// The value at the end, where the giver was stepped before (Gauss–Seidel), as the textbook has
    /// it: first order; else held.
    End,
    /// Effort and flow of power bonds with what they lacked over the step before: second order;
    /// others held.
    Balanced,
}

/// Communication step where nobody asks for one, s.
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
    /// What continuous inputs are between communication points.
    pub between: Between,
    /// How communication points stray from their grid, if they do.
    pub jitter: Option<Jitter>,
}

/// A clock that wakes up early and late, and now and then not at all.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Jitter {
    /// Equal seeds give equal runs.
    pub seed: u64,
    /// Largest change of a communication step, as a part of it: each point is early or late by up
    /// to half of that, uniformly; points do not drift away from their grid.
    pub part: f64,
    /// Share of the points that are lost: the step over such a point is one of twice the length.
    pub lost: f64,
}

impl Jitter {
    /// By what part of a step point `k` is late, or `None` where it is lost. A hash of seed and
    /// number (Steele, Lea, Flood 2014: SplitMix64) stands for the random numbers.
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

/// Communication steps in a time, s; none where it is no multiple of the step.
pub fn steps_in(time: f64, step: f64) -> Option<u64> {
    let steps = time / step;
    let is_whole =
        steps.round() >= 1.0 && steps < 1e12 && (steps - steps.round()).abs() <= 1e-6 * steps;
    is_whole.then_some(steps.round() as u64)
}
