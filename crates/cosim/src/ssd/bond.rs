//! Power bonds: which connection is the effort of one, and where its flow is.

use serde::Deserialize;

/// Type of the annotation that makes a connection half of a power bond.
pub(super) const POWER_BOND: &str = "io.github.hdrm-fmu.power-bond";

/// Annotation `io.github.hdrm-fmu.power-bond` of a connection.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct PowerBond {
    /// Output of the start element: mean of the connected effort over the last step.
    #[serde(rename = "@stepMean")]
    pub step_mean: String,
    /// Input of the start element that receives the conjugate flow.
    #[serde(rename = "@flow")]
    pub flow: String,
    /// Which way power goes where effort times flow is positive.
    #[serde(rename = "@power", default)]
    pub power: Power,
}

/// Direction of the power `effort · flow` of a bond.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq)]
#[serde(try_from = "String")]
pub enum Power {
    /// The start element delivers it, as an actuator that pushes.
    #[default]
    Delivered,
    /// The start element takes it, as a drive by the current that it draws.
    Drawn,
}

impl TryFrom<String> for Power {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        match text.as_str() {
            "delivered" => Ok(Self::Delivered),
            "drawn" => Ok(Self::Drawn),
            _ => Err(format!(
                "power = `{text}` of a PowerBond must be `delivered` or `drawn`"
            )),
        }
    }
}
