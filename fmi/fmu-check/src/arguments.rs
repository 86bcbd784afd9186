//! The command line of a check, for `fmu-check` and `cargo fmu check`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result};
use clap::Args;

use crate::options::CheckOptions;
use crate::outcome::Verdict;
use crate::{check, run};

/// What to check, and how.
#[derive(Args)]
pub struct Arguments {
    /// FMUs
    #[arg(required_unless_present = "probe", value_name = "FILE.fmu")]
    fmus: Vec<PathBuf>,
    /// Remarks count as failures
    #[arg(long)]
    strict: bool,
    /// Time limit for all probes of an FMU together, s
    #[arg(long, value_name = "SECONDS", default_value_t = 300)]
    timeout: u64,
    /// Check only the promises with these words
    #[arg(long, value_name = "WORDS", default_value = "")]
    only: String,
    /// Run one probe in this process: its name, the folder of the FMU, the file for its outcome
    #[arg(long = "try", hide = true, num_args = 3)]
    probe: Vec<PathBuf>,
}

impl Arguments {
    /// Checks the FMUs and prints their reports; the exit code says whether all pass. `words` are
    /// the arguments after which this program takes these, none for `fmu-check`.
    ///
    /// # Errors
    /// A file that cannot be read, or a process that cannot be started.
    pub fn run(&self, words: &[&str]) -> Result<ExitCode> {
        if let [name, folder, result] = &self.probe[..] {
            run::one(&name.to_string_lossy(), folder, result)?;
            return Ok(ExitCode::SUCCESS);
        }
        let program = std::env::current_exe().context("the path of this program")?;
        let options = CheckOptions {
            program: &program,
            words,
            only: &self.only,
            limit: Duration::from_secs(self.timeout),
        };
        let mut is_sound = true;
        for fmu in &self.fmus {
            let report = check(fmu, options)?;
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
