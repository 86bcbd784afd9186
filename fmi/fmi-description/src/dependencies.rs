//! Which states derivatives belong to, and which inputs outputs depend on (`ModelStructure`; FMI
//! 2.0, section 2.2.8; FMI 3.0, section 2.4.8), for the call order of the master and for the check.

use crate::description::{Description, Unknown, Version};
use crate::variable::{Causality, Initial};

impl Description {
    /// The continuous state of which a variable is the derivative.
    pub fn state_of(&self, derivative: usize) -> Option<usize> {
        let number = self.variables[derivative].derivative?;
        match self.fmi {
            Version::Fmi2 => (number as usize)
                .checked_sub(1)
                .filter(|k| *k < self.variables.len()),
            Version::Fmi3 => self.variables.iter().position(|v| v.reference == number),
        }
    }

    /// The inputs on which the output with index `output` depends directly, at communication points
    /// or in `initialization`; all inputs if [nothing is declared](Self::declared_feedthrough).
    pub fn feedthrough(&self, output: usize, initialization: bool) -> Vec<usize> {
        let declared = self.declared_feedthrough(output, initialization);
        declared.unwrap_or_else(|| {
            let all = 0..self.variables.len();
            all.filter(|k| self.variables[*k].is_input()).collect()
        })
    }

    /// As [`Self::feedthrough`], but None if the description does not declare it: `ModelStructure`
    /// lists the output without `dependencies`, or not at all.
    ///
    /// In Initialization Mode `InitialUnknowns` count. An output that they do not list has its
    /// dependencies at communication points, or none if it is given (`initial="exact"`). A variable
    /// that is no output depends on nothing unless it is listed.
    pub fn declared_feedthrough(&self, output: usize, initialization: bool) -> Option<Vec<usize>> {
        let entry =
            |list: &'_ [Unknown]| list.iter().position(|u| self.is_same(u.variable, output));
        let initially = entry(&self.initial_unknowns).map(|k| &self.initial_unknowns[k]);
        let initially = initially.filter(|_| initialization);
        let is_given = self.variables[output].initial == Some(Initial::Exact);
        if initialization && initially.is_none() && is_given {
            return Some(Vec::new());
        }
        let always = || entry(&self.outputs).map(|k| &self.outputs[k]);
        let Some(unknown) = initially.or_else(always) else {
            let is_output = self.variables[output].causality == Causality::Output;
            return (!is_output).then(Vec::new);
        };
        let known = unknown.dependencies.as_ref()?.iter().copied();
        Some(known.filter(|k| self.variables[*k].is_input()).collect())
    }

    /// Whether one entry of `ModelStructure` is about both variables: in FMI 3.0 aliases share
    /// entries.
    pub(crate) fn is_same(&self, one: usize, other: usize) -> bool {
        let place = |k: usize| (self.variables[k].reference, self.variables[k].element);
        match self.fmi {
            Version::Fmi2 => one == other,
            Version::Fmi3 => place(one) == place(other),
        }
    }
}
