//! Power bonds as system structures declare them, for `flatten`: an annotation on the connection
//! that carries the effort names the conjugate flow. The master reports the residual of each bond.

use anyhow::{Result, bail};
use system_structure::Annotation;

/// Type of the annotation that makes a connection the effort of a power bond.
const POWER_BOND: &str = "io.github.hdrm-fmu.power-bond";

/// Power bond of a connection that carries its effort.
#[derive(Clone, Debug, PartialEq)]
pub struct PowerBond {
    /// Output of the start element: mean of the connected effort over the last step.
    pub step_mean: String,
    /// Input of the start element that receives the conjugate flow.
    pub flow: String,
    /// Direction of the power where effort times flow is positive.
    pub power: Power,
}

/// Direction of the power `effort · flow` of a bond.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Power {
    /// The start element delivers it, as a pushing actuator does.
    #[default]
    Delivered,
    /// The start element takes it, as a drive does by the current that it draws.
    Drawn,
}

impl PowerBond {
    /// The bond among the annotations of a connection.
    pub(super) fn read(annotations: &[Annotation]) -> Result<Option<Self>> {
        let mut bond = None;
        for annotation in annotations {
            let Some(content) = annotation.content.child("PowerBond") else {
                continue;
            };
            if annotation.kind != POWER_BOND {
                bail!(content.error(format!(
                    "a PowerBond stands in an annotation of type `{}`; the type must be `{POWER_BOND}`",
                    annotation.kind
                )));
            }
            let power = match content.get("power") {
                None | Some("delivered") => Power::Delivered,
                Some("drawn") => Power::Drawn,
                Some(text) => bail!(content.error(format!(
                    "power = `{text}` of a PowerBond must be `delivered` or `drawn`"
                ))),
            };
            bond = Some(Self {
                step_mean: content.required("stepMean")?,
                flow: content.required("flow")?,
                power,
            });
        }
        Ok(bond)
    }
}
