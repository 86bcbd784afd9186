//! Methods of `System` that find variables by name and suggest a known name for an unknown one.

use std::collections::HashMap;

use anyhow::{Context, Result, bail};
use fmi_description::Variable;

use super::System;
use crate::structure::{OuterInput, OuterOutput, arrays};
use crate::wiring::Port;

/// Least similarity of a known name that is suggested for an unknown one; 1 is the same name.
const LEAST_SIMILARITY: f64 = 0.85;

/// The names of a system, for many look-ups.
pub(crate) struct Names<'a> {
    pub system: &'a System,
    components: HashMap<&'a str, usize>,
    /// Inputs of the system.
    pub inputs: HashMap<&'a str, &'a OuterInput>,
    outputs: HashMap<&'a str, &'a OuterOutput>,
}

impl<'a> Names<'a> {
    pub fn new(system: &'a System) -> Self {
        // Of two of the same name the first counts.
        let structure = &system.structure;
        let components = structure.components.iter().enumerate().rev();
        let inputs = structure.inputs.iter().rev();
        let outputs = structure.outputs.iter().rev();
        Self {
            system,
            components: components.map(|(k, c)| (c.name.as_str(), k)).collect(),
            inputs: inputs.map(|input| (input.name.as_str(), input)).collect(),
            outputs: outputs.map(|o| (o.name.as_str(), o)).collect(),
        }
    }

    /// Index of a component.
    pub fn component(&self, name: &str) -> Option<usize> {
        self.components.get(name).copied()
    }

    /// As [`System::port`].
    pub fn port(&self, name: &str) -> Result<Port> {
        if let Some(output) = self.outputs.get(name)
            && let Some(component) = self.component(&output.start.0)
        {
            return self.system.port_of(component, &output.start.1);
        }
        let mut dots = name.rmatch_indices('.');
        let found = dots.find_map(|(at, _)| Some((self.component(&name[..at])?, &name[at + 1..])));
        match found {
            Some((component, variable)) => self.system.port_of(component, variable),
            None => self.system.port(name),
        }
    }

    /// As [`System::ports`].
    pub fn ports(&self, name: &str) -> Result<Vec<Port>> {
        let found = self.port(name);
        found.map_or_else(|_| self.system.ports(name), |port| Ok(vec![port]))
    }
}

impl System {
    /// The variable named `component.variable`, or `variable` if only one component has it, or
    /// named as an output of the system.
    pub fn port(&self, name: &str) -> Result<Port> {
        let has = |k: usize, name: &str| self.fmus[k].description.index(name).is_some();
        match self.owners(name, has)[..] {
            [(component, variable)] => self.port_of(component, variable),
            [] => bail!(
                "no component of the system has a variable `{name}`{}; its components are {}",
                self.nearest(name),
                self.structure.component_names()
            ),
            _ => bail!(
                "several components have a variable `{name}`; name the component: component.{name}"
            ),
        }
    }

    /// The variables that a user means by a name, in every option: one, as of [`Self::port`], or
    /// all elements of the array of this name.
    pub fn ports(&self, name: &str) -> Result<Vec<Port>> {
        let found = self.known_ports(name);
        found.map_or_else(|| self.port(name).map(|port| vec![port]), Ok)
    }

    fn known_ports(&self, name: &str) -> Option<Vec<Port>> {
        let port = |component: usize, name: &str| {
            let variable = self.fmus[component].description.index(name)?;
            Some(Port::new(component, variable))
        };
        if let [(k, variable)] = self.owners(name, |k, name| port(k, name).is_some())[..]
            && let Some(port) = port(k, variable)
        {
            return Some(vec![port]);
        }
        let elements = |k: usize, array: &str| -> Vec<Port> {
            let arrays = arrays::elements(&self.fmus[k]);
            let names = arrays.get(array).map_or(&[][..], Vec::as_slice);
            names.iter().filter_map(|name| port(k, name)).collect()
        };
        match self.owners(name, |k, array| !elements(k, array).is_empty())[..] {
            [(k, array)] => Some(elements(k, array)).filter(|ports| !ports.is_empty()),
            _ => None,
        }
    }

    /// The component that a name belongs to, and the name in it; none, or two if more components
    /// have a variable of this name, as `has` says.
    fn owners<'a>(
        &'a self,
        name: &'a str,
        has: impl Fn(usize, &str) -> bool,
    ) -> Vec<(usize, &'a str)> {
        if let Some(output) = self.structure.outputs.iter().find(|o| o.name == name)
            && let Some(component) = self.structure.component(&output.start.0)
        {
            return vec![(component, &output.start.1)];
        }
        if let Some(own) = self.structure.split(name) {
            return vec![own];
        }
        let owners = (0..self.fmus.len()).filter(|k| has(*k, name));
        owners.take(2).map(|k| (k, name)).collect()
    }

    /// Splits `NAME=REST` after the longest name of a variable, an array or an input of the system,
    /// since a name may contain `=`; else at the first `=`. None without any `=`.
    pub fn split_name<'a>(&self, text: &'a str) -> Option<(&'a str, &'a str)> {
        let split = |(k, _): (usize, &str)| (text[..k].trim(), text[k + 1..].trim());
        let first = text.find('=')?;
        let later = text.rmatch_indices('=').take_while(|(k, _)| *k > first);
        let longest = later.map(split).find(|(name, _)| self.is_known(name));
        Some(longest.unwrap_or_else(|| split((first, "="))))
    }

    /// Whether it names a variable, an array or an input of the system.
    pub(crate) fn is_known(&self, name: &str) -> bool {
        let mut inputs = self.structure.inputs.iter();
        inputs.any(|input| input.name == name) || self.known_ports(name).is_some()
    }

    /// A suggestion for an unknown name, as the end of an error message.
    fn nearest(&self, name: &str) -> String {
        let all = self.structure.components.iter().zip(&self.fmus);
        let names = all.flat_map(|(c, fmu)| {
            let variables = fmu.description.variables.iter();
            variables.flat_map(|v| [v.name.clone(), format!("{}.{}", c.name, v.name)])
        });
        let inputs = self.structure.inputs.iter().map(|input| input.name.clone());
        let outputs = self.structure.outputs.iter().map(|o| o.name.clone());
        let names = names.chain(inputs).chain(outputs);
        let rated = names.map(|known| (strsim::jaro_winkler(name, &known), known));
        let best = rated.max_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((likeness, known)) if likeness > LEAST_SIMILARITY => {
                format!("; did you mean `{known}`?")
            }
            _ => String::new(),
        }
    }

    /// All variables, component by component.
    pub fn all_ports(&self) -> impl Iterator<Item = Port> {
        let all = self.fmus.iter().map(|fmu| fmu.description.variables.len());
        all.enumerate().flat_map(|(component, count)| {
            (0..count).map(move |variable| Port::new(component, variable))
        })
    }

    /// A variable of the component with this index.
    pub fn port_of(&self, component: usize, variable: &str) -> Result<Port> {
        let description = &self.fmus[component].description;
        let found = description.variable(variable);
        found.with_context(|| {
            let name = format!("{}.{variable}", self.structure.components[component].name);
            format!("`{name}`{}", self.nearest(&name))
        })?;
        Ok(Port::new(
            component,
            description.index(variable).unwrap_or_default(),
        ))
    }

    /// The elements 1 to `count` of the array `array` of the component with this index.
    pub fn elements(&self, component: usize, array: &str, count: usize) -> Result<Vec<Port>> {
        let element = |k| self.port_of(component, &format!("{array}[{k}]"));
        (1..=count).map(element).collect()
    }

    /// A variable in the model description.
    pub fn variable(&self, port: Port) -> &Variable {
        &self.fmus[port.component].description.variables[port.variable]
    }

    /// Name of the component that a variable belongs to.
    pub fn component_of(&self, port: Port) -> &str {
        &self.structure.components[port.component].name
    }

    /// `component.variable`.
    pub fn name(&self, port: Port) -> String {
        format!("{}.{}", self.component_of(port), self.variable(port).name)
    }
}
