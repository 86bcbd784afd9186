//! A tree of XML elements with numbers as attributes, for files of other tools.

use std::fmt::Display;
use std::io;

use anyhow::Result;
use quick_xml::Writer;
use quick_xml::events::{BytesText, Event};

/// An XML element with attributes and child elements.
pub(crate) struct Element {
    name: &'static str,
    attributes: Vec<(&'static str, String)>,
    content: Vec<Element>,
}

impl Element {
    pub fn new(name: &'static str) -> Self {
        Self {
            name,
            attributes: Vec::new(),
            content: Vec::new(),
        }
    }

    /// Appends an attribute; a number is written with as many digits as tell it apart.
    pub fn with(mut self, name: &'static str, value: impl Display) -> Self {
        self.attributes.push((name, value.to_string()));
        self
    }

    /// Appends an attribute of several numbers.
    pub fn numbers(self, name: &'static str, values: &[f64]) -> Self {
        let words: Vec<_> = values.iter().map(f64::to_string).collect();
        self.with(name, words.join(" "))
    }

    /// Appends child elements.
    pub fn holding(mut self, content: impl IntoIterator<Item = Self>) -> Self {
        self.content.extend(content);
        self
    }

    /// The text of an XML file with this root after a comment.
    pub fn file(&self, comment: &str) -> Result<String> {
        let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
        xml.write_event(Event::Comment(BytesText::from_escaped(comment)))?;
        self.write(&mut xml)?;
        Ok(String::from_utf8(xml.into_inner())? + "\n")
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
