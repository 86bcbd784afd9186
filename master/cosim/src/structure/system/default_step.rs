//! The communication step of a run for which none is given, for programs, Python and pages: what
//! the structure asks for, else its FMUs; a tiny step only where an FMU needs it.

use std::fmt;

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
    /// The step that was asked for, s; the communication step may be a multiple of it.
    asked: f64,
    /// Who asked.
    who: String,
    /// Why a run of many steps keeps it.
    reason: Option<&'static str>,
    /// Length of the run, s.
    span: f64,
}

impl DefaultStep {
    /// Whether it is longer than what was asked for.
    pub fn is_widened(&self) -> bool {
        self.step > self.asked
    }
}

impl fmt::Display for DefaultStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (who, [step, asked]) = (&self.who, [self.step, self.asked].map(short));
        let [steps, asked_steps] = [self.step, self.asked].map(|h| (self.span / h).round());
        write!(f, "the communication step is {step} s, ")?;
        if self.is_widened() {
            let times = (self.step / self.asked).round();
            return write!(
                f,
                "{times} times the {asked} s that {who} asks for: {steps} steps instead of {asked_steps} (give the step to choose another)"
            );
        }
        write!(f, "as {who} asks")?;
        if steps > MOST_STEPS {
            let reason = self.reason.map_or(String::new(), |why| format!(", {why}"));
            write!(f, "{reason}: {steps} steps")?;
        }
        Ok(())
    }
}

impl System {
    /// The communication step that the structure requests, else the smallest that an FMU prefers,
    /// for a run over `span`, s. If that would be very many tiny steps, and the FMU can vary its
    /// step, it is a whole multiple of that.
    pub fn default_step(&self, span: f64) -> Option<DefaultStep> {
        let chosen = |step, who, reason| DefaultStep {
            step,
            asked: step,
            who,
            reason,
            span,
        };
        if let Some(step) = self.structure.step {
            return Some(chosen(step, "the system structure".into(), None));
        }
        let all = self.structure.components.iter().zip(&self.fmus);
        let asked = all.filter_map(|(c, fmu)| {
            let (d, preferred) = (&fmu.description, &fmu.description.default_experiment);
            let reason = match (d.capabilities.variable_step, d.capabilities.internal_step) {
                (_, Some(_)) => Some("whose internal step is fixed"),
                (false, None) => Some("which cannot vary its step"),
                (true, None) => None,
            };
            let step = preferred.step.or(d.capabilities.internal_step)?;
            let is_step = step.is_finite() && step > 0.0;
            is_step.then(|| chosen(step, format!("`{}`", c.name), reason))
        });
        let asked: Vec<DefaultStep> = asked.collect();
        let least = |all: &mut dyn Iterator<Item = &DefaultStep>| {
            all.min_by(|a, b| a.step.total_cmp(&b.step)).cloned()
        };
        let mut first = least(&mut asked.iter())?;
        let steps = span / first.asked;
        if first.reason.is_none() && first.asked < STEP && steps > MOST_STEPS {
            first.step = first.asked * (steps / MOST_STEPS - 1e-9).ceil();
            let bound = least(&mut asked.iter().filter(|a| a.reason.is_some()));
            return bound.filter(|b| b.step < first.step).or(Some(first));
        }
        Some(first)
    }
}
