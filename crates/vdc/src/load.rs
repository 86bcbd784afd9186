//! Loads that a path picks up and sets down, and whether the controller is told.

use crate::adaptation::Bounds;
use crate::controller::Controller;
use crate::{Level, Settings};
use hdrm::Body;
use nalgebra::{Matrix3, Vector3};
use spatial::Inertia;

pub use tip_path::Load;

impl Controller {
    /// What the path has the end-effector carry at the time of the state; None where it says nothing of loads.
    #[inline]
    pub(crate) fn carried(&self, settings: &Settings) -> Option<Load> {
        let path = self.given.as_ref()?;
        path.load(self.path_time(settings))
    }

    /// Takes over what the path says of the load, if the controller is told.
    #[inline]
    pub(crate) fn hear_of_loads(&mut self, settings: &Settings) {
        if settings.load_told && settings.level == Level::Machine {
            let load = self.carried(settings);
            if let Some(load) = load.filter(|load| *load != self.nominal.load) {
                self.tell_load(&load);
            }
        }
    }

    /// Tells the controller that the end-effector carries `load` from now on: the nominal inertia of the body `PL`, its estimate and the bounds
    /// around it change by the difference to what it was told before. A mass that is not finite and ≥ 0 changes nothing.
    pub fn tell_load(&mut self, load: &Load) {
        const PL: usize = Body::PL as usize;
        let nominal = &mut self.nominal;
        let r_D4_T4 = nominal.tree.r_D4_T4;
        let point = |load: &Load| {
            Inertia::from_com(
                load.mass,
                r_D4_T4 + Vector3::from(load.com),
                Matrix3::zeros(),
            )
        };
        let (before, left, comes) = (nominal.inertia[PL], point(&nominal.load), point(load));
        let after = Inertia {
            m: before.m - left.m + comes.m,
            h: before.h - left.h + comes.h,
            I: before.I - left.I + comes.I,
        };
        let is_mass = load.mass.is_finite() && load.mass >= 0.0;
        let Some(bounds) = Bounds::around(&after, nominal.inverse_bounds).filter(|_| is_mass)
        else {
            return;
        };
        let estimate = &mut self.state.estimates[PL];
        *estimate = estimate.moved(&before, &after, &bounds);
        nominal.inertia[PL] = after;
        nominal.bounds[PL] = bounds;
        nominal.load = *load;
    }
}
