//! Efficiency of an actuator FMU over load and rod speed, for the map in the report. Each point is
//! an instance of its own that is initialized in steady motion against a constant load. Efficiency
//! is defined while the rod moves against the load (quadrant I) or is moved back by it (quadrant
//! IV).

use anyhow::{Context, Result};
use cosim::instance::At;
use cosim::{Experiment, System, instantiate};
use rayon::prelude::*;

/// Loads: number and largest, N. The shipped network was trained up to it.
const LOADS: (u32, f64) = (28, 70e3);
/// Rod speeds of each direction: number and largest, m/s. The shipped network was trained up to it.
const SPEEDS: (u32, f64) = (28, 0.07);
/// Outputs of the actuator: whether the efficiency is defined, and its values in the order of
/// [`Point`].
const VALID: &str = "efficiency_valid";
const OUTPUTS: [&str; 3] = ["efficiency_phys", "efficiency_net", "efficiency"];

/// Efficiencies at one point: of the physics, of the network, and of both blended as in the
/// actuator.
pub type Point = [f64; 3];

/// Efficiency over a grid.
#[derive(Clone, Debug)]
pub struct Map {
    /// Name of the actuator's component.
    pub actuator: String,
    /// Loads, N, ascending.
    pub loads: Vec<f64>,
    /// Rod speeds, m/s, ascending; positive where the rod moves against the load.
    pub speeds: Vec<f64>,
    /// Row by row of load; None where the efficiency is not defined.
    pub points: Vec<Option<Point>>,
}

/// Computes the map of the first component that has an efficiency, with the start values of the
/// structure and of `base`. Fails if no component has one, or an instance fails.
pub fn map(system: &System, base: &Experiment) -> Result<Map> {
    let is_actuator = |k: &usize| system.port_of(*k, VALID).is_ok();
    let actuator = (0..system.fmus.len()).find(is_actuator);
    let actuator = actuator.with_context(|| format!("no component has an output `{VALID}`"))?;
    let loads: Vec<f64> = ascending(LOADS).collect();
    let against: Vec<f64> = ascending(SPEEDS).collect();
    let back = against.iter().rev().map(|v| -v);
    let speeds: Vec<f64> = back.chain(against.iter().copied()).collect();
    let columns = speeds.len();
    let one = |k: usize| {
        let (load, speed) = (loads[k / columns], speeds[k % columns]);
        point(system, base, actuator, load, speed)
            .with_context(|| format!("efficiency at {load} N, {speed} m/s"))
    };
    let points = (0..loads.len() * columns).into_par_iter().map(one);
    let points = points.collect::<Result<_>>()?;
    Ok(Map {
        actuator: system.structure.components[actuator].name.clone(),
        loads,
        speeds,
        points,
    })
}

/// `count` equal steps up to the largest value, without zero.
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
    let [physics, network, blended] = OUTPUTS.map(read);
    Ok(Some([physics?, network?, blended?]))
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
