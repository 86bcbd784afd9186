//! Derivatives of inputs and outputs.

use std::path::Path;

use fmu_description::{Access, Causality, Variability, Variable, Version};

use super::trial::{Trial, open, trial};
use super::values::without_reading_after_set;
use crate::check::outcome::Outcome;
use crate::fmi::functions::Functions;
use crate::fmi::instance::{Instance, references, step_size};
use crate::fmi::symbols::{Pointer, WARNING};

/// By which share a directional derivative may differ from a difference of outputs, which is itself
/// an approximation.
const TOLERANCE: f64 = 1e-2;

pub const TRIALS: &[Trial] = &[
    trial(
        "directional",
        "derivatives",
        directional,
        "directional derivatives are the slopes of the outputs, if providesDirectionalDerivative",
        "importers solve algebraic loops with them, and diverge with wrong ones",
    ),
    trial(
        "outputs",
        "derivatives",
        outputs,
        "derivatives of outputs are given, if maxOutputDerivativeOrder says so",
        "importers extrapolate with them",
    ),
    trial(
        "adjoint",
        "derivatives",
        adjoint,
        "adjoint derivatives are the directional ones transposed: v·(J u) = (Jᵀ v)·u, if both are claimed",
        "optimizers take gradients from the one and check them with the other",
    )
    .only_in(Version::Fmi3),
    trial(
        "inputs",
        "derivatives",
        inputs,
        "derivatives of inputs are taken, if canInterpolateInputs",
        "importers that extrapolate inputs send them",
    )
    .only_in(Version::Fmi2),
];

fn is_continuous_input(v: &Variable) -> bool {
    v.is_input() && v.access() == Access::Real && v.variability == Variability::Continuous
}

fn is_real_output(v: &Variable) -> bool {
    v.causality == Causality::Output && v.access() == Access::Real
}

/// What the FMU does not claim is not tried.
pub fn unless(claimed: bool, outcome: &mut Outcome) -> bool {
    if !claimed {
        outcome.not_checked = Some("the FMU does not claim it".into());
    }
    !claimed
}

fn directional(folder: &Path, outcome: &mut Outcome) -> Result<(), String> {
    let fmu = open(folder)?;
    if unless(
        fmu.description.capabilities.directional_derivatives,
        outcome,
    ) {
        return Ok(());
    }
    if without_reading_after_set(&fmu, outcome) {
        return Ok(());
    }
    let variables = &fmu.description.variables;
    let unknowns = references(variables, is_real_output);
    let mut instance = Instance::started(&fmu, "directional")?;
    instance.step(step_size(&fmu))?;
    let mut compared = 0;
    for input in variables.iter().filter(|v| is_continuous_input(v)) {
        // Of an array, all elements move together.
        let seed = vec![1.0; input.size()];
        let mut slopes = vec![0.0; fmu.functions.count(&unknowns)];
        // SAFETY: a live instance, arrays of fitting lengths.
        let status = unsafe {
            fmu.functions.get_directional_derivative(
                instance.c,
                unknowns.as_ptr(),
                unknowns.len(),
                &input.reference,
                1,
                seed.as_ptr(),
                slopes.as_mut_ptr(),
            )
        };
        instance.must(
            &format!("fmi2GetDirectionalDerivative by `{}`", input.name),
            status,
        )?;
        let Some(Around {
            outputs: [below, here, above],
            step,
        }) = around(&instance, input, &unknowns)?
        else {
            continue;
        };
        let outputs = variables.iter().filter(|v| is_real_output(v));
        let outputs = outputs.flat_map(|v| vec![v; v.size()]);
        for (k, output) in outputs.enumerate() {
            let [down, up] = [(here[k] - below[k]) / step, (above[k] - here[k]) / step];
            let difference = 0.5 * (down + up);
            let scale = slopes[k].abs().max(down.abs()).max(up.abs());
            let rounding = 1e-12 * here[k].abs() / step;
            compared += 1;
            if (slopes[k] - difference).abs() > TOLERANCE * scale + rounding {
                outcome.remark(format!(
                    "d `{}` / d `{}` is {}, a difference gives {difference}",
                    output.name, input.name, slopes[k]
                ));
            }
        }
    }
    outcome.note(format!(
        "{compared} slopes compared with central differences"
    ));
    Ok(())
}

/// `v·(J u)` against `(Jᵀ v)·u` for all inputs and outputs at once, with directions that no
/// symmetry favours.
fn adjoint(folder: &Path, outcome: &mut Outcome) -> Result<(), String> {
    let fmu = open(folder)?;
    let claimed = fmu.description.capabilities;
    let is_claimed = claimed.directional_derivatives && claimed.adjoint_derivatives;
    if unless(is_claimed, outcome) {
        return Ok(());
    }
    let variables = &fmu.description.variables;
    let knowns = references(variables, is_continuous_input);
    let unknowns = references(variables, is_real_output);
    let f = &fmu.functions;
    let of_3 = f.fmi3().ok_or("it is not of FMI 3.0")?;
    let mut instance = Instance::started(&fmu, "adjoint")?;
    instance.step(step_size(&fmu))?;
    let mut compared = 0;
    for round in 0..8 {
        let direction = |n: usize, rate: f64| -> Vec<f64> {
            (0..n)
                .map(|k| (rate * (k + 7 * round + 1) as f64).sin())
                .collect()
        };
        let u = direction(f.count(&knowns), 1.3);
        let v = direction(f.count(&unknowns), 0.7);
        let (mut forward, mut back) = (vec![0.0; v.len()], vec![0.0; u.len()]);
        let (known, n_known) = (knowns.as_ptr(), knowns.len());
        let (unknown, n_unknown) = (unknowns.as_ptr(), unknowns.len());
        // SAFETY: a live instance, arrays of fitting lengths.
        let (status, adjoint) = unsafe {
            let (seed, result) = (u.as_ptr(), forward.as_mut_ptr());
            let status = f.get_directional_derivative(
                instance.c, unknown, n_unknown, known, n_known, seed, result,
            );
            let (seed, result) = (v.as_ptr(), back.as_mut_ptr());
            let (c, n, m) = (instance.c, v.len(), u.len());
            let adjoint = (of_3.fmi3GetAdjointDerivative)(
                c, unknown, n_unknown, known, n_known, seed, n, result, m,
            );
            (status, adjoint)
        };
        instance.must("fmi3GetDirectionalDerivative of all outputs", status)?;
        instance.must("fmi3GetAdjointDerivative of all outputs", adjoint)?;
        let [of_outputs, of_inputs] = [(&v, &forward), (&u, &back)].map(|(a, b)| products(a, b));
        let [left, right]: [f64; 2] = [&of_outputs, &of_inputs].map(|terms| terms.iter().sum());
        let size = |terms: &[f64]| terms.iter().map(|term| term.abs()).sum::<f64>();
        // Both sides are sums of the same products in another order.
        let rounding = 1e-9 * size(&of_outputs).max(size(&of_inputs));
        let differs = (left - right).abs() > rounding;
        if differs || !(left.is_finite() && right.is_finite()) {
            return Err(format!("v·(J u) is {left}, (Jᵀ v)·u is {right}"));
        }
        compared += 1;
    }
    outcome.note(format!("{compared} pairs of directions compared"));
    Ok(())
}

fn products(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}

/// Outputs below, at and above the present value of an input.
struct Around {
    outputs: [Vec<f64>; 3],
    /// Distance of the values of the input.
    step: f64,
}

/// None where bounds or the model forbid one of the values.
fn around(
    instance: &Instance,
    input: &Variable,
    outputs: &[u32],
) -> Result<Option<Around>, String> {
    let vr = [input.reference];
    let (status, old) = instance.reals(&vr);
    instance.must(&format!("fmi2GetReal of `{}`", input.name), status)?;
    let step = 1e-4 * input.nominal.unwrap_or(old[0].abs().max(1.0)).abs();
    let [min, max] = input.bounds();
    let at = |shift: f64| {
        let moved: Vec<f64> = old.iter().map(|value| value + shift).collect();
        let are_inside = moved.iter().all(|value| (min..=max).contains(value));
        let is_set = are_inside && instance.set_reals(&vr, &moved) <= WARNING;
        let (status, values) = instance.reals(outputs);
        (is_set && status <= WARNING).then_some(values)
    };
    let found = [-step, 0.0, step].map(at);
    let status = instance.set_reals(&vr, &old);
    instance.must(&format!("fmi2SetReal of `{}`", input.name), status)?;
    let [Some(below), Some(here), Some(above)] = found else {
        return Ok(None);
    };
    let outputs = [below, here, above];
    Ok(Some(Around { outputs, step }))
}

fn outputs(folder: &Path, outcome: &mut Outcome) -> Result<(), String> {
    let fmu = open(folder)?;
    if unless(
        fmu.description.capabilities.output_derivative_order > 0,
        outcome,
    ) {
        return Ok(());
    }
    let is_continuous =
        |v: &Variable| is_real_output(v) && v.variability == Variability::Continuous;
    let vr = references(&fmu.description.variables, is_continuous);
    let mut instance = Instance::started(&fmu, "outputs")?;
    instance.step(step_size(&fmu))?;
    let mut values = vec![0.0; fmu.functions.count(&vr)];
    let orders = vec![1; vr.len()];
    // In FMI 3.0 they are to be had after a step, in Step Mode.
    let get = |f: &Functions, c: Pointer| {
        // SAFETY: a live instance, room for all elements.
        unsafe {
            f.get_output_derivatives(
                c,
                vr.as_ptr(),
                vr.len(),
                orders.as_ptr(),
                values.as_mut_ptr(),
            )
        }
    };
    let status = instance.stepping(get);
    instance.must("fmi2GetRealOutputDerivatives of all outputs", status)?;
    match values.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(format!("a derivative is {value}")),
        None => Ok(()),
    }
}

fn inputs(folder: &Path, outcome: &mut Outcome) -> Result<(), String> {
    let fmu = open(folder)?;
    if unless(fmu.description.capabilities.interpolates_inputs, outcome) {
        return Ok(());
    }
    let vr = references(&fmu.description.variables, is_continuous_input);
    let mut instance = Instance::started(&fmu, "inputs")?;
    let (orders, values) = (vec![1; vr.len()], vec![0.0; vr.len()]);
    // SAFETY: a live instance, arrays of equal length.
    let status = unsafe {
        fmu.functions.set_input_derivatives(
            instance.c,
            vr.as_ptr(),
            vr.len(),
            orders.as_ptr(),
            values.as_ptr(),
        )
    };
    instance.must("fmi2SetRealInputDerivatives of all inputs", status)?;
    instance.step(step_size(&fmu))
}
