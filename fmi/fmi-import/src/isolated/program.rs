//! Which program the process of an isolated instance runs: this one itself, if it serves, else
//! `cosim`.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;

use anyhow::{Context, Result};

use super::ARGUMENT;

static SERVES: AtomicBool = AtomicBool::new(false);

/// The present program answers requests when it is started with [`ARGUMENT`].
pub fn serves() {
    SERVES.store(true, Relaxed);
}

/// The command of a process for the instance `name`.
pub fn command(name: &str) -> Result<Command> {
    let mut command = Command::new(match SERVES.load(Relaxed) {
        // This file, even if another one has replaced it.
        true => PathBuf::from("/proc/self/exe"),
        false => cosim()?,
    });
    command.args([ARGUMENT, name]);
    Ok(command)
}

/// The program `cosim`: next to this one, or where programs are looked for.
fn cosim() -> Result<PathBuf> {
    let own = env::current_exe().unwrap_or_default();
    let folder = own.parent().unwrap_or(Path::new("/"));
    // Tests of Cargo are in a folder below it.
    let mut folders: Vec<PathBuf> = [folder, &folder.join("..")].map(Path::to_path_buf).into();
    folders.extend(env::split_paths(&env::var_os("PATH").unwrap_or_default()));
    let mut files = folders.iter().map(|folder| folder.join("cosim"));
    files.find(|file| file.is_file()).with_context(|| {
        format!(
            "a process of its own runs the program `cosim`, which is neither in `{}` nor in a folder of PATH: install it, or add its folder to PATH",
            folder.display()
        )
    })
}
