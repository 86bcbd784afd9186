//! `modelDescription.xml` of FMI 3.0 from the table, for `entry`, `check` and tests of models.

#[cfg(feature = "can")]
mod can;
mod structure;
mod terminals;
mod variables;

use super::instance::Fmi3;
use crate::c_api::description::{Dialect, flag, table_check};
use crate::c_api::files::{self, Packed};
use crate::c_api::fmi_instance::Version;
use crate::core::layout::Layout;
use crate::core::sizes::StartValues;
use crate::{Clock, Model};

/// The text of `modelDescription.xml` of FMI 3.0, or the first mistake in the table of variables.
///
/// The instantiation token is a hash like the GUID of FMI 2.0, but not the same.
pub fn model_description3<M: Model>() -> Result<String, String> {
    model_description_with_sizes::<M>("")
}

/// The files of the FMU other than its binaries.
pub(super) fn files<M: Model>(sizes: &str) -> Result<Vec<Packed>, String> {
    let xml = model_description_with_sizes::<M>(sizes)?;
    let mut files = files::files::<M>(xml, "terminalsAndIcons/icon.png");
    if let Some(xml) = terminals::text::<M>()? {
        let path = "terminalsAndIcons/terminalsAndIcons.xml".to_owned();
        files.push((path, xml.into_bytes().into()));
    }
    #[cfg(feature = "can")]
    if let Some(xml) = can::manifest::<M>()? {
        files.push((can::MANIFEST.to_owned(), xml.into_bytes().into()));
    }
    Ok(files)
}

/// [`model_description3`] with the sizes that were chosen when the FMU was packed.
fn model_description_with_sizes<M: Model>(sizes: &str) -> Result<String, String> {
    let info = &M::INFO;
    let derivatives = flag(info.directional_derivatives || M::MODEL_EXCHANGE.is_some());
    let is_aperiodic = |clock: &Clock<M>| matches!(clock.variability(), "countdown" | "triggered");
    let early_return =
        info.early_return || M::EVENTS.is_some() && M::CLOCKS.iter().any(is_aperiodic);
    let order = if info.output_derivatives { "1" } else { "0" };
    let dialect = Dialect {
        name: Fmi3::NAME,
        version: "3.0",
        hash: "instantiationToken",
        indicators: None,
        model_exchange: vec![
            ("modelIdentifier", info.model),
            ("needsExecutionTool", "false"),
            ("canBeInstantiatedOnlyOncePerProcess", "false"),
            ("canGetAndSetFMUState", "true"),
            ("canSerializeFMUState", "true"),
            ("providesDirectionalDerivatives", "true"),
            ("providesAdjointDerivatives", "true"),
            ("providesPerElementDependencies", "true"),
            ("needsCompletedIntegratorStep", "true"),
            ("providesEvaluateDiscreteStates", "false"),
        ],
        scheduled_execution: M::SCHEDULED_EXECUTION.then(|| {
            vec![
                ("modelIdentifier", info.model),
                ("needsExecutionTool", "false"),
                ("canBeInstantiatedOnlyOncePerProcess", "false"),
                ("canGetAndSetFMUState", "true"),
                ("canSerializeFMUState", "true"),
            ]
        }),
        co_simulation: vec![
            ("modelIdentifier", info.model),
            ("needsExecutionTool", "false"),
            ("canBeInstantiatedOnlyOncePerProcess", "false"),
            ("canGetAndSetFMUState", "true"),
            ("canSerializeFMUState", "true"),
            ("providesDirectionalDerivatives", derivatives),
            ("providesAdjointDerivatives", derivatives),
            ("providesPerElementDependencies", "true"),
            ("canHandleVariableCommunicationStepSize", "true"),
            ("maxOutputDerivativeOrder", order),
            ("providesIntermediateUpdate", "true"),
            ("mightReturnEarlyFromDoStep", flag(early_return)),
            ("canReturnEarlyAfterIntermediateUpdate", "false"),
            ("hasEventMode", "true"),
            ("providesEvaluateDiscreteStates", "false"),
        ],
        types: [("EnumerationType", None), ("Float64Type", None)],
        variables: variables::model_variables,
        structure: structure::model_structure,
    };
    dialect.describe(sizes, check::<M>)
}

/// The first mistake in the table or the terminals.
pub(crate) fn check<M: Model>(layout: &Layout<M>, start: &StartValues<M>) -> Result<(), String> {
    terminals::check(layout)?;
    #[cfg(feature = "can")]
    can::check(layout)?;
    table_check::check(layout, start)
}
