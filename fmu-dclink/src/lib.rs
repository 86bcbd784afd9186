//! FMU `DcLink` for co-simulation in FMI 2.0 and 3.0: battery pack, capacitor, precharge and brake
//! chopper.
//!
//! `table` is the single source of names, units, bounds and dependencies; this file connects it to
//! the `dclink` library.
#![allow(non_snake_case)] // symbols of the books

mod model;
mod table;

use dclink::{DcLink, Input, Output, Params};
use fmu_export::{Info, InputPolynomial, Log, Model, ModelError, StepEnd, Variable};
use model::DcLinkFmu;

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
