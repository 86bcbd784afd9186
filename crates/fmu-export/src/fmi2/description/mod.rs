//! `modelDescription.xml` of FMI 2.0, made from the table of variables.

mod structure;
mod variables;

use super::component::Fmi2;
use crate::Model;
use crate::border::body::Version;
use crate::border::description::{
    Xml, categories, described, enumerations, experiment, flag, items, root_attributes, table,
    units,
};
use crate::core::layout::Layout;
use std::io;

/// The text of `modelDescription.xml` of FMI 2.0, or what is wrong with the table of variables.
///
/// The GUID is a hash of the table and of what [`Info`](crate::Info) says of the model: it is the same on every platform and says when the
/// interface changed.
pub fn model_description<M: Model>() -> Result<String, String> {
    described(Fmi2::NAME, table::check::<M>, write::<M>)
}

fn write<M: Model>(xml: &mut Xml, layout: &Layout<M>, hash: &str) -> io::Result<()> {
    xml.create_element("fmiModelDescription")
        .with_attributes(root_attributes(&M::INFO, "2.0", ("guid", hash)))
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
    xml.create_element("CoSimulation")
        .with_attributes([
            ("modelIdentifier", M::INFO.model),
            ("needsExecutionTool", "false"),
            ("canHandleVariableCommunicationStepSize", "true"),
            ("canInterpolateInputs", flag(M::INFO.input_derivatives)),
            (
                "maxOutputDerivativeOrder",
                if M::INFO.output_derivatives { "1" } else { "0" },
            ),
            ("canRunAsynchronuously", "false"),
            ("canBeInstantiatedOnlyOncePerProcess", "false"),
            ("canNotUseMemoryManagementFunctions", "true"),
            ("canGetAndSetFMUstate", "true"),
            ("canSerializeFMUstate", "true"),
            (
                "providesDirectionalDerivative",
                flag(M::INFO.directional_derivatives),
            ),
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
                xml.create_element("SimpleType")
                    .with_attributes(attributes)
                    .write_inner_content(|xml| {
                        xml.create_element("Enumeration")
                            .write_inner_content(|xml| items(xml, &enumeration))?;
                        Ok(())
                    })?;
            }
            Ok(())
        })?;
    Ok(())
}
