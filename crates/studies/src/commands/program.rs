//! A program from its command to its exit code, and the programs beside `hdrm-fmu` that do what it
//! leaves to them, so that it is built in a third of the time: `hdrm-fmu-report` draws,
//! `hdrm-fmu-surrogate` trains networks. They take its arguments over.

use std::env::{self, consts::EXE_SUFFIX};
use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};
use clap::Args;
use cosim::Verdict;
use cosim::cli::exit;

use super::python;

/// Whether a bad verdict ends the program with a code of its own, and the verdict.
pub type Ending = (bool, Result<Verdict>);

/// Run a command, with Python inside where it needs that.
pub fn run(needs_python: bool, command: impl FnOnce() -> Ending) -> ExitCode {
    if needs_python {
        match python::with_python() {
            Ok(None) => {}
            // Code 1 too where a signal ended it.
            Ok(Some(ended)) => {
                let code = ended.code().and_then(|code| u8::try_from(code).ok());
                return ExitCode::from(code.unwrap_or(1));
            }
            Err(error) => return exit(Err(error), false),
        }
    }
    let (check, verdict) = command();
    exit(verdict, check)
}

/// Arguments that another program reads; it is asked for its options by `--help`, too.
#[derive(Args)]
pub struct OtherArguments {
    #[arg(
        trailing_var_arg = true,
        allow_hyphen_values = true,
        value_name = "OPTIONS"
    )]
    _arguments: Vec<OsString>,
}

/// A program beside this one.
#[derive(Clone, Copy)]
pub enum Sibling {
    /// Page, drawings and pictures.
    Report,
    /// Training.
    Surrogate,
}

impl Sibling {
    fn name(self) -> &'static str {
        match self {
            Self::Report => "hdrm-fmu-report",
            Self::Surrogate => "hdrm-fmu-surrogate",
        }
    }

    /// The package that it is built from.
    fn package(self) -> &'static str {
        match self {
            Self::Report => "report",
            Self::Surrogate => "surrogate",
        }
    }

    /// Let it do what this program was asked to do by `arguments`; how it ended.
    ///
    /// # Errors
    /// It does not lie beside this program, or cannot be started.
    pub fn take_over(self, arguments: &[OsString]) -> Result<ExitCode> {
        let own = env::current_exe().context("where this program lies")?;
        let folder = own.parent().unwrap_or(Path::new(""));
        let program = folder.join(format!("{}{EXE_SUFFIX}", self.name()));
        if !program.is_file() {
            bail!(
                "this is done by the program `{}`, which is not beside this one, at {}; in this project's sources it is built by `cargo build \
                 --release --package {}`",
                self.name(),
                program.display(),
                self.package()
            );
        }
        let arguments = match arguments {
            [word, rest @ ..] if word == "surrogate" => rest,
            all => all,
        };
        let mut command = Command::new(&program);
        command.args(arguments);
        start(&mut command).with_context(|| program.display().to_string())
    }
}

/// On Unix it becomes this process, so that signals reach it.
#[cfg(unix)]
fn start(command: &mut Command) -> Result<ExitCode> {
    use std::os::unix::process::CommandExt as _;
    Err(command.exec().into())
}

/// Elsewhere it is waited for; Ctrl-C reaches both, and only it acts on that.
#[cfg(not(unix))]
fn start(command: &mut Command) -> Result<ExitCode> {
    use signal_hook::consts::SIGINT;
    signal_hook::flag::register(SIGINT, std::sync::Arc::default())?;
    let code = command.status()?.code();
    let code = code.and_then(|code| u8::try_from(code).ok());
    // Code 1 too where it has none that fits.
    Ok(ExitCode::from(code.unwrap_or(1)))
}
