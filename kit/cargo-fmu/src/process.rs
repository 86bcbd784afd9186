//! Runs programs for `cargo fmu` and `xtask`, with errors that name the whole command.

use std::process::{Command, ExitCode, Stdio};

use anyhow::{Context, Result, ensure};

/// Ends a program: returns its exit code, or prints an error and returns that of a failure.
pub fn end(result: Result<ExitCode>) -> ExitCode {
    result.unwrap_or_else(|error| {
        eprintln!("error: {error:#}");
        ExitCode::FAILURE
    })
}

/// Runs a command, which must succeed.
pub fn execute(command: &mut Command) -> Result<()> {
    let (text, status) = (shown(command), command.status());
    let status = status.with_context(|| format!("`{text}` cannot be started"))?;
    ensure!(status.success(), "`{text}` failed ({status})");
    Ok(())
}

/// Runs a command, which must succeed; returns what it wrote to standard output.
pub fn output(command: &mut Command) -> Result<String> {
    let (text, result) = (shown(command), command.stderr(Stdio::inherit()).output());
    let result = result.with_context(|| format!("`{text}` cannot be started"))?;
    let status = result.status;
    ensure!(status.success(), "`{text}` failed ({status})");
    String::from_utf8(result.stdout).with_context(|| format!("`{text}` wrote no UTF-8"))
}

fn shown(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    let words: Vec<_> = words.map(|w| w.to_string_lossy()).collect();
    words.join(" ")
}
