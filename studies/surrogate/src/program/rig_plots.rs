//! Pictures of the rig: efficiency of physics, hybrid and rig in all four quadrants, and responses
//! over time.

use std::path::{Path, PathBuf};

use anyhow::Result;
use charts::{Curve, Figure, Panel, save};
use emla::Surrogate;
use plotters::style::{BLUE, RED};
use surrogate::measurement::profile::SPEED;
use surrogate::measurement::windows::Window;
use surrogate::prediction::efficiency_map::maps;
use surrogate::prediction::model::Model;
use surrogate::prediction::responses;

use super::plots::{EfficiencyMaps, MAP_CELLS, SIZE};

/// All pictures, in a folder; `work` is a held-out profile.
pub fn all(
    models: &[Model; 3],
    surrogate: &Surrogate,
    work: &[Window],
    folder: &Path,
) -> Result<Vec<PathBuf>> {
    let maps = maps(models, MAP_CELLS)?;
    let speeds = [-SPEED[1], SPEED[1]];
    let maps = EfficiencyMaps {
        maps: &maps,
        speeds,
    };
    let files = [
        save(&maps, folder, "rig_efficiency_maps", SIZE)?,
        over_time(responses::responses(surrogate, work)).save(folder)?,
    ];
    Ok(files.concat())
}

/// Force, kN, and rod speed, mm/s, over time, s: desired and rig above, network and rig below.
fn over_time(panels: [responses::Panel; 4]) -> Figure {
    let panel = |panel: responses::Panel| {
        let mut curves = Vec::new();
        for ((name, line), color) in panel.lines.into_iter().zip([BLUE, RED]) {
            // Windows in which the rod stands or turns are left out: a line does not bridge them.
            for (k, piece) in line.chunk_by(|a, b| b.0 - a.0 < 0.03).enumerate() {
                let label = if k == 0 { name } else { "" };
                curves.push(Curve::new(label, color, piece.to_vec()));
            }
        }
        Panel::over_time(&format!("{}: {}", panel.title, panel.unit), curves)
    };
    Figure {
        name: "rig_responses".into(),
        title: "Responses of the rig and of the network".into(),
        panels: panels.into_iter().map(panel).collect(),
    }
}
