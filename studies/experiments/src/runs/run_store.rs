//! Keeps results of runs in a folder, for `draws`, `margins` and `tournament` (option `--store`): a
//! result that is there is read, not computed, so an interrupted analysis continues.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use cosim::run::interrupt;
use cosim::{Experiment, System};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use surrogate::measurement::data::sha256;

use super::ended_run::EndedRun;

/// A folder of kept results for one system.
pub struct RunStore {
    folder: Option<PathBuf>,
    /// SHA-256 of the system's file.
    system: String,
}

/// A result and the hash of what it was computed from.
#[derive(Serialize, Deserialize)]
struct Kept<T> {
    made_of: String,
    #[serde(rename = "trial")]
    value: T,
}

impl RunStore {
    /// A store in `folder`, which is created if it is missing; without a folder nothing is kept.
    pub fn new(folder: Option<&Path>, system: &System) -> Result<Self> {
        if let Some(folder) = folder {
            fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        }
        let bytes = fs::read(&system.path).with_context(|| system.path.display().to_string())?;
        Ok(Self {
            folder: folder.map(Into::into),
            system: sha256(&bytes),
        })
    }

    /// The run `name` of `experiment`: read from the store, else executed and kept.
    pub fn run(&self, name: &str, system: &System, experiment: &Experiment) -> Result<EndedRun> {
        let run = || EndedRun::run(system, experiment);
        self.load_or_make(name, system, experiment, run)
    }

    /// The result `name` of `experiment`: read from the store, else computed by `make` and kept. A
    /// machine file counts by its content, not by its path. Fails if the store has a result of this
    /// name for another system or other start values.
    pub fn load_or_make<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        system: &System,
        experiment: &Experiment,
        make: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        let Some(folder) = &self.folder else {
            return make();
        };
        let Experiment { stepping, stop, .. } = experiment;
        let mut made_of = format!("{} {stepping:?} {stop:?}", self.system);
        for setting in &experiment.settings {
            let value = match fs::read(&setting.value) {
                Ok(bytes) => sha256(&bytes),
                Err(_) => setting.value.clone(),
            };
            made_of += &format!(" {}={value}", system.name(setting.port));
        }
        let made_of = sha256(made_of.as_bytes());
        let file = folder.join(format!("{}.json", name.replace([' ', '/', ','], "_")));
        if let Ok(text) = fs::read_to_string(&file) {
            let kept: Kept<T> = serde_json::from_str(&text)
                .with_context(|| format!("`{}` is not a kept run", file.display()))?;
            ensure!(
                kept.made_of == made_of,
                "`{}` is of another system, or of other start values: take another folder, or remove it",
                file.display()
            );
            return Ok(kept.value);
        }
        let value = make()?;
        interrupt::check()?;
        let kept = Kept { made_of, value };
        output_file::write(&file, serde_json::to_string_pretty(&kept)?)?;
        Ok(kept.value)
    }
}
