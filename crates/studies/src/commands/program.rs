//! A program from its command to its exit code.

use std::process::ExitCode;

use anyhow::Result;
use cosim::cli::exit;
use cosim::verdict::Verdict;

use super::python;

/// Run a command, with Python inside where it needs that; with `check`, a bad verdict has an exit
/// code of its own.
pub fn run(needs_python: bool, check: bool, command: impl FnOnce() -> Result<Verdict>) -> ExitCode {
    if needs_python {
        match python::with_python() {
            Ok(None) => {}
            // Code 1 too where a signal ended it.
            Ok(Some(ended)) => {
                let code = ended.code().and_then(|code| u8::try_from(code).ok());
                return ExitCode::from(code.unwrap_or(1));
            }
            Err(error) => return exit(Err(error), check),
        }
    }
    exit(command(), check)
}
