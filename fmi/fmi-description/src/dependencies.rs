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
        let Dependence::On(known) = self.dependence(output, initialization) else {
            return None;
        };
        let known = known.iter().copied();
        Some(known.filter(|k| self.variables[*k].is_input()).collect())
    }

    /// What the output with index `output` depends on directly.
    ///
    /// In Initialization Mode `InitialUnknowns` count. An output that they do not list has its
    /// dependencies at communication points, or none if it is given (`initial="exact"`). A variable
    /// that is no output depends on nothing unless it is listed.
    pub fn dependence(&self, output: usize, initialization: bool) -> Dependence<'_> {
        let initially = match initialization {
            true => self.initial_unknown(output),
            false => None,
        };
        let is_given = self.variables[output].initial == Some(Initial::Exact);
        if initialization && initially.is_none() && is_given {
            return Dependence::On(&[]);
        }
        let Some(unknown) = initially.or_else(|| self.output(output)) else {
            return match self.variables[output].causality {
                Causality::Output => Dependence::Undeclared,
                _ => Dependence::On(&[]),
            };
        };
        match &unknown.dependencies {
            Some(known) => Dependence::On(known),
            None => Dependence::Undeclared,
        }
    }
}

/// What an output depends on directly.
#[derive(Clone, Copy, Debug)]
pub enum Dependence<'a> {
    /// Nothing is declared: on all inputs.
    Undeclared,
    /// On those of these variables that are inputs.
    On(&'a [usize]),
}
