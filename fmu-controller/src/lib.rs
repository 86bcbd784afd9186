//! FMU `Controller` for co-simulation in FMI 2.0 and 3.0: the adaptive modular controller of the
//! manipulator, for the shipped systems and any importer.
//!
//! This file connects the table of variables (`table`) to the `vdc` library.
#![allow(non_snake_case)] // the paper's symbols

mod enumerations;
mod files;
mod model;
mod table;

use fmu_export::{Info, InputPolynomial, Model, ModelError, StepEnd, Variable};
pub use model::{ControllerFmu, Input, Parameters};
use table::{INFO, VARIABLES};
use vdc::{Controller, Derating, Evaluation, Output, ReportedWarnings};

impl fmu_export::Evaluation<ControllerFmu> for Evaluation {
    fn new(model: &ControllerFmu, p: &Parameters, u: &Input) -> Result<Self, ModelError> {
        Ok(model.controller.evaluate(&p.settings()?, &u.measured())?)
    }
}

impl Model for ControllerFmu {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = Evaluation;
    const INFO: Info = INFO;

    fn variables() -> &'static [Variable<Self>] {
        VARIABLES
    }

    fn defaults() -> (Parameters, Input) {
        let parameters = Parameters::reference();
        let input = Input::at_start(&parameters.machine);
        (parameters, input)
    }

    fn initialize(p: &Parameters, u: &Input, t: f64) -> Result<Self, ModelError> {
        if p.derated.start >= p.derated.end {
            let Derating { start, end } = p.derated;
            return Err(ModelError::new(format!(
                "`derating.start` = {start} K must be below `derating.end` = {end} K"
            )));
        }
        let (settings, measured) = (p.settings()?, u.measured());
        let (machine, network, path) = (&p.machine, &p.surrogate, p.trajectory()?);
        let controller = Controller::new(machine, network, path, &settings, &measured, t);
        let controller = controller.map_err(|error| p.refusal(error))?;
        let controller = controller.with_timing(p.timing()?);
        let mut fmu = Self {
            controller,
            reported: ReportedWarnings::default(),
            warning: None,
        };
        fmu.warning = fmu.stability_warning(p);
        Ok(fmu)
    }

    fn tune(&mut self, p: &Parameters) -> Result<(), ModelError> {
        p.machine.controller.check()?;
        self.warning = self.stability_warning(p);
        Ok(())
    }

    fn output(&self, _p: &Parameters, u: &Input, now: &Evaluation) -> Result<Output, ModelError> {
        Ok(now.output(&u.u.F))
    }

    fn step(
        &mut self,
        p: &Parameters,
        u: &InputPolynomial<Input>,
        now: &Evaluation,
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        // A sampled controller: it uses the measurements of the communication point.
        let settings = p.settings()?;
        let measured = u.value().measured();
        self.controller.step(now, &settings, &measured, t, h)?;
        let warning = self
            .controller
            .next_warning(now, &settings, &mut self.reported, t, h);
        self.warning = warning.map(|warning| warning.to_string());
        Ok(StepEnd::WHOLE)
    }

    fn take_warning(&mut self) -> Option<String> {
        self.warning.take()
    }
}

#[cfg(not(test))] // tests need no C functions, which take longest to compile
fmu_export::export_fmu!(ControllerFmu);

#[cfg(test)]
mod tests {
    use super::*;

    /// Every accessor works, and the declared dependencies are those found by varying the inputs.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<ControllerFmu>(), [""; 0]);
    }
}
