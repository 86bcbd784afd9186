//! FMU `DcLink` for Co-Simulation and Model Exchange in FMI 2.0 and 3.0: battery pack, capacitor,
//! precharge and brake chopper, for the system `Electric.ssd` and for any importer. This file
//! connects the table of variables (`table`) to the `dclink` library.
#![allow(non_snake_case)] // symbols of the books

mod model;
mod table;

use dclink::{DcLink, Input, Output, Params};
use fmu_export::{
    Continuous, Event, Info, InputPolynomial, Log, Model, ModelError, ModelExchange, StepEnd,
    Variable,
};
use model::DcLinkFmu;

impl Model for DcLinkFmu {
    type Parameters = Params;
    type Input = Input;
    type Output = Output;
    type Evaluation = ();
    const INFO: Info = table::INFO;
    const MODEL_EXCHANGE: Option<ModelExchange<Self>> = ModelExchange::from_continuous();

    fn variables() -> &'static [Variable<Self>] {
        table::VARIABLES
    }

    fn defaults() -> (Params, Input) {
        let u = Input {
            T_ambient: table::ROOM_TEMPERATURE,
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
            seen: None,
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
        let before = self.state;
        let after = self.link.step(&before, u.value(), t, h)?;
        self.warn(u.value(), &before, &after, t + h);
        self.state = after;
        Ok(StepEnd::WHOLE)
    }

    fn log(&mut self) -> Option<&mut Log> {
        Some(&mut self.log)
    }
}

impl Continuous for DcLinkFmu {
    const INDICATORS: &'static [Variable<Self>] = table::INDICATORS;

    fn derivative_rows() -> &'static [Variable<Self>] {
        table::DERIVATIVES
    }

    fn states(&self, x: &mut [f64]) {
        let (s, e) = (&self.state, &self.state.energy);
        let [v_1, v_2] = s.v;
        x.copy_from_slice(&[
            s.soc, v_1, v_2, s.v_c, s.T, e.battery, e.load, e.brake, e.loss,
        ]);
    }

    fn set_states(&mut self, x: &[f64]) {
        let s = &mut self.state;
        (s.soc, s.v, s.v_c, s.T) = (x[0], [x[1], x[2]], x[3], x[4]);
        let e = &mut s.energy;
        (e.battery, e.load, e.brake, e.loss) = (x[5], x[6], x[7], x[8]);
    }

    fn derivatives(
        &self,
        _p: &Params,
        u: &Input,
        _now: &(),
        _t: f64,
        dx: &mut Self,
    ) -> Result<(), ModelError> {
        dx.state = self.link.derivative(&self.state, u);
        Ok(())
    }

    fn indicators(
        &self,
        _p: &Params,
        u: &Input,
        _now: &(),
        _t: f64,
        z: &mut [f64],
    ) -> Result<(), ModelError> {
        z.copy_from_slice(&self.link.mode_ends(&self.state, u));
        Ok(())
    }

    fn event(&mut self, p: &Params, u: &Input, t: f64) -> Result<Event, ModelError> {
        self.state = self.link.with_current_mode(&self.state, u);
        self.completed_step(p, u, t)?;
        Ok(Event::NONE)
    }

    fn completed_step(&mut self, _p: &Params, u: &Input, t: f64) -> Result<bool, ModelError> {
        // in Model Exchange there is no step to take the mean over: the mean is the value
        self.state.v_mean = self.state.v_c;
        let after = self.state;
        if let Some(before) = self.seen.replace(after) {
            self.warn(u, &before, &after, t);
        }
        Ok(false)
    }
}

#[cfg(not(test))] // tests need no C functions, which take longest to compile
fmu_export::export_fmu!(DcLinkFmu);

#[cfg(test)]
mod tests {
    use super::*;

    /// Every accessor works, and the declared dependencies are those found by varying the inputs.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<DcLinkFmu>(), [""; 0]);
    }
}
