//! The command line of a check, for `fmu-check` and `cargo fmu check`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result};
use clap::builder::NonEmptyStringValueParser;
use clap::{Args, value_parser};

use crate::options::CheckOptions;
use crate::outcome::Verdict;
use crate::{check, run};

/// What to check, and how.
#[derive(Args)]
pub struct Arguments {
    /// FMUs
    #[arg(required_unless_present = "probe", value_name = "FILE.fmu")]
    fmus: Vec<PathBuf>,
    /// What is not robust counts as what breaks the standard
    #[arg(long)]
    strict: bool,
    /// Time limit for all probes of an FMU together, s
    #[arg(long, value_name = "SECONDS", default_value_t = 300, value_parser = value_parser!(u64).range(1..))]
    timeout: u64,
    /// Check only the promises with these words
    #[arg(long, value_name = "WORDS", value_parser = NonEmptyStringValueParser::new())]
    only: Option<String>,
    /// Run one probe in this process: its name, the folder of the FMU, the file for its outcome, the
    /// time limit in ms
    #[arg(long = "try", hide = true, num_args = 4)]
    probe: Vec<PathBuf>,
    /// Get each variable in a call of its own
    #[arg(long, hide = true, requires = "probe")]
    one_by_one: bool,
}

impl Arguments {
    /// Checks the FMUs and prints their reports; the exit code says whether all pass, which one of
    /// which nothing was checked does not. `words` are the arguments after which this program takes
    /// these, none for `fmu-check`.
    ///
    /// # Errors
    /// A file that cannot be read, or a process that cannot be started.
    pub fn run(&self, words: &[&str]) -> Result<ExitCode> {
        if let [name, folder, result, limit] = &self.probe[..] {
            let limit = limit.to_string_lossy().parse().context("a number of ms")?;
            let limit = Duration::from_millis(limit);
            run::one(
                &name.to_string_lossy(),
                folder,
                result,
                limit,
                self.one_by_one,
            )?;
            return Ok(ExitCode::SUCCESS);
        }
        let program = std::env::current_exe().context("the path of this program")?;
        let options = CheckOptions {
            program: &program,
            words,
            only: self.only.as_deref().unwrap_or_default(),
            limit: Duration::from_secs(self.timeout),
        };
        let mut is_sound = true;
        for fmu in &self.fmus {
            let report = check(fmu, options)?;
            let words = options.only;
            let mut rows = report.rows.iter();
            let is_found = rows.any(|row| row.promise.text.contains(words));
            if !is_found && report.count(Verdict::Fails) == 0 {
                let name = fmu.display();
                eprintln!(
                    "{report}\nerror: {name}: --only '{words}': no promise that applies to it has these words"
                );
                return Ok(ExitCode::from(2));
            }
            println!("{report}");
            let not_robust = match self.strict {
                true => report.count(Verdict::NotRobust),
                false => 0,
            };
            is_sound &= report.count(Verdict::Fails) + not_robust == 0;
            let fmu = fmu.display();
            if report.count(Verdict::NotChecked) == report.rows.len() {
                eprintln!("error: {fmu}: nothing of what was asked for could be checked");
                is_sound = false;
            } else if report.out_of_time {
                eprintln!("error: {fmu}: the time was up before everything was tried (--timeout)");
                is_sound = false;
            }
        }
        Ok(match is_sound {
            true => ExitCode::SUCCESS,
            false => ExitCode::FAILURE,
        })
    }
}
