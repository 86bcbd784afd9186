//! [`Work`]: what an `ExchangeInstance` integrates and tracks, and how that is saved.

use anyhow::{Result, ensure};
use fmu_solver::{Integrator, TOLERANCE};
use serde::{Deserialize, Serialize};

use super::crowding::Crowding;
use super::equations::Sides;
use super::integrals::Integrals;
use super::plan::ExchangePlan;
use super::ramp::Ramp;
use super::start::BEYOND;

/// What is integrated, and its workspace.
pub(super) struct Work {
    pub integrator: Integrator,
    pub tolerance: f64,
    /// Indicators.
    pub z: Vec<f64>,
    pub ramps: Vec<Ramp>,
    pub integrals: Integrals,
    pub tracked: Tracked,
}

/// What is tracked of an instance, and saved with the state of its FMU.
#[derive(Clone, Deserialize, Serialize)]
pub(super) struct Tracked {
    /// Present time and time of the next time event, s.
    pub time: f64,
    pub next: f64,
    pub x: Vec<f64>,
    pub sides: Sides,
    /// Bits of the last value of each variable that was set.
    pub given: Vec<Option<u64>>,
    /// An input has another value than in the last step, or there was no step.
    pub is_changed: bool,
    pub is_started: bool,
    pub is_initialized: bool,
    pub is_in_event_mode: bool,
    pub crowding: Crowding,
    pub evaluations: u64,
    pub events: u64,
    pub stiff_since: Option<f64>,
    /// Means over the last step of the outputs that the plan names; NaN before the first step.
    pub means: Vec<f64>,
}

#[derive(Clone, Deserialize, Serialize)]
pub(super) struct SavedWork {
    pub tracked: Tracked,
    pub integrator: Vec<f64>,
    /// Start, values and rates of inputs that change.
    pub ramps: Vec<(f64, Vec<f64>, Vec<f64>)>,
}

impl Work {
    pub fn new(plan: &ExchangePlan) -> Self {
        let [n, indicators] = [plan.states, plan.indicators];
        // With room for what an FMU writes too much, before that is found.
        let zeros = |n: usize| {
            let mut zeros = Vec::with_capacity(n + BEYOND);
            zeros.resize(n, 0.0);
            zeros
        };
        Self {
            integrator: Integrator::new(
                plan.choice,
                vec![1.0; n],
                indicators,
                plan.pattern.clone(),
                1.0,
            ),
            tolerance: TOLERANCE,
            z: zeros(indicators),
            ramps: plan.followed.iter().map(Ramp::of_plan).collect(),
            integrals: Integrals::new(plan.means.as_ref()),
            tracked: Tracked {
                time: f64::NAN,
                next: f64::INFINITY,
                x: zeros(n),
                sides: Sides {
                    thresholds: vec![0.0; indicators],
                    largest: vec![0.0; indicators],
                },
                given: vec![None; plan.is_continuous.len()],
                is_changed: false,
                is_started: false,
                is_initialized: false,
                is_in_event_mode: false,
                crowding: Crowding::default(),
                evaluations: 0,
                events: 0,
                stiff_since: None,
                means: vec![f64::NAN; plan.means.as_ref().map_or(0, |m| m.1.len())],
            },
        }
    }

    pub fn save(&self) -> SavedWork {
        let ramps = self.ramps.iter();
        SavedWork {
            tracked: self.tracked.clone(),
            integrator: self.integrator.state(),
            ramps: ramps
                .map(|r| (r.start, r.values.clone(), r.rates.clone()))
                .collect(),
        }
    }

    pub fn restore(&mut self, saved: &SavedWork) -> Result<()> {
        let fits = saved.ramps.len() == self.ramps.len()
            && saved.tracked.given.len() == self.tracked.given.len();
        ensure!(
            fits && self.integrator.set_state(&saved.integrator),
            "a state of another run"
        );
        self.tracked.clone_from(&saved.tracked);
        for (ramp, (start, values, rates)) in self.ramps.iter_mut().zip(&saved.ramps) {
            ramp.start = *start;
            ramp.values.clone_from(values);
            ramp.rates.clone_from(rates);
        }
        Ok(())
    }
}
