//! What outputs depend on: names of the table become positions among all elements.

use super::causality::{ALL_PARAMETERS, Causality, Dependencies};
use super::layout::Layout;
use super::model::Variable;
use crate::Model;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Rows that others may depend on, by name.
pub(crate) struct Knowns {
    rows: BTreeMap<&'static str, Known>,
    /// Positions of all parameters, ascending.
    parameters: Vec<usize>,
}

/// An input or parameter.
struct Known {
    /// Positions of its elements.
    elements: Range<usize>,
    is_input: bool,
}

impl Knowns {
    pub(crate) fn new<M: Model>(layout: &Layout<M>) -> Self {
        let mut rows = BTreeMap::new();
        let mut parameters = Vec::new();
        for (elements, row) in layout.rows() {
            let is_input = row.causality == Causality::Input;
            if row.structural {
                // A constant by the time that anything is computed.
                let elements = elements.start..elements.start;
                rows.insert(row.name, Known { elements, is_input });
                continue;
            } else if row.causality == Causality::Parameter {
                parameters.extend(elements.clone());
            } else if !is_input {
                continue;
            }
            rows.insert(row.name, Known { elements, is_input });
        }
        Self { rows, parameters }
    }

    /// Positions of what element `i` of a row depends on at communication points or initially,
    /// ascending; None: not said. Parameters may be named only initially.
    pub(crate) fn resolve<M: Model>(
        &self,
        row: &Variable<M>,
        i: usize,
        initially: bool,
    ) -> Result<Option<Vec<usize>>, String> {
        let lists = match row.declared(initially) {
            Dependencies::Unknown => return Ok(None),
            Dependencies::Same(lists) => lists,
            Dependencies::Each(lists) => match lists.get(i) {
                Some(list) => [*list, &[]],
                None => {
                    return Err(format!(
                        "has {} lists of dependencies, fewer than elements",
                        lists.len()
                    ));
                }
            },
        };
        let mut elements = Vec::new();
        for name in lists.into_iter().flatten() {
            match self.find(name, i) {
                _ if initially && *name == ALL_PARAMETERS => elements.extend(&self.parameters),
                Some((known, range)) if known.is_input || initially => elements.extend(range),
                _ => {
                    let allowed = if initially {
                        "an input or parameter"
                    } else {
                        "an input"
                    };
                    return Err(format!(
                        "depends on `{name}`; it must be {allowed} of the table"
                    ));
                }
            }
        }
        elements.sort_unstable();
        elements.dedup();
        Ok(Some(elements))
    }

    /// The numbers of the blocks that any element of a row depends on, or None: not said; `i` is of
    /// an element to which the rules apply.
    pub(crate) fn blocks<M: Model>(
        &self,
        layout: &Layout<M>,
        row: &Variable<M>,
        (first, n): (usize, usize),
        initially: bool,
    ) -> Result<Option<BTreeSet<u32>>, String> {
        let mut blocks = BTreeSet::new();
        // Rules say the same of each element but those at the ends.
        let is_rule = !matches!(row.declared(initially), Dependencies::Each(_));
        let tried = [0, 1, n / 2, n - 1];
        for i in (first..first + n).filter(|i| !is_rule || n <= 8 || tried.contains(i)) {
            let Some(positions) = self.resolve(row, i, initially)? else {
                return Ok(None);
            };
            blocks.extend(positions.iter().map(|&p| layout.block_at(p).0));
        }
        Ok(Some(blocks))
    }

    /// Positions of all inputs, with `parameters` of the parameters too, ascending: what an element
    /// depends on that does not say.
    pub(crate) fn all(&self, parameters: bool) -> Vec<usize> {
        let known = self.rows.values().filter(|k| parameters || k.is_input);
        let mut elements: Vec<_> = known.flat_map(|k| k.elements.clone()).collect();
        elements.sort_unstable();
        elements
    }

    /// `x`: all of a row; `x[2]`: one element; `x[i]`: the element with index `i` (from 0);
    /// `x[i-1]`, `x[i+2]`: one beside it, nothing at the ends.
    fn find(&self, name: &str, i: usize) -> Option<(&Known, Range<usize>)> {
        let Some((row, index)) = name.strip_suffix(']').and_then(|name| name.split_once('['))
        else {
            let known = self.rows.get(name)?;
            return Some((known, known.elements.clone()));
        };
        let known = self.rows.get(row)?;
        let elements = known.elements.clone();
        let (index, is_beside) = match index.strip_prefix('i') {
            Some("") => (Some(i), false),
            Some(offset) => (i.checked_add_signed(offset.parse().ok()?), true),
            None => (index.parse::<usize>().ok()?.checked_sub(1), false),
        };
        match index.map(|index| elements.start + index) {
            Some(element) if element < elements.end => Some((known, element..element + 1)),
            _ => is_beside.then_some((known, elements.start..elements.start)),
        }
    }
}

impl<M: Model> Variable<M> {
    /// What is said of its dependencies at communication points or initially.
    fn declared(&self, initially: bool) -> Dependencies {
        match initially {
            true => self.initial_dependencies,
            false => self.dependencies,
        }
    }

    /// Whether it is computed and may depend on something, at communication points or initially.
    pub(crate) fn is_unknown(&self, initially: bool) -> bool {
        match self.causality {
            Causality::Output => true,
            Causality::CalculatedParameter => initially,
            _ => false,
        }
    }
}
