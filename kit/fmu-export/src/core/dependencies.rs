//! Resolves the dependencies that the table declares by name to positions among all elements, for
//! `ModelStructure`, fmi3GetVariableDependencies, `Ode`'s solver and [`check`](crate::check).

use super::causality::{ALL_PARAMETERS, Causality, Dependencies, NO_STATES};
use super::layout::Layout;
use super::model::{ModelExchange, Variable};
use crate::Model;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// The rows that others may depend on, by name.
pub(crate) struct Knowns {
    rows: BTreeMap<&'static str, Known>,
    /// Positions of all parameters, ascending.
    parameters: Vec<usize>,
    /// Positions of all continuous states, in their order.
    pub(crate) states: Vec<usize>,
}

/// An input, a parameter or a continuous state.
struct Known {
    /// Positions of its elements.
    elements: Range<usize>,
    role: Role,
}

#[derive(Clone, Copy, PartialEq)]
enum Role {
    Input,
    Parameter,
    State,
    /// A structural parameter: constant once anything is computed.
    Size,
}

impl Knowns {
    pub(crate) fn new<M: Model>(layout: &Layout<M>) -> Self {
        let mut rows = BTreeMap::new();
        let mut parameters = Vec::new();
        let mut states = Vec::new();
        for (elements, row) in layout.rows().filter(|(_, row)| !row.storage.is_clock()) {
            let role = match row.causality {
                Causality::Parameter if row.structural => Role::Size,
                Causality::Parameter => Role::Parameter,
                Causality::Input => Role::Input,
                _ if row.is_state() => Role::State,
                _ => continue,
            };
            let elements = match role {
                Role::Size => elements.start..elements.start,
                _ => elements,
            };
            if role == Role::Parameter {
                parameters.extend(elements.clone());
            }
            rows.insert(row.name, Known { elements, role });
        }
        for row in ModelExchange::<M>::rows().filter(|row| row.storage.is_derivative()) {
            let known = rows.get(row.name).into_iter();
            states.extend(known.flat_map(|known| known.elements.clone()));
        }
        Self {
            rows,
            parameters,
            states,
        }
    }

    /// Positions of the elements that element `i` of a row depends on, initially or at
    /// communication points, ascending; None if not declared. Only initial ones may be parameters.
    pub(crate) fn resolve<M: Model>(
        &self,
        row: &Variable<M>,
        i: usize,
        initially: bool,
    ) -> Result<Option<Vec<usize>>, String> {
        let lists = match (row.same(initially), row.declared(initially)) {
            (Some(lists), _) => lists,
            (None, Dependencies::Each(lists)) => match lists.get(i) {
                Some(list) => [*list, &[]],
                None => {
                    return Err(format!(
                        "has {} lists of dependencies, fewer than elements",
                        lists.len()
                    ));
                }
            },
            _ => return Ok(None),
        };
        let mut elements = Vec::new();
        // An output that names no state depends on all.
        let mut no_states = initially || row.storage.is_equation() || row.is_state();
        if !initially && row.is_state() {
            elements.extend(self.find(row.name, i).and_then(|(_, mut own)| own.nth(i)));
        }
        for name in lists.into_iter().flatten() {
            match self.find(name, i) {
                _ if initially && *name == ALL_PARAMETERS => elements.extend(&self.parameters),
                _ if *name == NO_STATES => no_states = true,
                Some((known, _)) if initially && known.role == Role::State => {}
                Some((known, range)) if initially || known.role != Role::Parameter => {
                    no_states |= known.role == Role::State;
                    elements.extend(range);
                }
                _ => {
                    let allowed = match (initially, self.states.is_empty()) {
                        (true, _) => "an input or parameter",
                        (false, true) => "an input",
                        (false, false) => "an input or state",
                    };
                    return Err(format!(
                        "depends on `{name}`; it must be {allowed} of the table"
                    ));
                }
            }
        }
        if !no_states {
            elements.extend(&self.states);
        }
        elements.sort_unstable();
        elements.dedup();
        Ok(Some(elements))
    }

    /// The blocks that any of `n` elements of a row, from `first` on, depends on; None: undeclared.
    pub(crate) fn blocks<M: Model>(
        &self,
        layout: &Layout<M>,
        row: &Variable<M>,
        (first, n): (usize, usize),
        initially: bool,
    ) -> Result<Option<BTreeSet<u32>>, String> {
        let mut blocks = BTreeSet::new();
        // A rule gives the same for each element except those at the ends.
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

    /// Positions of all inputs and states, or initially of all inputs and parameters, ascending:
    /// the dependencies of an element that declares none.
    pub(crate) fn all(&self, initially: bool) -> Vec<usize> {
        let other = if initially {
            Role::Parameter
        } else {
            Role::State
        };
        let known = (self.rows.values()).filter(|k| k.role == Role::Input || k.role == other);
        let mut elements: Vec<_> = known.flat_map(|k| k.elements.clone()).collect();
        elements.sort_unstable();
        elements
    }

    fn find(&self, name: &str, i: usize) -> Option<(&Known, Range<usize>)> {
        elements(name, i, |row| {
            let known = self.rows.get(row)?;
            Some((known, known.elements.clone()))
        })
    }
}

/// The elements that a name in a list stands for, for the element with index `i` (from 0): `x` the
/// whole row, `x[2]` one element, `x[i]` the same index, `x[i-1]` and `x[i+2]` a neighbour, none
/// beyond the ends. `row` finds a row and the positions of its elements by name.
pub(crate) fn elements<T>(
    name: &str,
    i: usize,
    row: impl Fn(&str) -> Option<(T, Range<usize>)>,
) -> Option<(T, Range<usize>)> {
    let inside = name.strip_suffix(']');
    let Some((name, index)) = inside.and_then(|inside| inside.rsplit_once('[')) else {
        return row(name);
    };
    let (known, all) = row(name)?;
    let (index, is_beside) = match index.strip_prefix('i') {
        Some("") => (Some(i), false),
        Some(offset) => (i.checked_add_signed(offset.parse().ok()?), true),
        None => (index.parse::<usize>().ok()?.checked_sub(1), false),
    };
    match index.map(|index| all.start + index) {
        Some(element) if element < all.end => Some((known, element..element + 1)),
        _ => is_beside.then_some((known, all.start..all.start)),
    }
}

impl<M: Model> Variable<M> {
    /// Its declared dependencies, initially or at communication points.
    pub(crate) fn declared(&self, initially: bool) -> Dependencies {
        match initially {
            true => self.initial_dependencies,
            false => self.dependencies,
        }
    }

    /// Those of them that are the same two lists, joined, for each element.
    pub(crate) fn same(&self, initially: bool) -> Option<[&'static [&'static str]; 2]> {
        match (self.declared(initially), self.dependencies) {
            (Dependencies::Same(list), _) => Some([list, &[]]),
            (Dependencies::Also(more), Dependencies::Same(list)) => Some([list, more]),
            _ => None,
        }
    }

    /// Whether `ModelStructure` lists it as an unknown, initially or at communication points.
    pub(crate) fn is_unknown(&self, initially: bool) -> bool {
        match self.causality {
            _ if self.storage.is_equation() => self.storage.is_derivative() || !initially,
            Causality::Output => true,
            Causality::CalculatedParameter => initially,
            _ => initially && self.is_state(),
        }
    }

    /// Whether it is a continuous state of a model for Model Exchange.
    pub(crate) fn is_state(&self) -> bool {
        let is_it = |row: &Variable<M>| row.storage.is_derivative() && row.name == self.name;
        !self.storage.is_equation() && ModelExchange::<M>::rows().any(is_it)
    }
}
