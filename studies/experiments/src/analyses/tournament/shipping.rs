//! What gains must do besides being accurate, so that what wins may ship: a sample of what the subcommands
//! `rest`, `margins` and `faults` ask for, of the nominal machine of the real world.

use anyhow::{Context, Result};
use cosim::{Experiment, System};

use crate::analyses::faults;
use crate::analyses::faults::grid::{self, Fault, Instant, SHARES};
use crate::analyses::margins::{self, PLACES, Place};
use crate::analyses::rest::{self, Follows, Pose};
use crate::runs::ended_run::Fate;
use crate::runs::run_store::RunStore;
use crate::setup::machine_choice::MachineFile;
use crate::setup::start_values::{BY_RATES, Law};
use crate::worlds::World;

use super::contestants::TUNING_PATHS;

/// Seed of the poses and faults, and their numbers; each pose with three payloads.
const SEED: u64 = 101;
const POSES: usize = 3;
const FAULTS: usize = 8;

/// What is asked for.
#[derive(Clone, Copy, Debug, Eq, PartialEq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Asked {
    /// That the machine rests in some poses.
    Rest,
    /// That half or twice of what the margins change is tolerated.
    Margins,
    /// That it is kept or stopped after some faults.
    Faults,
}

impl Asked {
    pub const ALL: [Self; 3] = [Self::Rest, Self::Margins, Self::Faults];

    pub fn name(self) -> &'static str {
        match self {
            Self::Rest => "rest",
            Self::Margins => "margins",
            Self::Faults => "faults",
        }
    }
}

/// The sample.
pub struct Sample {
    poses: Vec<Pose>,
    places: Vec<(Place, f64)>,
    faults: Vec<(Instant, Fault)>,
}

impl Sample {
    /// Draws the sample for the machine of `system`.
    pub fn draw(system: &System, base: &Experiment) -> Result<Self> {
        let machine = MachineFile::from_manipulator(system, &base.settings)?.machine;
        let full = machine.bodies.PL.mass;
        let place = |name| PLACES.into_iter().find(|place| place.0 == name);
        let places = [(TUNING_PATHS[0], full), (BY_RATES, 1.0)]
            .map(|(name, payload)| Ok((place(name).context("a place of `margins`")?, payload)));
        let all = grid::faults(system, base, 1.0)?;
        let cases = [0.0, full].into_iter().flat_map(|payload| {
            let instant = Instant {
                path: TUNING_PATHS[0],
                payload,
                share: SHARES[1],
            };
            all.iter().map(move |fault| (instant, fault.clone()))
        });
        Ok(Self {
            poses: rest::poses(&machine, SEED, POSES)?,
            places: places.into_iter().collect::<Result<_>>()?,
            faults: grid::sample(cases.collect(), FAULTS, SEED),
        })
    }

    /// Whether `law` does what is `asked` for.
    pub fn is_met_by(
        &self,
        asked: Asked,
        (system, base): (&System, &Experiment),
        law: &Law,
        store: &RunStore,
    ) -> Result<bool> {
        let no_progress = || ();
        match asked {
            Asked::Rest => {
                let world = (system, base, World::Real);
                let rests = rest::run(world, law, Follows::Rates, &self.poses, store, no_progress)?;
                Ok(rests.iter().all(|rest| rest.run.rests()))
            }
            Asked::Margins => margins::tolerates_all((system, base), law, &self.places, store),
            Asked::Faults => {
                let settings = law.settings(system)?;
                for faults in self.faults.chunk_by(|a, b| a.0 == b.0) {
                    let instant = &faults[0].0;
                    let undisturbed = instant.experiment((system, base), &settings)?;
                    let name = format!("{} {} kg", law.name, instant.payload);
                    if store.run(&name, system, &undisturbed)?.fate != Fate::Kept {
                        return Ok(false);
                    }
                }
                let results = faults::run((system, base), law, &self.faults, store, no_progress)?;
                Ok(results.iter().all(|result| result.run.fate != Fate::Lost))
            }
        }
    }
}
