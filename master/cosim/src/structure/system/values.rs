//! Start values of a `System`, from the structure, from parameter sets and from the user, converted
//! to the types and units of their variables.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Context, Result, anyhow, bail, ensure};
use fmi_description::{Causality, Initial, Variability, Variable};
use system_structure::DataType;

use super::System;
use crate::fmu::Fmu;
use crate::structure::package::{Package, read_text};
use crate::structure::{Parameter, arrays, parse_set};
use crate::wiring::Port;
use crate::wiring::transformation::{Linear, Transformation, compose, conversion, unit_of};

/// A start value for a variable, as text.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Variable.
    pub port: Port,
    /// A number, `true` or `false`, the name or number of an enumeration item, or a string.
    pub value: String,
}

impl System {
    /// Convert the bound values to the units of their variables. Values for variables that the FMUs
    /// lack are ignored, as the standard requires, and noted.
    pub(super) fn fit_values(&mut self) -> Result<()> {
        let (structure, fmus) = (&mut self.structure, &self.fmus);
        for (component, fmu) in structure.components.iter_mut().zip(fmus) {
            let values = std::mem::take(&mut component.parameters);
            let mut arrays = None;
            let split = |value| split_array(fmu, &mut arrays, value);
            for parameter in values.into_iter().flat_map(split) {
                if fmu.description.index(&parameter.name).is_none() {
                    let (name, origin) = (&parameter.name, &parameter.origin);
                    let text = format!("`{}.{name}` ({origin})", component.name);
                    structure.unmatched.push(text);
                    continue;
                }
                if let Some(remark) = left_out(&component.name, fmu, &parameter) {
                    structure.remarks.push(remark);
                    continue;
                }
                let parameter = convert(&component.name, fmu, parameter)?;
                component.parameters.push(parameter);
            }
        }
        Ok(())
    }

    /// Apply a parameter set (`.ssv`) after the values of the structure: a file of the packed
    /// system, else one on disk. Its names are those of [`System::port`].
    pub fn apply_set(&mut self, file: &Path) -> Result<()> {
        self.apply_set_from(&mut Package::open(&self.path)?, file)
    }

    /// As [`System::apply_set`], with the packed system open already.
    pub fn apply_set_from(&mut self, package: &mut Package, file: &Path) -> Result<()> {
        for parameter in self.parameter_set(package, file)? {
            let port = self.port(&parameter.name);
            let port = port.with_context(|| parameter.origin.clone())?;
            let name = self.variable(port).name.clone();
            let parameter = Parameter { name, ..parameter };
            let component = &mut self.structure.components[port.component];
            let fmu = &self.fmus[port.component];
            if let Some(remark) = left_out(&component.name, fmu, &parameter) {
                self.structure.remarks.push(remark);
                continue;
            }
            let parameter = convert(&component.name, fmu, parameter)?;
            component.parameters.push(parameter);
        }
        Ok(())
    }

    /// The values of a parameter set.
    pub(super) fn parameter_set(
        &self,
        package: &mut Package,
        file: &Path,
    ) -> Result<Vec<Parameter>> {
        let name = file.display().to_string();
        let text = if package.holds(&name) {
            package.text(&name)?
        } else {
            let hint = match package.names().next() {
                Some(_) => {
                    let system = self.path.display();
                    format!("parameter set `{name}` is not in `{system}`, and as a file")
                }
                None => format!("parameter set `{name}`"),
            };
            read_text(file).context(hint)?
        };
        parse_set(&text, &name)
    }

    /// A start value for a variable named as in [`System::port`].
    pub fn setting(&self, name: &str, value: impl ToString) -> Result<Setting> {
        let port = self.port(name)?;
        self.check_settable(port)?;
        Ok(Setting {
            port,
            value: value.to_string(),
        })
    }

    fn check_settable(&self, port: Port) -> Result<()> {
        let Some(why) = unsettable(self.variable(port)) else {
            return Ok(());
        };
        let all = self.fmus[port.component].description.variables.iter();
        let mut own = all.filter(|v| unsettable(v).is_none());
        let mut names: Vec<&str> = own.by_ref().take(8).map(|v| v.name.as_str()).collect();
        names.extend(own.next().map(|_| "…"));
        let (name, owner) = (self.name(port), self.component_of(port));
        let none = if names.is_empty() { "nothing" } else { "" };
        bail!(
            "`{name}` {why}; of `{owner}` can be set: {none}{}",
            names.join(", ")
        )
    }

    /// Parse `name=value` with a name as in [`System::ports`]; [`System::settings`] of both.
    pub fn parse_settings(&self, text: &str) -> Result<Vec<Setting>> {
        let parts = self.split_name(text);
        let (name, value) =
            parts.with_context(|| format!("`{text}` is not component.variable=value"))?;
        self.settings(name, value)
    }

    /// Start values of the variables that a name means: of an array one value for all elements, or
    /// one for each, separated by blanks. Of an input of the system they are those of all inputs
    /// that it feeds.
    pub fn settings(&self, name: &str, value: &str) -> Result<Vec<Setting>> {
        let mut inputs = self.structure.inputs.iter();
        let Some(input) = inputs.find(|input| input.name == name) else {
            let ports = self.ports(name)?;
            let each: Vec<&str> = value.split_whitespace().collect();
            let is_one_each = ports.len() > 1 && each.len() == ports.len();
            ensure!(
                is_one_each || ports.len() == 1 || each.len() <= 1,
                "`{name}` has {} elements; it needs one value for all, or one for each, but {} are given",
                ports.len(),
                each.len()
            );
            let values = match is_one_each {
                true => each,
                false => vec![value; ports.len()],
            };
            (ports.iter()).try_for_each(|port| self.check_settable(*port))?;
            let values = values.into_iter().map(str::to_string);
            let pairs = ports.into_iter().zip(values);
            return Ok(pairs.map(|(port, value)| Setting { port, value }).collect());
        };
        let mut settings = Vec::new();
        for ((component, variable), way) in &input.ends {
            let port = self.port(&format!("{component}.{variable}"))?;
            let fmu = &self.fmus[port.component];
            let data_type = DataType::from_name(self.variable(port).kind.name());
            let parameter = Parameter {
                name: variable.clone(),
                value: value.trim().to_string(),
                data_type: data_type.unwrap_or(DataType::Integer),
                unit: input.unit.clone(),
                way: way.clone(),
                origin: format!("input `{}` of the system", input.name),
            };
            let value = convert(component, fmu, parameter)?.value;
            settings.push(Setting { port, value });
        }
        Ok(settings)
    }

    /// Check that the units of connectors are those of the FMUs, where both are declared.
    pub(super) fn check_units(&self) -> Result<()> {
        for (c, fmu) in self.structure.components.iter().zip(&self.fmus) {
            for connector in &c.connectors {
                let variable = fmu.description.variable(&connector.name).ok();
                let unit = variable.and_then(|v| unit_of(&fmu.description, v));
                if let (Some(declared), Some(unit)) = (&connector.unit, unit)
                    && conversion(declared, &unit) != Some(Linear::NONE)
                {
                    bail!(
                        "connector `{}.{}` is declared in `{}`, but its FMU has it in `{}`",
                        c.name,
                        connector.name,
                        declared.name,
                        unit.name
                    );
                }
            }
        }
        Ok(())
    }
}

/// Why no start value can be given to a variable; None if one can. What a description leaves to the
/// standard's defaults is calculated, unless it has a start value.
pub fn unsettable(v: &Variable) -> Option<&'static str> {
    use Causality::{CalculatedParameter, Independent, Local, Output};
    let is_calculated = v.initial == Some(Initial::Calculated);
    let is_left_open = v.initial.is_none() && v.start.is_empty();
    match (v.causality, v.variability) {
        (Independent, _) => Some("is the independent variable, which is not set"),
        (_, Variability::Constant) => Some("is a constant"),
        (CalculatedParameter, _) if v.initial != Some(Initial::Approx) => {
            Some("is calculated from parameters")
        }
        (Local | Output, _) if is_calculated || is_left_open => Some("is calculated by its FMU"),
        _ => None,
    }
}

/// Why the value of a parameter set is left out, as a remark, if the variable cannot be set.
fn left_out(component: &str, fmu: &Fmu, parameter: &Parameter) -> Option<String> {
    let (name, value, origin) = (&parameter.name, &parameter.value, &parameter.origin);
    let why = unsettable(fmu.description.variable(name).ok()?)?;
    Some(format!(
        "`{component}.{name}` {why}: its value {value} is left out ({origin})"
    ))
}

/// Split the values of an array into one for each element; any other value stays as it is. `arrays`
/// is made once it is needed.
fn split_array<'a>(
    fmu: &'a Fmu,
    arrays: &mut Option<HashMap<&'a str, Vec<&'a str>>>,
    parameter: Parameter,
) -> Vec<Parameter> {
    if fmu.description.index(&parameter.name).is_some() {
        return vec![parameter];
    }
    let arrays = arrays.get_or_insert_with(|| arrays::elements(fmu));
    let names = arrays.get(&*parameter.name).map_or(&[][..], Vec::as_slice);
    let values = parameter.value.split_whitespace();
    if names.is_empty() || names.len() != values.clone().count() {
        return vec![parameter];
    }
    let pairs = names.iter().zip(values);
    let each = pairs.map(|(name, value)| Parameter {
        name: (*name).to_string(),
        value: value.to_string(),
        ..parameter.clone()
    });
    each.collect()
}

/// Check that a value has the type of its variable, and convert it to the variable's unit. An
/// Integer may be given for a Real and for an enumeration.
pub(super) fn convert(component: &str, fmu: &Fmu, parameter: Parameter) -> Result<Parameter> {
    let Parameter {
        name,
        value,
        data_type,
        unit,
        way,
        origin,
    } = &parameter;
    let variable = fmu.description.variable(name);
    let variable = variable.with_context(|| format!("{origin}: component `{component}`"))?;
    let expected = variable.kind.name();
    let fits = data_type.name() == expected
        || *data_type == DataType::Integer && ["Real", "Enumeration"].contains(&expected);
    if !fits {
        bail!(
            "{origin}: `{component}.{name}` = {value}: given as {}, but its FMU has it as {expected}",
            data_type.name()
        );
    }
    let mut way = way.clone();
    let mut last = way.pop().unwrap_or_default();
    last.unit = unit_of(&fmu.description, variable);
    way.push(last);
    let ends = [None, Some(variable)];
    let transformation = compose(&way, unit.clone(), ends, &mut None).map_err(|_| {
        anyhow!(
            "{origin}: `{component}.{name}` = {value} in `{}`: it must be in the unit of the variable, `{}`, or in one that is defined with \
             the same base units",
            unit.as_ref().map_or("1", |u| &u.name),
            variable.unit.as_deref().unwrap_or("1")
        )
    })?;
    if transformation == Transformation::NONE {
        return Ok(parameter);
    }
    if !transformation.has_linear()
        && let Ok(number) = value.trim().parse()
    {
        return Ok(Parameter {
            value: transformation.apply_whole(number).to_string(),
            way: Vec::new(),
            ..parameter
        });
    }
    let number: f64 = match (value.trim(), value.trim().parse()) {
        ("true", _) => 1.0,
        ("false", _) => 0.0,
        (_, Ok(number)) => number,
        _ => bail!("{origin}: `{component}.{name}` = {value}: it is not a number"),
    };
    let number = transformation.apply(number);
    let value = match data_type {
        DataType::Boolean => (number != 0.0).to_string(),
        _ => number.to_string(),
    };
    Ok(Parameter {
        value,
        way: Vec::new(),
        ..parameter
    })
}
