//! `modelDescription.xml` of FMI 3.0, made from the table of variables.

mod structure;
pub(crate) mod terminals;
mod variables;

use super::instance::Fmi3;
use crate::Model;
use crate::border::body::Version;
use crate::border::description::{
    Xml, categories, described, enumerations, experiment, flag, items, root_attributes, table,
    units,
};
use crate::core::layout::Layout;
use std::io;

/// The text of `modelDescription.xml` of FMI 3.0, or what is wrong with the table of variables.
///
/// The instantiation token is a hash as the GUID of FMI 2.0 is, another one.
pub fn model_description3<M: Model>() -> Result<String, String> {
    described(Fmi3::NAME, check::<M>, write::<M>)
}

/// The first thing that is wrong with the table or the terminals.
pub(crate) fn check<M: Model>(layout: &Layout<M>) -> Result<(), String> {
    terminals::check(layout)?;
    table::check(layout)
}

fn write<M: Model>(xml: &mut Xml, layout: &Layout<M>, hash: &str) -> io::Result<()> {
    xml.create_element("fmiModelDescription")
        .with_attributes(root_attributes(
            &M::INFO,
            "3.0",
            ("instantiationToken", hash),
        ))
        .write_inner_content(|xml| {
            co_simulation::<M>(xml)?;
            units(xml, layout)?;
            types(xml, layout)?;
            categories::<M>(xml)?;
            experiment::<M>(xml)?;
            variables::write(xml, layout)?;
            structure::write(xml, layout)
        })?;
    Ok(())
}

fn co_simulation<M: Model>(xml: &mut Xml) -> io::Result<()> {
    let info = &M::INFO;
    let derivatives = flag(info.directional_derivatives);
    xml.create_element("CoSimulation")
        .with_attributes([
            ("modelIdentifier", info.model),
            ("needsExecutionTool", "false"),
            ("canBeInstantiatedOnlyOncePerProcess", "false"),
            ("canGetAndSetFMUState", "true"),
            ("canSerializeFMUState", "true"),
            ("providesDirectionalDerivatives", derivatives),
            ("providesAdjointDerivatives", derivatives),
            ("providesPerElementDependencies", "true"),
            ("canHandleVariableCommunicationStepSize", "true"),
            (
                "maxOutputDerivativeOrder",
                if info.output_derivatives { "1" } else { "0" },
            ),
            ("providesIntermediateUpdate", "true"),
            ("mightReturnEarlyFromDoStep", flag(info.early_return)),
            ("canReturnEarlyAfterIntermediateUpdate", "false"),
            ("hasEventMode", "true"),
            ("providesEvaluateDiscreteStates", "false"),
        ])
        .write_empty()?;
    Ok(())
}

fn types<M: Model>(xml: &mut Xml, layout: &Layout<M>) -> io::Result<()> {
    let used = enumerations(layout);
    if used.is_empty() {
        return Ok(());
    }
    xml.create_element("TypeDefinitions")
        .write_inner_content(|xml| {
            for enumeration in used {
                let attributes = [
                    ("name", enumeration.name),
                    ("description", enumeration.description),
                ];
                xml.create_element("EnumerationType")
                    .with_attributes(attributes)
                    .write_inner_content(|xml| items(xml, &enumeration))?;
            }
            Ok(())
        })?;
    Ok(())
}
