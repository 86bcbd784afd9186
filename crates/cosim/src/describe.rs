//! What `cosim info` prints of an FMU.

use std::fmt::Write as _;

use fmu_description::{Description, Variable};

/// Everything that a user of the FMU needs to know, as text.
pub fn fmu<'a>(
    file: &str,
    description: &Description,
    names: impl Iterator<Item = &'a str>,
) -> String {
    let d = description;
    let mut text = format!("{file}: {}, FMI {}", d.model, d.fmi);
    let mut line = |l: String| {
        text.push_str(&l);
        text.push('\n');
    };
    match d.tool.is_empty() {
        true => line(String::new()),
        false => line(format!(", made by {}", d.tool)),
    }
    let mut platforms: Vec<&str> = names
        .filter_map(|name| name.strip_prefix("binaries/")?.split_once('/'))
        .map(|(platform, _)| platform)
        .collect();
    platforms.dedup();
    line(format!("  platforms: {}", listed(&platforms)));
    let c = &d.capabilities;
    let abilities = [
        (c.variable_step, "variable step"),
        (c.interpolates_inputs, "interpolates inputs"),
        (c.output_derivative_order > 0, "derivatives of outputs"),
        (c.saves_state, "saves its state"),
        (c.serializes_state, "state as bytes"),
        (c.directional_derivatives, "directional derivatives"),
        (c.event_mode, "Event Mode"),
        (c.needs_execution_tool, "needs its tool"),
        (c.only_once, "only one instance in a process"),
    ];
    let has: Vec<&str> = abilities
        .iter()
        .filter(|(has, _)| *has)
        .map(|(_, name)| *name)
        .collect();
    line(format!("  abilities: {}", listed(&has)));
    let e = &d.default_experiment;
    let times = [("start", e.start), ("stop", e.stop), ("step", e.step)];
    let times: Vec<String> = times
        .iter()
        .filter_map(|(n, t)| Some(format!("{n} {} s", (*t)?)))
        .collect();
    if !times.is_empty() {
        line(format!("  default experiment: {}", times.join(", ")));
    }
    for remark in &d.remarks {
        line(format!("  remark: {remark}"));
    }
    for v in &d.variables {
        line(variable(d, v));
    }
    text
}

fn listed(items: &[&str]) -> String {
    match items.is_empty() {
        true => "none".into(),
        false => items.join(", "),
    }
}

fn variable(description: &Description, v: &Variable) -> String {
    let word = |x: &dyn std::fmt::Debug| format!("{x:?}").to_lowercase();
    let mut text = format!(
        "  {}: {}, {} {}",
        v.name,
        word(&v.causality),
        word(&v.variability),
        v.kind.name()
    );
    if !v.dimensions.is_empty() {
        let _ = write!(text, " {:?}", v.dimensions);
    }
    if let Some(unit) = &v.unit {
        let _ = write!(text, ", {unit}");
    }
    if let Some(start) = v.start_of(0) {
        let _ = write!(text, ", start {start}");
    }
    match (v.min, v.max) {
        (None, None) => {}
        (min, max) => {
            let bound = |b: Option<f64>| b.map_or("…".to_string(), |b| b.to_string());
            let _ = write!(text, ", {} to {}", bound(min), bound(max));
        }
    }
    let index = description.index(&v.name);
    let is_output = v.causality == fmu_description::Causality::Output;
    let unknown = index
        .filter(|_| is_output)
        .map(|k| description.declared_feedthrough(k, false));
    match unknown {
        Some(None) => text.push_str(", dependencies not declared"),
        Some(Some(inputs)) if !inputs.is_empty() => {
            let names: Vec<_> = inputs
                .iter()
                .map(|k| description.variables[*k].name.as_str())
                .collect();
            let _ = write!(text, ", depends at once on {}", names.join(", "));
        }
        _ => {}
    }
    if !v.description.is_empty() {
        let _ = write!(text, ": {}", v.description);
    }
    text
}
