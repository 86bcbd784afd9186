//! Structural parameters of an instance, on which the sizes of its arrays depend: set in
//! Configuration Mode when the instance is made, refused at any other time.

use std::collections::BTreeSet;

use anyhow::{Context, Result, bail, ensure};
use fmi_description::Variable;
use fmi_import::messages;
use fmi_import::value::Value;

use super::{At, Call, Instance};

impl Instance {
    /// Sets the structural parameters that its FMU was given other values for.
    pub(super) fn configure(&self) -> Result<()> {
        if self.fmu.configuration.is_empty() {
            return Ok(());
        }
        self.call(Call::EnterConfiguration, At::Initialization)?;
        for (variable, value) in &self.fmu.configuration {
            let batch = self.fmu.any_batch(vec![*variable]);
            let set = self.set_whole(&batch, std::slice::from_ref(value), At::Initialization);
            let name = &self.fmu.description.variables[*variable].name;
            set.with_context(|| format!("{}.{name} = {value} in Configuration Mode", self.name))?;
        }
        (self.call(Call::ExitConfiguration, At::Initialization)).map(drop)
    }

    /// Reads what resized arrays hold of which not all elements are `given`, by index: FMI 3.0
    /// passes whole arrays even where some elements alone are set. The standard leaves these values
    /// open, so an FMU may refuse.
    pub(crate) fn read_resized(&self, given: &BTreeSet<usize>) -> Result<()> {
        for batch in &self.fmu.resized {
            let all = &batch.variables;
            let count = all.iter().filter(|element| given.contains(element)).count();
            let mut values = vec![Value::empty(batch.access); batch.len()];
            if count == all.len() || self.fmi.get_values(batch, &mut values).is_ok() {
                continue;
            }
            messages::reasons(&self.name);
            ensure!(
                count == 0,
                "`{}.{}` and the other elements of its array: {count} of {} have start values, but the FMU does not tell those of the others at this size; give all of them",
                self.name,
                self.fmu.description.variables[all[0]].name,
                all.len()
            );
        }
        Ok(())
    }

    /// Refuses another value of a structural parameter than it has.
    #[cold]
    pub(super) fn check_configuration(
        &self,
        v: &Variable,
        value: &Value,
        text: &str,
    ) -> Result<()> {
        let own = v.start_of(0).unwrap_or("its start value");
        if Value::parse(v.access(), own).as_ref() == Some(value) {
            return Ok(());
        }
        bail!(
            "`{}.{}` = {text}: a structural parameter has its value, here {own}, from before the run on, because the sizes of arrays depend on it; it is given with the start values (--set, a parameter set, the settings of a script or page)",
            self.name,
            v.name
        )
    }
}
