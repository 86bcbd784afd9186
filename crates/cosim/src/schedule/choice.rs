//! The schedules to choose from, and the times of a run.

/// What is exchanged when, and in which order the components are stepped.
///
/// The staged exchange of all but [`Schedule::Standard`] reads outputs again after inputs were set
/// at the same communication point, in the order of direct feedthrough. FMI 2.0 (section 4.2.4)
/// does not promise that: it asks an FMU for it. FMI 3.0 allows it in Event Mode, which the
/// instances of that version are in during the exchange; one that has none is refused.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
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

/// Times and schedule of a run.
#[derive(Clone, Copy, Debug)]
pub struct Stepping {
    /// Start, s.
    pub start: f64,
    /// Communication step, s.
    pub step: f64,
    /// Order of stepping.
    pub schedule: Schedule,
}
