//! Keeps results of runs in a folder, for `draws`, `margins` and `tournament` (option `--store`): a
//! result that is there is read, not computed, so an interrupted analysis continues.
//!
//! A file's name ends in the key of its run, so results of several set-ups may lie in one folder.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::{Context, Result};
use cosim::io::digest::sha256;
use cosim::run::interrupt;
use cosim::run::run_key::RunKey;
use cosim::{Experiment, System};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::ended_run::EndedRun;

/// Digits of the key in the name of a file.
const DIGITS: usize = 16;

/// A folder of kept results.
pub struct RunStore {
    folder: Option<PathBuf>,
    /// SHA-256 of this program, which measures the runs.
    program: String,
    /// Files that were in the folder at first, by the names of their results.
    there: BTreeMap<String, Vec<String>>,
    found: Mutex<Found>,
}

/// What was found in the folder.
#[derive(Default)]
struct Found {
    /// Names of the results that were asked for, and their files.
    names: BTreeSet<String>,
    files: BTreeSet<String>,
    damaged: BTreeSet<String>,
}

impl RunStore {
    /// A store in `folder`, which is created if it is missing; without a folder nothing is kept.
    pub fn new(folder: Option<&Path>) -> Result<Self> {
        let mut store = Self {
            folder: folder.map(Into::into),
            program: String::new(),
            there: BTreeMap::new(),
            found: Mutex::default(),
        };
        let Some(folder) = folder else {
            return Ok(store);
        };
        let context = || folder.display().to_string();
        fs::create_dir_all(folder).with_context(context)?;
        for entry in fs::read_dir(folder).with_context(context)? {
            let file = entry.with_context(context)?.file_name();
            let Some(file) = file.to_str().filter(|file| file.ends_with(".json")) else {
                continue;
            };
            let name = file.trim_end_matches(".json");
            let is_key =
                |end: &str| end.len() == DIGITS && end.chars().all(|c| c.is_ascii_hexdigit());
            let keyed = name.rsplit_once('.').filter(|(_, end)| is_key(end));
            let name = keyed.map_or(name, |(name, _)| name);
            let files = store.there.entry(name.into()).or_default();
            files.push(file.into());
        }
        let program = std::env::current_exe().and_then(fs::read);
        store.program = sha256(&program.context("this program, whose results are kept")?);
        Ok(store)
    }

    /// The run `name` of `experiment`: read from the store, else executed and kept.
    pub fn run(&self, name: &str, system: &System, experiment: &Experiment) -> Result<EndedRun> {
        let run = || EndedRun::run(system, experiment);
        self.load_or_make(name, system, experiment, run)
    }

    /// The result `name` of `experiment`: read from the store, else computed by `make` and kept. A
    /// result of another run is not taken, nor is a damaged file.
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
        let mut key = RunKey::new(system, experiment);
        key.add("the program", &*self.program);
        key.add("the result", name);
        let key = key.digest();
        let name = name.replace([' ', '/', ','], "_");
        let file_name = format!("{name}.{}.json", &key[..DIGITS]);
        let file = folder.join(&file_name);
        let there = fs::read(&file).ok();
        let mut value = there.as_deref().and_then(|bytes| unpack(&key, bytes));
        {
            let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
            if there.is_some() && value.is_none() {
                found.damaged.insert(file.display().to_string());
            }
            found.names.insert(name);
            found.files.insert(file_name);
        }
        if let Some(value) = value.take() {
            return Ok(value);
        }
        let value = make()?;
        interrupt::check()?;
        let text = pack(&key, &serde_json::to_string(&value)?);
        // Two threads may have the same run.
        let _writing = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        output_file::write(&file, text)?;
        Ok(value)
    }

    /// Says on standard error what lies in the folder and was not taken.
    pub fn report_unused(&self) {
        let Some(folder) = &self.folder else { return };
        let found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        let alike = found.names.iter().filter_map(|name| self.there.get(name));
        let unused = alike.flatten().filter(|file| !found.files.contains(*file));
        let count = unused.count();
        if count > 0 {
            eprintln!(
                "{count} kept results in `{}` belong to other runs (other options, FMUs or files, or another build) and were not used",
                folder.display()
            );
        }
        for file in &found.damaged {
            eprintln!("`{file}` was damaged: its run was made again");
        }
    }
}

/// The parts of a file: the key of the run, the checksum of its result, and the result as JSON.
const PARTS: [&str; 4] = [
    "{\"key\":\"",
    "\",\n\"sha256\":\"",
    "\",\n\"result\":",
    "}\n",
];

/// The text of a file with a result.
fn pack(key: &str, result: &str) -> String {
    let [start, checksum, value, end] = PARTS;
    let sum = sha256(result.as_bytes());
    format!("{start}{key}{checksum}{sum}{value}{result}{end}")
}

/// The result in a file; None if it is not exactly as it was written.
fn unpack<T: DeserializeOwned>(key: &str, file: &[u8]) -> Option<T> {
    let text = std::str::from_utf8(file).ok()?;
    let (_, rest) = text.split_once(PARTS[2])?;
    let result = rest.strip_suffix(PARTS[3])?;
    let is_whole = pack(key, result) == text;
    is_whole.then(|| serde_json::from_str(result).ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever bit is flipped, wherever the file ends: the result is the same or there is none.
    #[test]
    fn a_damaged_file_is_no_result() {
        let key = sha256(b"a run");
        let run = EndedRun {
            rmse: Some(1.25e-4),
            force: 0.7,
            ..EndedRun::lost("rod 2 swings".into())
        };
        let text = pack(&key, &serde_json::to_string(&run).expect("JSON"));
        let read = |bytes: &[u8]| unpack::<EndedRun>(&key, bytes);
        assert_eq!(read(text.as_bytes()), Some(run));
        for k in 0..8 * text.len() {
            let mut bytes = text.clone().into_bytes();
            bytes[k / 8] ^= 1 << (k % 8);
            assert_eq!(read(&bytes), None, "bit {k}");
            assert_eq!(read(&text.as_bytes()[..k / 8]), None, "{} bytes", k / 8);
        }
        assert_eq!(
            unpack::<EndedRun>(&sha256(b"another"), text.as_bytes()),
            None
        );
    }
}
