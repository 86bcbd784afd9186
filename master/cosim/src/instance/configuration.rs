//! Structural parameters of an instance, on which the sizes of its arrays depend: set in
//! Configuration Mode when the instance is made, refused at any other time.

use std::collections::BTreeSet;

use anyhow::{Context, Result, bail, ensure};
use fmi_description::Variable;
use fmi_import::messages;
use fmi_import::value::Value;

use super::{At, Call, Instance};

impl Instance {
    /// Sets the structural parameters that its FMU was given other values for. What the resized
    /// arrays then hold is read, because FMI 3.0 passes whole arrays even where some elements alone
    /// are set. The standard leaves these values open, so an FMU may refuse to tell them.
    pub(super) fn configure(&mut self) -> Result<()> {
        if self.fmu.configuration.is_empty() {
            return Ok(());
        }
        let at = At::Initialization;
        self.call(Call::EnterConfiguration, at)?;
        for (variable, value) in &self.fmu.configuration {
            let set = self.set_whole(
                &self.fmu.any_batch(vec![*variable]),
                std::slice::from_ref(value),
                at,
            );
            let name = &self.fmu.description.variables[*variable].name;
            set.with_context(|| format!("{}.{name} = {value} in Configuration Mode", self.name))?;
        }
        self.call(Call::ExitConfiguration, at)?;
        for (k, batch) in self.fmu.resized.iter().enumerate() {
            let mut values = vec![Value::empty(batch.access); batch.len()];
            if self.fmi.get_values(batch, &mut values).is_err() {
                messages::reasons(&self.name);
                self.untold.push(k);
            }
        }
        Ok(())
    }

    /// Refuses start values of some elements of an array, `given` by index, whose others are
    /// unknown.
    pub(crate) fn check_given_elements(&self, given: &BTreeSet<usize>) -> Result<()> {
        for k in &self.untold {
            let elements = &self.fmu.resized[*k].variables;
            let count = elements.iter().filter(|element| given.contains(element)).count();
            let first = &self.fmu.description.variables[elements[0]].name;
            ensure!(
                count == 0 || count == elements.len(),
                "`{}.{first}` and the other elements of its array: {count} of {} have start values, but the FMU does not tell those of the others at this size; give all of them",
                self.name,
                elements.len()
            );
        }
        Ok(())
    }

    /// Refuses another value of a structural parameter than it has.
    #[cold]
    pub(super) fn check_configuration(&self, v: &Variable, value: &Value, text: &str) -> Result<()> {
        let own = v.start_of(0).and_then(|own| Value::parse(v.access(), own));
        if own.as_ref() == Some(value) {
            return Ok(());
        }
        bail!(
            "`{}.{}` = {text}: a structural parameter has its value, here {}, from before the run on, because the sizes of arrays depend on it; it is given with the start values (--set, a parameter set, the settings of a script or page)",
            self.name,
            v.name,
            v.start_of(0).unwrap_or("its start value")
        )
    }
}
