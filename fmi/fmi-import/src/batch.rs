//! A [`Batch`] says what one call of a co-simulation master reads or sets: which value references,
//! and where each value stands among those that the call passes. The master plans it before the
//! run, so that nothing is looked up in a step.
//!
//! FMI 2.0 passes single elements. FMI 3.0 passes whole arrays: to set some elements, the last
//! values of the others are passed too, from a memory whose slots are given by a [`Layout`].
//!
//! ```
//! use fmi_import::batch::{Batch, Layout};
//! fn first_variable(description: &fmi_description::Description) -> Batch {
//!     Batch::new(description, &Layout::new(description), vec![0])
//! }
//! ```

use std::collections::{BTreeMap, HashMap};
use std::ops::{Deref, Range};
use std::sync::Arc;

use fmi_description::{Access, Description, Variability, Version};

use crate::value::{Value, is_non_numeric};

/// Variables of one instance and of one type that one call reads or sets. Clones share the plan.
#[derive(Clone, Debug)]
pub struct Batch(Arc<BatchPlan>);

/// The plan of a [`Batch`].
#[derive(Debug)]
pub struct BatchPlan {
    /// Type of the values.
    pub access: Access,
    /// Variables by index in the description, one for each value.
    pub variables: Vec<usize>,
    /// References as the call passes them.
    pub references: Vec<u32>,
    /// The order 1 for each reference, for calls that pass first derivatives.
    pub first_orders: Vec<i32>,
    /// Number of values that the call passes.
    pub passed: usize,
    /// Place of each value among those that are passed.
    pub places: Vec<usize>,
    /// For each reference, the slots of its values in the memory. FMI 3.0 only.
    pub spans: Vec<Range<usize>>,
    /// Slot of each value in the memory. FMI 3.0 only.
    pub slots: Vec<usize>,
    /// The call passes exactly the values of the batch, in their order.
    pub is_whole: bool,
    /// Slots of inputs that change at events only, and their places in the batch. FMI 3.0 only.
    pub discrete: Vec<(usize, usize)>,
    /// Clocks at whose ticks the values are exchanged, all of the same clocks. FMI 3.0 only.
    pub clocks: Vec<u32>,
    /// The type is one that an `f64` cannot represent.
    pub is_non_numeric: bool,
}

/// The memory of an instance of FMI 3.0: a slot for each element, which holds the bits of the
/// number that it was last set to. Empty for FMI 2.0.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    spans: HashMap<u32, Range<usize>>,
    /// Start values, by slot.
    pub initial: Vec<u64>,
    /// Start values of texts and bytes, by slot.
    pub texts: BTreeMap<usize, Value>,
}

impl Layout {
    /// A slot for each element of a description that has its variables [by
    /// element](Description::by_element).
    pub fn new(description: &Description) -> Self {
        let mut layout = Self::default();
        if description.fmi == Version::Fmi2 {
            return layout;
        }
        for v in &description.variables {
            let next = layout.initial.len();
            let span = layout.spans.entry(v.reference).or_insert(next..next);
            let place = v.element.unwrap_or(0);
            if place < span.len() {
                continue; // an alias
            }
            span.end += 1;
            let start = v.start_of(0).map(|start| match v.access() {
                Access::String | Access::Binary => start,
                _ => start.trim(),
            });
            let start = start.and_then(|start| Value::parse(v.access(), start));
            layout.initial.push(start.as_ref().map_or(0, Value::bits));
            if let Some(text @ (Value::Text(_) | Value::Bytes(_))) = start {
                layout.texts.insert(next, text);
            }
        }
        layout
    }

    /// Slots of the elements with this value reference.
    pub fn span(&self, reference: u32) -> Range<usize> {
        self.spans.get(&reference).cloned().unwrap_or(0..0)
    }
}

impl Batch {
    /// Plans a call for variables of one type, by index in a description that has them [by
    /// element](Description::by_element).
    pub fn new(description: &Description, layout: &Layout, variables: Vec<usize>) -> Self {
        let variable = |k: &usize| &description.variables[*k];
        let first = variables.first();
        let access = first.map_or(Access::Real, |k| variable(k).access());
        debug_assert!(variables.iter().all(|k| variable(k).access() == access));
        let mut batch = BatchPlan {
            access,
            references: Vec::new(),
            first_orders: Vec::new(),
            passed: 0,
            places: Vec::new(),
            spans: Vec::new(),
            slots: Vec::new(),
            is_whole: true,
            discrete: Vec::new(),
            clocks: Vec::new(),
            is_non_numeric: is_non_numeric(access),
            variables,
        };
        if description.fmi == Version::Fmi2 {
            let references = batch.variables.iter().map(|k| variable(k).reference);
            batch.references = references.collect();
            batch.passed = batch.references.len();
            batch.first_orders = vec![1; batch.passed];
            return Self(Arc::new(batch));
        }
        let first = batch.variables.first();
        batch.clocks = first.map_or(Vec::new(), |k| variable(k).clocks.clone());
        let mut firsts = HashMap::new();
        for (k, v) in batch.variables.iter().map(variable).enumerate() {
            let first = *firsts.entry(v.reference).or_insert_with(|| {
                let (span, first) = (layout.span(v.reference), batch.passed);
                batch.passed += span.len();
                batch.references.push(v.reference);
                batch.spans.push(span);
                first
            });
            let place = v.element.unwrap_or(0);
            batch.places.push(first + place);
            let slot = layout.span(v.reference).start + place;
            batch.slots.push(slot);
            if v.is_input() && v.variability == Variability::Discrete && v.clocks.is_empty() {
                batch.discrete.push((slot, k));
            }
        }
        let in_order = batch.places.iter().copied().eq(0..batch.places.len());
        batch.is_whole = in_order && batch.passed == batch.places.len();
        batch.first_orders = vec![1; batch.references.len()];
        Self(Arc::new(batch))
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        self.variables.len()
    }

    /// Whether it is a clone of another batch.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// Whether it is the only one of its clones that is left.
    pub fn is_last(&self) -> bool {
        Arc::strong_count(&self.0) == 1
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.variables.is_empty()
    }
}

impl Deref for Batch {
    type Target = BatchPlan;

    fn deref(&self) -> &BatchPlan {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"<fmiModelDescription fmiVersion="3.0" modelName="M" instantiationToken="t"><CoSimulation modelIdentifier="M"/>
      <ModelVariables><Float64 name="a" valueReference="5" causality="input" start="1 2 3"><Dimension start="3"/><Alias name="same"/></Float64>
      <Float64 name="b" valueReference="9" causality="input" start="-4"/></ModelVariables><ModelStructure/></fmiModelDescription>"#;

    fn batch(names: &[&str]) -> Batch {
        let d = Description::parse(TEXT).unwrap().by_element();
        let variables = names.iter().map(|n| d.index(n).unwrap()).collect();
        Batch::new(&d, &Layout::new(&d), variables)
    }

    #[test]
    fn some_elements_take_their_whole_array_along() {
        let some = batch(&["b", "a[3]", "same[1]"]);
        assert_eq!((some.references.as_slice(), some.passed), (&[9, 5][..], 4));
        assert_eq!(some.places, [0, 3, 1], "an alias is its variable");
        assert_eq!(
            (some.spans.as_slice(), some.slots.as_slice()),
            (&[3..4, 0..3][..], &[3, 2, 0][..])
        );
        assert!(!some.is_whole);
        assert!(batch(&["b", "a[1]", "a[2]", "a[3]"]).is_whole);
        assert!(!batch(&["a[2]", "a[1]", "a[3]"]).is_whole, "another order");
    }

    #[test]
    fn the_memory_begins_with_the_start_values() {
        let d = Description::parse(TEXT).unwrap().by_element();
        let initial = Layout::new(&d).initial.into_iter().map(f64::from_bits);
        assert_eq!(initial.collect::<Vec<_>>(), [1.0, 2.0, 3.0, -4.0]);
    }
}
