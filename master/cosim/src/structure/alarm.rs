//! Alarms as system structures declare them, for `flatten`, `System` and the supervision of runs:
//! outputs that mean that the result is not good. An annotation of a component, or of a system for
//! the components in it, names the variable, the condition and what it means.

use std::sync::Arc;

use anyhow::{Context, Result, bail, ensure};
use fmi_description::Kind;
use fmi_description::xml::Element;
use system_structure::Annotation;

use super::arrays::elements;
use super::ways::join;
use crate::fmu::Fmu;
use crate::io::numbers;
use crate::structure::system::System;
use crate::wiring::Port;

/// Type of the annotation that holds the alarms.
const ALARMS: &str = "io.github.hdrm-fmu.alarms";

/// An output that means that the result is not good.
#[derive(Clone, Debug, PartialEq)]
pub struct Alarm {
    /// Name of the component.
    pub component: String,
    /// Name of the variable; of an array each element counts.
    pub variable: String,
    condition: Condition,
    /// What the value is compared with: a number, `true`, `false` or an enumeration item.
    bound: String,
    /// What it means, for people.
    pub text: String,
    /// File and line.
    place: String,
}

/// How the value is compared with the bound.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Condition {
    Equals,
    Above,
    Below,
}

const CONDITIONS: [(&str, Condition); 3] = [
    ("equals", Condition::Equals),
    ("above", Condition::Above),
    ("below", Condition::Below),
];

/// An alarm on one variable of a loaded system.
#[derive(Clone, Debug)]
pub(crate) struct PortAlarm {
    pub port: Port,
    condition: Condition,
    bound: f64,
    text: String,
}

impl Alarm {
    /// The alarms among the annotations of the element with the path `path`. Their components are
    /// known only to [`Alarm::find_component`].
    pub(super) fn read_all(annotations: &[Annotation], path: &str, file: &str) -> Result<Vec<Self>> {
        let mut alarms = Vec::new();
        for Annotation { kind, content } in annotations {
            let list = content.child("Alarms");
            if (kind == ALARMS) != list.is_some() {
                bail!(content.error(format!(
                    "an annotation of type `{kind}` must not hold Alarms, only and always one of type `{ALARMS}`"
                )));
            }
            for alarm in list.iter().flat_map(|list| &list.children) {
                alarms.push(Self::read(alarm, path, file)?);
            }
        }
        Ok(alarms)
    }

    fn read(node: &Element, path: &str, file: &str) -> Result<Self> {
        let given = CONDITIONS.map(|(name, condition)| Some((condition, node.get(name)?)));
        let mut given = given.into_iter().flatten();
        let (Some((condition, bound)), None, true) =
            (given.next(), given.next(), node.tag == "Alarm")
        else {
            bail!(node.error(
                "Alarms must be elements `Alarm`, each with a variable, a text and one condition: equals, above or below".into()
            ));
        };
        Ok(Self {
            component: String::new(),
            variable: join(path, &node.required("variable")?),
            condition,
            bound: bound.into(),
            text: node.required("text")?,
            place: format!("`{file}`, line {}", node.line),
        })
    }

    /// Splits the component's name off the variable's.
    pub(super) fn find_component(&mut self, structure: &super::Structure) -> Result<()> {
        let Some((component, variable)) = structure.split(&self.variable) else {
            let (place, name) = (&self.place, &self.variable);
            bail!(
                "{place}: an alarm is on `{name}`, of no component of the system; these are {}",
                structure.component_names()
            );
        };
        (self.component, self.variable) = (
            structure.components[component].name.clone(),
            variable.to_string(),
        );
        Ok(())
    }

    /// Whether an FMU has the variable.
    fn is_in(&self, fmu: &Fmu) -> bool {
        fmu.description.index(&self.variable).is_some() || !elements(fmu, &self.variable).is_empty()
    }
}

impl System {
    /// The alarms of the structure, by variables.
    ///
    /// # Errors
    /// A variable that the FMU does not have or whose type is no number, or a bound that it cannot
    /// be compared with.
    pub(crate) fn alarms(&self) -> Result<Vec<PortAlarm>> {
        let mut alarms = Vec::new();
        for alarm in &self.structure.alarms {
            let place = || format!("{}: an alarm", alarm.place);
            let component = self.structure.component(&alarm.component);
            let component = component.with_context(place)?;
            let mut names = elements(&self.fmus[component], &alarm.variable);
            if names.is_empty() {
                names.push(alarm.variable.clone());
            }
            for name in names {
                let port = self.port_of(component, &name).with_context(place)?;
                let (v, name) = (self.variable(port), self.name(port));
                let on = || format!("{} on `{name}`", place());
                ensure!(v.access().is_number(), "{}, which is no number", on());
                // Bounds of inputs do not hold for what is compared with them.
                let mut free = v.clone();
                (free.min, free.max) = (None, None);
                let bound = numbers::number(&free, &alarm.bound).with_context(on)?;
                alarms.push(PortAlarm {
                    port,
                    condition: alarm.condition,
                    bound,
                    text: alarm.text.clone(),
                });
            }
        }
        Ok(alarms)
    }

    /// Drops, with a remark, alarms on variables that the FMUs given for components `replaced`
    /// do not have.
    pub(super) fn drop_alarms<'a>(&mut self, mut replaced: impl Iterator<Item = &'a String> + Clone) {
        let Self {
            structure, fmus, ..
        } = self;
        let mut alarms = std::mem::take(&mut structure.alarms);
        alarms.retain(|alarm| {
            let component = structure.component(&alarm.component);
            let own: Option<&Arc<Fmu>> = component.map(|k| &fmus[k]);
            let is_kept = own.is_none_or(|fmu| alarm.is_in(fmu))
                || !replaced.clone().any(|name| *name == alarm.component);
            if !is_kept {
                structure.remarks.push(format!(
                    "the alarm on `{}.{}` is left out, because the FMU given for `{}` has no such variable",
                    alarm.component, alarm.variable, alarm.component
                ));
            }
            is_kept
        });
        structure.alarms = alarms;
    }
}

impl PortAlarm {
    /// Whether it holds for a value.
    pub fn holds(&self, value: f64) -> bool {
        match self.condition {
            Condition::Equals => value == self.bound,
            Condition::Above => value > self.bound,
            Condition::Below => value < self.bound,
        }
    }

    /// As text: what it means, and the value since the time `t`, s, at which it first held.
    pub fn describe(&self, system: &System, value: f64, t: f64) -> String {
        let value = match &system.variable(self.port).kind {
            Kind::Boolean => (value != 0.0).to_string(),
            Kind::Enumeration(items) => {
                let item = items.iter().find(|item| item.value as f64 == value);
                item.map_or(value.to_string(), |item| item.name.clone())
            }
            _ => value.to_string(),
        };
        let name = system.name(self.port);
        format!("{}: `{name}` is {value}, first at t = {t} s", self.text)
    }
}
