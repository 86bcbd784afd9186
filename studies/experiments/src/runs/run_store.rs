//! Runs that are kept in a folder, a file each: one that is asked for once more is read from there,
//! so an analysis that was interrupted goes on where it was.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use cosim::{Experiment, System};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use surrogate::measurement::data::sha256;

use super::ended_run::EndedRun;

/// Where runs are kept.
pub struct RunStore {
    folder: Option<PathBuf>,
    /// SHA-256 of the system's file.
    system: String,
}

/// A run, or something else, with what it was made of.
#[derive(Serialize, Deserialize)]
struct Kept<T> {
    made_of: String,
    #[serde(rename = "trial")]
    value: T,
}

impl RunStore {
    /// In `folder`, which is made where it is missing; without one nothing is kept.
    ///
    /// # Errors
    /// A folder that cannot be made, or a system that cannot be read.
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

    /// The run called `name` of `experiment`: as it is kept, else run and kept.
    ///
    /// # Errors
    /// As [`EndedRun::of`]; as [`RunStore::kept`].
    pub fn run(&self, name: &str, system: &System, experiment: &Experiment) -> Result<EndedRun> {
        self.kept(name, system, experiment, || {
            EndedRun::of(system, experiment)
        })
    }

    /// What is called `name` and made by `make` of `experiment`: as it is kept, else made and kept.
    /// What its machine file says counts, not where it lies.
    ///
    /// # Errors
    /// As of `make`; something of this name was made of something else.
    pub fn kept<T: Serialize + DeserializeOwned>(
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
                .with_context(|| format!("`{}` is no trial", file.display()))?;
            ensure!(
                kept.made_of == made_of,
                "`{}` is of another system, or of other start values: take another folder, or remove it",
                file.display()
            );
            return Ok(kept.value);
        }
        let value = make()?;
        let kept = Kept { made_of, value };
        let part = file.with_extension("part");
        fs::write(&part, serde_json::to_string_pretty(&kept)?)
            .and_then(|()| fs::rename(&part, &file))
            .with_context(|| file.display().to_string())?;
        Ok(kept.value)
    }
}
