//! The alarms of a structure on the variables of a loaded `System`, for `run::alarms`.

use anyhow::{Context, Result, ensure};
use fmi_description::Access;

use super::System;
use crate::io::numbers;
use crate::structure::arrays;
use crate::wiring::Port;

impl System {
    /// Whether the structure declares an alarm on a variable.
    pub fn has_alarm(&self, port: Port) -> bool {
        self.alarms.iter().any(|(own, ..)| *own == port)
    }

    /// Finds the variables of the alarms. One on a variable that an FMU lacks is refused, but left
    /// out with a remark for components whose FMU is `given` instead of the structure's.
    pub(super) fn find_alarms(&mut self, given: impl Fn(&str) -> bool) -> Result<()> {
        for alarm in std::mem::take(&mut self.structure.alarms) {
            let on = || format!("{}: alarm on `{}`", alarm.place, alarm.name);
            let split = self.structure.split(&alarm.name);
            let (k, variable) = split.with_context(|| {
                let all = self.structure.component_names();
                format!("{}, of none of the components {all}", on())
            })?;
            let arrays = arrays::elements(&self.fmus[k]);
            let names = arrays.get(variable).map_or(&[][..], Vec::as_slice);
            let mut names: Vec<String> = names.iter().map(ToString::to_string).collect();
            if names.is_empty() {
                names.push(variable.to_string());
            }
            let component = &self.structure.components[k].name;
            if self.port_of(k, &names[0]).is_err() && given(component) {
                let remark = format!("{} left out: the FMU given for it lacks it", on());
                self.structure.remarks.push(remark);
                continue;
            }
            for name in names {
                let port = self.port_of(k, &name).with_context(on)?;
                // What a value is compared with may lie outside its range.
                let mut free = self.variable(port).clone();
                (free.min, free.max) = (None, None);
                ensure!(free.access().is_number(), "{}, which is no number", on());
                let mut bound = numbers::number(&free, &alarm.bound).with_context(on)?;
                if free.access() == Access::Float32 {
                    bound = f64::from(bound as f32);
                }
                self.alarms.push((port, bound, alarm.clone()));
            }
        }
        Ok(())
    }
}
