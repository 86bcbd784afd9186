//! Model Exchange, for `fmi2` and `fmi3`: the importer integrates the model, gets derivatives and
//! event indicators, sets time and states, and lets the model handle events.

use super::equation_cache::Equations;
use super::event::{self, Event};
use super::fault::{Fault, check_number, discard, refuse};
use super::instance::{Instance, collect_log, collect_messages, set_log_filter};
use super::layout::{RowSpan, state};
use super::message::{Kind, shown};
use super::model::{ModelExchange, Variable};
use super::phase::Phase;
use super::step::slack;
use super::storage::Storage;
use super::value::Value;
use crate::{Model, ModelError};
use std::mem;

/// How far a time event may be from the time of a communication point to which it belongs, relative
/// to that time: importers add up their steps.
const NEAR: f64 = 1e-12;

/// The results of updating the discrete states.
pub(crate) struct EventOutcome {
    pub(crate) event: Event,
    /// The event has changed continuous states.
    pub(crate) is_moved: bool,
}

/// The model's equations; no instance is made for Model Exchange without them.
pub(super) fn equations<M: Model>() -> Result<ModelExchange<M>, Fault> {
    match M::MODEL_EXCHANGE.or(M::EVENTS) {
        Some(equations) => Ok(equations),
        None => refuse!("this FMU offers Co-Simulation only"),
    }
}

/// The fault of equations that cannot be evaluated; an integrator may try a smaller step.
fn failed(t: f64, error: &ModelError) -> Fault {
    Fault::discarded(format_args!("t = {} s: {error}", shown(t)))
}

impl<M: Model> Instance<M> {
    /// Recomputes derivatives or event indicators, if they are out of date.
    fn compute(&mut self, which: Equations) -> Result<&[f64], Fault> {
        let (equations, n) = (equations::<M>()?, self.layout.states);
        let all = n + self.layout.indicators;
        let range = match which {
            Equations::Derivatives => 0..n,
            Equations::Indicators => n..all,
        };
        if self.equation_cache.is_valid[which as usize] {
            return Ok(&self.equation_cache.numbers[range]);
        }
        self.model()?; // inconsistent start values are an error, as for outputs
        let t = self.state.time;
        self.evaluate().map_err(|error| failed(t, &error))?;
        let Self {
            equation_cache,
            state,
            evaluation,
            ..
        } = self;
        let (Some(model), Some(now)) = (&state.model, &*evaluation) else {
            unreachable!("`evaluate` comes first");
        };
        equation_cache.numbers.resize(all, f64::NAN);
        let (p, u) = (&state.parameters, state.input());
        let numbers = &mut equation_cache.numbers[range.clone()];
        let computed = if which == Equations::Derivatives {
            let rate = equation_cache.rate.get_or_insert_with(|| model.clone());
            equations.write_derivatives(model, (p, u, now, t), rate, numbers)
        } else {
            (equations.indicate)(model, p, u, now, t, numbers)
        };
        computed.map_err(|error| failed(t, &error))?;
        if let Some(k) = numbers.iter().position(|x| !x.is_finite()) {
            return self.not_finite_equation(range.start + k);
        }
        self.equation_cache.is_valid[which as usize] = true;
        Ok(&self.equation_cache.numbers[range])
    }

    #[cold]
    fn not_finite_equation<T>(&self, at: usize) -> Result<T, Fault> {
        let (name, value) = (self.equation_name(at), self.equation_cache.numbers[at]);
        discard!(
            "t = {} s: `{name}` became {value}; it must be finite",
            shown(self.state.time)
        )
    }

    /// The name of the derivative or event indicator with this position among them.
    fn equation_name(&self, at: usize) -> String {
        let mut rows = (self.layout.iter()).filter(|(_, row)| row.storage.is_equation());
        let (i, row) = rows.nth(at).expect("counted");
        self.name(row, i)
    }

    /// The values of a row of derivatives or event indicators. Other rows and types are refused;
    /// `i` is the requested element.
    pub(super) fn equation_values<T: Value>(
        &mut self,
        span: &RowSpan<M>,
        i: usize,
    ) -> Result<&[T], Fault> {
        let is_there = M::MODEL_EXCHANGE.is_some() && span.row.storage.is_equation();
        if !is_there || T::from_reals(&[]).is_none() {
            return Err(self.not_gettable(span.row, i, T::KIND.name(self.names)));
        }
        if self.state.phase == Phase::Instantiated {
            self.start_output(span.row)?;
        }
        self.compute(match span.row.storage.is_derivative() {
            true => Equations::Derivatives,
            false => Equations::Indicators,
        })?;
        let numbers = &self.equation_cache.numbers[span.offset as usize..];
        Ok(T::from_reals(numbers).expect("asked for above"))
    }

    /// The derivatives of all `n` states.
    pub(crate) fn derivatives(&mut self, name: &str, n: usize) -> Result<&[f64], Fault> {
        check_number(name, n, self.layout.states, "continuous states")?;
        self.compute(Equations::Derivatives)
    }

    /// All `n` event indicators.
    pub(crate) fn event_indicators(&mut self, name: &str, n: usize) -> Result<&[f64], Fault> {
        check_number(name, n, self.layout.indicators, "event indicators")?;
        self.compute(Equations::Indicators)
    }

    /// All `n` states.
    pub(crate) fn continuous_states(&mut self, name: &str, n: usize) -> Result<&[f64], Fault> {
        check_number(name, n, self.layout.states, "continuous states")?;
        self.model()?;
        let states = &mut self.equation_cache.states;
        states.resize(n, 0.0);
        if let Some(model) = &self.state.model {
            (equations::<M>()?.states)(model, states);
        }
        Ok(states)
    }

    /// Sets all states: `value(k)` is the `k`-th of `n`.
    pub(crate) fn set_continuous_states(
        &mut self,
        name: &str,
        n: usize,
        value: impl Fn(usize) -> f64,
    ) -> Result<(), Fault> {
        check_number(name, n, self.layout.states, "continuous states")?;
        let states = &mut self.equation_cache.states;
        states.clear();
        states.extend((0..n).map(value));
        if let Some(k) = states.iter().position(|x| !x.is_finite()) {
            let value = states[k];
            let name = self.equation_name(k);
            let name = name.trim_start_matches("der(").trim_end_matches(')');
            return discard!("state `{name}` = {value} must be finite");
        }
        if let Some(model) = &mut self.state.model {
            (equations::<M>()?.set_states)(model, states);
        }
        self.invalidate();
        Ok(())
    }

    /// Nominal values of all `n` states: those of their rows, else 1.
    pub(crate) fn nominals(&self, name: &str, n: usize) -> Result<Vec<f64>, Fault> {
        check_number(name, n, self.layout.states, "continuous states")?;
        let rows = self.layout.iter().map(|(_, row)| row);
        let states = rows.filter(|row| row.storage.is_derivative());
        let nominal = |rate: &Variable<M>| state::<M>(rate.name).and_then(|row| row.nominal);
        Ok(states.map(|row| nominal(row).unwrap_or(1.0)).collect())
    }

    /// Sets the time at which the equations are evaluated, s: not before the last event.
    pub(crate) fn set_time(&mut self, t: f64) -> Result<(), Fault> {
        let earliest = self.state.event;
        if !(t.is_finite() && t >= earliest) {
            return refuse!(
                "time = {t} s must be finite and at least {earliest} s, the time of the last event"
            );
        }
        self.state.time = t;
        self.output_is_valid &= !M::HAS_TIMED_OUTPUTS;
        self.equation_cache.invalidate();
        Ok(())
    }

    /// In Continuous-Time Mode, refuses elements that are not continuous inputs.
    #[inline(always)]
    pub(crate) fn check_between_events(
        &self,
        number: impl Fn(usize) -> Option<u32>,
    ) -> Result<(), Fault> {
        if M::MODEL_EXCHANGE.is_none() || self.state.phase != Phase::Continuous {
            return Ok(());
        }
        for number in (0..).map_while(number) {
            let (i, row) = self.layout.find_any(number)?;
            if !matches!(row.storage, Storage::RealIn(_)) || row.discrete {
                let (name, kind) = (self.name(row, i), row.kind(self.names));
                return refuse!(
                    "`{name}` is {kind}; in Continuous-Time Mode only continuous inputs can be set"
                );
            }
        }
        Ok(())
    }

    /// Lets the model handle an event at the present time.
    pub(super) fn handle_event(&mut self) -> Result<EventOutcome, Fault> {
        let (equations, now, due) = (equations::<M>()?, self.state.time, self.state.event);
        let t = match due > now && due - now <= NEAR * now.abs() {
            true => due,
            false => now,
        };
        let [mut before, mut after] = [(); 2].map(|()| vec![0.0; self.layout.states]);
        self.check_stop()?;
        let mut rate = self.equation_cache.rate.take();
        let event = self.change(|model, p, u| {
            // The model before the event, stored in the existing copy.
            let backup = rate.get_or_insert_with(|| model.clone());
            backup.clone_from(model);
            let event = (equations.event)(model, p, u, t)?;
            if !before.is_empty() {
                (equations.states)(backup, &mut before);
                (equations.states)(model, &mut after);
            }
            event.check(t)?;
            Ok(event)
        });
        self.invalidate();
        if event.is_err() {
            mem::swap(&mut self.state.model, &mut rate);
        }
        self.equation_cache.rate = rate;
        let event = event?;
        self.state.event = match self.state.phase {
            Phase::Event => t,
            _ => event.due(),
        };
        let is_moved = before.iter().zip(&after).any(|(a, b)| !a.is_same(b));
        self.report(Kind::Event, format!("t = {} s: events handled", shown(t)));
        Ok(EventOutcome { event, is_moved })
    }

    /// In Co-Simulation, the event at the end of initialization, where the importer has no Event Mode.
    #[cold]
    pub(crate) fn first_event(&mut self) -> Result<(), Fault> {
        let (equations, t) = (equations::<M>()?, self.state.time);
        let mut model = self.state.model.clone();
        let event =
            self.change(|model, p, u| event::handle(t, || (equations.event)(model, p, u, t)));
        self.invalidate();
        if event.is_err() {
            mem::swap(&mut self.state.model, &mut model);
        }
        self.state.event = event?.due();
        Ok(())
    }

    /// The integrator has accepted a step; returns whether the model needs event handling.
    pub(crate) fn completed_step(&mut self) -> Result<bool, Fault> {
        let (equations, t) = (equations::<M>()?, self.state.time);
        self.check_stop()?;
        let needs_event = self.change(|model, p, u| (equations.completed_step)(model, p, u, t))?;
        self.invalidate();
        Ok(needs_event)
    }

    /// Refuses accepted steps beyond the stop time; evaluations there are allowed.
    fn check_stop(&self) -> Result<(), Fault> {
        let t = self.state.time;
        match self.state.stop {
            Some(stop) if t > stop + slack(stop, 0.0) => {
                refuse!("time = {t} s must be at most the stop time = {stop} s")
            }
            _ => Ok(()),
        }
    }

    /// Lets `f` change the model and collects its messages.
    fn change<T>(
        &mut self,
        f: impl FnOnce(&mut M, &M::Parameters, &M::Input) -> Result<T, ModelError>,
    ) -> Result<T, Fault> {
        let state = &mut self.state;
        let u = match &state.held_input {
            Some(held) => &held.value,
            None => &state.input.value,
        };
        let Some(model) = &mut state.model else {
            unreachable!("made at the end of initialization");
        };
        set_log_filter(self.log_filter, model);
        let done = f(model, &state.parameters, u);
        match done {
            Ok(_) => collect_messages(&mut self.messages, model),
            Err(_) => collect_log(&mut self.messages, model),
        }
        Ok(done?)
    }
}
