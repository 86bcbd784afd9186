//! Renames a system's variables to those of a component's FMU, for `System` (`--map`, and `maps` in
//! Python): a parameter mapping (`.ssm`) gives the FMU's name for each name of the structure.

use std::fmt::Debug;

use anyhow::{Context, Result, bail};
use fmi_description::Description;
use system_structure::{ParameterMapping, Transformation};

use crate::structure::{Hop, Structure};

/// Rename the connections, connectors and values, and inputs and outputs of the system, of the
/// component with the index `component` to the names of its FMU. Connections to variables that the
/// FMU lacks, and power bonds whose mean effort it lacks, are dropped with a remark.
pub(crate) fn rename(
    structure: &mut Structure,
    component: usize,
    mapping: &ParameterMapping,
    description: &Description,
) -> Result<()> {
    let name = structure.components[component].name.clone();
    let entry = |variable: &str| mapping.entries.iter().find(|e| e.source == variable);
    let renamed = |variable: &str| entry(variable).map_or(variable, |e| &e.target).to_string();
    let mut remarks = Vec::new();
    for connection in &mut structure.connections {
        if connection.end.0 == name
            && let Some(entry) = entry(&connection.end.1)
        {
            connection.end.1.clone_from(&entry.target);
            connection.way.push(entry.into());
        }
        if connection.start.0 != name {
            continue;
        }
        if let Some(entry) = entry(&connection.start.1) {
            connection.start.1.clone_from(&entry.target);
            let back = entry.transformation.as_ref().map(inverse).transpose();
            let back = back.with_context(|| format!("`{}` of `{name}`", entry.source))?;
            // The other way round: the transformation first, which acts in the unit of the FMU.
            let first = Hop {
                transformation: back,
                ..Hop::default()
            };
            let second = Hop {
                transformation: None,
                unit: connection.unit.take(),
                ..entry.into()
            };
            connection.way.splice(0..0, [first, second]);
        }
        if let Some(bond) = &mut connection.bond {
            bond.step_mean = renamed(&bond.step_mean);
            bond.flow = renamed(&bond.flow);
            if description.index(&bond.step_mean).is_none() {
                remarks.push(format!(
                    "the power bond of {name}.{} is left out: its FMU has no mean effort `{}`",
                    connection.start.1, bond.step_mean
                ));
                connection.bond = None;
            }
        }
    }
    structure.connections.retain(|connection| {
        let ends = [&connection.start, &connection.end];
        let mut own = ends.into_iter().filter(|end| end.0 == name);
        let lacking = own.find(|end| description.index(&end.1).is_none());
        if let Some((_, variable)) = lacking {
            remarks.push(format!(
                "not connected: {connection}, because the FMU of `{name}` has no variable `{variable}` and the mapping names none for it"
            ));
        }
        lacking.is_none()
    });
    let inputs = structure.inputs.iter_mut();
    for ((owner, variable), way) in inputs.flat_map(|input| &mut input.ends) {
        if *owner == name
            && let Some(entry) = entry(variable)
        {
            variable.clone_from(&entry.target);
            way.push(entry.into());
        }
    }
    for output in &mut structure.outputs {
        if output.start.0 == name {
            output.start.1 = renamed(&output.start.1);
        }
    }
    for alarm in &mut structure.alarms {
        let own = alarm.name.strip_prefix(&format!("{name}."));
        if let Some(entry) = own.and_then(entry) {
            alarm.name = format!("{name}.{}", entry.target);
        }
    }
    let component = &mut structure.components[component];
    for connector in &mut component.connectors {
        if let Some(entry) = entry(&connector.name) {
            connector.name.clone_from(&entry.target);
            connector.unit = None;
        }
    }
    for parameter in &mut component.parameters {
        if let Some(entry) = entry(&parameter.name) {
            parameter.name.clone_from(&entry.target);
            parameter.way.push(entry.into());
        }
    }
    structure.remarks.extend(remarks);
    Ok(())
}

/// The transformation from the FMU's values to those of the structure.
///
/// # Errors
/// Several values become one.
fn inverse(transformation: &Transformation) -> Result<Transformation> {
    fn swapped<T: Clone + Debug + PartialEq>(entries: &[(T, T)]) -> Result<Vec<(T, T)>> {
        for (k, (source, target)) in entries.iter().enumerate() {
            if let Some((other, _)) = entries[..k].iter().find(|(_, t)| t == target) {
                bail!(
                    "its mapping cannot be applied to an output, which takes it backwards: {other:?} and {source:?} both become {target:?}"
                );
            }
        }
        let all = entries.iter().cloned();
        Ok(all.map(|(source, target)| (target, source)).collect())
    }
    Ok(match transformation {
        Transformation::Linear { factor: 0.0, .. } => {
            bail!("its factor 0 cannot be applied to an output, which takes it backwards")
        }
        Transformation::Linear { factor, offset } => Transformation::Linear {
            factor: 1.0 / factor,
            offset: -offset / factor,
        },
        Transformation::Booleans(entries) => Transformation::Booleans(swapped(entries)?),
        Transformation::Integers(entries) => Transformation::Integers(swapped(entries)?),
        Transformation::Items(entries) => Transformation::Items(swapped(entries)?),
    })
}

#[cfg(test)]
mod tests {
    use fmi_description::Unit;
    use system_structure::MappingEntry;

    use super::*;
    use crate::structure::{Component, Connection, OuterInput, OuterOutput};
    use crate::wiring::transformation::compose;

    fn length(name: &str, factor: f64) -> Unit {
        Unit {
            name: name.into(),
            exponents: Some([0, 1, 0, 0, 0, 0, 0, 0]),
            factor,
            offset: 0.0,
        }
    }

    fn structure() -> Structure {
        let end = |component: &str, variable: &str| (component.to_string(), variable.to_string());
        let component = |name: &str| Component {
            name: name.into(),
            source: String::new(),
            connectors: Vec::new(),
            parameters: Vec::new(),
        };
        Structure {
            components: ["a", "b"].map(component).to_vec(),
            connections: vec![Connection {
                start: end("a", "y"),
                end: end("b", "u"),
                unit: Some(length("mm", 1e-3)),
                way: vec![Hop::default()],
                ..Connection::default()
            }],
            inputs: vec![OuterInput {
                name: "push".into(),
                unit: Some(length("mm", 1e-3)),
                ends: vec![(end("a", "x"), vec![Hop::default()])],
            }],
            outputs: vec![OuterOutput {
                name: "shown".into(),
                start: end("a", "y"),
            }],
            ..Structure::default()
        }
    }

    fn renamed(transformation: Transformation) -> Result<Structure> {
        let description = Description::parse(
            r#"<fmiModelDescription fmiVersion="2.0" modelName="M" guid="g"><CoSimulation modelIdentifier="M"/><ModelVariables>
            <ScalarVariable name="X" valueReference="0" causality="input"><Real/></ScalarVariable>
            <ScalarVariable name="Y" valueReference="1" causality="output"><Real/></ScalarVariable></ModelVariables><ModelStructure/>
            </fmiModelDescription>"#,
        );
        let entry = |(source, target): (&str, &str)| MappingEntry {
            source: source.into(),
            target: target.into(),
            keeps_units: false,
            transformation: Some(transformation.clone()),
        };
        let entries = [("x", "X"), ("y", "Y")].map(entry).to_vec();
        let mut structure = structure();
        rename(
            &mut structure,
            0,
            &ParameterMapping { entries },
            &description.unwrap(),
        )?;
        Ok(structure)
    }

    /// 3000 mm of the structure are 3 m, twice that and 0.5 are 6.5 m of the FMU; an output takes
    /// the same way back.
    #[test]
    fn an_output_takes_the_way_of_an_input_back() {
        let (factor, offset) = (2.0, 0.5);
        let structure = renamed(Transformation::Linear { factor, offset }).unwrap();
        let (metre, millimetre) = (length("m", 1.0), length("mm", 1e-3));
        let ((end, way), unit) = (&structure.inputs[0].ends[0], Some(millimetre));
        assert_eq!(end.1, "X");
        let mut way = way.clone();
        way.last_mut().unwrap().unit = Some(metre.clone());
        let there = compose(&way, unit, [None; 2], &mut None).unwrap();
        assert_eq!(there.apply(3000.0), 6.5);
        let back = &structure.connections[0];
        assert_eq!(back.start.1, "Y");
        let back = compose(&back.way, Some(metre), [None; 2], &mut None).unwrap();
        assert_eq!(back.apply(6.5), 3000.0);
        assert_eq!(structure.outputs[0].start.1, "Y");
    }

    #[test]
    fn what_has_no_way_back_is_refused() {
        let (factor, offset) = (0.0, 1.0);
        let zero = renamed(Transformation::Linear { factor, offset }).unwrap_err();
        assert!(format!("{zero:#}").contains("`y` of `a`: its factor 0"));
        let twice = renamed(Transformation::Integers(vec![(1, 5), (2, 5)])).unwrap_err();
        assert!(format!("{twice:#}").contains("1 and 2 both become 5"));
    }
}
