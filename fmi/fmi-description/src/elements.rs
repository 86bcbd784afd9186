//! Splits arrays of FMI 3.0 into a variable for each element, such as `zeta[3]` or `A[2,1]`, for
//! the importing master (`fmu.rs` of `cosim`), which connects single elements as SSP 1.0 does.

use std::sync::Arc;

use crate::description::{Description, Unknown};
use crate::variable::Variable;

impl Description {
    /// The description with a variable for each element of every array. If an array depends on
    /// another, each of its elements depends on all elements of the other, since the file says no
    /// more.
    pub fn by_element(&self) -> Self {
        let mut ranges = Vec::with_capacity(self.variables.len());
        let mut variables = Vec::with_capacity(self.variables.len());
        for v in &self.variables {
            let first = variables.len();
            if v.dimensions.is_empty() {
                variables.push(v.clone());
            } else {
                variables.extend((0..v.size()).map(|k| element(v, k)));
            }
            ranges.push(first..variables.len());
        }
        let unknowns = |list: &[Unknown]| {
            let each = list.iter().flat_map(|u| {
                let known = u.dependencies.as_ref();
                let known: Option<Arc<[usize]>> =
                    known.map(|known| known.iter().flat_map(|k| ranges[*k].clone()).collect());
                ranges[u.variable].clone().map(move |variable| Unknown {
                    variable,
                    dependencies: known.clone(),
                })
            });
            each.collect()
        };
        let mut by_element = Self {
            outputs: unknowns(&self.outputs),
            derivatives: unknowns(&self.derivatives),
            initial_unknowns: unknowns(&self.initial_unknowns),
            variables,
            ..self.clone()
        };
        by_element.make_index();
        by_element
    }
}

/// The element at this place, counted from 0, with the last index running fastest.
fn element(array: &Variable, place: usize) -> Variable {
    let mut indices = Vec::new();
    let mut rest = place;
    for length in array.dimensions.iter().rev() {
        indices.push((rest % length + 1).to_string());
        rest /= length;
    }
    indices.reverse();
    Variable {
        name: format!("{}[{}]", array.name, indices.join(",")),
        start: Vec::from_iter(array.start_of(place).map(String::from)),
        dimensions: Vec::new(),
        element: Some(place),
        ..array.clone()
    }
}
