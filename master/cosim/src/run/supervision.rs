//! Supervises a run of `simulate` or of a page: watches every communication point for divergence
//! and for alarms that the structure declares, and judges the result by these, by energy that the
//! coupling created or lost, and by messages of FMUs.

use std::collections::HashMap;

use anyhow::Result;

use crate::exchange::bond::Residual;
use crate::fmu::Fmu;
use crate::instance::Ended;
use crate::master::Master;
use crate::run::alarms::AlarmWatch;
use crate::run::divergence::Watch;
use crate::run::verdict::Verdict;
use crate::structure::system::{System, method_name};
use fmi_import::digits::short;
use fmi_import::fmi_instance::Integration;
use fmi_import::messages::{self, Message};

/// Share of the energy through all bonds that the coupling may create or lose.
const SPURIOUS: f64 = 0.01;
/// Energy that may be due to rounding, J.
const ROUNDING: f64 = 1e-9;

/// The supervision of one run.
#[derive(Clone, Debug)]
pub struct Supervision {
    pub(crate) watch: Watch,
    pub(crate) alarms: AlarmWatch,
    /// The findings so far, without those that are judged at the end.
    pub findings: Verdict,
}

impl Supervision {
    /// For a run of `system` that begins, with the findings so far.
    pub fn new(system: &System, master: &Master, mut findings: Verdict) -> Result<Self> {
        let step = master.stepping().step;
        if let Some((component, internal)) = system.uneven_step(step) {
            findings.note(format!(
                "the communication step of {} s is no multiple of the fixed internal step of `{component}`, {} s",
                short(step),
                short(internal)
            ));
        }
        let fmus = || system.structure.components.iter().zip(&system.fmus);
        for (is_wasm, what) in [
            (false, "in a process of its own"),
            (true, "from WebAssembly, in a process of its own"),
        ] {
            let alike = |fmu: &Fmu| fmu.is_isolated() && fmu.loaded.is_wasm() == is_wasm;
            let alike = fmus().filter(|(_, fmu)| alike(fmu));
            let names: Vec<&str> = alike.map(|(component, _)| &*component.name).collect();
            if !names.is_empty() {
                findings.note(format!("{what}: {}", names.join(", ")));
            }
        }
        Ok(Self {
            watch: Watch::new(master.time(), &master.exchange().values),
            alarms: AlarmWatch::new(system, master)?,
            findings,
        })
    }

    /// Adds the present communication point.
    pub fn add(&mut self, master: &Master) -> Result<()> {
        self.watch.add(master.time(), &master.exchange().values);
        self.alarms.add(master)
    }

    /// Adds to the error of a step which loop had begun to diverge, if one had, and no FMU asked to
    /// end the run.
    pub fn explain(&self, error: anyhow::Error, system: &System, master: &Master) -> anyhow::Error {
        match self.divergence(system, master) {
            Some(cause) if !error.is::<Ended>() => error.context(cause),
            _ => error,
        }
    }

    /// The verdict so far, without the messages of the FMUs.
    pub fn verdict(&self, system: &System, master: &Master) -> Verdict {
        let mut verdict = self.findings.clone();
        if let Some(text) = self.divergence(system, master) {
            verdict.object(text);
        }
        judge(master.residuals(), &mut verdict);
        master.judge_unconnected(system, &mut verdict);
        self.alarms.judge(system, &mut verdict);
        verdict
    }

    /// Terminates all instances and returns the verdict.
    pub fn end(&self, system: &System, master: Master) -> Result<Verdict> {
        let mut verdict = self.so_far(system, &master, Vec::new());
        master.terminate()?;
        tell(system, messages::take(), &mut verdict);
        Ok(verdict)
    }

    /// The verdict so far, with these messages of the FMUs.
    pub fn so_far(&self, system: &System, master: &Master, messages: Vec<Message>) -> Verdict {
        let mut verdict = self.verdict(system, master);
        for instance in master.instances() {
            if let Some(integration) = instance.integration() {
                let method = instance.fmu().method().map(method_name);
                verdict.note(describe(&instance.name, method, &integration));
            }
        }
        tell(system, messages, &mut verdict);
        verdict
    }

    /// Which output diverges since when, as text.
    fn divergence(&self, system: &System, master: &Master) -> Option<String> {
        let (slot, since) = self.watch.diverged?;
        let name = system.name(master.exchange().output(slot)?);
        let [since, step] = [since, master.stepping().step].map(short);
        Some(format!(
            "`{name}` diverges from t = {since} s on: it jumps up and down from one communication point to the next, further each time; the \
             communication step of {step} s is too long for the loops of this system"
        ))
    }
}

/// Adds what the FMUs said, apart from information. Threads have delivered their messages one after
/// the other.
fn tell(system: &System, mut messages: Vec<Message>, verdict: &mut Verdict) {
    let components = system.structure.components.iter().enumerate();
    let components: HashMap<_, _> = components.map(|(k, c)| (c.name.as_str(), k)).collect();
    let component = |m: &Message| components.get(&*m.instance).copied();
    messages.sort_by_key(|message| component(message).unwrap_or(usize::MAX));
    let findings = messages.iter().filter(|message| !message.is_info);
    findings.for_each(|message| verdict.note(message.to_string()));
}

/// Judges the energy that the coupling created or lost at each bond, relative to the energy through
/// all bonds: one that transfers next to nothing proves nothing.
fn judge(residuals: &[Residual], verdict: &mut Verdict) {
    let all: f64 = residuals.iter().map(|r| r.turnover).sum();
    for Residual { bond, energy, .. } in residuals {
        let share = energy.abs() / all;
        // An energy that is not finite is not small.
        let is_small = share <= SPURIOUS || energy.abs() <= ROUNDING;
        if !is_small {
            let done = if *energy < 0.0 { "created" } else { "lost" };
            verdict.object(format!(
                "the coupling {done} {:.3e} J at the bond {bond}, {:.1} % of what went through all bonds: a loop is unstable, or the \
                 communication step too long",
                energy.abs(),
                100.0 * share
            ));
        }
    }
}

/// What the integration of a component of Model Exchange took.
fn describe(name: &str, method: Option<String>, integration: &Integration) -> String {
    let Integration {
        steps,
        rejected,
        evaluations,
        jacobians,
        events,
        stiff_since,
    } = integration;
    let stiff = stiff_since.map_or(String::new(), |since| {
        let since = short(since);
        format!(", {jacobians} Jacobians: stiff from t = {since} s on")
    });
    let method = method.map_or(String::new(), |method| format!(", {method}"));
    format!(
        "{name} is integrated (Model Exchange{method}): {steps} steps, {rejected} rejected, {evaluations} right-hand sides, {events} events{stiff}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bond_is_judged_relative_to_the_energy_through_all() {
        let residual = |energy, turnover| Residual {
            energy,
            turnover,
            ..Residual::new("a.F".into())
        };
        let is_bad = |residuals: &[Residual]| {
            let mut verdict = Verdict::default();
            judge(residuals, &mut verdict);
            verdict.is_bad()
        };
        assert!(is_bad(&[residual(-0.02, 1.0)]) && is_bad(&[residual(0.02, 1.0)]));
        assert!(!is_bad(&[residual(-0.02, 1.0), residual(0.0, 2.0)]));
        assert!(!is_bad(&[residual(-1e-12, 1e-12)]), "rounding");
    }
}
