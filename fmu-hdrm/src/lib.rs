//! FMU `Hdrm` for Co-Simulation and Model Exchange in FMI 2.0 and 3.0: the heavy-duty manipulator
//! with both closed loops, for systems in `system` and for any importer.
//!
//! This file connects the table of variables (`table`) to the `hdrm` library.
#![allow(non_snake_case)] // the paper's symbols

mod model;
mod table;

use fmu_export::{
    Continuous, Event, Info, InputPolynomial, Model, ModelError, ModelExchange, StepEnd, Variable,
};
use hdrm::{Dynamics, Hdrm, Output, Slips, State};
pub use model::HdrmFmu;
use model::{Input, Parameters};

impl HdrmFmu {
    /// Plant and state with the load of the inputs.
    fn reloaded(
        &self,
        p: &Parameters,
        u: &Input,
        now: &Dynamics,
        input: &hdrm::Input,
    ) -> Result<(Hdrm, State), ModelError> {
        let own = (!p.load_moves_with_tip).then_some(p.load_velocity);
        Ok((self.plant).change_load(now, &p.load(u), own, input)?)
    }

    /// A step that begins with another load.
    #[cold]
    #[inline(never)]
    fn step_reloaded(
        &mut self,
        p: &Parameters,
        u: &InputPolynomial<Input>,
        now: &Dynamics,
        t: f64,
        h: f64,
    ) -> Result<(), ModelError> {
        let acts = p.push.acts(t);
        let input = p.push.on(u.value().u, acts);
        let (plant, state) = self.reloaded(p, u.value(), now, &input)?;
        let start = plant.dynamics_with(&state, &input);
        self.state = plant.step_from(&start, |s| p.push.on(u.at::<Self>(s).u, acts), t, h)?;
        self.plant = plant;
        Ok(())
    }
}

impl Model for HdrmFmu {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = Dynamics;
    const INFO: Info = table::INFO;
    const MODEL_EXCHANGE: Option<ModelExchange<Self>> = ModelExchange::from_continuous();

    fn variables() -> &'static [Variable<Self>] {
        table::VARIABLES
    }

    fn defaults() -> (Parameters, Input) {
        let parameters = Parameters::new(actuator_table::own_machine(), String::new());
        (parameters, Input::default())
    }

    fn initialize(p: &Parameters, u: &Input, t: f64) -> Result<Self, ModelError> {
        p.check_start()?;
        let state = State {
            zeta: p.zeta_start,
            zeta_dot: p.zeta_dot_start,
            ..State::default()
        };
        let plant = Hdrm::new(&p.machine, &p.options)?.with_load(&p.load(u))?;
        Ok(Self {
            state: plant.start_state(state, &u.u),
            plant,
            is_pushed: p.push.acts(t),
            slips: Slips::default(),
            closes: [None; 3],
        })
    }

    fn output(&self, p: &Parameters, u: &Input, now: &Dynamics) -> Result<Output, ModelError> {
        Ok(self.plant.output_at(now, &p.push.on(u.u, self.is_pushed)))
    }

    fn step(
        &mut self,
        p: &Parameters,
        u: &InputPolynomial<Input>,
        now: &Dynamics,
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        if p.load(u.value()) != *self.plant.load() {
            self.step_reloaded(p, u, now, t, h)?;
        } else {
            let acts = p.push.acts(t);
            let input = |s| p.push.on(u.at::<Self>(s).u, acts);
            self.state = (self.plant).step_from(now, input, t, h)?;
        }
        self.is_pushed = p.push.acts(t + h);
        Ok(StepEnd::WHOLE)
    }

    fn output_derivative(
        &self,
        p: &Parameters,
        u: &Input,
        _now: &Dynamics,
        u_dot: &Input,
    ) -> Result<Output, ModelError> {
        let input = p.push.on(u.u, self.is_pushed);
        Ok(self.plant.output_derivative(&self.state, &input, &u_dot.u))
    }

    fn directional_derivative(
        &self,
        _p: &Parameters,
        u: &Input,
        _now: &Dynamics,
        du: &Input,
    ) -> Result<Output, ModelError> {
        Ok(self.plant.directional_derivative(&self.state, &u.u, &du.u))
    }
}

impl Continuous for HdrmFmu {
    const INDICATORS: &'static [Variable<Self>] = table::INDICATORS;

    fn derivative_rows() -> &'static [Variable<Self>] {
        table::DERIVATIVES
    }

    fn states(&self, x: &mut [f64]) {
        let s = &self.state;
        x[..6].copy_from_slice(&s.zeta);
        x[6..12].copy_from_slice(&s.zeta_dot);
        x[12] = s.contact_loss;
        for (i, drive) in s.wrist.iter().enumerate() {
            [x[13 + i], x[16 + i], x[19 + i]] = drive.moving();
        }
    }

    fn set_states(&mut self, x: &[f64]) {
        let s = &mut self.state;
        s.zeta.copy_from_slice(&x[..6]);
        s.zeta_dot.copy_from_slice(&x[6..12]);
        s.contact_loss = x[12];
        for (i, drive) in s.wrist.iter_mut().enumerate() {
            drive.set_moving([x[13 + i], x[16 + i], x[19 + i]]);
        }
        self.state = self.plant.with_gear_torques(self.state);
    }

    fn derivatives(
        &self,
        p: &Parameters,
        u: &Input,
        now: &Dynamics,
        _t: f64,
        dx: &mut Self,
    ) -> Result<(), ModelError> {
        let input = p.push.on(u.u, self.is_pushed);
        dx.state = self.plant.derivative(now, &input, &self.slips);
        Ok(())
    }

    fn indicators(
        &self,
        _p: &Parameters,
        u: &Input,
        now: &Dynamics,
        _t: f64,
        z: &mut [f64],
    ) -> Result<(), ModelError> {
        z.copy_from_slice(&self.plant.indicators(now, &u.u, &self.slips));
        Ok(())
    }

    fn event(&mut self, p: &Parameters, u: &Input, t: f64) -> Result<Event, ModelError> {
        let acts = p.push.acts(t);
        if p.load(u) != *self.plant.load() {
            let input = p.push.on(u.u, acts);
            let now = self.plant.dynamics_with(&self.state, &input);
            (self.plant, self.state) = self.reloaded(p, u, &now, &input)?;
        }
        let due = |closes: Option<f64>| closes.is_some_and(|closes| t >= closes);
        let passed = (self.closes).map(|closes| if due(closes) { f64::INFINITY } else { 0.0 });
        self.state = self.plant.after_braking(self.state, &u.u, passed);
        let awaited = self.plant.awaited_brakes(&self.state, &u.u);
        for (closes, wait) in self.closes.iter_mut().zip(awaited) {
            *closes = wait.map(|wait| closes.unwrap_or(t + wait));
        }
        (self.state, self.slips) = self.plant.update_slips(self.state, &u.u, &self.slips);
        self.is_pushed = acts;
        let next = self.closes.into_iter().chain([p.push.next(t)]).flatten();
        Ok(next.min_by(f64::total_cmp).map_or(Event::NONE, Event::at))
    }
}

#[cfg(not(test))] // tests need no C functions, which take longest to compile
fmu_export::export_fmu!(HdrmFmu);

#[cfg(test)]
mod tests {
    use super::*;

    /// Every accessor works, and the declared dependencies are those found by varying the inputs.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<HdrmFmu>(), [""; 0]);
    }

    /// A push is the wrench of the same force on the tip, from its start to its end, and nothing
    /// before and after: step by step the same state, to the last bit.
    #[test]
    fn a_push_acts_as_the_wrench_does_for_its_time() {
        let (mut parameters, resting) = HdrmFmu::defaults();
        let step = |fmu: &mut HdrmFmu, p: &Parameters, u: Input, t: f64| {
            let u = InputPolynomial::held(u);
            let now = fmu.plant.dynamics_with(&fmu.state, &u.value().u);
            fmu.step(p, &u, &now, t, 1e-3).expect("free motion");
        };
        let mut pulled = HdrmFmu::initialize(&parameters, &resting, 0.0).expect("valid");
        parameters.push.force = [170.0, -90.0, 240.0];
        (parameters.push.start, parameters.push.duration) = (0.02, 0.03);
        let mut pushed = HdrmFmu::initialize(&parameters, &resting, 0.0).expect("valid");
        let free = HdrmFmu::defaults().0;
        for k in 0..80 {
            let mut u = resting;
            if (20..50).contains(&k) {
                u.u.wrench_env[..3].copy_from_slice(&parameters.push.force);
            }
            let t = f64::from(k) * 1e-3;
            step(&mut pulled, &free, u, t);
            step(&mut pushed, &parameters, resting, t);
            assert_eq!(pushed.state, pulled.state, "{k}");
        }
    }
}
