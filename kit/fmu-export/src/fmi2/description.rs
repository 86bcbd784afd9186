//! `modelDescription.xml` of FMI 2.0 from the table, for `entry`, `check` and tests of models.

mod structure;
mod variables;

use super::instance::Fmi2;
use crate::Model;
use crate::c_api::description::{Dialect, flag, table_check};
use crate::c_api::files::{self, Packed};
use crate::c_api::fmi_instance::Version;
use crate::core::storage::{Kind, TypeNames};

/// The text of `modelDescription.xml` of FMI 2.0, or the first mistake in the table of variables.
///
/// The GUID is a hash of the table and of the model's [`Info`](crate::Info): the same on every
/// platform, and another one when the interface changes.
pub fn model_description<M: Model>() -> Result<String, String> {
    model_description_with_sizes::<M>("")
}

/// Names the first variable whose type FMI 2.0 does not have.
pub(crate) fn unsupported_type<M: Model>() -> Option<String> {
    const KNOWN: [Kind; 4] = [Kind::Real, Kind::Integer, Kind::Boolean, Kind::String];
    if let Some(clock) = M::CLOCKS.iter().find(|clock| clock.is_triggered()) {
        return Some(format!(
            "clock `{}` is triggered, which is of FMI 3.0; in FMI 2.0 clocks that follow time are time events",
            clock.row.name
        ));
    }
    let row = (M::variables().iter()).find(|row| !KNOWN.contains(&row.storage.kind()))?;
    let (name, kind) = (row.name, row.storage.kind().name(&TypeNames::PLAIN));
    Some(format!(
        "variable `{name}` is {kind}, a type of FMI 3.0; FMI 2.0 has f64, i32, bool, String and enumerations"
    ))
}

/// The files of the FMU other than its binaries.
pub(super) fn files<M: Model>(sizes: &str) -> Result<Vec<Packed>, String> {
    let xml = model_description_with_sizes::<M>(sizes)?;
    Ok(files::files::<M>(xml, "model.png"))
}

/// [`model_description`] with the sizes that were chosen when the FMU was packed.
fn model_description_with_sizes<M: Model>(sizes: &str) -> Result<String, String> {
    if let Some(reason) = unsupported_type::<M>() {
        return Err(reason);
    }
    let info = &M::INFO;
    let derivatives = flag(info.directional_derivatives || M::MODEL_EXCHANGE.is_some());
    let order = if info.output_derivatives { "1" } else { "0" };
    let dialect = Dialect {
        name: Fmi2::NAME,
        version: "2.0",
        hash: "guid",
        indicators: Some("numberOfEventIndicators"),
        model_exchange: vec![
            ("modelIdentifier", info.model),
            ("needsExecutionTool", "false"),
            ("completedIntegratorStepNotNeeded", "false"),
            ("canBeInstantiatedOnlyOncePerProcess", "false"),
            ("canNotUseMemoryManagementFunctions", "true"),
            ("canGetAndSetFMUstate", "true"),
            ("canSerializeFMUstate", "true"),
            ("providesDirectionalDerivative", "true"),
        ],
        scheduled_execution: None,
        co_simulation: vec![
            ("modelIdentifier", info.model),
            ("needsExecutionTool", "false"),
            ("canHandleVariableCommunicationStepSize", "true"),
            ("canInterpolateInputs", flag(info.input_derivatives)),
            ("maxOutputDerivativeOrder", order),
            ("canRunAsynchronuously", "false"),
            ("canBeInstantiatedOnlyOncePerProcess", "false"),
            ("canNotUseMemoryManagementFunctions", "true"),
            ("canGetAndSetFMUstate", "true"),
            ("canSerializeFMUstate", "true"),
            ("providesDirectionalDerivative", derivatives),
        ],
        types: ["Enumeration", "Real"].map(|inner| ("SimpleType", Some(inner))),
        variables: variables::model_variables,
        structure: structure::model_structure,
    };
    dialect.describe(sizes, table_check::check::<M>)
}
