//! Tables of variables, written by hand and by derives: what they become, and how each mistake in
//! one is named.
#![allow(missing_docs)]

/// What a model does whose table alone is looked at: nothing.
macro_rules! idle_model {
    () => {
        fn initialize(_p: &Parameters, _u: &Input, _t: f64) -> Result<Self, ModelError> {
            Ok(Self)
        }

        fn output(&self, _p: &Parameters, _u: &Input, _now: &()) -> Result<Output, ModelError> {
            Ok(Output::default())
        }

        fn step(
            &mut self,
            _p: &Parameters,
            _u: &InputPolynomial<Input>,
            _now: &(),
            _t: f64,
            _h: f64,
        ) -> Result<StepEnd, ModelError> {
            Ok(StepEnd::WHOLE)
        }
    };
}

mod check;
mod clocked;
mod compile_fail;
mod derive;
mod described;
mod hash;
mod ode;
mod table;
