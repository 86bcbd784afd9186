//! A run in a page: steps the system, records the watched variables, sets inputs and parameters,
//! and keeps saved states. `engine` owns the run; `command` calls it.

use std::collections::BTreeMap;

use anyhow::{Context, Result, bail, ensure};
use cosim::exchange::faults::{self, Faults};
use cosim::instance::{At, messages};
use cosim::io::numbers;
use cosim::master::{Master, Saved};
use cosim::run::experiment::Experiment;
use cosim::run::signals::{Inputs, Signals};
use cosim::run::supervision::Supervision;
use cosim::run::verdict::Verdict;
use cosim::schedule::Schedule;
use cosim::structure::system::{Setting, System};
use cosim::wiring::Port;
use fmi_description::{Causality, Kind};
use serde_json::Value;

/// A run.
pub struct Run {
    /// The system.
    pub system: System,
    /// The master that runs it.
    pub master: Master,
    supervision: Supervision,
    names: Vec<String>,
    signals: Option<Signals>,
    /// Error that has ended the run.
    end: Option<String>,
    /// Settings that take effect at the next step.
    waiting: Vec<Setting>,
    /// Driven inputs that have another value than the connection's.
    overridden: Faults,
    saved: BTreeMap<u64, (Saved, Supervision, Faults)>,
    next_id: u64,
}

impl Run {
    /// Start a run; `verdict` has the findings so far.
    pub fn start(system: System, experiment: &Experiment, verdict: Verdict) -> Result<Self> {
        let master = experiment.start(&system)?;
        let supervision = Supervision::new(&system, &master, verdict)?;
        Ok(Self {
            system,
            master,
            supervision,
            names: Vec::new(),
            signals: None,
            end: None,
            waiting: Vec::new(),
            overridden: experiment.faults.clone(),
            saved: BTreeMap::new(),
            next_id: 0,
        })
    }

    /// Watch these variables from now on.
    pub fn watch(&mut self, names: Vec<String>) -> Result<()> {
        let ports = names.iter().map(|name| self.system.port(name));
        let ports = ports.collect::<Result<Vec<_>>>()?;
        let signals = (!ports.is_empty()).then(|| Signals::new(&self.system, &ports));
        self.signals = signals.transpose()?;
        self.names = names;
        Ok(())
    }

    /// Names of the watched variables.
    pub fn watched(&self) -> &[String] {
        &self.names
    }

    /// Add a row to `history`: the present time, s, and the values of the watched variables.
    pub fn record(&mut self, history: &mut Vec<f64>) -> Result<()> {
        history.push(self.master.time());
        if let Some(signals) = &mut self.signals {
            history.extend_from_slice(signals.read(&self.master)?);
        }
        Ok(())
    }

    /// Make a communication step and add a row to `history`.
    pub fn step(&mut self, history: &mut Vec<f64>) -> Result<()> {
        if let Some(end) = &self.end {
            bail!("{end}");
        }
        let waiting = std::mem::take(&mut self.waiting);
        let given = waiting.iter().try_for_each(|setting| self.apply(setting));
        let time = self.master.time();
        if let Err(error) = given.and_then(|()| self.master.step()) {
            let error = (self.supervision).explain(error, &self.system, &self.master);
            let text = format!("{error:#}");
            self.supervision.findings.object(text.clone());
            self.end = Some(text);
            // An FMU has ended the run after a step, whose row counts if it can be read.
            let before = history.len();
            if self.master.time() > time && self.record(history).is_err() {
                history.truncate(before);
            }
            return Err(error);
        }
        self.supervision.add(&self.master)?;
        self.record(history)
    }

    /// Present value of a variable.
    pub fn get(&self, name: &str) -> Result<Value> {
        let port = self.system.port(name)?;
        let v = self.system.variable(port);
        let is_truth = v.kind == Kind::Boolean;
        Ok(match v.access().is_number() {
            true => match self.master.number(port)? {
                number if is_truth => (number != 0.0).into(),
                number => number.into(),
            },
            false => self.master.text(port)?.into(),
        })
    }

    /// Set an input that no connection drives, or a tunable parameter; an input of the system sets
    /// all inputs that it feeds. It takes effect at the present communication point, but with the
    /// schedule `standard` just before the next step, because nothing may be read after it. The text
    /// `override:VALUE` gives an input that a connection drives this value instead, and
    /// `override:` the connection's again.
    pub fn set(&mut self, name: &str, text: &str) -> Result<()> {
        if let Some(value) = text.strip_prefix("override:") {
            let port = self.system.port(name)?;
            if self.driver(port)?.is_some() {
                return self.override_input(port, value);
            }
        }
        let settings = self.system.settings(name, text)?;
        for setting in &settings {
            self.refuse_fixed(setting.port)?;
            let v = self.system.variable(setting.port);
            if v.access().is_number() {
                let number = numbers::number(v, &setting.value);
                number.with_context(|| self.system.name(setting.port))?;
            }
        }
        if self.master.stepping().schedule == Schedule::Standard {
            self.waiting.extend(settings);
            return Ok(());
        }
        let mut settings = settings.iter();
        settings.try_for_each(|setting| self.apply(setting))?;
        self.master.pass()
    }

    fn override_input(&mut self, port: Port, value: &str) -> Result<()> {
        let mut overridden = self.overridden.clone();
        overridden.list.retain(|fault| fault.port != port);
        if !value.is_empty() {
            let name = self.system.name(port);
            overridden.add(&self.system, &format!("{name}=override:{value}"))?;
        }
        self.master.apply_faults(&self.system, &overridden)?;
        self.overridden = overridden;
        Ok(())
    }

    /// Name of the output that drives an input during the run.
    pub fn driver(&self, port: Port) -> Result<Option<String>> {
        let wiring = self.system.wiring()?;
        let link = wiring.driver(port).map(|k| &wiring.links[k]);
        let link = link.filter(|link| !link.is_initial);
        Ok(link.map(|link| wiring.name(link.from)))
    }

    fn apply(&self, setting: &Setting) -> Result<()> {
        let v = self.system.variable(setting.port);
        if v.access().is_number() {
            let number = numbers::number(v, &setting.value)?;
            let mut inputs = Inputs::new(&self.system, &[setting.port])?;
            return inputs.set(&self.master, &[number]);
        }
        let instance = &self.master.instances()[setting.port.component];
        let set = instance.set_from_text(&v.name, &setting.value);
        set.with_context(|| At::Time(self.master.time()).to_string())
    }

    /// Refuse variables that cannot be set during a run.
    fn refuse_fixed(&self, port: Port) -> Result<()> {
        let (v, name) = (self.system.variable(port), self.system.name(port));
        ensure!(
            !faults::is_source(&self.system, port),
            "`{name}` is an output; inputs and parameters can be set"
        );
        if let Some(from) = self.driver(port)? {
            bail!(
                "`{name}` cannot be set: the connection from `{from}` gives it its values; `override:VALUE` replaces them"
            );
        }
        ensure!(
            v.causality == Causality::Input || v.is_tunable(),
            "`{name}` is fixed once a run has begun: it takes effect by a restart"
        );
        Ok(())
    }

    /// Save the state of the run; returns its number.
    pub fn save(&mut self) -> Result<u64> {
        let saved = (
            self.master.save()?,
            self.supervision.clone(),
            self.overridden.clone(),
        );
        self.next_id += 1;
        self.saved.insert(self.next_id, saved);
        Ok(self.next_id)
    }

    /// Return to a saved state.
    pub fn restore(&mut self, id: u64) -> Result<()> {
        let saved = self.saved.get(&id);
        let (saved, supervision, overridden) =
            saved.with_context(|| format!("this run has no saved state {id}"))?;
        if *overridden != self.overridden {
            self.master.apply_faults(&self.system, overridden)?;
            self.overridden.clone_from(overridden);
        }
        self.master.restore(saved)?;
        self.supervision.clone_from(supervision);
        self.end = None;
        self.waiting.clear();
        Ok(())
    }

    /// Drop a saved state.
    pub fn forget(&mut self, id: u64) {
        self.saved.remove(&id);
    }

    /// The findings of the run so far.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = self.supervision.verdict(&self.system, &self.master);
        for message in messages::present().iter().filter(|m| !m.is_info) {
            verdict.note(message.to_string());
        }
        verdict
    }
}
