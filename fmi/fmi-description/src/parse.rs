//! Reads a [`Description`] from a `modelDescription.xml` (bytes or text), for all who open FMUs.

use std::collections::{HashMap, HashSet};

use crate::description::{Description, Interface, Version};
use crate::error::DescriptionError;
use crate::remark::Remark;
use crate::variable::Causality;
use crate::xml::Element;
use crate::{encoding, file, fmi2, fmi3};

impl Description {
    /// Reads a `modelDescription.xml` in any of the usual encodings.
    ///
    /// # Errors
    /// It is no valid model description for co-simulation by FMI 2.0 or 3.0.
    pub fn read(bytes: &[u8]) -> Result<Self, DescriptionError> {
        Self::parse(&encoding::text(bytes)?)
    }

    /// Reads the text of a `modelDescription.xml`, with the errors of [`Self::read`].
    pub fn parse(text: &str) -> Result<Self, DescriptionError> {
        Self::parse_as(text, &[Interface::CoSimulation], &HashMap::new())
    }

    /// As [`Self::parse`], of an FMU with any interface, to be described rather than run.
    ///
    /// # Errors
    /// It is no valid model description by FMI 2.0 or 3.0.
    pub fn parse_any(text: &str) -> Result<Self, DescriptionError> {
        use Interface::{CoSimulation, ModelExchange, ScheduledExecution};
        let all = [CoSimulation, ModelExchange, ScheduledExecution];
        Self::parse_as(text, &all, &HashMap::new())
    }

    /// As [`Self::parse`], for the first of the interfaces `wanted` that the FMU has, with these
    /// values of structural parameters of FMI 3.0, by value reference: their start values, on which
    /// the sizes of arrays depend. Arrays that get another size have no start values, as the
    /// standard says.
    ///
    /// # Errors
    /// Arrays become too large, besides the errors of [`Self::parse`].
    pub fn parse_as(
        text: &str,
        wanted: &[Interface],
        sizes: &HashMap<u32, String>,
    ) -> Result<Self, DescriptionError> {
        let root = Element::parse(text, "modelDescription.xml", "fmiModelDescription")?;
        let version = root.required("fmiVersion")?;
        let model = root.required("modelName")?;
        let fmi = match version.trim() {
            three if three.starts_with("3.") => Version::Fmi3,
            two if two.starts_with("2.0") => Version::Fmi2,
            _ => return Err(DescriptionError::Version { model, version }),
        };
        let mut description = file::read_head(&root, fmi, wanted)?;
        if fmi == Version::Fmi2 && version != "2.0" {
            description.remarks.push(Remark::Version(version));
        }
        match fmi {
            Version::Fmi2 => fmi2::read(&root, &mut description)?,
            Version::Fmi3 => fmi3::read(&root, &mut description, sizes)?,
        }
        add_remarks(&root, &mut description);
        description.make_index();
        Ok(description)
    }
}

/// Adds remarks on the variables and outputs of the whole file.
fn add_remarks(root: &Element, description: &mut Description) {
    let types = root.all_in("TypeDefinitions");
    let types: HashSet<_> = types.filter_map(|declared| declared.get("name")).collect();
    let unknown = |element: &Element| {
        let mut elements = std::iter::once(element).chain(&element.children);
        let declared = elements.find_map(|e| e.get("declaredType"))?;
        let is_unknown = !types.contains(declared);
        is_unknown.then(|| (element.text("name"), declared.to_string()))
    };
    let mut unknown = root.all_in("ModelVariables").filter_map(unknown);
    if let Some((variable, declared)) = unknown.next() {
        description.remarks.push(Remark::UnknownType {
            variable,
            declared,
            count: 1 + unknown.count(),
        });
    }
    // FMI 3.0 lists value references, which aliases share.
    let place = |k: usize| match description.fmi {
        Version::Fmi2 => k,
        Version::Fmi3 => description.variables[k].reference as usize,
    };
    let listed = description.outputs.iter().map(|u| place(u.variable));
    let listed: HashSet<_> = listed.collect();
    let outputs = description.variables.iter().enumerate();
    let outputs = outputs.filter(|(_, v)| v.causality == Causality::Output);
    let mut unlisted = outputs.filter(|(k, _)| !listed.contains(&place(*k)));
    let unlisted = unlisted.next().map(|(_, first)| Remark::UnlistedOutputs {
        variable: first.name.clone(),
        count: 1 + unlisted.count(),
    });
    description.remarks.extend(unlisted);
    let mut names = HashSet::new();
    let mut variables = description.variables.iter();
    let twice = variables.find(|v| !names.insert(&v.name));
    let twice = twice.map(|v| Remark::SameName(v.name.clone()));
    description.remarks.extend(twice);
}
