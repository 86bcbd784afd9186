//! Programs that `cargo xtask` builds and runs with the arguments it was given.

use std::ffi::OsStr;
use std::path::Path;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result};
use cargo_fmu::process::execute;

use crate::workspace::Workspace;

/// Words on the command line of `hdrm-fmu` by which it starts a program beside it.
const STARTED: [(&str, &[&str]); 2] = [
    (
        "hdrm-fmu-report",
        &["report", "plot", "draw", "scene", "--figures"],
    ),
    ("hdrm-fmu-surrogate", &["train", "surrogate"]),
];

/// `hdrm-fmu`, and what it may start with these arguments.
pub fn beside(arguments: &[String]) -> Vec<&'static str> {
    let words = |all: &[&str]| {
        let mut words = arguments.iter().filter_map(|a| a.split('=').next());
        words.any(|word| all.contains(&word))
    };
    let started = STARTED.into_iter().filter(|(_, all)| words(all));
    let started = started.map(|(program, _)| program);
    ["hdrm-fmu"].into_iter().chain(started).collect()
}

/// Run a program in the caller's folder, so that paths are as the shell means them; its exit code.
pub fn handed_on(program: &Path, arguments: &[impl AsRef<OsStr>]) -> Result<ExitCode> {
    let status = Command::new(program).args(arguments).status();
    let status = status.with_context(|| format!("`{}` cannot be started", program.display()))?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    // 1 too where a signal ended it.
    Ok(ExitCode::from(code.unwrap_or(1)))
}

/// Robustness, by the script `tests/robustness.py`: random calls, sanitizers, valgrind, threads,
/// fuzzing and long runs on the FMUs, as its options say.
pub fn torture(workspace: &Workspace, options: &[String]) -> Result<()> {
    let mut script = workspace.command("python3");
    execute(script.arg("tests/robustness.py").args(options))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_arguments_start_is_built() {
        let beside = |line: &str| super::beside(&Vec::from_iter(line.split(' ').map(String::from)));
        assert_eq!(beside("table --world real"), ["hdrm-fmu"]);
        assert_eq!(beside("help report"), ["hdrm-fmu", "hdrm-fmu-report"]);
        assert_eq!(
            beside("sizing --figures=x"),
            ["hdrm-fmu", "hdrm-fmu-report"]
        );
        assert_eq!(
            beside("surrogate compare"),
            ["hdrm-fmu", "hdrm-fmu-surrogate"]
        );
    }

    /// A verdict that is bad, code 2, stays one.
    #[cfg(unix)]
    #[test]
    fn exit_codes_are_handed_on() {
        for code in ["0", "1", "2"] {
            let ended = handed_on(Path::new("sh"), &["-c", &format!("exit {code}")]).unwrap();
            let expected = ExitCode::from(code.parse::<u8>().unwrap());
            assert_eq!(format!("{ended:?}"), format!("{expected:?}"));
        }
    }
}
