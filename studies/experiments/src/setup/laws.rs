//! The lists of control laws that `hdrm-fmu table --study` compares. A law is a controller mode
//! with other start values, mostly of the controller or of the sensors.

use std::path::Path;

use anyhow::Result;
use cosim::System;
use cosim::structure::Parameter;

use crate::setup::start_values::Law;

/// Rates of the integral of the tip error in [`integral_rates`], 1/s.
const RATES: [f64; 5] = [1.25, 2.5, 5.0, 10.0, 20.0];

/// Adaptation, disturbance observer, integral of the voltage law and integral of the tip's error,
/// each on and off.
pub fn ablation() -> Vec<Law> {
    let mut laws = Vec::new();
    for set in (0..16).rev() {
        let [adaptation, observer, voltage, tip] = [8, 4, 2, 1].map(|bit| set & bit != 0);
        let mode = match (adaptation, tip) {
            (true, true) => "adaptive_integral",
            (true, false) => "adaptive",
            (false, true) => "modular_integral",
            (false, false) => "modular",
        };
        let parts = ["adaptation", "observer", "voltage", "tip"].into_iter();
        let parts = parts.zip([adaptation, observer, voltage, tip]);
        let on: Vec<_> = parts.filter_map(|(name, on)| on.then_some(name)).collect();
        let name = match on.is_empty() {
            true => "none".into(),
            false => on.join(" + "),
        };
        let mut law = Law::new(name, mode);
        if !observer {
            law = law.with("omega_d", 0.0);
        }
        if !voltage {
            law = law.with("omega_i", 0.0);
        }
        laws.push(law);
    }
    laws
}

/// The other laws with integral (without adaptation) at several rates of that integral, to see what
/// another tuning would give them.
pub fn integral_rates() -> Vec<Law> {
    let modes = ["modular_integral", "pd_gravity_integral", "pd_integral"];
    let law = |mode: &str, rate: f64| {
        Law::new(format!("{mode} {rate} 1/s"), mode).with("omega_tip", rate)
    };
    let laws = modes
        .iter()
        .flat_map(|mode| RATES.map(|rate| law(mode, rate)));
    laws.collect()
}

/// The law `mode` with other sensors: true speeds, speeds by difference or by an observer, force
/// measured or not, and other delays.
pub fn sensor_variants(mode: &str) -> Vec<Law> {
    let other = |name: &str, variable: &str, value: &str| {
        Law::new(format!("{mode}, {name}"), mode).with(&format!("sensors.{variable}"), value)
    };
    vec![
        Law::new(format!("{mode}, as shipped"), mode),
        other("speeds known", "speed", "ideal"),
        other("speeds by difference", "speed", "difference"),
        other("force known", "force", "ideal"),
        other("no force sensor", "force", "absent"),
        other("no delay", "delay", "0"),
        other("two steps of delay", "delay", "2"),
        other("zeros known", "joint_zero", "false"),
    ]
}

/// The options of the controller that the real world's parameter set leaves off, each added to the
/// shipped law `mode`: prediction over the dead time, joint rates by the controller's observer,
/// leakage, and friction compensated with the `network` that was trained on the rig.
pub fn unused_options(mode: &str, network: &Path) -> Vec<Law> {
    let law = |name: &str| Law::new(format!("{mode}, {name}"), mode);
    vec![
        law("as shipped"),
        law("delay predicted")
            .with("sensors.delay", 0)
            .with("controller.delay", 1),
        law("omega_speed 100").with("omega_speed", 100),
        law("omega_speed 300").with("omega_speed", 300),
        law("leakage 0.02").with("leakage", 0.02),
        law("leakage 0.2").with("leakage", 0.2),
        law("friction by network")
            .with("controller.alpha", 0.9)
            .with("controller.surrogate_file", network.display()),
    ]
}

/// Laws that take back what the parameter set `file` of the system changes, one variable at a time
/// and all together, to show what each change brings. A variable of the same name in several
/// components is one change, such as the `delay` that moves from the sensors into the controller.
/// Values from the set `bound` do not count as the values before the change.
pub fn without_changes(system: &System, bound: &str, file: &str, mode: &str) -> Result<Vec<Law>> {
    let mut laws = vec![Law::new("as shipped", mode)];
    let mut without = Law::new("without any", mode);
    for (component, element) in system.structure.components.iter().enumerate() {
        for (k, parameter) in element.parameters.iter().enumerate() {
            // The structure itself binds a set; the same set or another may be applied after it.
            let is_of_world = |p: &Parameter| p.origin.contains(file) || p.origin.contains(bound);
            let again = |p: &Parameter| p.name == parameter.name && p.origin.contains(file);
            if !parameter.origin.contains(file) || element.parameters[k + 1..].iter().any(again) {
                continue;
            }
            let port = system.port_of(component, &parameter.name)?;
            let mut earlier = element.parameters[..k].iter();
            let before = earlier.rfind(|p| p.name == parameter.name && !is_of_world(p));
            let start = || system.variable(port).start_of(0).map(String::from);
            let Some(before) = before.map(|p| p.value.clone()).or_else(start) else {
                continue;
            };
            let full = system.name(port);
            without = without.with(&full, &before);
            let title = |law: &Law| law.name.starts_with(&format!("{} ", parameter.name));
            match laws.iter_mut().find(|law| title(law)) {
                Some(law) => law.values.push((full, before)),
                None => {
                    let name = format!("{} {} -> {before}", parameter.name, parameter.value);
                    laws.push(Law::new(name, mode).with(&full, &before));
                }
            }
        }
    }
    laws.push(without);
    Ok(laws)
}
