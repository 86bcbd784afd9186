//! The worlds side by side: the adaptive law and its rivals in each, with a sentence on what is in it.

use anyhow::Result;
use cosim::run::Experiment;
use cosim::system::System;
use serde::Serialize;

use super::Request;
use crate::laws::{self, Law};
use crate::worlds::{self, Summary, World};

/// Laws that are shown.
const MODES: [&str; 4] = [
    "adaptive",
    "adaptive_integral",
    "modular_integral",
    "pd_integral",
];
/// Machines drawn for the real world: one, because the page is made often; `table --world real` takes 20.
const SEEDS: u64 = 1;

/// A world on the page.
#[derive(Serialize)]
pub struct Shown {
    name: &'static str,
    /// What is in it.
    sentence: &'static str,
    /// Machines.
    cases: usize,
    laws: Vec<Summary>,
}

/// The ideal world, and the real one where its system is at hand; those that fail are named.
pub fn shown(request: &Request, failures: &mut Vec<String>) -> Vec<Shown> {
    let ideal = (World::Ideal, request.system);
    let real = request.real.map(|system| (World::Real, system));
    let mut found = Vec::new();
    for (world, system) in [ideal].into_iter().chain(real) {
        match one(world, system, request.base) {
            Ok(shown) => found.push(shown),
            Err(error) => failures.push(format!("{world:?} world: {error:#}")),
        }
    }
    found
}

fn one(world: World, system: &System, base: &Experiment) -> Result<Shown> {
    let base = Experiment {
        settings: match world {
            World::Ideal => base.settings.clone(),
            World::Real => Vec::new(), // of another system
        },
        ..base.clone()
    };
    let laws: Vec<Law> = laws::rivals();
    let laws: Vec<Law> = laws
        .into_iter()
        .filter(|law| MODES.contains(&law.name.as_str()))
        .collect();
    let cases = worlds::cases(world, system, 1..1 + SEEDS)?;
    let cells = worlds::run(system, &base, &laws, cases.list(), || ())?;
    let (name, sentence) = match world {
        World::Ideal => (
            "ideal",
            "The plant is the controller's own model and all inertias differ by one factor, -40 to +40 %: a check of the code.",
        ),
        World::Real => (
            "real",
            "Actuators as built (stiction, play, soft mounting, heat, a sampling inverter), encoders, noise and biases, one step of \
             delay, and every body's mass, centre of mass, dimensions, plumb and zeros drawn by seed: what the controller does not know.",
        ),
    };
    Ok(Shown {
        name,
        sentence,
        cases: cases.list().len(),
        laws: worlds::summaries(&cells, None),
    })
}
