//! What outputs depend on: names of the table become positions of elements.

use super::layout::Layout;
use super::variable::{ALL_PARAMETERS, Causality, Dependencies};
use crate::Model;
use std::collections::BTreeMap;
use std::ops::Range;

/// Rows that others may depend on, by name.
pub(crate) struct Knowns {
    rows: BTreeMap<&'static str, Known>,
    /// Positions of all parameters, ascending.
    parameters: Vec<usize>,
}

/// An input or parameter: the 1-based position of its first element in the table, counted by element, and how many there are.
struct Known {
    first: usize,
    len: usize,
    is_input: bool,
}

impl Knowns {
    pub(crate) fn new<M: Model>(layout: &Layout<M>) -> Self {
        let mut rows: BTreeMap<_, Known> = BTreeMap::new();
        let mut parameters = Vec::new();
        for (position, (_, row)) in (1..).zip(layout.iter()) {
            let is_input = row.causality == Causality::Input;
            if row.causality == Causality::Parameter {
                parameters.push(position);
            } else if !is_input {
                continue;
            }
            rows.entry(row.name)
                .or_insert(Known {
                    first: position,
                    len: 0,
                    is_input,
                })
                .len += 1;
        }
        Self { rows, parameters }
    }

    /// The positions of what an element depends on, ascending; None: not said. Without `parameters`, only inputs may be named.
    pub(crate) fn resolve(
        &self,
        dependencies: Dependencies,
        i: usize,
        parameters: bool,
    ) -> Result<Option<Vec<usize>>, String> {
        let names = match dependencies {
            Dependencies::Unknown => return Ok(None),
            Dependencies::Same(names) => names,
            Dependencies::Each(lists) => match lists.get(i) {
                Some(list) => list,
                None => {
                    return Err(format!(
                        "has {} lists of dependencies, fewer than elements",
                        lists.len()
                    ));
                }
            },
        };
        let mut positions = Vec::new();
        for name in names {
            match self.find(name, i) {
                _ if parameters && *name == ALL_PARAMETERS => positions.extend(&self.parameters),
                Some((known, range)) if known.is_input || parameters => positions.extend(range),
                _ => {
                    let allowed = if parameters {
                        "inputs and parameters"
                    } else {
                        "inputs"
                    };
                    return Err(format!(
                        "depends on `{name}`; allowed are {allowed} of the table"
                    ));
                }
            }
        }
        positions.sort_unstable();
        positions.dedup();
        Ok(Some(positions))
    }

    /// `x`: all of a row; `x[2]`: one element; `x[i]`: the element with index `i` (from 0).
    fn find(&self, name: &str, i: usize) -> Option<(&Known, Range<usize>)> {
        let Some((row, index)) = name.strip_suffix(']').and_then(|name| name.split_once('['))
        else {
            let known = self.rows.get(name)?;
            return Some((known, known.first..known.first + known.len));
        };
        let known = self.rows.get(row)?;
        let index = if index == "i" {
            i + 1
        } else {
            index.parse().ok()?
        };
        let position = known.first + index.checked_sub(1)?;
        (index <= known.len).then_some((known, position..position + 1))
    }
}
