//! Communication steps.

use super::fault::{Fault, discard, refuse};
use super::input::InputPolynomial;
use super::instance::{Instance, warn};
use super::layout::Layout;
use super::value::{Value, allowed};
use super::variable::Place;
use crate::{Model, ModelError};

/// How far a model has gone in a step, and what happened there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepEnd {
    /// Time reached, s after the start of the step; None: all of it.
    pub reached: Option<f64>,
    /// Something happened there that the importer may want to react to before it goes on.
    pub event: bool,
    /// The model wants the simulation to end there.
    pub terminate: bool,
}

impl StepEnd {
    /// The whole step, and nothing to tell of.
    pub const WHOLE: Self = Self {
        reached: None,
        event: false,
        terminate: false,
    };
}

/// Where a step of an instance has ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End {
    /// Time, s.
    pub(crate) time: f64,
    /// Whether that is where the step should have ended.
    pub(crate) is_whole: bool,
    #[expect(dead_code, reason = "FMI 2.0 has no words for it, FMI 3.0 has")]
    pub(crate) event: bool,
    pub(crate) terminate: bool,
}

/// Refuses inputs that their derivatives would carry out of their bounds within the step.
fn check_inputs<M: Model>(
    layout: &Layout<M>,
    u: &InputPolynomial<M::Input>,
    h: f64,
) -> Result<(), ModelError> {
    for (i, row) in layout.iter() {
        let Place::RealIn(place) = &row.place else {
            continue;
        };
        if let Some(value) = (u.range(place, i, h).into_iter()).find(|x| !x.is_allowed(row)) {
            let (name, allowed) = (row.element_name(i), allowed(row));
            return Err(ModelError::new(format!(
                "the derivatives of `{name}` take it to {value}; it must be {allowed}"
            )));
        }
    }
    Ok(())
}

/// How far `t` may be from `limit` in a step of `h` and still count as equal, all s: importers add steps up, or keep time in
/// nanoseconds.
fn slack(t: f64, h: f64) -> f64 {
    (1e-3 * h).max(1e-9 * t.abs().max(1.0))
}

/// Whether two times `gap` apart differ by rounding alone, s.
fn is_rounding(gap: f64, t: f64, now: f64) -> bool {
    let relative = 4.0 * f64::EPSILON;
    gap <= relative * t.abs() || gap <= relative * now.abs()
}

impl<M: Model> Instance<M> {
    /// A step from `t` by `h`, both s. Where `t` is not quite the present time, the step makes up for it.
    #[inline]
    pub(crate) fn do_step(&mut self, t: f64, h: f64) -> Result<End, Fault> {
        let from_now = self.check_step(t, h)?;
        let step = match self.advance(from_now) {
            Ok(step) => step,
            Err(error) => return discard!("t = {t} s, h = {h} s: {error}"),
        };
        let reached = step.reached.filter(|&s| s < from_now);
        let time = match reached {
            Some(s) => self.state.time + s,
            None => t + h,
        };
        self.state.hold_inputs(reached.unwrap_or(from_now));
        self.state.time = time;
        self.evaluation = None;
        self.fresh = false;
        Ok(End {
            time,
            is_whole: reached.is_none(),
            event: step.event,
            terminate: step.terminate,
        })
    }

    /// Moves the model on by `h`; on error it is where it was.
    #[inline]
    fn advance(&mut self, h: f64) -> Result<StepEnd, ModelError> {
        self.evaluate()?;
        let state = &mut self.state;
        let course = (!state.is_held()).then(|| state.input_course());
        let (Some(model), Some(now)) = (&mut state.model, &self.evaluation) else {
            unreachable!("`evaluate` comes first");
        };
        let mut step = |u: &_| model.step(&state.parameters, u, now, state.time, h);
        let end = match &course {
            Some(course) => {
                check_inputs(&self.layout, course, h)?;
                step(course)?
            }
            None => step(&state.input)?,
        };
        warn(&mut self.messages, model);
        Ok(end)
    }

    /// The length of a step from the present time, s, that ends a time `h` after `t`.
    #[inline]
    fn check_step(&self, t: f64, h: f64) -> Result<f64, Fault> {
        let now = self.state.time;
        if !(h.is_finite() && h > 0.0) {
            return refuse!("step size = {h} s must be finite and > 0");
        }
        let gap = (t - now).abs();
        let is_exact = is_rounding(gap, t, now);
        if !(t.is_finite() && (is_exact || gap <= slack(t, h))) {
            return refuse!("time = {t} s must be the present time {now} s");
        }
        let from_now = if is_exact { h } else { (t - now) + h };
        let end = t + h;
        if !(end > now.max(t) && from_now > 0.0 && end.is_finite()) {
            return refuse!(
                "step size = {h} s does not move the time {now} s; it must be larger, and finite"
            );
        }
        match self.state.stop {
            Some(stop) if end > stop && end > stop + slack(stop, h) => {
                refuse!(
                    "the step from {t} s by {h} s passes the stop time; it must end by {stop} s"
                )
            }
            _ => Ok(from_now),
        }
    }
}
