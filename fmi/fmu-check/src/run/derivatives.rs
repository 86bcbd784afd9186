//! Probes of directional and adjoint derivatives and of time derivatives, for `supervision`.

use anyhow::{Result, bail, ensure};
use fmi_description::{Access, Causality, Variability, Variable, Version};

use super::probe::probes;
use super::values::without_reading_after_set;
use crate::outcome::Outcome;
use fmi_import::Fmu;
use fmi_import::instance::{Instance, references, step_size};
use fmi_import::status::WARNING;

/// Relative difference that is allowed between a directional derivative and a central difference,
/// which is itself an approximation.
const TOLERANCE: f64 = 1e-2;

probes! {
    "derivatives" {
        opened directional.if_claimed(|c| c.directional_derivatives).unless(without_reading_after_set):
            "directional derivatives are the slopes of the outputs, if providesDirectionalDerivative",
            "importers solve algebraic loops with them, and diverge with wrong ones [FMI 2.0, 2.1.9; FMI 3.0, 2.2.12]";
        opened outputs.if_claimed(|c| c.output_derivative_order > 0):
            "derivatives of outputs are given, if maxOutputDerivativeOrder says so",
            "importers extrapolate with them [FMI 2.0, 4.2.1; FMI 3.0, 4.2.1.1]";
        opened adjoint.only_in(Version::Fmi3).if_claimed(|c| c.directional_derivatives && c.adjoint_derivatives):
            "adjoint derivatives are the directional ones transposed: v·(J u) = (Jᵀ v)·u, if both are claimed",
            "optimizers take gradients from one and check them with the other [FMI 3.0, 2.2.12]";
        opened inputs.only_in(Version::Fmi2).if_claimed(|c| c.interpolates_inputs):
            "derivatives of inputs are taken, if canInterpolateInputs",
            "importers that extrapolate inputs send them [FMI 2.0, 4.2.1]";
    }
}

fn is_continuous_input(v: &Variable) -> bool {
    v.is_input() && v.access() == Access::Real && v.variability == Variability::Continuous
}

fn is_real_output(v: &Variable) -> bool {
    v.causality == Causality::Output && v.access() == Access::Real
}

fn directional(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let variables = &fmu.description.variables;
    let unknowns = references(variables, is_real_output);
    let mut instance = Instance::started(fmu, "directional")?;
    if unknowns.is_empty() {
        return Ok(()); // not every FMU takes arrays of length 0
    }
    instance.step(step_size(fmu))?;
    let mut compared = 0;
    for input in variables.iter().filter(|v| is_continuous_input(v)) {
        // All elements of an array change together.
        let seed = vec![1.0; input.size()];
        let (status, slopes) = instance.directional(&unknowns, &[input.reference], &seed);
        let call = format!("fmi2GetDirectionalDerivative by `{}`", input.name);
        instance.must(&call, status)?;
        let Some(([below, here, above], step)) = outputs_around(&instance, input, &unknowns)?
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

/// Compares `v·(J u)` with `(Jᵀ v)·u` for all inputs and outputs at once, in directions without
/// symmetry.
fn adjoint(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let variables = &fmu.description.variables;
    let knowns = references(variables, is_continuous_input);
    let unknowns = references(variables, is_real_output);
    let f = &fmu.functions;
    let mut instance = Instance::started(fmu, "adjoint")?;
    if knowns.is_empty() || unknowns.is_empty() {
        return Ok(());
    }
    instance.step(step_size(fmu))?;
    let mut compared = 0;
    for round in 0..8 {
        let direction = |n: usize, rate: f64| -> Vec<f64> {
            (0..n)
                .map(|k| (rate * (k + 7 * round + 1) as f64).sin())
                .collect()
        };
        let u = direction(f.count(&knowns), 1.3);
        let v = direction(f.count(&unknowns), 0.7);
        let (status, forward) = instance.directional(&unknowns, &knowns, &u);
        instance.must("fmi3GetDirectionalDerivative of all outputs", status)?;
        let (status, back) = instance.adjoint(&unknowns, &knowns, &v);
        instance.must("fmi3GetAdjointDerivative of all outputs", status)?;
        let [of_outputs, of_inputs] = [(&v, &forward), (&u, &back)].map(|(a, b)| products(a, b));
        let [left, right]: [f64; 2] = [&of_outputs, &of_inputs].map(|terms| terms.iter().sum());
        let size = |terms: &[f64]| terms.iter().map(|term| term.abs()).sum::<f64>();
        // Both sides are sums of the same products in another order.
        let rounding = 1e-9 * size(&of_outputs).max(size(&of_inputs));
        let differs = (left - right).abs() > rounding;
        ensure!(
            !differs && left.is_finite() && right.is_finite(),
            "v·(J u) is {left}, (Jᵀ v)·u is {right}"
        );
        compared += 1;
    }
    outcome.note(format!("{compared} pairs of directions compared"));
    Ok(())
}

fn products(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}

/// The outputs for values of an input below, at and above its present one, and the distance of
/// these values. None if bounds or the model forbid one of them.
fn outputs_around(
    instance: &Instance,
    input: &Variable,
    outputs: &[u32],
) -> Result<Option<([Vec<f64>; 3], f64)>> {
    let vr = [input.reference];
    let old = instance.read(input)?;
    let step = 1e-4 * input.nominal.unwrap_or(old[0].abs().max(1.0)).abs();
    let [min, max] = input.bounds();
    let at = |shift: f64| {
        let moved: Vec<f64> = old.iter().map(|value| value + shift).collect();
        let are_inside = moved.iter().all(|value| (min..=max).contains(value));
        let is_set = are_inside && instance.set_reals(&vr, &moved) <= WARNING;
        let (status, values) = instance.reals(outputs);
        (is_set && status <= WARNING).then_some(values)
    };
    let [Some(below), Some(here), Some(above)] = [-step, 0.0, step].map(at) else {
        instance.set_reals(&vr, &old);
        return Ok(None);
    };
    let status = instance.set_reals(&vr, &old);
    instance.must(&format!("fmi2SetReal of `{}`", input.name), status)?;
    Ok(Some(([below, here, above], step)))
}

fn outputs(fmu: &Fmu, _: &mut Outcome) -> Result<()> {
    let is_continuous =
        |v: &Variable| is_real_output(v) && v.variability == Variability::Continuous;
    let vr = references(&fmu.description.variables, is_continuous);
    let mut instance = Instance::started(fmu, "outputs")?;
    if vr.is_empty() {
        return Ok(());
    }
    instance.step(step_size(fmu))?;
    // FMI 3.0 gives them after a step, in Step Mode.
    let mut values = Vec::new();
    let status = instance.stepping(|_| {
        let (status, derivatives) = instance.output_derivatives(&vr, &vec![1; vr.len()]);
        values = derivatives;
        status
    });
    instance.must("fmi2GetRealOutputDerivatives of all outputs", status)?;
    if let Some(value) = values.iter().find(|value| !value.is_finite()) {
        bail!("a derivative is {value}");
    }
    Ok(())
}

fn inputs(fmu: &Fmu, _: &mut Outcome) -> Result<()> {
    let vr = references(&fmu.description.variables, is_continuous_input);
    let mut instance = Instance::started(fmu, "inputs")?;
    if vr.is_empty() {
        return Ok(());
    }
    let status = instance.set_input_derivatives(&vr, &vec![1; vr.len()], &vec![0.0; vr.len()]);
    instance.must("fmi2SetRealInputDerivatives of all inputs", status)?;
    instance.step(step_size(fmu))
}
