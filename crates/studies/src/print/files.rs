//! What a command writes: CSV and JSON files, and in them what the numbers were made under.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use anyhow::{Context, Result};
use cosim::{Experiment, Setting, System};
use serde::Serialize;
use serde_json::{Value, json};

/// Write a file where one is asked for.
///
/// # Errors
/// It cannot be written.
pub fn write(
    path: Option<&Path>,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let file = File::create(path);
    let file = file.with_context(|| format!("`{}` cannot be written", path.display()))?;
    let mut file = BufWriter::new(file);
    content(&mut file)
        .and_then(|()| file.flush())
        .with_context(|| path.display().to_string())
}

/// Write a JSON file where one is asked for.
///
/// # Errors
/// It cannot be written.
pub fn write_json(path: Option<&Path>, value: &impl Serialize) -> Result<()> {
    write(path, |file| {
        serde_json::to_writer_pretty(&mut *file, value)?;
        writeln!(file)
    })
}

/// What the numbers were made under.
pub fn conditions(system: &System, base: &Experiment) -> Value {
    let setting = |s: &Setting| format!("{}={}", system.name(s.port), s.value);
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "step_s": base.stepping.step,
        "schedule": format!("{:?}", base.stepping.schedule),
        "settings": base.settings.iter().map(setting).collect::<Vec<_>>(),
    })
}
