//! A communication step of an `Ode`, which calls it: integrates the model with a solver of
//! `fmu-solver` and handles the events within the step.

use super::clock;
use super::continuous::Continuous;
use super::error::ModelError;
use super::event::{self, Event};
use super::input::InputPolynomial;
use super::message::shown;
use super::model::{Evaluation, zero};
use super::solver_workspace::{Scratch, SolverWorkspace};
use super::step_end::StepEnd;
use fmu_solver::{Failure, Solver, System};

/// Most events within [`CLOSE`] of a communication step: more of them accumulate.
const MOST_EVENTS: u32 = 1000;
/// Part of a communication step within which events are close together.
const CLOSE: f64 = 1e-6;
/// How far a time event may be from the end of a step that it belongs to, relative to the length of
/// the step and to the rounding of the time.
const NEAR: [f64; 2] = [1e-9, 8.0 * f64::EPSILON];

/// The model as a system for the solver; `s` is the last event's time from the step's start, s.
struct StepSystem<'a, M: Continuous> {
    at: &'a mut M,
    rate: &'a mut M,
    direction: Option<&'a mut (M, M::Input)>,
    p: &'a M::Parameters,
    u: &'a InputPolynomial<M::Input>,
    t: f64,
    s: f64,
}

impl<M: Continuous> StepSystem<'_, M> {
    /// Calls `f` with the model at the states `x`, its inputs and time, `s` s after the last event.
    fn evaluate_at<T>(
        &mut self,
        s: f64,
        x: &[f64],
        f: impl FnOnce(&M, &M::Input, &M::Evaluation, f64, &mut M) -> Result<T, ModelError>,
    ) -> Result<T, ModelError> {
        self.at.set_states(x);
        let s = self.s + s;
        let moved = (self.u.order() > 0).then(|| self.u.at::<M>(s));
        let u = moved.as_ref().unwrap_or(self.u.value());
        let now = M::Evaluation::new(self.at, self.p, u)?;
        f(self.at, u, &now, self.t + s, self.rate)
    }

    /// Handles an event at the present time, which is `t` to the last bit.
    fn event(&mut self, t: f64) -> Result<Event, ModelError> {
        let moved = (self.u.order() > 0).then(|| self.u.at::<M>(self.s));
        let u = moved.as_ref().unwrap_or(self.u.value());
        event::handle(t, || self.at.event(self.p, u, t))
    }
}

impl<M: Continuous> System for StepSystem<'_, M> {
    type Error = ModelError;

    fn derivative(&mut self, s: f64, x: &[f64], dx: &mut [f64]) -> Result<(), ModelError> {
        let p = self.p;
        self.evaluate_at(s, x, |model, u, now, t, rate| {
            model.derivatives(p, u, now, t, rate)?;
            rate.states(dx);
            Ok(())
        })
    }

    fn directional(
        &mut self,
        s: f64,
        x: &[f64],
        seed: &[f64],
        change: &mut [f64],
    ) -> Result<bool, ModelError> {
        let Some(direction) = self.direction.take() else {
            return Ok(false);
        };
        direction.0.set_states(seed);
        let (p, seed) = (self.p, (&direction.0, &direction.1));
        let done = self.evaluate_at(s, x, |model, u, now, t, rate| {
            model.directional(p, u, now, t, seed, rate, None)?;
            rate.states(change);
            Ok(true)
        });
        self.direction = Some(direction);
        done
    }

    fn indicators(&mut self, s: f64, x: &[f64], z: &mut [f64]) -> Result<(), ModelError> {
        let p = self.p;
        z.fill(f64::NAN); // what the model does not write is no number
        self.evaluate_at(s, x, |model, u, now, t, _| {
            model.indicators(p, u, now, t, z)?;
            match z.iter().position(|z| !z.is_finite()) {
                Some(k) => Err(not_finite_indicator::<M>(k, z[k], t)),
                None => Ok(()),
            }
        })
    }
}

/// Advances a model with `n` states from `t` by `h`, both s, with events; on an error the model is
/// as before. `make` makes the solver, `name` finds the name of a state that is not finite.
pub(crate) fn solve<M: Continuous>(
    model: &mut M,
    workspace: &mut SolverWorkspace<M, M::Input>,
    make: impl FnOnce(&M) -> Result<Solver, ModelError>,
    n: usize,
    name: impl Fn(&mut M, usize, f64) -> &'static str,
    (p, u): (&M::Parameters, &InputPolynomial<M::Input>),
    (t, h): (f64, f64),
) -> Result<StepEnd, ModelError> {
    // The number of states changes when an instance is reconfigured.
    let old = workspace.scratch.take();
    let mut scratch = match old.filter(|old| old.states.len() == n) {
        Some(scratch) => scratch,
        None => {
            let direction = || (model.clone(), zero::<M>(u.value()));
            Box::new(Scratch {
                solver: make(model)?,
                at: model.clone(),
                rate: model.clone(),
                direction: M::HAS_DIRECTIONAL.then(direction),
                states: vec![0.0; n],
                left: vec![0.0; n],
                rates: [vec![0.0; n], vec![0.0; n]],
            })
        }
    };
    scratch.solver.set_tolerance(workspace.tolerance);
    let before = scratch.solver.counts();
    scratch.solver.forget_event();
    let carried = (&mut workspace.first, &mut workspace.next_event);
    let end = scratch.run(model, carried, &name, (p, u), (t, h));
    let now = scratch.solver.counts();
    let (steps, rejected) = (now.steps - before.steps, now.rejected - before.rejected);
    if rejected > 0 {
        let done = format_args!("{steps} internal steps were accepted, {rejected} rejected");
        let (t, h) = (shown(t), shown(h));
        let text = format_args!("t = {t} s, h = {h} s: {done} by the tolerance");
        workspace.log.info("", text);
    }
    workspace.scratch = Some(scratch);
    end
}

impl<M: Continuous> Scratch<M, M::Input> {
    /// Does the step. On an error `model` and what is carried from step to step (the first internal
    /// step, and the time of the next time event, s) are as before.
    fn run(
        &mut self,
        model: &mut M,
        (first, next_event): (&mut f64, &mut f64),
        name: &dyn Fn(&mut M, usize, f64) -> &'static str,
        (p, u): (&M::Parameters, &InputPolynomial<M::Input>),
        (t, h): (f64, f64),
    ) -> Result<StepEnd, ModelError> {
        let Self {
            solver,
            at,
            rate,
            direction,
            states,
            left,
            rates,
        } = self;
        at.clone_from(model);
        let mut system = StepSystem {
            at: &mut *at,
            rate,
            direction: direction.as_mut(),
            p,
            u,
            t,
            s: 0.0,
        };
        let (mut next_first, mut end) = (*first, StepEnd::WHOLE);
        let near = NEAR[0] * h + NEAR[1] * (t.abs() + h);
        let mut next = *next_event;
        let mut event = Event::NONE;
        let (mut events, mut close_from) = (0, 0.0);
        loop {
            // A time event at the end belongs to the next step, which has the inputs of that time.
            let is_time = next - t <= (h - near).max(0.0);
            let until = if is_time { (next - t).max(system.s) } else { h };
            let mut found = None;
            if until > system.s + if is_time { near } else { 0.0 } {
                system.at.states(states);
                let from = (t + system.s, until - system.s);
                found = (solver.advance(&mut system, from, states, &mut next_first))
                    .map_err(|failure| to_model_error(failure, system.rate, name))?;
                system.at.set_states(states);
            }
            system.s = found.map_or(until, |s| system.s + s);
            if found.is_some() || is_time {
                // What is due at the start was known before.
                end.event |= system.s > 0.0;
                let now = t + system.s;
                let at = if found.is_none() && next > now {
                    next
                } else {
                    now
                };
                if found.is_some() {
                    system.derivative(system.s, states, &mut rates[0])?;
                }
                event = system.event(at)?;
                next = event.next.unwrap_or(f64::INFINITY);
                if system.s > close_from + CLOSE * h {
                    (events, close_from) = (0, system.s);
                }
                events += 1;
                if events > MOST_EVENTS {
                    return Err(accumulation::<M>(solver.event_indicator(), now, CLOSE * h));
                }
                // Who switches rates alone has changed sides; who is thrown back has not.
                system.at.states(left);
                if found.is_some() && left == states {
                    system.derivative(system.s, states, &mut rates[1])?;
                    if rates[0] != rates[1] {
                        solver.forget_event();
                    }
                }
            }
            if event.terminate {
                (end.reached, end.terminate) = (Some(system.s), true);
            }
            let (mut is_started, mut is_early) = (false, false);
            if !M::CLOCKS.is_empty() && (found.is_some() || is_time) {
                (is_started, is_early) = clock::has_started(system.at, system.rate);
            }
            end.event |= is_started;
            is_early &= system.s > 0.0;
            if is_early {
                // The importer ticks the clock, which may be due within the step.
                end.reached = Some(system.s);
            }
            if is_early || event.terminate || system.s >= h {
                end.event |= next - t <= h + near; // it is due
                (*first, *next_event) = (next_first, next);
                std::mem::swap(model, at);
                return Ok(end);
            }
        }
    }
}

/// The error of events without end: those of an indicator or time events.
#[cold]
fn accumulation<M: Continuous>(indicator: Option<usize>, t: f64, within: f64) -> ModelError {
    let what = match indicator.and_then(|k| M::INDICATORS.get(k)) {
        Some(row) => format!("event indicator `{}` has changed its sign", row.name),
        None => "time events have occurred".to_owned(),
    };
    let t = shown(t);
    ModelError::new(format!(
        "t = {t} s: {what} {MOST_EVENTS} times within {within} s: the events accumulate (Zeno); let the model come to rest there, by a \
         discrete state that stops its motion"
    ))
}

/// The error of an indicator without a sign, as in Model Exchange.
#[cold]
fn not_finite_indicator<M: Continuous>(k: usize, value: f64, t: f64) -> ModelError {
    let name = M::INDICATORS.get(k).map_or("", |row| row.name);
    let t = shown(t);
    ModelError::new(format!(
        "t = {t} s: event indicator `{name}` became {value}; it must be finite"
    ))
}

/// The error of a failed step, with the name of a state that is not finite.
fn to_model_error<M>(
    failure: Failure<ModelError>,
    rate: &mut M,
    name: &dyn Fn(&mut M, usize, f64) -> &'static str,
) -> ModelError {
    match failure {
        Failure::System(error) => error,
        Failure::NotFinite(state, value) => {
            let name = name(rate, state, value);
            ModelError::new(format!(
                "`{name}` became {value} at the end of the step; it must be finite"
            ))
        }
        failure => ModelError::new(failure.to_string()),
    }
}
