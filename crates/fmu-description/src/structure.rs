//! Which variables each computed variable depends on (`ModelStructure`; FMI 2.0, section 2.2.8; FMI 3.0, section 2.4.8).

use crate::{Description, Initial, Version};

/// A computed variable and what it depends on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// Index into [`Description::variables`].
    pub variable: usize,
    /// Indices of the variables it depends on; None where nothing is said, which means: on all inputs.
    pub dependencies: Option<Vec<usize>>,
}

impl Description {
    /// Inputs on which the output with index `output` depends directly at a communication point (`initialization` = false) or in
    /// Initialization Mode.
    ///
    /// There, `InitialUnknowns` count; an output they leave out is taken by its dependencies at communication points, or is given
    /// (`initial="exact"`) and depends on nothing.
    pub fn feedthrough(&self, output: usize, initialization: bool) -> Vec<usize> {
        // FMI 3.0 lists value references, which aliases share.
        let place = |k: usize| (self.variables[k].reference, self.variables[k].element);
        let is_same = |k: usize| match self.fmi {
            Version::Fmi2 => k == output,
            Version::Fmi3 => place(k) == place(output),
        };
        let of = |list: &'_ [Unknown]| list.iter().position(|u| is_same(u.variable));
        let always = || of(&self.outputs).map(|k| &self.outputs[k]);
        let initially = || of(&self.initial_unknowns).map(|k| &self.initial_unknowns[k]);
        let is_given = || self.variables[output].initial == Some(Initial::Exact);
        let unknown = match initialization {
            false => always(),
            true => initially().or_else(|| if is_given() { None } else { always() }),
        };
        let inputs = |k: &usize| self.variables[*k].is_input();
        match unknown.map(|u| &u.dependencies) {
            Some(Some(known)) => known.iter().copied().filter(inputs).collect(),
            Some(None) => (0..self.variables.len()).filter(inputs).collect(),
            None => Vec::new(),
        }
    }
}
