//! Coverage-guided fuzzing of everything that reads what others have written (`fuzz/`).

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use cargo_fmu::process::output;

use crate::nightly;
use crate::workspace::Workspace;

/// Each fuzz target for some time, from the committed corpus on; what it finds beyond goes to the
/// target directory.
pub fn run(workspace: &Workspace, seconds: u64) -> Result<()> {
    let folder = workspace.root.join("fuzz");
    let list = output(
        nightly::cargo(workspace)
            .args(["fuzz", "list", "--fuzz-dir"])
            .arg(&folder),
    )
    .context("cargo-fuzz; install it with `cargo install cargo-fuzz`")?;
    let mut total = 0;
    for target in list.lines() {
        let inputs = one(workspace, &folder, target, seconds)?;
        println!("{target}: {inputs} inputs in {seconds} s, no complaint");
        total += inputs;
    }
    println!(
        "fuzzing: {} targets, {total} inputs: 0 crashes, 0 hangs",
        list.lines().count()
    );
    Ok(())
}

/// Fuzz one target; the number of inputs it was given.
fn one(workspace: &Workspace, folder: &Path, target: &str, seconds: u64) -> Result<u64> {
    let found = workspace.target.join("fuzz-corpus").join(target);
    std::fs::create_dir_all(&found)?;
    let mut command = nightly::cargo(workspace);
    command
        .args(["fuzz", "run", "--fuzz-dir"])
        .arg(folder)
        .arg(target)
        .arg(&found)
        .arg(seeds(folder, target))
        .env("CARGO_TARGET_DIR", workspace.target.join("fuzz"))
        .arg("--")
        .arg(format!("-max_total_time={seconds}"))
        .args(["-timeout=20", "-print_final_stats=1", "-print_funcs=0"]);
    let done = command.output().context("cargo-fuzz")?;
    let log = String::from_utf8_lossy(&done.stderr);
    if !done.status.success() {
        bail!("fuzz target {target}, {}:\n{log}", done.status);
    }
    let count = log
        .lines()
        .find_map(|l| l.strip_prefix("stat::number_of_executed_units:"));
    let count = count.context("libFuzzer printed no statistics")?;
    Ok(count.trim().parse()?)
}

fn seeds(folder: &Path, target: &str) -> PathBuf {
    folder.join("seeds").join(target)
}
