//! Communication steps for fmi2DoStep and fmi3DoStep: checks time and step, advances the model.

use super::fault::Fault;
use super::input::InputPolynomial;
use super::instance::{Instance, collect_log, collect_messages, set_log_filter};
use super::layout::Layout;
use super::message::shown;
use super::step_end::StepEnd;
use super::storage::Storage;
use super::value::{Value, allowed};
use crate::{Model, ModelError};

/// The end of a step of an instance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CompletedStep {
    /// Time, s.
    pub(crate) time: f64,
    /// Whether the whole step was done.
    pub(crate) is_whole: bool,
    /// Whether an event occurred in the step.
    pub(crate) event: bool,
    pub(crate) terminate: bool,
}

/// Refuses inputs whose derivatives would lead them out of their bounds within the step.
fn check_inputs<M: Model>(
    layout: &Layout<M>,
    u: &InputPolynomial<M::Input>,
    h: f64,
) -> Result<(), ModelError> {
    for (i, row) in layout.iter() {
        let Storage::RealIn(field) = &row.storage else {
            continue;
        };
        if let Some(value) = (u.range(field, i, h).into_iter()).find(|x| !x.is_allowed(row)) {
            let (name, allowed) = (row.element_name(i), allowed(row));
            return Err(ModelError::new(format!(
                "the derivatives of `{name}` take it to {value}; it must be {allowed}"
            )));
        }
    }
    Ok(())
}

/// The deviation from `t` in a step of `h` that still counts as equal, all s: importers add up
/// steps, or count time in nanoseconds.
pub(super) fn slack(t: f64, h: f64) -> f64 {
    (1e-3 * h).max(1e-9 * t.abs().max(1.0))
}

/// Whether two times that differ by `gap`, s, differ by rounding alone.
fn is_rounding(gap: f64, t: f64, now: f64) -> bool {
    let relative = 4.0 * f64::EPSILON;
    gap <= relative * t.abs() || gap <= relative * now.abs()
}

/// The fault of a wrong step at the time `now`. Out of line, like all handling of failures, so that
/// the numbers of a successful step stay in registers.
#[cold]
#[inline(never)]
fn not_a_step(t: f64, h: f64, now: f64) -> Fault {
    let gap = (t - now).abs();
    let is_now = t.is_finite() && (is_rounding(gap, t, now) || gap <= slack(t, h));
    Fault::Refused(if !(h.is_finite() && h > 0.0) {
        format!("step size = {h} s must be finite and > 0")
    } else if !is_now {
        format!("time = {t} s must be the present time {now} s")
    } else {
        format!("step size = {h} s does not move the time {now} s; it must be larger, and finite")
    })
}

#[cold]
#[inline(never)]
fn beyond(t: f64, h: f64, stop: f64) -> Fault {
    Fault::refused(format_args!(
        "the step from {t} s by {h} s passes the stop time; it must end by {stop} s"
    ))
}

/// The fault of a step that the model could not do.
#[cold]
#[inline(never)]
fn failed(t: f64, h: f64, error: &ModelError) -> Fault {
    let (t, h) = (shown(t), shown(h));
    Fault::discarded(format_args!("t = {t} s, h = {h} s: {error}"))
}

impl<M: Model> Instance<M> {
    /// Does a step from `t` by `h`, both s. If `t` deviates slightly from the present time, the
    /// step is longer or shorter by the deviation.
    #[inline(always)] // into each version's step: a call would cost several per cent of a small one
    pub(crate) fn do_step(&mut self, t: f64, h: f64) -> Result<CompletedStep, Fault> {
        if !M::CLOCKS.is_empty() && self.ticks_itself {
            return self.do_step_with_ticks(t, h);
        }
        self.do_plain_step(t, h)
    }

    #[inline(always)]
    pub(super) fn do_plain_step(&mut self, t: f64, h: f64) -> Result<CompletedStep, Fault> {
        let from_now = self.check_step(t, h)?;
        let step = match self.advance(from_now) {
            Ok(step) => step,
            Err(error) => return Err(failed(t, h, &error)),
        };
        let reached = step.reached.filter(|&s| s < from_now);
        let time = match reached {
            Some(s) => self.state.time + s,
            None => t + h,
        };
        (self.state).hold_inputs(reached.unwrap_or(from_now), &self.layout);
        self.state.time = time;
        self.invalidate();
        Ok(CompletedStep {
            time,
            is_whole: reached.is_none(),
            event: step.event,
            terminate: step.terminate,
        })
    }

    /// [`do_step`](Self::do_step) for the rare rest of a step, not inlined.
    #[cold]
    #[inline(never)]
    pub(crate) fn do_rest_of_step(&mut self, t: f64, h: f64) -> Result<CompletedStep, Fault> {
        self.do_step(t, h)
    }

    /// Advances the model by `h`; on an error it is as before.
    #[inline(always)]
    fn advance(&mut self, h: f64) -> Result<StepEnd, ModelError> {
        self.evaluate()?;
        let state = &mut self.state;
        let polynomial = (!state.is_held()).then(|| state.input_polynomial());
        let (Some(model), Some(now)) = (&mut state.model, &self.evaluation) else {
            unreachable!("`evaluate` comes first");
        };
        if let Some(polynomial) = &polynomial {
            check_inputs(&self.layout, polynomial, h)?;
        }
        let u = polynomial.as_ref().unwrap_or(&state.input);
        set_log_filter(self.log_filter, model);
        let workspace = &mut self.workspace;
        if let Some(usual) = M::INFO.tolerance {
            workspace.tolerance = state.tolerance.unwrap_or(usual);
            (workspace.log).prepare(self.log_filter, M::INFO.log_categories);
        }
        if M::EVENTS.is_some() {
            workspace.next_event = state.event;
        }
        let (p, t) = (&state.parameters, state.time);
        let end = model.step_with_workspace(workspace, p, u, now, t, h);
        if M::EVENTS.is_some() {
            state.event = workspace.next_event;
        }
        match end {
            Ok(_) => collect_messages(&mut self.messages, model),
            Err(_) => collect_log(&mut self.messages, model),
        }
        if M::INFO.tolerance.is_some() {
            self.workspace.log.empty_into(&mut self.messages);
        }
        end
    }

    /// Checks a step, and returns its length from the present time, s, so that it ends at `t + h`.
    #[inline(always)]
    pub(super) fn check_step(&self, t: f64, h: f64) -> Result<f64, Fault> {
        let now = self.state.time;
        let gap = (t - now).abs();
        let is_exact = is_rounding(gap, t, now);
        let from_now = if is_exact { h } else { (t - now) + h };
        let end = t + h;
        // False for any NaN. That `t` is finite, and `h` finite and positive, follows from the end.
        let is_forward = end > now && end > t && end <= f64::MAX && from_now > 0.0;
        if !(is_forward && (is_exact || gap <= slack(t, h))) {
            return Err(not_a_step(t, h, now));
        }
        match self.state.stop {
            Some(stop) if end > stop && end > stop + slack(stop, h) => Err(beyond(t, h, stop)),
            _ => Ok(from_now),
        }
    }
}
