//! Instructions of a call, counted by valgrind's callgrind.

use std::process::Command;

use anyhow::{Context, Result};

use crate::workspace::Workspace;

/// valgrind, to which the program is added.
pub fn valgrind(workspace: &Workspace) -> Command {
    let mut command = workspace.command("valgrind");
    command.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]);
    command
}

/// Instructions per call, from the difference of two runs: what the start of the program costs
/// drops out.
pub fn per_call([few, many]: [u32; 2], command: impl Fn(u32) -> Command) -> Result<u64> {
    let total = |n| -> Result<u64> {
        let result = command(n).output().context("is valgrind installed?")?;
        let said = String::from_utf8_lossy(&result.stderr).into_owned();
        let count = said.lines().find_map(|l| l.split("Collected :").nth(1));
        let count = count.with_context(|| format!("callgrind gave no count: {said}"))?;
        count.trim().parse().context("count of callgrind")
    };
    Ok(total(many)?.saturating_sub(total(few)?) / u64::from(many - few))
}
