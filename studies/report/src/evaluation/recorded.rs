//! The report's sections on studies that take hours, tournament and stability margins: the command
//! `report` reads them from the JSON files that the studies' commands wrote.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use experiments::analyses::margins::{CHANGES, Margin};
use serde::Serialize;
use serde_json::{Value, json};

/// Results of these studies, where a file was given.
#[derive(Clone, Serialize)]
pub struct RecordedStudies {
    tournament: Option<Value>,
    margins: Option<Value>,
}

impl RecordedStudies {
    /// Reads the files of `tournament --json` and `margins --json`; refuses those that another
    /// command wrote.
    pub fn read(tournament: Option<&Path>, margins: Option<&Path>) -> Result<Self> {
        Ok(Self {
            tournament: tournament.map(read_tournament).transpose()?,
            margins: margins.map(read_margins).transpose()?,
        })
    }
}

/// The file as JSON, and the list that it holds under `key`.
fn read_list(file: &Path, command: &str, key: &str) -> Result<(Value, Value)> {
    let read = || -> Result<(Value, Value)> {
        let mut json: Value = serde_json::from_slice(&fs::read(file)?)?;
        let list = json[key].take();
        let is_list = list.as_array().is_some_and(|list| !list.is_empty());
        anyhow::ensure!(is_list, "no list `{key}` is in it");
        Ok((json, list))
    };
    read().with_context(|| format!("--{command} {}: not of `{command} --json`", file.display()))
}

fn read_tournament(file: &Path) -> Result<Value> {
    let (json, rows) = read_list(file, "tournament", "rows")?;
    Ok(json!({ "rows": rows, "tuned": json["tuned"] }))
}

/// The margins, with the changes' names and the margin that a law needs.
fn read_margins(file: &Path) -> Result<Value> {
    let (_, margins) = read_list(file, "margins", "margins")?;
    let margins: Vec<Margin> =
        serde_json::from_value(margins).with_context(|| format!("--margins {}", file.display()))?;
    let changes = CHANGES.map(
        |(change, name, ..)| json!({ "change": change, "name": name, "target": change.target() }),
    );
    Ok(json!({ "changes": changes, "margins": margins }))
}
