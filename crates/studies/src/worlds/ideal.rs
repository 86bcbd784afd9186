//! The ideal world: the plant is the controller's own model, all inertias by one factor; a check of
//! the code.

use anyhow::Result;
use cosim::system::System;

use crate::grid::Case;

/// Inertia scales, in the order of the paper's table.
pub const SCALES: [f64; 5] = [1.4, 1.2, 1.0, 0.8, 0.6];

/// One case for each scale.
pub fn cases(system: &System) -> Result<Vec<Case>> {
    let case = |scale: f64| {
        let label = format!("inertia {:+.0} %", 100.0 * (scale - 1.0));
        let setting = system.setting("inertia_scale", scale)?;
        Ok(Case::new(label, vec![setting]))
    };
    SCALES.into_iter().map(case).collect()
}
