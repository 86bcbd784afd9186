//! Derivatives of an instance: of outputs by inputs, by time, and of inputs by time.

use std::ffi::c_int;

use super::instance::Instance;
use super::symbols::ABSENT;

impl Instance<'_> {
    /// Directional derivatives of the unknowns for a change of the knowns by the seed.
    pub fn directional(&self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> (c_int, Vec<f64>) {
        let f = &self.fmu.functions;
        assert_eq!(f.count(knowns), seed.len());
        let mut result = vec![0.0; f.count(unknowns)];
        let (unknown, n, known, m) = slices(unknowns, knowns);
        let (seed, place) = (seed.as_ptr(), result.as_mut_ptr());
        // SAFETY: a live instance, arrays of fitting lengths.
        let status =
            unsafe { f.get_directional_derivative(self.c, unknown, n, known, m, seed, place) };
        (status, result)
    }

    /// Adjoint derivatives of FMI 3.0; of fewer seeds than there are elements of the unknowns, if
    /// that is tried.
    pub fn adjoint(&self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> (c_int, Vec<f64>) {
        let mut result = vec![0.0; self.fmu.functions.count(knowns)];
        let Some(f) = self.fmu.functions.fmi3() else {
            return (ABSENT, result);
        };
        let (unknown, n, known, m) = slices(unknowns, knowns);
        let (seeds, seed) = (seed.len(), seed.as_ptr());
        let (results, place) = (result.len(), result.as_mut_ptr());
        // SAFETY: a live instance, arrays of the lengths given.
        let status = unsafe {
            (f.fmi3GetAdjointDerivative)(self.c, unknown, n, known, m, seed, seeds, place, results)
        };
        (status, result)
    }

    /// Derivatives of outputs, of these orders.
    pub fn output_derivatives(&self, references: &[u32], orders: &[c_int]) -> (c_int, Vec<f64>) {
        let f = &self.fmu.functions;
        assert_eq!(references.len(), orders.len());
        let mut values = vec![0.0; f.count(references)];
        let (vr, n, place) = (references.as_ptr(), references.len(), values.as_mut_ptr());
        // SAFETY: a live instance, arrays of fitting lengths.
        let status = unsafe { f.get_output_derivatives(self.c, vr, n, orders.as_ptr(), place) };
        (status, values)
    }

    /// Set derivatives of inputs, of these orders (FMI 2.0).
    pub fn set_input_derivatives(
        &self,
        references: &[u32],
        orders: &[c_int],
        values: &[f64],
    ) -> c_int {
        let n = references.len();
        assert_eq!([orders.len(), values.len()], [n; 2]);
        let (vr, orders, values) = (references.as_ptr(), orders.as_ptr(), values.as_ptr());
        let f = &self.fmu.functions;
        // SAFETY: a live instance, arrays of equal length.
        unsafe { f.set_input_derivatives(self.c, vr, n, orders, values) }
    }
}

/// Two lists of value references as C functions take them.
fn slices(unknowns: &[u32], knowns: &[u32]) -> (*const u32, usize, *const u32, usize) {
    let (unknown, known) = (unknowns.as_ptr(), knowns.as_ptr());
    (unknown, unknowns.len(), known, knowns.len())
}
