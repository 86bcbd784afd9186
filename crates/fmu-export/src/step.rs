//! Communication steps and derivatives.

use crate::failure::{Failure, refuse};
use crate::ffi::Status;
use crate::instance::{Instance, warn};
use crate::layout::Layout;
use crate::value::{Value, allowed};
use crate::variable::{Causality, Place};
use crate::{MAX_INPUT_DERIVATIVE, Model, ModelError};

/// Times that differ by less than this part of the step (and their rounding) are the same.
const TIME_TOLERANCE: f64 = 1e-6;

/// Refuses inputs that their derivatives would carry out of their bounds within the step.
fn check_inputs<M: Model>(layout: &Layout<M>, u: &M::Input) -> Result<(), ModelError> {
    for (i, row) in layout.iter() {
        if let Place::RealIn(place) = &row.place
            && !place.get(u, i).is_allowed(row)
        {
            let (name, value, allowed) = (row.element_name(i), place.get(u, i), allowed(row));
            return Err(ModelError::new(format!(
                "the derivatives of `{name}` take it to {value}; allowed are {allowed}"
            )));
        }
    }
    Ok(())
}

/// How far `t` may be from `limit` in a step of `h` and still count as equal, all s.
fn slack(t: f64, limit: f64, h: f64) -> f64 {
    TIME_TOLERANCE * h + 4.0 * f64::EPSILON * t.abs().max(limit.abs())
}

impl<M: Model> Instance<M> {
    /// fmi2DoStep from `t` by `h`, both s.
    #[inline]
    pub(crate) fn do_step(&mut self, t: f64, h: f64) -> Result<(), Failure> {
        self.check_step(t, h)?;
        if let Err(error) = self.advance(t, h) {
            self.last_step = Status::Discard;
            return Err(Failure::Discard(format!("t = {t} s, h = {h} s: {error}")));
        }
        self.state.hold_inputs(h);
        self.state.time = t + h;
        self.last_step = Status::Ok;
        self.evaluation = None;
        self.fresh = false;
        Ok(())
    }

    /// Moves the model on; on error it is where it was.
    #[inline]
    fn advance(&mut self, t: f64, h: f64) -> Result<(), ModelError> {
        self.evaluate()?;
        let state = &mut self.state;
        let with_derivatives = state.input.order > 0 || state.reached.is_some();
        let course = with_derivatives.then(|| state.input_course());
        if let Some(course) = &course {
            check_inputs(&self.layout, &course.at::<M>(h))?;
        }
        let (Some(model), Some(now)) = (&mut state.model, &self.evaluation) else {
            return Err(ModelError::new("the model is not initialized"));
        };
        let course = course.as_ref().unwrap_or(&state.input);
        model.step(&state.parameters, course, now, t, h)?;
        warn(&self.log, model);
        Ok(())
    }

    #[inline]
    fn check_step(&self, t: f64, h: f64) -> Result<(), Failure> {
        let now = self.state.time;
        if !(h.is_finite() && h > 0.0) {
            return refuse!("communicationStepSize = {h} s; allowed are finite values > 0");
        }
        let is_now = t.is_finite() && (t - now).abs() <= slack(t, now, h);
        if !is_now {
            return refuse!(
                "currentCommunicationPoint = {t} s; allowed is the present time {now} s"
            );
        }
        let end = t + h;
        if !(end > t && end.is_finite()) {
            return refuse!(
                "communicationStepSize = {h} s does not move the time {t} s; allowed are larger, finite steps"
            );
        }
        match self.state.stop {
            Some(stop) if end > stop + slack(end, stop, h) => {
                refuse!("the step from {t} s by {h} s passes stopTime; allowed is up to {stop} s")
            }
            _ => Ok(()),
        }
    }

    /// fmi2SetRealInputDerivatives: for the next step only.
    pub(crate) fn set_input_derivatives(
        &mut self,
        vr: &[u32],
        order: &[i32],
        values: &[f64],
    ) -> Result<(), Failure> {
        for ((&vr, &order), &value) in vr.iter().zip(order).zip(values) {
            let (i, row) = self.layout.find(vr)?;
            if !matches!(row.place, Place::RealIn(_)) || row.discrete {
                let (name, kind) = (row.element_name(i), row.kind());
                return refuse!(
                    "`{name}` is {kind} without derivatives; allowed are continuous Real inputs"
                );
            }
            if !(1..=MAX_INPUT_DERIVATIVE as i32).contains(&order) {
                let name = row.element_name(i);
                return refuse!(
                    "`{name}`: order of derivative = {order}; allowed are 1 to {MAX_INPUT_DERIVATIVE}"
                );
            }
            if !value.is_finite() {
                let name = row.element_name(i);
                return refuse!(
                    "`{name}`: derivative of order {order} = {value}; allowed are finite values"
                );
            }
        }
        for ((&vr, &order), &value) in vr.iter().zip(order).zip(values) {
            let (i, row) = self.layout.find(vr)?;
            if let Place::RealIn(place) = &row.place {
                (self.state).set_input_derivative(place, i, order as usize, value);
            }
        }
        Ok(())
    }

    /// fmi2GetRealOutputDerivatives, first order.
    pub(crate) fn output_derivatives(
        &mut self,
        vr: &[u32],
        order: &[i32],
        values: &mut [f64],
    ) -> Result<(), Failure> {
        if !M::INFO.output_derivatives {
            return refuse!("this FMU has no output derivatives (maxOutputDerivativeOrder = 0)");
        }
        for (&vr, &order) in vr.iter().zip(order) {
            let (i, row) = self.layout.find(vr)?;
            if !matches!(row.place, Place::RealOut(_)) || row.causality != Causality::Output {
                let (name, kind) = (row.element_name(i), row.kind());
                return refuse!("`{name}` is {kind}; allowed are Real outputs");
            }
            if order != 1 {
                let name = row.element_name(i);
                return refuse!("`{name}`: order of derivative = {order}; allowed is 1");
            }
        }
        if vr.is_empty() {
            return Ok(());
        }
        self.evaluate()?;
        let (state, (model, now)) = (&self.state, self.evaluated());
        let (p, u, u_dot) = (&state.parameters, state.input(), state.input_slope());
        let y_dot = model.output_derivative(p, u, now, &u_dot)?;
        self.read_outputs(vr, &y_dot, values, "time derivative")
    }

    /// fmi2GetDirectionalDerivative: ∂unknown/∂known · seed at fixed state.
    pub(crate) fn directional_derivative(
        &mut self,
        unknown: &[u32],
        known: &[u32],
        seed: &[f64],
        result: &mut [f64],
    ) -> Result<(), Failure> {
        if !M::INFO.directional_derivatives {
            return refuse!(
                "this FMU has no directional derivatives (providesDirectionalDerivative = false)"
            );
        }
        let mut du = M::Input::default();
        for (&vr, &seed) in known.iter().zip(seed) {
            let (i, row) = self.layout.find(vr)?;
            let Place::RealIn(place) = &row.place else {
                let (name, kind) = (row.element_name(i), row.kind());
                return refuse!("known `{name}` is {kind}; allowed are Real inputs");
            };
            if !seed.is_finite() {
                let name = row.element_name(i);
                return refuse!("known `{name}`: seed = {seed}; allowed are finite values");
            }
            *place.get_mut(&mut du, i) += seed;
        }
        for &vr in unknown {
            let (i, row) = self.layout.find(vr)?;
            if !matches!(row.place, Place::RealOut(_)) {
                let (name, kind) = (row.element_name(i), row.kind());
                return refuse!("unknown `{name}` is {kind}; allowed are Real outputs");
            }
        }
        if unknown.is_empty() {
            return Ok(());
        }
        self.evaluate()?;
        let (state, (model, now)) = (&self.state, self.evaluated());
        let dy = model.directional_derivative(&state.parameters, state.input(), now, &du)?;
        self.read_outputs(unknown, &dy, result, "directional derivative")
    }

    /// Reads Real outputs, already checked to be such, from `from`.
    fn read_outputs(
        &self,
        vr: &[u32],
        from: &M::Output,
        to: &mut [f64],
        what: &str,
    ) -> Result<(), Failure> {
        for (&vr, slot) in vr.iter().zip(to) {
            let (i, row) = self.layout.find(vr)?;
            if let Place::RealOut(place) = &row.place {
                let value = place.get(from, i);
                if !value.is_finite() {
                    let name = row.element_name(i);
                    return refuse!("{what} of `{name}` became {value}; allowed are finite values");
                }
                *slot = value;
            }
        }
        Ok(())
    }
}
