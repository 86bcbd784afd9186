//! Which program the process of an isolated instance runs: this one itself, if it serves, else the
//! one that it names, else `cosim`.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;

use anyhow::{Context, Result};

use super::ARGUMENT;

static SERVES: AtomicBool = AtomicBool::new(false);
static NAMED: OnceLock<(PathBuf, Vec<OsString>)> = OnceLock::new();

/// The present program answers requests when it is started with [`ARGUMENT`].
pub fn serves() {
    SERVES.store(true, Relaxed);
}

/// Names the program that processes of isolated instances run, with the arguments after which it
/// [serves](super::serve). The first that is named counts.
pub fn set_program(program: PathBuf, arguments: Vec<OsString>) {
    let _ = NAMED.set((program, arguments));
}

/// The command of a process for the instance `name`.
pub fn command(name: &str) -> Result<Command> {
    let mut command = if let Some((program, arguments)) = NAMED.get() {
        let mut command = Command::new(program);
        command.args(arguments);
        command
    } else if SERVES.load(Relaxed) {
        use std::os::unix::process::CommandExt;
        // This file, even if another one has replaced it.
        let mut command = Command::new("/proc/self/exe");
        command.arg0(env::args_os().next().unwrap_or_default());
        command
    } else {
        Command::new(cosim()?)
    };
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
