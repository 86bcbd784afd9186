//! The command line of a check, which programs share.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result};
use clap::Args;

use crate::checker::Checker;
use crate::outcome::Verdict;
use crate::{check, run};

/// What to check, and how.
#[derive(Args)]
pub struct Arguments {
    /// FMUs
    #[arg(required_unless_present = "attempt", value_name = "FILE.fmu")]
    fmus: Vec<PathBuf>,
    /// Remarks count as failures
    #[arg(long)]
    strict: bool,
    /// What all trials of an FMU together may take, s
    #[arg(long, value_name = "SECONDS", default_value_t = 300)]
    timeout: u64,
    /// Check only the promises with these words
    #[arg(long, value_name = "WORDS", default_value = "")]
    only: String,
    /// One trial, in this process: its name, the folder of the FMU, the file for its outcome
    #[arg(long = "try", hide = true, num_args = 3)]
    attempt: Vec<PathBuf>,
}

impl Arguments {
    /// Check and print; the exit code tells whether all FMUs pass. `words` lead to these arguments
    /// in this program.
    ///
    /// # Errors
    /// A file that cannot be read, or a process that cannot be started.
    pub fn run(&self, words: &[&str]) -> Result<ExitCode> {
        if let [name, folder, result] = &self.attempt[..] {
            run::one(&name.to_string_lossy(), folder, result)?;
            return Ok(ExitCode::SUCCESS);
        }
        let program = std::env::current_exe().context("the path of this program")?;
        let checker = Checker {
            program: &program,
            words,
            only: &self.only,
            limit: Duration::from_secs(self.timeout),
        };
        let mut is_sound = true;
        for fmu in &self.fmus {
            let report = check(fmu, checker)?;
            println!("{report}");
            let remarks = match self.strict {
                true => report.count(Verdict::Remark),
                false => 0,
            };
            is_sound &= report.count(Verdict::Fails) + remarks == 0;
        }
        Ok(match is_sound {
            true => ExitCode::SUCCESS,
            false => ExitCode::FAILURE,
        })
    }
}
