//! The equations of an instance as the solver asks for them: derivatives, directional derivatives
//! and event indicators at a time and at states, by the C functions of either version.

use fmu_solver::System;
use serde::{Deserialize, Serialize};

use super::plan::ExchangePlan;
use super::ramp::Ramp;
use crate::answer::Answer;
use crate::fmi_instance::FmiInstance;
use crate::raw::{Array, ContinuousValues, RawInstance};
use crate::status::{DISCARD, ERROR, OK, WARNING};

/// Part of the largest value of an indicator that it must exceed to count as positive again: with
/// this hysteresis rounding makes no events.
const HYSTERESIS: f64 = 1e-13;

/// Which way each event indicator counts.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Sides {
    /// What an indicator must exceed to be positive: 0 if it is, else its hysteresis.
    pub thresholds: Vec<f64>,
    /// Largest value of each so far.
    pub largest: Vec<f64>,
}

impl Sides {
    /// After an event: what counts is the sign of each indicator there.
    pub fn set(&mut self, z: &[f64]) {
        for ((threshold, largest), z) in self.thresholds.iter_mut().zip(&mut self.largest).zip(z) {
            *largest = largest.max(z.abs());
            let least = (HYSTERESIS * *largest).max(f64::MIN_POSITIVE);
            *threshold = if *z > 0.0 { 0.0 } else { least };
        }
    }

    /// Whether an indicator is on the other side than at the last event.
    pub fn has_event(&self, z: &[f64]) -> bool {
        let mut all = self.thresholds.iter().zip(z);
        all.any(|(threshold, z)| (*threshold == 0.0) != (*z > *threshold))
    }
}

/// Why the equations could not be evaluated.
#[derive(Clone, Copy, Debug)]
pub(super) enum Fault {
    /// A C function returned this status.
    Answer(Answer),
    /// The derivative of this state is not finite: state, value, time in s.
    NotFinite(usize, f64, f64),
    /// This event indicator is NaN; time in s.
    Indicator(usize, f64),
}

/// The status of a C function, which has this name in FMI 2.0.
pub(super) fn check(raw: &RawInstance, status: i32, name: &'static str) -> Result<(), Answer> {
    match status {
        OK | WARNING => Ok(()),
        _ => Err(Answer {
            status,
            call: raw.functions().name(name),
        }),
    }
}

/// The answer in an error of an instance.
#[cold]
pub(super) fn answer(error: anyhow::Error, call: &'static str) -> Answer {
    let status = ERROR;
    error.downcast().unwrap_or(Answer { status, call })
}

/// The equations of one instance.
pub(super) struct Equations<'a> {
    pub raw: &'a RawInstance,
    pub inner: &'a dyn FmiInstance,
    pub plan: &'a ExchangePlan,
    /// Time from which the solver counts, s.
    pub t: f64,
    pub ramps: &'a mut Vec<Ramp>,
    pub sides: &'a Sides,
    /// Numbers of derivatives that were evaluated.
    pub evaluations: &'a mut u64,
}

impl Equations<'_> {
    /// Sets time, states and inputs that change.
    pub fn set(&mut self, t: f64, x: &[f64]) -> Result<(), Answer> {
        check(self.raw, self.raw.set_time(t), "fmi2SetTime")?;
        if !x.is_empty() {
            let status = self.raw.set_continuous_states(Array::Elements(x));
            check(self.raw, status, "fmi2SetContinuousStates")?;
        }
        for ramp in self.ramps.iter_mut() {
            ramp.at(t);
            let set = self.inner.set(&ramp.batch, &ramp.now);
            set.map_err(|error| answer(error, "fmi2SetReal"))?;
        }
        Ok(())
    }

    pub fn get(&self, which: ContinuousValues, values: &mut [f64]) -> Result<(), Answer> {
        if values.is_empty() {
            return Ok(()); // not every FMU takes an array of length 0
        }
        let n = values.len();
        let status = self.raw.get_continuous(which, Some(values), n);
        check(self.raw, status, which.function())
    }
}

impl System for Equations<'_> {
    type Error = Fault;

    fn derivative(&mut self, s: f64, x: &[f64], dx: &mut [f64]) -> Result<(), Fault> {
        *self.evaluations += 1;
        let t = self.t + s;
        self.set(t, x).map_err(Fault::Answer)?;
        self.get(ContinuousValues::Derivatives, dx)
            .map_err(Fault::Answer)?;
        match dx.iter().position(|rate| !rate.is_finite()) {
            Some(state) => Err(Fault::NotFinite(state, dx[state], t)),
            None => Ok(()),
        }
    }

    fn directional(
        &mut self,
        s: f64,
        x: &[f64],
        seed: &[f64],
        change: &mut [f64],
    ) -> Result<bool, Fault> {
        if !self.plan.has_directional {
            return Ok(false);
        }
        self.set(self.t + s, x).map_err(Fault::Answer)?;
        let (y, u) = (&self.plan.unknown, &self.plan.known);
        let status = self.raw.get_directional_derivative(y, u, seed, change);
        check(self.raw, status, "fmi2GetDirectionalDerivative").map_err(Fault::Answer)?;
        Ok(true)
    }

    /// Shorter steps help only where the FMU says so.
    fn may_retry(&self, fault: &Fault) -> bool {
        match fault {
            Fault::Answer(answer) => answer.status == DISCARD,
            Fault::NotFinite(..) => true,
            Fault::Indicator(..) => false,
        }
    }

    /// Relative to what they must exceed.
    fn indicators(&mut self, s: f64, x: &[f64], z: &mut [f64]) -> Result<(), Fault> {
        self.set(self.t + s, x).map_err(Fault::Answer)?;
        self.get(ContinuousValues::Indicators, z)
            .map_err(Fault::Answer)?;
        if let Some(k) = z.iter().position(|z| z.is_nan()) {
            return Err(Fault::Indicator(k, self.t + s));
        }
        let thresholds = self.sides.thresholds.iter();
        z.iter_mut().zip(thresholds).for_each(|(z, at)| *z -= at);
        Ok(())
    }
}
