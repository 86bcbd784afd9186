//! Which states derivatives belong to, and which inputs outputs depend on (`ModelStructure`; FMI
//! 2.0, section 2.2.8; FMI 3.0, section 2.4.8), for the call order of the master and for the check.

use crate::description::{Description, Version};
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
    pub fn declared_feedthrough(&self, output: usize, initialization: bool) -> Option<Vec<usize>> {
        let known = self.dependence(output, initialization)?.iter().copied();
        Some(known.filter(|k| self.variables[*k].is_input()).collect())
    }

    /// The variables on which the output with index `output` depends directly, as far as they are
    /// inputs; None if nothing is declared, which means on all inputs.
    ///
    /// In Initialization Mode `InitialUnknowns` count. An output that they do not list has its
    /// dependencies at communication points, or none if it is given (`initial="exact"`). A variable
    /// that is no output depends on nothing unless it is listed.
    pub fn dependence(&self, output: usize, initialization: bool) -> Option<&[usize]> {
        let initially = initialization
            .then(|| self.initial_unknown(output))
            .flatten();
        let is_given = self.variables[output].initial == Some(Initial::Exact);
        if initialization && initially.is_none() && is_given {
            return Some(&[]);
        }
        match initially.or_else(|| self.output(output)) {
            Some(unknown) => unknown.dependencies.as_deref(),
            None if self.variables[output].causality == Causality::Output => None,
            None => Some(&[]),
        }
    }
}
