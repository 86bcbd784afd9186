//! Studies that take hours: shown from the JSON files that their commands wrote.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use experiments::analyses::margins::{CHANGES, Margin};
use serde::Serialize;
use serde_json::{Value, json};

/// What was recorded, where there is a file of it.
#[derive(Clone, Serialize)]
pub struct Recorded {
    tournament: Option<Value>,
    margins: Option<Value>,
}

impl Recorded {
    /// Of the files of `tournament --json` and `margins --json`.
    ///
    /// # Errors
    /// A file that cannot be read, or of another command.
    pub fn read(tournament: Option<&Path>, margins: Option<&Path>) -> Result<Self> {
        Ok(Self {
            tournament: tournament.map(of_tournament).transpose()?,
            margins: margins.map(of_margins).transpose()?,
        })
    }
}

/// The file as JSON, and what it holds under `key`, which must be a list.
fn list(file: &Path, command: &str, key: &str) -> Result<(Value, Value)> {
    let read = || -> Result<(Value, Value)> {
        let mut found: Value = serde_json::from_slice(&fs::read(file)?)?;
        let list = found[key].take();
        let is_list = list.as_array().is_some_and(|list| !list.is_empty());
        anyhow::ensure!(is_list, "no list `{key}` is in it");
        Ok((found, list))
    };
    read().with_context(|| format!("--{command} {}: not of `{command} --json`", file.display()))
}

fn of_tournament(file: &Path) -> Result<Value> {
    let (found, rows) = list(file, "tournament", "rows")?;
    Ok(json!({ "rows": rows, "tuned": found["tuned"] }))
}

/// With the changes' names and what a law is asked for.
fn of_margins(file: &Path) -> Result<Value> {
    let (_, margins) = list(file, "margins", "margins")?;
    let margins: Vec<Margin> =
        serde_json::from_value(margins).with_context(|| format!("--margins {}", file.display()))?;
    let changes = CHANGES.map(
        |(change, name, ..)| json!({ "change": change, "name": name, "target": change.target() }),
    );
    Ok(json!({ "changes": changes, "margins": margins }))
}
