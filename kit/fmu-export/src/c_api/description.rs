//! Writes `modelDescription.xml` for `fmi2` and `fmi3`; a [`Dialect`] says what differs.

mod element;
mod hash;
mod parts;
pub(crate) mod table_check;

pub(crate) use element::Element;
pub(crate) use hash::hash;
pub(crate) use parts::{flag, listed, real, type_attributes, variable};

use crate::Model;
use crate::core::layout::Layout;
use crate::core::sizes::{self, StartValues};
use parts::{categories, experiment, root, types, units};

/// What a version of FMI writes differently in a model description.
pub(crate) struct Dialect<M: Model> {
    /// Name of the version, padded with zeros.
    pub(crate) name: [u8; 4],
    /// The value of `fmiVersion`.
    pub(crate) version: &'static str,
    /// Name of the attribute that holds the hash (`guid`, `instantiationToken`).
    pub(crate) hash: &'static str,
    /// Attributes of the element `ModelExchange`, if the model supports it.
    pub(crate) model_exchange: Vec<(&'static str, &'static str)>,
    /// Name of the root's attribute for the number of event indicators.
    pub(crate) indicators: Option<&'static str>,
    /// Attributes of the element `ScheduledExecution`, if the version and the model have it.
    pub(crate) scheduled_execution: Option<Vec<(&'static str, &'static str)>>,
    /// Attributes of the element `CoSimulation`.
    pub(crate) co_simulation: Vec<(&'static str, &'static str)>,
    /// Names of the elements that define types, enumerations and Reals: outer and inner.
    pub(crate) types: [(&'static str, Option<&'static str>); 2],
    /// The element `ModelVariables`.
    pub(crate) variables: fn(&Layout<M>, &StartValues<M>) -> Element,
    /// The element `ModelStructure`.
    pub(crate) structure: fn(&Layout<M>) -> Result<Element, String>,
}

impl<M: Model> Dialect<M> {
    /// The text of `modelDescription.xml`, or the mistake in the table that `check` finds.
    pub(crate) fn describe(
        &self,
        sizes: &str,
        check: impl FnOnce(&Layout<M>, &StartValues<M>) -> Result<(), String>,
    ) -> Result<String, String> {
        let start = sizes::start::<M>(sizes)?;
        let layout = Layout::<M>::new(&start.0, &start.1);
        check(&layout, &start)?;
        let hash = hash(&layout, &start, self.name);
        let slave = self.co_simulation.iter().copied();
        let exchange = M::MODEL_EXCHANGE.map(|_| self.model_exchange.iter().copied());
        let scheduled = self.scheduled_execution.as_ref();
        let scheduled = scheduled.map(|scheduled| scheduled.iter().copied());
        let indicators = self.indicators.zip(M::MODEL_EXCHANGE);
        root(&M::INFO, self.version, (self.hash, format!("{{{hash}}}")))
            .with(indicators.map(|(name, _)| (name, layout.indicators.to_string())))
            .holding(exchange.map(|exchange| Element::new("ModelExchange").with(exchange)))
            .holding([Element::new("CoSimulation").with(slave)])
            .holding(scheduled.map(|scheduled| Element::new("ScheduledExecution").with(scheduled)))
            .holding(units(&layout))
            .holding(types(&layout, self.types))
            .holding([categories::<M>(), experiment::<M>()])
            .holding([
                (self.variables)(&layout, &start),
                (self.structure)(&layout)?,
            ])
            .file()
    }
}
