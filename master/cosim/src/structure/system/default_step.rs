//! The communication step of a run for which none is given, for programs, Python and pages: what
//! the structure asks for, else its FMUs; a tiny step only where an FMU needs it.

use super::System;
use crate::schedule::STEP;
use fmi_import::digits::short;

/// Most steps of a run that are made because an FMU asks for a step shorter than [`STEP`].
const MOST_STEPS: f64 = 1e5;

/// A communication step, and why it is this one.
#[derive(Clone, Debug, PartialEq)]
pub struct DefaultStep {
    /// Step, s.
    pub step: f64,
    /// It is a multiple of the step that was asked for.
    pub is_widened: bool,
    /// What the user must know of it.
    pub text: String,
}

impl System {
    /// The communication step that the structure requests, else the smallest that an FMU prefers,
    /// for a run over `span`, s. If that would be very many tiny steps, and the FMU can vary its
    /// step, it is a whole multiple of that.
    pub fn default_step(&self, span: f64) -> Option<DefaultStep> {
        let all = self.structure.components.iter().zip(&self.fmus);
        let asked = all.filter_map(|(c, fmu)| {
            let (d, preferred) = (&fmu.description, &fmu.description.default_experiment);
            let reason = match (d.capabilities.variable_step, d.capabilities.internal_step) {
                (_, Some(_)) => ", whose internal step is fixed",
                (false, None) => ", which cannot vary its step",
                (true, None) => "",
            };
            let step = preferred.step.or(d.capabilities.internal_step)?;
            let is_step = step.is_finite() && step > 0.0;
            is_step.then(|| (step, format!("`{}`", c.name), reason))
        });
        let asked: Vec<_> = asked.collect();
        let least = |is_bound: bool| {
            let fitting = asked.iter().filter(|a| !is_bound || !a.2.is_empty());
            fitting.min_by(|a, b| a.0.total_cmp(&b.0)).cloned()
        };
        let of_structure = self.structure.step;
        let of_structure = of_structure.map(|step| (step, "the system structure".to_string(), ""));
        let mut chosen = of_structure.or_else(|| least(false))?;
        let (mut step, count) = (chosen.0, |h: f64| (span / h).round());
        if self.structure.step.is_none() && chosen.2.is_empty() && step < STEP {
            step *= (span / step / MOST_STEPS - 1e-9).ceil().max(1.0);
            if let Some(bound) = least(true).filter(|bound| bound.0 < step) {
                (step, chosen) = (bound.0, bound);
            }
        }
        let (asked, who, reason) = chosen;
        let is_widened = step > asked;
        let why = match count(step) > MOST_STEPS {
            _ if is_widened => format!(
                "{} times the {} s that {who} asks for: {} steps instead of {} (give the step to choose another)",
                (step / asked).round(),
                short(asked),
                count(step),
                count(asked)
            ),
            true => format!("as {who} asks{reason}: {} steps", count(step)),
            false => format!("as {who} asks"),
        };
        let text = format!("the communication step is {} s, {why}", short(step));
        Some(DefaultStep {
            step,
            is_widened,
            text,
        })
    }
}
