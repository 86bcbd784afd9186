//! Model descriptions: what is the same in every version of FMI, and how a version says what is
//! not.

mod element;
mod hash;
mod parts;
pub(crate) mod table_check;

pub(crate) use element::Element;
pub(crate) use hash::hash;
pub(crate) use parts::{flag, listed, type_attributes, variable};

use crate::Model;
use crate::core::layout::Layout;
use crate::core::sizes::{self, StartValues};
use parts::{categories, experiment, root, types, units};

/// How a version of FMI writes a model description.
pub(crate) struct Dialect<M: Model> {
    /// Its name, filled up with zeros.
    pub(crate) name: [u8; 4],
    /// Its name in the root.
    pub(crate) version: &'static str,
    /// What it calls the hash.
    pub(crate) hash: &'static str,
    /// Attributes of the element `ModelExchange`, where the model has that.
    pub(crate) model_exchange: Vec<(&'static str, &'static str)>,
    /// Where the root tells the number of event indicators.
    pub(crate) indicators: Option<&'static str>,
    /// Attributes of the element `CoSimulation`.
    pub(crate) co_simulation: Vec<(&'static str, &'static str)>,
    /// Elements of an enumeration's type.
    pub(crate) enumeration: (&'static str, Option<&'static str>),
    /// The element `ModelVariables`.
    pub(crate) variables: fn(&Layout<M>, &StartValues<M>) -> Element,
    /// The element `ModelStructure`.
    pub(crate) structure: fn(&Layout<M>) -> Result<Element, String>,
}

impl<M: Model> Dialect<M> {
    /// The text of `modelDescription.xml`, or what `check` finds wrong with the table.
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
        let indicators = self.indicators.zip(M::MODEL_EXCHANGE);
        root(&M::INFO, self.version, (self.hash, format!("{{{hash}}}")))
            .with(indicators.map(|(name, _)| (name, layout.indicators.to_string())))
            .holding(exchange.map(|exchange| Element::new("ModelExchange").with(exchange)))
            .holding([Element::new("CoSimulation").with(slave)])
            .holding(units(&layout))
            .holding(types(&layout, self.enumeration))
            .holding([categories::<M>(), experiment::<M>()])
            .holding([
                (self.variables)(&layout, &start),
                (self.structure)(&layout)?,
            ])
            .file()
    }
}
