//! Derivatives of an instance: of outputs by inputs, by time, and of inputs by time.

use std::ffi::c_int;

use crate::instance::Instance;

impl Instance<'_> {
    /// Directional derivatives of the unknowns for a change of the knowns by the seed.
    pub fn directional(&self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> (c_int, Vec<f64>) {
        let f = &self.fmu.functions;
        assert_eq!(f.count(knowns), seed.len());
        let mut result = vec![0.0; f.count(unknowns)];
        let status = self.get_directional_derivative(unknowns, knowns, seed, &mut result);
        (status, result)
    }

    /// Adjoint derivatives of FMI 3.0; of fewer seeds than there are elements of the unknowns, if
    /// that is tried.
    pub fn adjoint(&self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> (c_int, Vec<f64>) {
        let mut result = vec![0.0; self.fmu.functions.count(knowns)];
        let status = self.get_adjoint_derivative(unknowns, knowns, seed, &mut result);
        (status, result)
    }

    /// Derivatives of outputs, of these orders.
    pub fn output_derivatives(&self, references: &[u32], orders: &[c_int]) -> (c_int, Vec<f64>) {
        let mut values = vec![0.0; self.fmu.functions.count(references)];
        let status = self.get_output_derivatives(references, orders, &mut values);
        (status, values)
    }
}
