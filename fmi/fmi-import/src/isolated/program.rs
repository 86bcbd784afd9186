//! Which program the process of an isolated instance runs: `cosim-wasm` for WebAssembly; else this
//! one itself, if it serves, or `cosim`.

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

/// The command of a process for the instance `name`, of WebAssembly or not.
pub fn command(name: &str, is_wasm: bool) -> Result<Command> {
    let named = env::var_os("COSIM_WASM").filter(|_| is_wasm);
    let mut command = Command::new(match (named, SERVES.load(Relaxed)) {
        (Some(named), _) => named.into(),
        (None, _) if is_wasm => find("cosim-wasm").context(
            "its WebAssembly is run by the program `cosim-wasm`, which is neither next to this program nor in a folder of PATH: it is in what is handed out for Linux, `cargo xtask cosim-wasm` builds it, and the environment variable COSIM_WASM may name it",
        )?,
        // This file, even if another one has replaced it.
        (None, true) => PathBuf::from("/proc/self/exe"),
        (None, false) => find("cosim").context(
            "a process of its own runs the program `cosim`, which is neither next to this program nor in a folder of PATH: install it, or add its folder to PATH",
        )?,
    });
    command.args([ARGUMENT, name]);
    Ok(command)
}

/// A program next to this one, or where programs are looked for.
fn find(program: &str) -> Option<PathBuf> {
    let own = env::current_exe().unwrap_or_default();
    let folder = own.parent().unwrap_or(Path::new("/"));
    // Tests of Cargo are in a folder below it.
    let mut folders: Vec<PathBuf> = [folder, &folder.join("..")].map(Path::to_path_buf).into();
    folders.extend(env::split_paths(&env::var_os("PATH").unwrap_or_default()));
    let mut files = folders.iter().map(|folder| folder.join(program));
    files.find(|file| file.is_file())
}
