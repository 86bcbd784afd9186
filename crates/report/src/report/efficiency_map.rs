//! The actuator's efficiency map as the page takes it.

use serde::Serialize;

use super::samples::Samples;
use studies::studies::efficiency;

/// Efficiency over a grid of load and rod speed.
#[derive(Serialize)]
pub struct EfficiencyMap {
    actuator: String,
    /// N, ascending.
    loads: Vec<f64>,
    /// m/s, ascending.
    speeds: Vec<f64>,
    /// Row by row of load; NaN where the efficiency is not defined.
    physics: Samples,
    network: Samples,
    hybrid: Samples,
}

impl From<efficiency::Map> for EfficiencyMap {
    fn from(map: efficiency::Map) -> Self {
        let surface = |k: usize| {
            let points = map.points.iter();
            Samples::new(points.map(|point| point.map_or(f64::NAN, |values| values[k])))
        };
        Self {
            physics: surface(0),
            network: surface(1),
            hybrid: surface(2),
            actuator: map.actuator,
            loads: map.loads,
            speeds: map.speeds,
        }
    }
}
