//! The outputs that a command line names, for `cosim` and the programs of the studies: they are
//! claimed before the work, so that none replaces an input or another output; and a run that fails
//! keeps its rows.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::Result;
use clap::builder::{PathBufValueParser, TypedValueParser};

use crate::io::csv::Log;
use fmi_import::digits::short;

/// Outputs that were named and are not claimed yet.
static NAMED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn named(path: PathBuf) -> PathBuf {
    let mut named = NAMED.lock().unwrap_or_else(PoisonError::into_inner);
    named.push(path.clone());
    path
}

/// Parses an option that names an output file.
pub fn output() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().map(named)
}

/// The same for a CSV file with signals, which has a second file with their units.
pub fn csv_output() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().map(|path| {
        let units = path.with_extension("units.csv");
        let path = named(path);
        named(units);
        path
    })
}

/// Claims the outputs that the command line names; to be called before anything is read.
///
/// # Errors
/// An output that cannot be written, or two that go to the same file.
pub fn claim_outputs() -> Result<()> {
    let mut named = NAMED.lock().unwrap_or_else(PoisonError::into_inner);
    for path in named.drain(..) {
        output_file::claim(&path)?;
    }
    Ok(())
}

/// Completes the files of a run at its end. Those of a run that failed keep the rows up to there,
/// which is said.
pub fn keep_rows<T>(log: Option<Log>, outcome: Result<T>) -> Result<T> {
    let Some(log) = log else { return outcome };
    let path = log.path().to_path_buf();
    keep_rows_in(&path, log.finish(), outcome)
}

/// The outcome of a run, of which the rows up to a time, s, were `kept` in a file.
pub fn keep_rows_in<T>(path: &Path, kept: Result<Option<f64>>, outcome: Result<T>) -> Result<T> {
    match (outcome, kept) {
        (Ok(outcome), kept) => kept.map(|_| outcome),
        (Err(error), Ok(Some(time))) => {
            let (time, path) = (short(time), path.display());
            eprintln!("the rows up to t = {time} s are in `{path}`");
            Err(error)
        }
        (Err(error), _) => Err(error),
    }
}
