//! Data for the report's section on worlds (a world: plant, sensors and errors that a law is tried
//! in): the errors of the adaptive law and its rivals in each.

use anyhow::{Context as _, Result};
use cosim::{Experiment, System};
use serde_json::{Value, json};

use super::request::{Request, success};
use experiments::analyses::comparison::{self, Summary};
use experiments::setup::start_values::laws_of_modes;
use experiments::worlds::{self, World};

/// Laws that are compared.
const MODES: [&str; 4] = [
    "adaptive",
    "adaptive_integral",
    "modular_integral",
    "pd_integral",
];
/// Number of machines drawn for a world: one, because the page is made often; `table --world` takes
/// more.
const SEEDS: u64 = 1;

/// The worlds, what each contains, and a command that runs it on more machines.
const WORLDS: [(World, &str, &str); 3] = [
    (
        World::Ideal,
        "The plant is the controller's own model and all inertias differ by one factor, -40 to +40 %: a check of the code.",
        "hdrm-fmu table --study rivals",
    ),
    (
        World::Real,
        "Actuators as built (stiction, play, soft mounting, heat, a sampling inverter), encoders, noise and biases, one step of \
         delay, and every body's mass, centre of mass, dimensions, plumb and zeros drawn by seed: what the controller does not know.",
        "hdrm-fmu table --world real",
    ),
    (
        World::Bending,
        "Column and booms that bend in MuJoCo, an engine that shares no line with the controller's model, with dry friction in the \
         joints and masses, centres of mass, dimensions and plumb drawn by seed; actuators and sensors are ideal.",
        "hdrm-fmu table --world bending",
    ),
];

/// An entry for each world, with the laws' errors if its system is at hand; a failure goes to
/// `failures`.
pub fn results(request: &Request, failures: &mut Vec<String>) -> Vec<Value> {
    let systems = [Some(request.system), request.real, request.bending];
    let mut entries = Vec::new();
    for ((world, sentence, command), system) in WORLDS.into_iter().zip(systems) {
        let base = match world {
            World::Ideal => request.base.clone(),
            _ => request.elsewhere(),
        };
        let compared = system.and_then(|system| {
            let result = compare(world, system, base);
            success(result.with_context(|| format!("{world:?} world")), failures)
        });
        let (cases, laws) = compared.unwrap_or_default();
        entries.push(json!({
            "name": world.name(),
            "sentence": sentence,
            "command": command,
            "cases": cases,
            "laws": laws,
        }));
    }
    entries
}

/// The number of machines, and each law's errors over them.
fn compare(world: World, system: &System, mut base: Experiment) -> Result<(usize, Vec<Summary>)> {
    if world.bends() {
        base.stepping.step = base.stepping.step.min(worlds::BENDING_STEP);
    }
    let laws = laws_of_modes(&MODES);
    let cases = worlds::cases(world, system, 1..1 + SEEDS, 1.0)?.list;
    let paths = world.trajectories();
    let cells = comparison::run(system, &base, &laws, &cases, paths, || ())?;
    Ok((cases.len(), comparison::summaries(&cells, None)))
}
