//! Inertias of the bodies: nominal values including a known load, and adapted estimates with
//! bounds. Control laws use and adapt them; `controller` sets the load and weighs the payload.

mod estimate;
mod payload;

pub(crate) use estimate::{Bounds, Estimate, adaptation_direction};
pub(crate) use payload::{HookModel, HookReadings, Weighing};

use crate::error::ControllerError;
use hdrm::{BODIES, Body};
use machine_file::Machine;
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use spatial::Inertia;
use tip_path::Load;

/// Inertias of all bodies, in the order of [`BODIES`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Bodies {
    /// Nominal inertias about each body's frame origin.
    pub(crate) nominal: [Inertia; Body::COUNT],
    pub(crate) bounds: [Bounds; Body::COUNT],
    pub(crate) estimates: [Estimate; Body::COUNT],
    /// Lower and upper bound of an inverse pseudo-inertia over its nominal value.
    inverse_bounds: [f64; 2],
    /// Known load of the end-effector in addition to the payload.
    load: Load,
    payload: Inertia,
    weighing: Weighing,
}

impl Bodies {
    /// Inertias of `machine`; the estimates start at the nominal values.
    pub(crate) fn new(
        machine: &Machine,
        inverse_bounds: [f64; 2],
    ) -> Result<Self, ControllerError> {
        let nominal = machine.bodies.in_order().map(|b| {
            let I_com = Matrix3::from_fn(|i, j| b.inertia_com.rows()[i][j]);
            Inertia::from_com(b.mass, b.com.into(), I_com)
        });
        let mut bounds = Vec::with_capacity(Body::COUNT);
        for body in BODIES {
            let around = Bounds::around(&nominal[body as usize], inverse_bounds);
            bounds.push(around.ok_or(ControllerError::NotPhysical { body })?);
        }
        let bounds: [Bounds; Body::COUNT] = bounds.try_into().expect("one per body");
        Ok(Self {
            payload: nominal[Body::PL as usize],
            weighing: Weighing::default(),
            estimates: std::array::from_fn(|k| bounds[k].nominal(nominal[k])),
            nominal,
            bounds,
            inverse_bounds,
            load: Load::default(),
        })
    }

    pub(crate) fn payload(&self) -> &Inertia {
        &self.payload
    }

    /// Weighs the payload with what is `felt` of the hook over `h` s; returns whether the hook is
    /// empty. Where that changes, nominal inertia, estimate and bounds of the payload are scaled to
    /// the share found, and all estimates, which learnt with the other share, begin anew.
    pub(crate) fn weigh(&mut self, felt: &HookReadings, hook: &HookModel, h: f64) -> bool {
        const PL: usize = Body::PL as usize;
        let before = self.weighing.is_empty();
        let share = self.weighing.advance(felt, hook, h);
        let payload = self.payload * share;
        let bounds = Bounds::around(&payload, self.inverse_bounds);
        if let (Some(bounds), true) = (bounds, self.weighing.is_empty() != before) {
            self.nominal[PL] = payload;
            self.bounds[PL] = bounds;
            self.estimates = std::array::from_fn(|k| self.bounds[k].nominal(self.nominal[k]));
        }
        self.weighing.is_empty()
    }

    /// Whether nothing was felt on the hook while it was weighed.
    pub(crate) fn feels_empty_hook(&self) -> bool {
        self.weighing.feels_empty()
    }

    /// Whether nothing hangs on the hook, by its weighing and the known load.
    pub(crate) fn is_hook_empty(&self) -> bool {
        self.weighing.is_empty() && self.load.mass == 0.0
    }

    pub(crate) fn load(&self) -> &Load {
        &self.load
    }

    /// Sets the known load, whose position is relative to `tip`, the tip in the frame of the body
    /// `PL`. Nominal inertia, estimate and bounds of that body change by the difference to the
    /// previous load. A mass that is not finite and ≥ 0 is ignored.
    pub(crate) fn carry(&mut self, load: &Load, tip: &Vector3<f64>) {
        const PL: usize = Body::PL as usize;
        let point = |load: &Load| {
            let place = tip + Vector3::from(load.com);
            Inertia::from_com(load.mass, place, Matrix3::zeros())
        };
        let (before, left, comes) = (self.nominal[PL], point(&self.load), point(load));
        let after = Inertia {
            m: before.m - left.m + comes.m,
            h: before.h - left.h + comes.h,
            I: before.I - left.I + comes.I,
        };
        let is_mass = load.mass.is_finite() && load.mass >= 0.0;
        let Some(bounds) = Bounds::around(&after, self.inverse_bounds).filter(|_| is_mass) else {
            return;
        };
        self.estimates[PL] = self.estimates[PL].moved(&before, &after, &bounds);
        self.nominal[PL] = after;
        self.bounds[PL] = bounds;
        self.load = *load;
    }
}
