//! Model descriptions: what is the same in every version of FMI, and how a version says what is
//! not.

mod hash;
mod parts;
pub(crate) mod table;

pub(crate) use hash::hash;
pub(crate) use parts::{Xml, empty, flag, text, type_attributes};

use crate::Model;
use crate::core::layout::Layout;
use parts::{categories, experiment, root_attributes, types, units};
use std::io;

/// How a version of FMI writes a model description.
pub(crate) struct Dialect<M: Model> {
    /// Its name, filled up with zeros.
    pub(crate) name: [u8; 4],
    /// Its name in the root.
    pub(crate) version: &'static str,
    /// What it calls the hash.
    pub(crate) hash: &'static str,
    /// Attributes of the element `CoSimulation`.
    pub(crate) co_simulation: Vec<(&'static str, &'static str)>,
    /// Elements of an enumeration's type.
    pub(crate) enumeration: (&'static str, Option<&'static str>),
    /// Writes the element `ModelVariables`.
    pub(crate) variables: fn(&mut Xml, &Layout<M>) -> io::Result<()>,
    /// Writes the element `ModelStructure`.
    pub(crate) structure: fn(&mut Xml, &Layout<M>) -> io::Result<()>,
}

impl<M: Model> Dialect<M> {
    /// The text of `modelDescription.xml`, or what `check` finds wrong with the table.
    pub(crate) fn describe(
        &self,
        check: impl FnOnce(&Layout<M>) -> Result<(), String>,
    ) -> Result<String, String> {
        let (parameters, input) = M::defaults();
        let layout = Layout::<M>::new(&parameters, &input);
        check(&layout)?;
        let hash = hash(&layout, (&parameters, &input), self.name);
        let text = text(|xml| self.write(xml, &layout, &format!("{{{hash}}}")))?;
        Ok(text + "\n")
    }

    fn write(&self, xml: &mut Xml, layout: &Layout<M>, hash: &str) -> io::Result<()> {
        let attributes = root_attributes(&M::INFO, self.version, (self.hash, hash));
        xml.create_element("fmiModelDescription")
            .with_attributes(attributes)
            .write_inner_content(|xml| {
                xml.create_element("CoSimulation")
                    .with_attributes(self.co_simulation.iter().copied())
                    .write_empty()?;
                units(xml, layout)?;
                types(xml, layout, self.enumeration)?;
                categories::<M>(xml)?;
                experiment::<M>(xml)?;
                (self.variables)(xml, layout)?;
                (self.structure)(xml, layout)
            })?;
        Ok(())
    }
}
