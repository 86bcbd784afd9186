//! A tree of XML elements, for `fmi2` and `fmi3`: model descriptions and terminals.

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::io;

/// An XML element with attributes and child elements.
pub(crate) struct Element {
    name: &'static str,
    attributes: Vec<(&'static str, String)>,
    content: Vec<Element>,
}

impl Element {
    pub(crate) fn new(name: &'static str) -> Self {
        Self {
            name,
            attributes: Vec::new(),
            content: Vec::new(),
        }
    }

    /// Appends attributes.
    pub(crate) fn with<T: Into<String>>(
        mut self,
        attributes: impl IntoIterator<Item = (&'static str, T)>,
    ) -> Self {
        let attributes = attributes.into_iter();
        (self.attributes).extend(attributes.map(|(name, value)| (name, value.into())));
        self
    }

    /// Appends child elements.
    pub(crate) fn holding(mut self, content: impl IntoIterator<Item = Self>) -> Self {
        self.content.extend(content);
        self
    }

    /// This element, if it has children.
    pub(crate) fn if_any(self) -> Option<Self> {
        (!self.content.is_empty()).then_some(self)
    }

    /// The text of an XML file with this root.
    pub(crate) fn file(&self) -> Result<String, String> {
        let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
        let declaration = Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None));
        (xml.write_event(declaration))
            .and_then(|()| self.write(&mut xml))
            .map_err(|e| e.to_string())?;
        let text = String::from_utf8(xml.into_inner()).map_err(|e| e.to_string())?;
        Ok(text + "\n")
    }

    fn write(&self, xml: &mut Writer<Vec<u8>>) -> io::Result<()> {
        let attributes = (self.attributes.iter()).map(|(name, value)| (*name, value.as_str()));
        let element = xml.create_element(self.name).with_attributes(attributes);
        let written = match &self.content[..] {
            [] => element.write_empty(),
            content => element.write_inner_content(|xml| {
                content.iter().try_for_each(|element| element.write(xml))
            }),
        };
        written.map(|_| ())
    }
}
