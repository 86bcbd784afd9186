//! Reads XML as a tree of elements, for `parse`, the check, `xtask` and `system-structure` (SSP).
//!
//! Names are compared without their namespace prefix, and attributes are read by name. Whatever
//! nobody reads, such as comments and additions of vendors, is ignored. An error names the file,
//! the line, the element and the value.
//!
//! ```
//! use fmi_description::xml::Element;
//! let text = "<a>\n  <x:b n='2' k='soft'/>\n</a>";
//! let b = &Element::parse(text, "a.xml", "a").unwrap().children[0];
//! assert_eq!(b.number("n"), Ok(Some(2.0)));
//! let error = b.number("k").unwrap_err().to_string();
//! assert_eq!(error, "`a.xml`, line 2: b has k = `soft`; it must be a number");
//! ```

use std::ops::Range;
use std::str::FromStr;
use std::sync::Arc;

use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use thiserror::Error;

use crate::limits::{ATTRIBUTES, DEPTH, ELEMENTS};

/// What is wrong with a file, and where.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("`{file}`, line {line}: {text}")]
pub struct XmlError {
    /// Name of the file.
    pub file: Arc<str>,
    /// Line, counted from 1.
    pub line: usize,
    /// What is wrong.
    pub text: String,
}

/// An element with its attributes and the elements in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Element {
    /// Its name, without the prefix of a namespace.
    pub tag: String,
    /// Line on which it begins, counted from 1.
    pub line: usize,
    /// The elements in it, in the order of the file.
    pub children: Vec<Element>,
    /// Its range in the text without byte order mark, for editing the text.
    pub range: Range<usize>,
    attributes: Vec<(String, String)>,
    file: Arc<str>,
}

impl Element {
    /// The outermost element of a text, which must be `root`; `file` is its name for messages.
    ///
    /// # Errors
    /// It is not well-formed, has another outermost element, is nested too deeply, is too large, or
    /// declares entities, which could multiply its length without end.
    pub fn parse(text: &str, file: &str, root: &str) -> Result<Self, XmlError> {
        let text = text.trim_start_matches('\u{feff}');
        let file: Arc<str> = file.into();
        let fail = |line: usize, text: String| XmlError {
            file: file.clone(),
            line,
            text,
        };
        if !text.trim_start().starts_with('<') {
            return Err(fail(1, "it is no XML".into()));
        }
        let mut reader = quick_xml::Reader::from_str(text);
        let mut open: Vec<Self> = Vec::new();
        let (mut lines, mut count) = (Lines::default(), 0);
        loop {
            let begin = usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX);
            let event = reader.read_event();
            let line = lines.at(text, begin);
            let unreadable = |reason: String| fail(line, format!("it is no XML: {reason}"));
            let end = usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX);
            let begun = |start: &BytesStart| {
                let element = Self::begin(start, &file, line, begin..end);
                element.map_err(unreadable)
            };
            let mut closed = match event.map_err(|e| unreadable(e.to_string()))? {
                Event::Start(_) if open.len() == DEPTH => {
                    let text = format!("more than {DEPTH} elements are nested in each other");
                    return Err(fail(line, text));
                }
                Event::Start(start) => {
                    open.push(begun(&start)?);
                    continue;
                }
                Event::Empty(start) => begun(&start)?,
                Event::End(_) => open
                    .pop()
                    .ok_or_else(|| unreadable("an element ends that has not begun".into()))?,
                Event::Eof => return Err(fail(line, format!("it has no element {root}"))),
                Event::DocType(declared) if declared.contains("<!ENTITY") => {
                    let text = "it declares entities (<!ENTITY), which are not read: what they stand for must be written out";
                    return Err(fail(line, text.into()));
                }
                _ => continue,
            };
            count += 1;
            if count > ELEMENTS {
                return Err(fail(line, format!("it has more than {ELEMENTS} elements")));
            }
            closed.range.end = end;
            match open.last_mut() {
                Some(parent) => parent.children.push(closed),
                None if closed.tag == root => return Ok(closed),
                None => return Err(closed.error(format!("its outermost element is not {root}"))),
            }
        }
    }

    fn begin(
        start: &BytesStart,
        file: &Arc<str>,
        line: usize,
        range: Range<usize>,
    ) -> Result<Self, String> {
        let attributes = start.attributes().map(|attribute| {
            let attribute = attribute.map_err(|e| e.to_string())?;
            let value = attribute.normalized_value(XmlVersion::Implicit1_0);
            let value = value.map_err(|e| e.to_string())?.into_owned();
            Ok((attribute.key.0.to_string(), value))
        });
        // The search for an attribute that is there twice takes the square of their number.
        let attributes = attributes.take(ATTRIBUTES + 1);
        let attributes = attributes.collect::<Result<Vec<_>, String>>()?;
        if attributes.len() > ATTRIBUTES {
            return Err(format!("an element has more than {ATTRIBUTES} attributes"));
        }
        Ok(Self {
            tag: start.local_name().as_ref().to_string(),
            line,
            children: Vec::new(),
            range,
            attributes,
            file: file.clone(),
        })
    }

    /// The elements in it with this tag.
    pub fn all<'a>(&'a self, tag: &str) -> impl Iterator<Item = &'a Self> + Clone {
        self.children.iter().filter(move |child| child.tag == tag)
    }

    /// The first element in it with this tag.
    pub fn child(&self, tag: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.tag == tag)
    }

    /// The elements in all its elements with this tag, of which there usually is at most one.
    pub fn all_in<'a>(&'a self, tag: &str) -> impl Iterator<Item = &'a Self> {
        self.all(tag).flat_map(|child| child.children.iter())
    }

    /// The elements with the tag `each` in its elements with the tag `list`.
    pub fn listed<'a>(&'a self, list: &str, each: &str) -> impl Iterator<Item = &'a Self> {
        self.all_in(list).filter(move |element| element.tag == each)
    }

    /// An attribute as it is written; one with a prefix only if there is none without.
    pub fn get(&self, name: &str) -> Option<&str> {
        let is_prefixed = |key: &str| key.rsplit_once(':').is_some_and(|(_, local)| local == name);
        let attributes = || self.attributes.iter();
        let plain = attributes().find(|(key, _)| key == name);
        let found = plain.or_else(|| attributes().find(|(key, _)| is_prefixed(key)));
        found.map(|(_, value)| value.as_str())
    }

    /// An attribute as it is written; empty if there is none.
    pub fn text(&self, name: &str) -> String {
        self.get(name).unwrap_or_default().to_string()
    }

    /// An attribute that must be there.
    ///
    /// # Errors
    /// It is not.
    pub fn required(&self, name: &str) -> Result<String, XmlError> {
        self.must(name, self.get(name).map(str::to_string))
    }

    /// The value of an attribute that must be there.
    ///
    /// # Errors
    /// There is none.
    pub fn must<T>(&self, name: &str, value: Option<T>) -> Result<T, XmlError> {
        value.ok_or_else(|| self.wrong(format!("has no attribute {name}")))
    }

    /// An attribute as a number, if it is there.
    ///
    /// # Errors
    /// It is something else.
    pub fn number(&self, name: &str) -> Result<Option<f64>, XmlError> {
        self.read(name, |text| text.parse().ok(), || "a number".into())
    }

    /// An attribute as a finite number, if it is there.
    ///
    /// # Errors
    /// It is something else.
    pub fn finite(&self, name: &str) -> Result<Option<f64>, XmlError> {
        let number = |text: &str| text.parse().ok().filter(|x: &f64| x.is_finite());
        self.read(name, number, || "a finite number".into())
    }

    /// An attribute as a whole number, if it is there.
    ///
    /// # Errors
    /// It is something else, or too large.
    pub fn whole<T: FromStr>(&self, name: &str) -> Result<Option<T>, XmlError> {
        let kind = || format!("a whole number ({})", std::any::type_name::<T>());
        self.read(name, |text| text.parse().ok(), kind)
    }

    /// A truth value; false if there is none.
    ///
    /// # Errors
    /// It is something else.
    pub fn flag(&self, name: &str) -> Result<bool, XmlError> {
        let flag = self.read(name, truth, || "true or false".into());
        Ok(flag?.unwrap_or(false))
    }

    /// An attribute that is one of these words, if it is there.
    ///
    /// # Errors
    /// It is something else.
    pub fn word<T: Copy>(&self, name: &str, words: &[(&str, T)]) -> Result<Option<T>, XmlError> {
        let value = |text: &str| {
            let found = words.iter().find(|(word, _)| *word == text);
            found.map(|(_, value)| *value)
        };
        self.read(name, value, || {
            let allowed: Vec<_> = words.iter().map(|(word, _)| *word).collect();
            format!("one of {}", allowed.join(", "))
        })
    }

    /// An attribute that must be what `kind` says, if it is there.
    fn read<T>(
        &self,
        name: &str,
        value: impl Fn(&str) -> Option<T>,
        kind: impl Fn() -> String,
    ) -> Result<Option<T>, XmlError> {
        let Some(text) = self.get(name) else {
            return Ok(None);
        };
        let unfit = || self.wrong(format!("has {name} = `{text}`; it must be {}", kind()));
        value(text.trim()).map(Some).ok_or_else(unfit)
    }

    /// An error at this element, whose text has its tag, and its name if it has one.
    pub fn wrong(&self, what: impl std::fmt::Display) -> XmlError {
        let name = self.get("name").map(|name| format!(" (of `{name}`)"));
        self.error(format!("{} {what}{}", self.tag, name.unwrap_or_default()))
    }

    /// An error at this element.
    pub fn error(&self, text: String) -> XmlError {
        XmlError {
            file: self.file.clone(),
            line: self.line,
            text,
        }
    }
}

/// A truth value as XML writes it.
pub fn truth(text: &str) -> Option<bool> {
    match text.trim() {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}

/// Finds lines by position, counting on from the last one.
#[derive(Default)]
struct Lines {
    place: usize,
    before: usize,
}

impl Lines {
    /// The line, counted from 1, of the first character from `place` on that is not blank. `place`
    /// must not decrease from call to call.
    fn at(&mut self, text: &str, place: usize) -> usize {
        let rest = text.get(place..).unwrap_or_default();
        let place = place + (rest.len() - rest.trim_start().len());
        let passed = text.as_bytes().get(self.place..place).unwrap_or_default();
        self.before += passed.iter().filter(|byte| **byte == b'\n').count();
        self.place = self.place.max(place);
        self.before + 1
    }
}

/// A text as the value of an attribute that is written, with its quotes.
pub fn quoted(text: &str) -> String {
    let escaped = text.replace('&', "&amp;").replace('<', "&lt;");
    let escaped = escaped.replace('"', "&quot;").replace('\n', "&#10;");
    format!("\"{escaped}\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_those_of_elements() {
        let text = "\u{feff}<?xml version=\"1.0\"?>\r\n<!-- a\nb -->\n<y:a>\n  <x:b n=\"1\"\n k=\"&lt;&#228;\"/>\n  text <c x:n='2'/></y:a>";
        let root = Element::parse(text, "f", "a").unwrap();
        let lines: Vec<_> = root
            .children
            .iter()
            .map(|c| (c.tag.as_str(), c.line))
            .collect();
        assert_eq!((root.line, lines), (4, vec![("b", 5), ("c", 7)]));
        let plain = text.trim_start_matches('\u{feff}');
        assert_eq!(&plain[root.children[1].range.clone()], "<c x:n='2'/>");
        assert!(plain[root.range.clone()].ends_with("</y:a>"));
        assert_eq!(root.children[0].get("k"), Some("<ä"));
        assert_eq!(root.children[1].whole("n"), Ok(Some(2)));
        let error = root.children[0].number("k").unwrap_err();
        assert_eq!(
            error.to_string(),
            "`f`, line 5: b has k = `<ä`; it must be a number"
        );
    }

    #[test]
    fn what_is_no_tree_is_refused_with_its_line() {
        for (text, expected) in [
            ("", "line 1: it is no XML"),
            ("time,x\n0,1\n", "line 1: it is no XML"),
            ("<a>\n", "line 2: it has no element a"),
            ("<a>\n<b>\n</b>\n", "line 4: it has no element a"),
            ("<a>\n</b>", "line 2: it is no XML: "),
            ("\n</a>", "line 2: it is no XML: "),
            ("\n<b/>", "line 2: its outermost element is not a"),
            ("<a b=1/>", "line 1: it is no XML: "),
            ("<a b='1' b='2'/>", "line 1: it is no XML: "),
            ("<a b=\"&x;\"/>", "line 1: it is no XML: "),
            (
                &"<a>\n".repeat(200_000),
                "line 257: more than 256 elements are nested in each other",
            ),
        ] {
            let error = Element::parse(text, "f", "a").unwrap_err().to_string();
            let start = format!("`f`, {expected}");
            assert!(error.starts_with(&start), "{error}");
        }
    }

    #[test]
    fn what_an_attribute_must_be_is_said() {
        let a = Element::parse("<a k='soft' name='x'/>", "f", "a").unwrap();
        for (error, text) in [
            (
                a.finite("k").unwrap_err(),
                "a has k = `soft`; it must be a finite number (of `x`)",
            ),
            (
                a.whole::<u32>("k").unwrap_err(),
                "it must be a whole number (u32)",
            ),
            (a.flag("k").unwrap_err(), "it must be true or false"),
            (
                a.word("k", &[("hard", 1), ("firm", 2)]).unwrap_err(),
                "it must be one of hard, firm",
            ),
            (a.required("n").unwrap_err(), "a has no attribute n"),
        ] {
            assert!(error.to_string().contains(text), "{error}");
        }
    }
}
