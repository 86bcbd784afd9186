//! Rewrites a schema for `schema` with equivalent constructs that the validator handles.
//!
//! uppsala 0.12 ignores how often a group may occur, a group that extends a type, how often the
//! sequence of an extension may occur, and the content of the base type if an extension adds only
//! attributes. FMI 3.0 uses all four.

use std::borrow::Cow;

use uppsala::{Document, NodeId, QName};

const XS: &str = "http://www.w3.org/2001/XMLSchema";
/// The attributes that say how often a group or sequence may occur.
const OCCURRENCE: [&str; 2] = ["minOccurs", "maxOccurs"];

/// Replaces what the validator handles wrongly.
pub fn rewrite(schema: &mut Document) {
    write_groups_out(schema);
    for extension in schema.get_elements_by_tag_name("extension") {
        wrap_content(schema, extension);
    }
}

/// Replaces each reference to a group by the content of the group, with the occurrence of the
/// reference.
fn write_groups_out(schema: &mut Document) {
    for reference in schema.get_elements_by_tag_name("group") {
        let Some(name) = schema.get_attribute(reference, "ref").map(str::to_string) else {
            continue;
        };
        let group = schema.get_elements_by_tag_name("group").into_iter();
        let mut group = group.filter(|g| schema.get_attribute(*g, "name") == Some(&name));
        let content = group
            .next()
            .and_then(|g| elements(schema, g).into_iter().next());
        let (Some(content), Some(parent)) = (content, schema.parent(reference)) else {
            continue;
        };
        let copy = copied(schema, content);
        for attribute in OCCURRENCE {
            if let Some(value) = schema
                .get_attribute(reference, attribute)
                .map(str::to_string)
            {
                set_attribute(schema, copy, attribute, value);
            }
        }
        schema.replace_child(parent, copy, reference);
    }
}

/// Puts what an extension adds into a sequence that occurs once; an empty one if it adds only
/// attributes.
fn wrap_content(schema: &mut Document, extension: NodeId) {
    let is_simple = |parent| {
        schema
            .element(parent)
            .is_some_and(|e| e.name.local_name == "simpleContent")
    };
    if schema.parent(extension).is_some_and(is_simple) {
        return;
    }
    let wrapper = schema.create_element(xs("sequence"));
    let is_content = |id: &NodeId| {
        let element = schema.element(*id);
        element.is_some_and(|e| matches!(&*e.name.local_name, "sequence" | "choice" | "all"))
    };
    let content = elements(schema, extension).into_iter().find(is_content);
    match (content, schema.first_child(extension)) {
        (Some(content), _) => {
            schema.replace_child(extension, wrapper, content);
            schema.append_child(wrapper, content);
        }
        (None, Some(first)) => schema.insert_before(extension, wrapper, first),
        (None, None) => schema.append_child(extension, wrapper),
    }
}

fn xs(name: &'static str) -> QName<'static> {
    QName::full("xs", XS, name)
}

fn elements(schema: &Document, of: NodeId) -> Vec<NodeId> {
    let children = schema.children_iter(of);
    children
        .filter(|id| schema.element(*id).is_some())
        .collect()
}

fn copied(schema: &mut Document, original: NodeId) -> NodeId {
    let source = schema.clone();
    schema
        .import_subtree(&source, original)
        .expect("an element can be copied")
}

fn set_attribute(schema: &mut Document, of: NodeId, name: &'static str, value: String) {
    if let Some(element) = schema.element_mut(of) {
        element.set_attribute(QName::local(name), Cow::Owned(value));
    }
}
