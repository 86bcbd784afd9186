//! FMI 2.0 co-simulation FMU `DcLink`: battery pack, capacitor, precharge and brake chopper.
//!
//! `table` is the single source of names, units, bounds and dependencies; this file connects it to the `dclink` library.
#![allow(non_snake_case)] // symbols of the books

mod table;

use dclink::{DcLink, Input, Output, Params, Regime, State};
use fmu_export::{Info, InputPolynomial, Log, Model, ModelError, StepEnd, Variable};
use serde::{Deserialize, Serialize};

/// The link behind the FMI border.
#[derive(Clone, Serialize, Deserialize)]
pub struct DcLinkFmu {
    link: DcLink,
    state: State,
    log: Log,
}

impl DcLinkFmu {
    /// Warn of what the step has brought.
    fn warn(&mut self, u: &Input, after: &State, t: f64) {
        let (before, Params { v_min, v_max, .. }) = (&self.state, *self.link.params());
        let now = self.link.output(after);
        let (v, i, soc) = (now.v_dc, now.i_battery, now.soc);
        let load = u.load();
        let discharges = |s: &State| s.mode.ready && s.mode.regime == Regime::Discharging;
        if discharges(after) && !discharges(before) && load > i {
            self.log.warning(
                "",
                format_args!("t = {t} s: the pack gives no more than {i:.4} A at soc = {soc:.4}, the drives draw {load:.4} A: v_dc falls"),
            );
        }
        if now.undervoltage && before.v_c >= v_min {
            self.log.warning(
                "",
                format_args!(
                    "t = {t} s: undervoltage, v_dc = {v:.2} V must be at least v_min = {v_min} V; the pack gives {i:.4} A at soc = {soc:.4}, \
                     the drives draw {load:.4} A"
                ),
            );
        }
        if v > v_max && before.v_c <= v_max {
            self.log.warning(
                "",
                format_args!(
                    "t = {t} s: overvoltage, v_dc = {v:.2} V must be at most v_max = {v_max} V; the drives give back {:.4} A, the pack takes \
                     {:.4} A and the brake resistor {:.0} W",
                    -load, -i, now.P_brake
                ),
            );
        }
    }
}

impl Model for DcLinkFmu {
    type Parameters = Params;
    type Input = Input;
    type Output = Output;
    type Evaluation = ();
    const INFO: Info = table::INFO;

    fn variables() -> &'static [Variable<Self>] {
        table::VARIABLES
    }

    fn defaults() -> (Params, Input) {
        let u = Input {
            T_ambient: table::ROOM,
            ..Input::default()
        };
        (Params::REFERENCE, u)
    }

    fn initialize(p: &Params, u: &Input, _t: f64) -> Result<Self, ModelError> {
        let link = DcLink::new(*p)?;
        Ok(Self {
            state: link.start(u),
            link,
            log: Log::default(),
        })
    }

    fn output(&self, _p: &Params, _u: &Input, _now: &()) -> Result<Output, ModelError> {
        Ok(self.link.output(&self.state))
    }

    fn step(
        &mut self,
        _p: &Params,
        u: &InputPolynomial<Input>,
        _now: &(),
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        let after = self.link.step(&self.state, u.value(), t, h)?;
        self.warn(u.value(), &after, t + h);
        self.state = after;
        Ok(StepEnd::WHOLE)
    }

    fn log(&mut self) -> Option<&mut Log> {
        Some(&mut self.log)
    }
}

fmu_export::export_fmu!(DcLinkFmu);

#[cfg(test)]
mod tests {
    use super::*;

    /// Accessors, and dependencies against trying.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<DcLinkFmu>(), [""; 0]);
    }
}
