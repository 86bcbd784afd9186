//! Programs that `cargo xtask` runs with its own arguments: `cosim`, `hdrm-fmu` with the programs
//! that this starts, and the script of the robustness checks; also for `web` and `test`.

use std::ffi::OsStr;
use std::path::Path;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result};
use cargo_fmu::process::execute;

use crate::workspace::Workspace;

/// Programs that `hdrm-fmu` starts, and the words on its command line with which it does.
const STARTED: [(&str, &[&str]); 2] = [
    (
        "hdrm-fmu-report",
        &["report", "plot", "draw", "scene", "--figures"],
    ),
    ("hdrm-fmu-surrogate", &["train", "surrogate"]),
];

/// `hdrm-fmu`, and the programs that it may start with these arguments.
pub fn with_started(arguments: &[String]) -> Vec<&'static str> {
    let words = |all: &[&str]| {
        let mut words = arguments.iter().filter_map(|a| a.split('=').next());
        words.any(|word| all.contains(&word))
    };
    let started = STARTED.into_iter().filter(|(_, all)| words(all));
    let started = started.map(|(program, _)| program);
    ["hdrm-fmu"].into_iter().chain(started).collect()
}

/// Runs a program in the caller's folder, so that relative paths start there; its exit code.
pub fn run(program: &Path, arguments: &[impl AsRef<OsStr>]) -> Result<ExitCode> {
    let status = Command::new(program).args(arguments).status();
    let status = status.with_context(|| format!("`{}` cannot be started", program.display()))?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    // A program that a signal ended has no code.
    Ok(ExitCode::from(code.unwrap_or(1)))
}

/// Runs the script `tests/robustness.py`: random calls, sanitizers, valgrind, threads, fuzzing and
/// long runs of the FMUs.
pub fn torture(workspace: &Workspace, options: &[String]) -> Result<()> {
    let mut script = workspace.command("python3");
    execute(script.arg("tests/robustness.py").args(options))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_arguments_start_is_built() {
        let started =
            |line: &str| super::with_started(&Vec::from_iter(line.split(' ').map(String::from)));
        assert_eq!(started("table --world real"), ["hdrm-fmu"]);
        assert_eq!(started("help report"), ["hdrm-fmu", "hdrm-fmu-report"]);
        assert_eq!(
            started("sizing --figures=x"),
            ["hdrm-fmu", "hdrm-fmu-report"]
        );
        assert_eq!(
            started("surrogate compare"),
            ["hdrm-fmu", "hdrm-fmu-surrogate"]
        );
    }

    /// A verdict that is bad, code 2, stays one.
    #[cfg(unix)]
    #[test]
    fn exit_codes_are_handed_on() {
        for code in ["0", "1", "2"] {
            let ended = run(Path::new("sh"), &["-c", &format!("exit {code}")]).unwrap();
            let expected = ExitCode::from(code.parse::<u8>().unwrap());
            assert_eq!(format!("{ended:?}"), format!("{expected:?}"));
        }
    }
}
