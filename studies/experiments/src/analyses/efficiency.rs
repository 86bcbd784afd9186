//! Efficiency of an actuator FMU over load and rod speed. Each point is an instance of its own that
//! is initialized in steady motion against a constant load. The efficiency is defined where the
//! motor's torque pushes against the load: while the rod moves against it (quadrant I) and while
//! the load moves the rod back (quadrant IV).

use anyhow::{Context, Result};
use cosim::instance::At;
use cosim::{Experiment, System, instantiate};
use rayon::prelude::*;

/// Loads: number and largest, N. The shipped network was trained up to it.
const LOADS: (u32, f64) = (28, 70e3);
/// Rod speeds of each direction: number and largest, m/s. The shipped network was trained up to it.
const SPEEDS: (u32, f64) = (28, 0.07);
/// The actuator's outputs that are read: whether the efficiency is defined, and its values in the
/// order of [`Point`].
const VALID: &str = "efficiency_valid";
const OUTPUTS: [&str; 3] = ["efficiency_phys", "efficiency_net", "efficiency"];

/// Efficiencies at one point: of the physics, of the network, and of both blended as the actuator
/// runs.
pub type Point = [f64; 3];

/// Efficiency over a grid.
#[derive(Clone, Debug)]
pub struct Map {
    /// The actuator's component.
    pub actuator: String,
    /// N, ascending.
    pub loads: Vec<f64>,
    /// m/s, ascending; positive where the rod moves against the load.
    pub speeds: Vec<f64>,
    /// Row by row of load; nothing where the efficiency is not defined.
    pub points: Vec<Option<Point>>,
}

/// Map of the first component that has an efficiency, with the start values of the structure and of
/// `base`.
///
/// # Errors
/// No component has one, or an instance fails.
pub fn map(system: &System, base: &Experiment) -> Result<Map> {
    let is_actuator = |k: &usize| system.port_of(*k, VALID).is_ok();
    let actuator = (0..system.fmus.len()).find(is_actuator);
    let actuator = actuator.with_context(|| format!("no component has an output `{VALID}`"))?;
    let loads: Vec<f64> = ascending(LOADS).collect();
    let falling = ascending(SPEEDS).map(|v| -v);
    let mut speeds: Vec<f64> = falling.collect();
    speeds.reverse();
    speeds.extend(ascending(SPEEDS));
    let pairs: Vec<_> = loads
        .iter()
        .flat_map(|load| speeds.iter().map(|speed| (*load, *speed)))
        .collect();
    let points = pairs
        .into_par_iter()
        .map(|(load, speed)| {
            point(system, base, actuator, load, speed)
                .with_context(|| format!("efficiency at {load} N, {speed} m/s"))
        })
        .collect::<Result<_>>()?;
    Ok(Map {
        actuator: system.structure.components[actuator].name.clone(),
        loads,
        speeds,
        points,
    })
}

/// Equal steps up to the largest value, without zero.
fn ascending((count, largest): (u32, f64)) -> impl Iterator<Item = f64> {
    (1..=count).map(move |k| largest * f64::from(k) / f64::from(count))
}

fn point(
    system: &System,
    base: &Experiment,
    actuator: usize,
    load: f64,
    speed: f64,
) -> Result<Option<Point>> {
    let instance = instantiate(system, actuator, &base.settings)?;
    instance.set_from_text("drive", "motion")?;
    instance.set_from_text("x_dot", &speed.to_string())?;
    instance.set_from_text("F_hold", &load.to_string())?;
    instance.enter_initialization(base.stepping.start)?;
    instance.exit_initialization()?;
    let read = |name: &str| {
        let port = system.port_of(actuator, name)?;
        instance.number(port.variable, At::Time(base.stepping.start))
    };
    if read(VALID)? < 0.5 {
        return Ok(None);
    }
    let mut values = Point::default();
    for (value, name) in values.iter_mut().zip(OUTPUTS) {
        *value = read(name)?;
    }
    Ok(Some(values))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_ends_at_the_largest_value_and_leaves_out_standstill() {
        assert_eq!(
            ascending((4, 2.0)).collect::<Vec<_>>(),
            [0.5, 1.0, 1.5, 2.0]
        );
    }
}
