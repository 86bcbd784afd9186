//! A model description as a tree of elements, each with the attributes that it has and no others.

use uppsala::{Document, NodeId};

/// An element.
#[derive(Clone, Copy)]
pub struct Element<'a> {
    document: &'a Document<'a>,
    id: NodeId,
}

impl<'a> Element<'a> {
    /// The outermost element.
    pub fn root(document: &'a Document<'a>) -> Option<Self> {
        let id = document.document_element()?;
        Some(Self { document, id })
    }

    /// Name of its tag.
    pub fn tag(self) -> &'a str {
        let element = self.document.element(self.id);
        element.map_or("", |e| &e.name.local_name)
    }

    /// An attribute.
    pub fn get(self, attribute: &str) -> Option<&'a str> {
        self.document.get_attribute(self.id, attribute)
    }

    /// An attribute that is a number.
    pub fn number(self, attribute: &str) -> Option<f64> {
        self.get(attribute)?.trim().parse().ok()
    }

    /// The elements in it.
    pub fn children(self) -> impl Iterator<Item = Self> {
        let Self { document, .. } = self;
        let nodes = document.children_iter(self.id);
        let elements = nodes.filter(move |id| document.element(*id).is_some());
        elements.map(move |id| Self { document, id })
    }

    /// The elements in it with this tag.
    pub fn all(self, tag: &str) -> impl Iterator<Item = Self> {
        self.children().filter(move |child| child.tag() == tag)
    }

    /// The first element in it with this tag.
    pub fn child(self, tag: &str) -> Option<Self> {
        self.all(tag).next()
    }

    /// The element in it with this tag and name.
    pub fn named(self, tag: &str, name: &str) -> Option<Self> {
        self.all(tag).find(|child| child.get("name") == Some(name))
    }
}
