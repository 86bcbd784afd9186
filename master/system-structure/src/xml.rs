//! A file as a tree of elements that know their line.

use std::sync::Arc;

use quick_xml::Reader;
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};

use crate::error::StructureError;

/// An element; names are without their namespace prefix.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Node {
    /// Name.
    pub name: String,
    /// Line, counted from 1.
    pub line: usize,
    /// Elements in it.
    pub children: Vec<Node>,
    attributes: Vec<(String, String)>,
    file: Arc<str>,
}

impl Node {
    /// Read the text of `file`, whose outermost element must be `root`; the errors never repeat
    /// more than names of it.
    pub(crate) fn parse(text: &str, file: &str, root: &str) -> Result<Self, StructureError> {
        let file: Arc<str> = file.into();
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let fail = |line: usize, text: String| StructureError {
            file: file.to_string(),
            line,
            text,
        };
        if !text.trim_start().starts_with('<') {
            return Err(fail(1, "it is no XML".into()));
        }
        let mut reader = Reader::from_str(text);
        let mut open: Vec<Node> = Vec::new();
        let (mut line, mut counted) = (1, 0);
        loop {
            let event = reader.read_event();
            let at = usize::try_from(reader.buffer_position()).unwrap_or_default();
            // Only what is new is counted: thousands of elements are read in one pass.
            let new = text.as_bytes().get(counted..at).unwrap_or_default();
            line += new.iter().filter(|byte| **byte == b'\n').count();
            counted += new.len();
            let mut closed = None;
            match event.map_err(|e| fail(line, format!("it is no XML: {e}")))? {
                Event::Start(element) => {
                    let node = node(&element, &file, line);
                    open.push(node.map_err(|reason| fail(line, reason))?);
                }
                Event::Empty(element) => {
                    let node = node(&element, &file, line);
                    closed = Some(node.map_err(|reason| fail(line, reason))?);
                }
                Event::End(_) => closed = open.pop(),
                Event::Eof => return Err(fail(line, format!("it has no element {root}"))),
                _ => {}
            }
            match (closed, open.last_mut()) {
                (Some(node), Some(parent)) => parent.children.push(node),
                (Some(node), None) if node.name == root => return Ok(node),
                (Some(node), None) => {
                    return Err(node.error(format!("its outermost element is not {root}")));
                }
                (None, _) => {}
            }
        }
    }

    /// Value of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(key, _)| key == name);
        found.map(|(_, value)| value.as_str())
    }

    /// Value of an attribute that must be there.
    ///
    /// # Errors
    /// It is not.
    pub fn required(&self, name: &str) -> Result<&str, StructureError> {
        let found = self.attribute(name);
        found.ok_or_else(|| self.error(format!("{} has no attribute {name}", self.name)))
    }

    /// Value of an attribute as a finite number.
    ///
    /// # Errors
    /// It is something else.
    pub fn number(&self, name: &str) -> Result<Option<f64>, StructureError> {
        let Some(text) = self.attribute(name) else {
            return Ok(None);
        };
        let number = text.trim().parse().ok().filter(|x: &f64| x.is_finite());
        let unfit = || {
            self.error(format!(
                "{} has {name} = `{text}`; it must be a finite number",
                self.name
            ))
        };
        number.map(Some).ok_or_else(unfit)
    }

    /// Value of an attribute as a truth value, false where it is not there.
    ///
    /// # Errors
    /// It is something else.
    pub fn flag(&self, name: &str) -> Result<bool, StructureError> {
        match self.attribute(name).map(str::trim) {
            None | Some("false" | "0") => Ok(false),
            Some("true" | "1") => Ok(true),
            Some(text) => Err(self.error(format!(
                "{} has {name} = `{text}`; it must be true or false",
                self.name
            ))),
        }
    }

    /// The first element in it of this name.
    pub fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|c| c.name == name)
    }

    /// The elements of the name `each` that stand in its element `list`.
    pub fn listed<'a>(&'a self, list: &str, each: &'a str) -> impl Iterator<Item = &'a Self> + 'a {
        let all = self.child(list).into_iter().flat_map(|l| &l.children);
        all.filter(move |c| c.name == each)
    }

    /// An error at this element.
    pub fn error(&self, text: String) -> StructureError {
        StructureError {
            file: self.file.to_string(),
            line: self.line,
            text,
        }
    }
}

fn node(element: &BytesStart, file: &Arc<str>, line: usize) -> Result<Node, String> {
    let mut attributes = Vec::new();
    for attribute in element.attributes() {
        let attribute = attribute.map_err(|e| format!("it is no XML: {e}"))?;
        let value = attribute.normalized_value(XmlVersion::Implicit1_0);
        let value = value.map_err(|e| format!("it is no XML: {e}"))?;
        let name = attribute.key.local_name();
        attributes.push((name.as_ref().to_string(), value.into_owned()));
    }
    Ok(Node {
        name: element.local_name().as_ref().to_string(),
        line,
        children: Vec::new(),
        attributes,
        file: file.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_know_their_line_and_forget_their_prefix() {
        let text = "\u{feff}<?xml version='1.0'?>\r\n<!-- a -->\r\n<x:a xmlns:x='u' x:k='1 &lt; 2'>\r\n<b/><!-- c -->\r\n<y:b n='2'/></x:a>";
        let a = Node::parse(text, "f", "a").unwrap();
        assert_eq!((a.attribute("k"), a.line), (Some("1 < 2"), 3));
        let lines: Vec<_> = a
            .children
            .iter()
            .map(|b| (b.name.as_str(), b.line))
            .collect();
        assert_eq!(lines, [("b", 4), ("b", 5)]);
        assert_eq!(a.children[1].number("n").unwrap(), Some(2.0));
    }

    #[test]
    fn what_is_no_such_file_is_refused_with_its_line() {
        for (text, expected) in [
            ("time,x\n0,1\n", "`f`, line 1: it is no XML"),
            ("<a>\n<b></a>", "line 2: it is no XML"),
            ("<a>\n", "line 2: it has no element a"),
            ("\n<b/>", "line 2: its outermost element is not a"),
            ("<a k='1' k='2'/>", "it is no XML"),
        ] {
            let error = Node::parse(text, "f", "a").unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        let a = Node::parse("<a k='soft'/>", "f", "a").unwrap();
        let errors = [
            a.number("k").unwrap_err(),
            a.flag("k").unwrap_err(),
            a.required("n").unwrap_err(),
        ];
        let texts = [
            "a has k = `soft`; it must be a finite number",
            "true or false",
            "a has no attribute n",
        ];
        for (error, text) in errors.iter().zip(texts) {
            assert!(error.to_string().contains(text), "{error}");
        }
    }
}
