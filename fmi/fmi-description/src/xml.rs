//! A file as a tree of elements. Attributes are read by name; what is not asked for, such as
//! namespaces, comments and what a vendor adds, does no harm. An error names the line, the element,
//! and the value.

use std::str::FromStr;

use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};

use crate::error::DescriptionError;

/// Elements in each other, at most: what is deeper was not made to be read.
const DEEPEST: usize = 256;

/// An element with its attributes and the elements in it.
#[derive(Debug)]
pub struct Element {
    /// Its name, without the prefix of a namespace.
    pub tag: String,
    /// The elements in it, in the order of the file.
    pub children: Vec<Element>,
    attributes: Vec<(String, String)>,
    line: usize,
}

impl Element {
    /// The outermost element of a text.
    pub fn parse(text: &str) -> Result<Self, DescriptionError> {
        let mut reader = quick_xml::Reader::from_str(text);
        let mut open: Vec<Self> = Vec::new();
        let mut lines = Lines::default();
        loop {
            let begin = usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX);
            let event = reader.read_event();
            let line = lines.at(text, begin);
            let unreadable = |reason: String| DescriptionError::Xml { line, reason };
            let closed = match event.map_err(|e| unreadable(e.to_string()))? {
                Event::Start(_) if open.len() == DEEPEST => {
                    let reason = format!("more than {DEEPEST} elements stand in each other");
                    return Err(unreadable(reason));
                }
                Event::Start(start) => {
                    open.push(Self::open(&start, line).map_err(unreadable)?);
                    continue;
                }
                Event::Empty(start) => Self::open(&start, line).map_err(unreadable)?,
                Event::End(_) => open
                    .pop()
                    .ok_or_else(|| unreadable("an element ends that has not begun".into()))?,
                Event::Eof => {
                    let reason = open.last().map_or_else(
                        || "there is no element".to_string(),
                        |element| format!("the element `{}` does not end", element.tag),
                    );
                    return Err(unreadable(reason));
                }
                _ => continue,
            };
            match open.last_mut() {
                Some(parent) => parent.children.push(closed),
                None => return Ok(closed),
            }
        }
    }

    fn open(start: &BytesStart, line: usize) -> Result<Self, String> {
        let attributes = start.attributes().map(|attribute| {
            let attribute = attribute.map_err(|e| e.to_string())?;
            let value = attribute.normalized_value(XmlVersion::Implicit1_0);
            let value = value.map_err(|e| e.to_string())?.into_owned();
            Ok((attribute.key.0.to_string(), value))
        });
        let name = start.name().0;
        Ok(Self {
            tag: name.rsplit(':').next().unwrap_or(name).to_string(),
            children: Vec::new(),
            attributes: attributes.collect::<Result<_, String>>()?,
            line,
        })
    }

    /// The elements in it with this tag.
    pub fn all(&self, tag: &str) -> impl Iterator<Item = &Self> {
        self.children.iter().filter(move |child| child.tag == tag)
    }

    /// The first element in it with this tag.
    pub fn child(&self, tag: &str) -> Option<&Self> {
        self.all(tag).next()
    }

    /// What stands in all elements in it with this tag: usually there is one at most.
    pub fn all_in<'a>(&'a self, tag: &'a str) -> impl Iterator<Item = &'a Self> {
        self.all(tag).flat_map(|child| child.children.iter())
    }

    /// An attribute as it is written.
    pub fn get(&self, name: &str) -> Option<&str> {
        let mut attributes = self.attributes.iter();
        let found = attributes.find(|(attribute, _)| attribute == name);
        found.map(|(_, value)| value.as_str())
    }

    /// An attribute as it is written, empty where there is none.
    pub fn text(&self, name: &str) -> String {
        self.get(name).unwrap_or_default().to_string()
    }

    /// An attribute that must be there.
    pub fn required(&self, name: &str) -> Result<String, DescriptionError> {
        let value = self.get(name).map(str::to_string);
        value.ok_or_else(|| self.error(format!("has no attribute `{name}`")))
    }

    /// An attribute of another type, if it is there.
    pub fn number<T: FromStr>(&self, name: &str) -> Result<Option<T>, DescriptionError> {
        let Some(text) = self.get(name) else {
            return Ok(None);
        };
        let number = text.trim().parse().ok();
        let number = number.ok_or_else(|| {
            let kind = std::any::type_name::<T>();
            self.error(format!("has {name}=\"{text}\", which is no {kind}"))
        });
        number.map(Some)
    }

    /// A truth value, false where there is none.
    pub fn flag(&self, name: &str) -> Result<bool, DescriptionError> {
        let words = ["false", "0", "true", "1"].map(|word| (word, matches!(word, "true" | "1")));
        Ok(self.word(name, &words)?.unwrap_or(false))
    }

    /// An attribute that is one of these words, if it is there.
    pub fn word<T: Copy>(
        &self,
        name: &str,
        words: &[(&str, T)],
    ) -> Result<Option<T>, DescriptionError> {
        let Some(text) = self.get(name) else {
            return Ok(None);
        };
        let found = words.iter().find(|(word, _)| *word == text.trim());
        let found = found.map(|(_, value)| Some(*value));
        found.ok_or_else(|| {
            let allowed: Vec<_> = words.iter().map(|(word, _)| *word).collect();
            let allowed = allowed.join(", ");
            self.error(format!(
                "has {name}=\"{text}\", but it must be one of {allowed}"
            ))
        })
    }

    /// What is wrong with this element.
    pub fn error(&self, what: impl std::fmt::Display) -> DescriptionError {
        let name = self.get("name").map(|name| format!(" `{name}`"));
        let (tag, name) = (&self.tag, name.unwrap_or_default());
        DescriptionError::Xml {
            line: self.line,
            reason: format!("{tag}{name} {what}"),
        }
    }
}

/// Counts lines as reading goes on.
#[derive(Default)]
struct Lines {
    place: usize,
    before: usize,
}

impl Lines {
    /// The line, counted from 1, of the first character from `place` on that is not blank; a place
    /// before the last one counts as that.
    fn at(&mut self, text: &str, place: usize) -> usize {
        let rest = text.get(place..).unwrap_or_default();
        let place = place + (rest.len() - rest.trim_start().len());
        let passed = text.as_bytes().get(self.place..place).unwrap_or_default();
        self.before += passed.iter().filter(|byte| **byte == b'\n').count();
        self.place = self.place.max(place);
        self.before + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_those_of_elements() {
        let text = "<?xml version=\"1.0\"?>\r\n<!-- a\nb -->\n<a>\n  <x:b n=\"1\"\n k=\"&lt;&#228;\"/>\n  text <c/></a>";
        let root = Element::parse(text).unwrap();
        let lines: Vec<_> = root
            .children
            .iter()
            .map(|c| (c.tag.as_str(), c.line))
            .collect();
        assert_eq!((root.line, lines), (4, vec![("b", 5), ("c", 7)]));
        assert_eq!(root.children[0].get("k"), Some("<ä"));
        let error = root.children[0].number::<f64>("k").unwrap_err();
        assert_eq!(
            error.to_string(),
            "the model description cannot be read: line 5: b has k=\"<ä\", which is no f64"
        );
    }

    #[test]
    fn what_is_no_tree_is_refused() {
        for (text, expected) in [
            ("", "line 1: there is no element"),
            ("<a>\n<b>\n</b>\n", "line 4: the element `a` does not end"),
            ("<a>\n</b>", "line 2: "),
            ("<a b=1/>", "line 1: "),
            ("<a b=\"&x;\"/>", "line 1: "),
            ("text", "line 1: there is no element"),
            (&"<a>".repeat(100_000), "line 1: more than 256 elements"),
        ] {
            let error = Element::parse(text).unwrap_err().to_string();
            let start = format!("the model description cannot be read: {expected}");
            assert!(error.starts_with(&start), "{text}: {error}");
        }
    }
}
