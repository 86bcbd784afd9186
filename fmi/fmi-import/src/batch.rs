//! What one call reads or writes, planned before the run: which references, and where each value
//! stands among those that the call passes.
//!
//! FMI 2.0 passes elements. FMI 3.0 passes whole arrays: to set some elements of one, the others
//! must be given too, as they were given last.

use std::collections::{BTreeMap, HashMap};
use std::ops::{Deref, Range};
use std::sync::Arc;

use fmi_description::{Access, Description, Variability, Version};

use crate::value::{Value, is_wide};

/// Values of some variables of one instance and of one type. A clone is the same plan.
#[derive(Clone, Debug)]
pub struct Batch(Arc<Planned>);

/// What a batch has planned.
#[derive(Debug)]
pub struct Planned {
    /// Type of the values.
    pub access: Access,
    /// Variables by index in the description, one for each value.
    pub variables: Vec<usize>,
    /// References as the call passes them.
    pub references: Vec<u32>,
    /// The same number of ones: orders of first derivatives.
    pub ones: Vec<i32>,
    /// Number of values that the call passes.
    pub passed: usize,
    /// Place of each value among those that are passed.
    pub places: Vec<usize>,
    /// Slots of what is passed in the memory of an instance, for each reference. FMI 3.0 only, as
    /// the next.
    pub spans: Vec<Range<usize>>,
    /// Slot of each value in that memory.
    pub slots: Vec<usize>,
    /// The passed values are just the values.
    pub is_whole: bool,
    /// Slots and places of values that change at events only. FMI 3.0 only, as the next.
    pub discrete: Vec<(usize, usize)>,
    /// Clocks at whose ticks alone the values are exchanged; the same for all of them.
    pub clocks: Vec<u32>,
    /// Values of this type do not pass as `f64`.
    pub is_wide: bool,
}

/// A memory for what was last given to the elements of an instance of FMI 3.0: a slot for each, as
/// bits of the number.
#[derive(Debug, Default)]
pub struct Layout {
    spans: HashMap<u32, Range<usize>>,
    /// Start values.
    pub initial: Vec<u64>,
    /// Start values of texts and bytes.
    pub texts: BTreeMap<usize, Value>,
}

impl Layout {
    /// Of the variables that a description has by element.
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

    /// Slots of the variable or array with this reference.
    pub fn span(&self, reference: u32) -> Range<usize> {
        self.spans.get(&reference).cloned().unwrap_or(0..0)
    }
}

impl Batch {
    /// Of variables of one type, by index in a description that has them by element.
    pub fn new(description: &Description, layout: &Layout, variables: Vec<usize>) -> Self {
        let of = |k: &usize| &description.variables[*k];
        let access = variables.first().map_or(Access::Real, |k| of(k).access());
        debug_assert!(variables.iter().all(|k| of(k).access() == access));
        let mut batch = Planned {
            access,
            references: Vec::new(),
            ones: Vec::new(),
            passed: 0,
            places: Vec::new(),
            spans: Vec::new(),
            slots: Vec::new(),
            is_whole: true,
            discrete: Vec::new(),
            clocks: Vec::new(),
            is_wide: is_wide(access),
            variables,
        };
        if description.fmi == Version::Fmi2 {
            batch.references = batch.variables.iter().map(|k| of(k).reference).collect();
            batch.passed = batch.references.len();
            batch.ones = vec![1; batch.passed];
            return Self(Arc::new(batch));
        }
        let first = batch.variables.first();
        batch.clocks = first.map_or(Vec::new(), |k| of(k).clocks.clone());
        let mut firsts = HashMap::new();
        for (k, v) in batch.variables.iter().map(of).enumerate() {
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
        batch.ones = vec![1; batch.references.len()];
        Self(Arc::new(batch))
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        self.variables.len()
    }

    /// True without values.
    pub fn is_empty(&self) -> bool {
        self.variables.is_empty()
    }
}

impl Deref for Batch {
    type Target = Planned;

    fn deref(&self) -> &Planned {
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
