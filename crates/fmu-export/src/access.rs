//! Setting and getting variables. A batch is checked completely before anything is written.

use crate::Model;
use crate::calls::Mode;
use crate::failure::Failure;
use crate::instance::{Instance, warn};
use crate::log::c_string;
use crate::value::{Value, allowed};
use crate::variable::{Causality, Place, Variable};
use std::ffi::CString;
use std::fmt::Display;

impl<M: Model> Instance<M> {
    /// fmi2SetReal, fmi2SetInteger, fmi2SetBoolean.
    #[inline]
    pub(crate) fn set<T: Value>(&mut self, vr: &[u32], values: &[T::C]) -> Result<(), Failure> {
        let mut parameters = false;
        for (&vr, &value) in vr.iter().zip(values) {
            let (i, row) = self.layout.find(vr)?;
            let value = T::from_c(value);
            parameters |= match (T::input(&row.place), T::parameter(&row.place)) {
                (Some(_), _) => false,
                (_, Some(_)) if row.tunable || self.state.mode != Mode::StepComplete => true,
                _ => return Err(self.not_settable(row, i, value, T::TYPE)),
            };
            if !value.is_allowed(row) {
                return Err(not_allowed(row, i, value));
            }
        }
        if parameters {
            self.set_parameters::<T>(vr, values)?;
            self.touch(true);
        }
        // Nothing is out of date if an input is set to what it is.
        let (mut is_changed, mut is_evaluated) = (false, false);
        for (&vr, &value) in vr.iter().zip(values) {
            let (i, row) = self.layout.find(vr)?;
            if let Some(place) = T::input(&row.place) {
                let mut changed = self.state.set_input(place, i, T::from_c(value));
                if let Some(counter) = row.counter {
                    self.state.count_set(counter);
                    changed = true;
                }
                is_changed |= changed;
                is_evaluated |= changed && !row.beside_evaluation;
            }
        }
        if is_changed {
            self.touch(is_evaluated);
        }
        Ok(())
    }

    /// Writes the parameters of a checked batch, and tells a running model.
    fn set_parameters<T: Value>(&mut self, vr: &[u32], values: &[T::C]) -> Result<(), Failure> {
        let mut parameters = self.state.parameters.clone();
        for (&vr, &value) in vr.iter().zip(values) {
            let (i, row) = self.layout.find(vr)?;
            if let Some(place) = T::parameter(&row.place) {
                *place.get_mut(&mut parameters, i) = T::from_c(value);
            }
        }
        if let (Mode::StepComplete, Some(model)) = (self.state.mode, &mut self.state.model) {
            model.tune(&parameters)?;
            warn(&self.log, model);
        }
        self.state.parameters = parameters;
        for &vr in vr {
            let (_, row) = self.layout.find(vr)?;
            self.state.explicit[vr as usize] |= row.causality == Causality::Parameter;
        }
        Ok(())
    }

    #[cold]
    fn not_settable(
        &self,
        row: &Variable<M>,
        i: usize,
        value: impl Display,
        given: &str,
    ) -> Failure {
        let (name, kind) = (row.element_name(i), row.kind());
        let reason = match row.causality {
            Causality::Output | Causality::Local => {
                "cannot be set; allowed are inputs and parameters".to_owned()
            }
            _ if row.place.type_name() != given => {
                format!(
                    "cannot be set as {given}; allowed is fmi2Set{}",
                    row.place.type_name()
                )
            }
            _ => "cannot be set any more; allowed until fmi2ExitInitializationMode".to_owned(),
        };
        Failure::Error(format!("`{name}` = {value}: {kind} {reason}"))
    }

    /// fmi2GetReal, fmi2GetInteger, fmi2GetBoolean.
    #[inline]
    pub(crate) fn get<T: Value>(&mut self, vr: &[u32], values: &mut [T::C]) -> Result<(), Failure> {
        for (&vr, slot) in vr.iter().zip(values) {
            let (i, row) = self.layout.find(vr)?;
            let value = if let Some(place) = T::output(&row.place) {
                self.refresh()?;
                place.get(&self.output, i)
            } else if let Some(place) = T::input(&row.place) {
                place.get(&self.state.input.value, i)
            } else if let Some(place) = T::parameter(&row.place) {
                place.get(&self.state.parameters, i)
            } else {
                return Err(not_gettable(row, i, T::TYPE));
            };
            if !value.is_finite() {
                return Err(not_finite(row, i, value));
            }
            *slot = value.to_c();
        }
        Ok(())
    }

    /// fmi2SetString: builds all parameters anew, so that the order of setting does not matter: defaults, then every text
    /// the importer has set, then every number it has set.
    pub(crate) fn set_string(&mut self, vr: &[u32], values: &[&str]) -> Result<(), Failure> {
        let mut texts: Vec<Option<String>> = vec![None; self.layout.len()];
        for (known, (_, row)) in self.layout.iter().enumerate() {
            if let Place::StringParameter(get, _) = &row.place
                && self.state.explicit[known]
            {
                texts[known] = Some(get(&self.state.parameters).to_owned());
            }
        }
        for (&vr, value) in vr.iter().zip(values) {
            let (i, row) = self.layout.find(vr)?;
            match row.place {
                Place::StringParameter(..) if self.state.mode != Mode::StepComplete => {
                    texts[vr as usize] = Some((*value).to_owned());
                }
                _ => return Err(self.not_settable(row, i, format!("\"{value}\""), "String")),
            }
        }
        if vr.is_empty() {
            return Ok(());
        }
        let (mut parameters, _) = M::defaults();
        for ((_, row), text) in self.layout.iter().zip(&texts) {
            if let (Place::StringParameter(_, set), Some(text)) = (&row.place, text) {
                let done = set(&mut parameters, text, self.resources.as_deref());
                done.map_err(|e| Failure::Error(format!("`{}` = \"{text}\": {e}", row.name)))?;
            }
        }
        self.copy_explicit(&mut parameters);
        self.state.parameters = parameters;
        for &vr in vr {
            self.state.explicit[vr as usize] = true;
        }
        self.touch(true);
        Ok(())
    }

    /// Copies the numbers the importer has set from the present parameters.
    fn copy_explicit(&self, to: &mut M::Parameters) {
        let from = &self.state.parameters;
        for ((i, row), explicit) in self.layout.iter().zip(&self.state.explicit) {
            match &row.place {
                _ if !explicit => {}
                Place::RealParameter(place) => *place.get_mut(to, i) = place.get(from, i),
                Place::IntegerParameter(place) => *place.get_mut(to, i) = place.get(from, i),
                Place::BooleanParameter(place) => *place.get_mut(to, i) = place.get(from, i),
                _ => {}
            }
        }
    }

    /// fmi2GetString; the texts stay valid until the next call of it.
    pub(crate) fn get_string(&mut self, vr: &[u32]) -> Result<&[CString], Failure> {
        let mut strings = Vec::with_capacity(vr.len());
        for &vr in vr {
            let (i, row) = self.layout.find(vr)?;
            let Place::StringParameter(get, _) = &row.place else {
                return Err(not_gettable(row, i, "String"));
            };
            strings.push(c_string(get(&self.state.parameters)));
        }
        self.strings = strings;
        Ok(&self.strings)
    }
}

#[cold]
fn not_allowed<M: Model>(row: &Variable<M>, i: usize, value: impl Display) -> Failure {
    let (name, allowed) = (row.element_name(i), allowed(row));
    Failure::Error(format!("`{name}` = {value}; allowed are {allowed}"))
}

#[cold]
fn not_finite<M: Model>(row: &Variable<M>, i: usize, value: impl Display) -> Failure {
    let name = row.element_name(i);
    Failure::Error(format!(
        "`{name}` became {value}; allowed are finite values"
    ))
}

#[cold]
fn not_gettable<M: Model>(row: &Variable<M>, i: usize, given: &str) -> Failure {
    let (name, kind, right) = (row.element_name(i), row.kind(), row.place.type_name());
    Failure::Error(format!(
        "`{name}` is {kind} and cannot be read as {given}; allowed is fmi2Get{right}"
    ))
}
