//! Calls about derivatives and dependencies of variables, and about clocks.

use std::ffi::c_int;
use std::ptr;

use super::{RawInstance, either, room};
use crate::functions::OwnFunctions::{self, Fmi2, Fmi3};
use crate::status::{ABSENT, DISCARD};

impl RawInstance {
    /// Derivatives of outputs, of these orders.
    pub fn get_output_derivatives(
        &self,
        vr: &[u32],
        orders: &[c_int],
        values: &mut [f64],
    ) -> c_int {
        assert!(orders.len() == vr.len() && values.len() >= vr.len());
        let (c, m, n) = (self.c, vr.len(), values.len());
        let (vr, orders, to) = (vr.as_ptr(), orders.as_ptr(), values.as_mut_ptr());
        // SAFETY: a live instance or NULL, arrays of fitting lengths.
        unsafe {
            either!(self, f =>
                (f.fmi2GetRealOutputDerivatives)(c, vr, m, orders, to),
                (f.fmi3GetOutputDerivatives)(c, vr, m, orders, to, n))
        }
    }

    /// Sets derivatives of inputs, of these orders. Not in FMI 3.0, where nothing is called.
    pub fn set_input_derivatives(&self, vr: &[u32], orders: &[c_int], values: &[f64]) -> c_int {
        assert_eq!([orders.len(), values.len()], [vr.len(); 2]);
        let (m, vr, orders, from) = (vr.len(), vr.as_ptr(), orders.as_ptr(), values.as_ptr());
        match &self.functions.own {
            // SAFETY: a live instance or NULL, arrays of equal length.
            Fmi2(f) => unsafe { (f.fmi2SetRealInputDerivatives)(self.c, vr, m, orders, from) },
            Fmi3(_) => DISCARD,
        }
    }

    /// Directional derivatives of the unknowns for a change of the knowns by the seed.
    pub fn get_directional_derivative(
        &self,
        [unknowns, knowns]: [&[u32]; 2],
        seed: &[f64],
        result: &mut [f64],
    ) -> c_int {
        assert!(seed.len() >= knowns.len() && result.len() >= unknowns.len());
        let (c, n, m, a, b) = (
            self.c,
            unknowns.len(),
            knowns.len(),
            seed.len(),
            result.len(),
        );
        let (y, u, seed, to) = (
            unknowns.as_ptr(),
            knowns.as_ptr(),
            seed.as_ptr(),
            result.as_mut_ptr(),
        );
        // SAFETY: a live instance or NULL, arrays of fitting lengths.
        unsafe {
            either!(self, f =>
                (f.fmi2GetDirectionalDerivative)(c, y, n, u, m, seed, to),
                (f.fmi3GetDirectionalDerivative)(c, y, n, u, m, seed, a, to, b))
        }
    }

    /// Adjoint derivatives of FMI 3.0; of fewer seeds than there are elements of the unknowns, if
    /// that is tried.
    pub fn get_adjoint_derivative(
        &self,
        [unknowns, knowns]: [&[u32]; 2],
        seed: &[f64],
        result: &mut [f64],
    ) -> c_int {
        let Fmi3(f) = &self.functions.own else {
            return ABSENT;
        };
        let (c, n, m, a, b) = (
            self.c,
            unknowns.len(),
            knowns.len(),
            seed.len(),
            result.len(),
        );
        let (y, u, seed, to) = (
            unknowns.as_ptr(),
            knowns.as_ptr(),
            seed.as_ptr(),
            result.as_mut_ptr(),
        );
        // SAFETY: a live instance or NULL, arrays of the lengths given.
        unsafe { (f.fmi3GetAdjointDerivative)(c, y, n, u, m, seed, a, to, b) }
    }

    /// Number of dependencies of a variable (FMI 3.0), or NULL in its place.
    pub fn count_dependencies(&self, vr: u32, n: Option<&mut usize>) -> c_int {
        match &self.functions.own {
            Fmi2(_) => ABSENT,
            // SAFETY: a live instance or NULL; NULL or a place for the result.
            Fmi3(f) => unsafe { (f.fmi3GetNumberOfVariableDependencies)(self.c, vr, room(n)) },
        }
    }

    /// `n` dependencies of a variable (FMI 3.0): which elements, of which variables.
    pub fn get_dependencies(&self, vr: u32, n: usize) -> (c_int, Vec<usize>, Vec<u32>) {
        let Fmi3(f) = &self.functions.own else {
            return (ABSENT, Vec::new(), Vec::new());
        };
        let (mut of, mut on, mut of_on, mut kinds) =
            (vec![0; n], vec![0; n], vec![0; n], vec![0; n]);
        let [to, of_to] =
            [&mut of, &mut of_on].map(|elements: &mut Vec<usize>| elements.as_mut_ptr());
        // SAFETY: a live instance or NULL; room for `n` of each.
        let status = unsafe {
            (f.fmi3GetVariableDependencies)(
                self.c,
                vr,
                to,
                on.as_mut_ptr(),
                of_to,
                kinds.as_mut_ptr(),
                n,
            )
        };
        (status, of, on)
    }

    /// Functions for clocks, with one reference and one answer or value; the interval without a
    /// place for its qualifier. `which` counts `fmi3GetClock`, `fmi3SetClock`,
    /// `fmi3GetIntervalDecimal`, `fmi3SetIntervalDecimal`, `fmi3GetShiftDecimal` and
    /// `fmi3SetShiftFraction`.
    pub fn clock_call(&self, which: usize, vr: u32) -> (&'static str, c_int) {
        let Fmi3(f) = &self.functions.own else {
            return ("fmi3GetClock", ABSENT);
        };
        let (mut active, mut number, fraction) = (false, 0.0, 0);
        macro_rules! call {
            ($name:ident($($argument:expr),*)) => { (stringify!($name), (f.$name)(self.c, &vr, 1 $(, $argument)*)) };
        }
        // SAFETY: a live instance or NULL; one reference, and a place for one answer.
        unsafe {
            match which {
                0 => call!(fmi3GetClock(&mut active)),
                1 => call!(fmi3SetClock(&active)),
                2 => call!(fmi3GetIntervalDecimal(&mut number, ptr::null_mut())),
                3 => call!(fmi3SetIntervalDecimal(&number)),
                4 => call!(fmi3GetShiftDecimal(&mut number)),
                _ => call!(fmi3SetShiftFraction(&fraction, &fraction)),
            }
        }
    }
}
