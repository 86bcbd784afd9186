//! Types of Real variables (what they measure, unit, bounds), for tables and model descriptions.

use super::setters::setters;

/// A type of Real variables: rows that have it by [`Variable::of_type`](crate::Variable::of_type)
/// take over its unit and bounds, and the model description defines it.
///
/// ```
/// # use fmu_export::TypeDefinition;
/// const PRESSURE: TypeDefinition = TypeDefinition::new("Pressure", "Absolute pressure").quantity("Pressure").unit("Pa").display_unit("bar").min(0.0);
/// const RISE: TypeDefinition = TypeDefinition::new("Rise", "Difference of temperatures").unit("K").display_unit("degC").relative();
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TypeDefinition {
    pub(crate) name: &'static str,
    pub(crate) description: &'static str,
    pub(crate) quantity: &'static str,
    pub(crate) relative: bool,
    pub(crate) unit: Option<&'static str>,
    pub(crate) display_unit: Option<&'static str>,
    pub(crate) min: f64,
    pub(crate) max: f64,
    pub(crate) nominal: Option<f64>,
}

impl TypeDefinition {
    /// Its name is that of no variable and no other type of the model.
    pub const fn new(name: &'static str, description: &'static str) -> Self {
        Self {
            name,
            description,
            quantity: "",
            relative: false,
            unit: None,
            display_unit: None,
            min: f64::NEG_INFINITY,
            max: f64::INFINITY,
            nominal: None,
        }
    }

    setters! {
        /// Physical quantity, such as `Pressure`.
        quantity(quantity: &'static str) quantity = quantity;

        /// Values are differences, which are shown without the offset of the display unit.
        relative() relative = true;

        /// Unit.
        unit(unit: &'static str) unit = Some(unit);

        /// Unit in which tools show values.
        display_unit(unit: &'static str) display_unit = Some(unit);

        /// Minimum.
        min(min: f64) min = min;

        /// Maximum.
        max(max: f64) max = max;

        /// Typical magnitude (> 0).
        nominal(nominal: f64) nominal = Some(nominal);
    }
}
