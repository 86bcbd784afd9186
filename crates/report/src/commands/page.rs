//! Subcommand `report`.

use std::path::PathBuf;

use crate::report::{Report, Request, figures};
use anyhow::Result;
use clap::Args;
use cosim::cli::{bar, find, print};
use cosim::verdict::Verdict;
use studies::worlds::{BENDING_SYSTEM, SYSTEM};

use studies::commands::MachineArgs;

/// The packed machine that a battery feeds, shown where it lies beside the system.
const ELECTRIC: &str = "Electric.ssp";

#[derive(Args)]
pub struct ReportArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// HTML file to write
    #[arg(long, default_value = "report.html", value_name = "FILE")]
    out: PathBuf,
    /// Also write the figures as PNG and SVG into this directory
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// One-axis experiment: a packed .ssp [default: Testbed.ssp beside the system, where there is one]
    #[arg(long, value_name = "FILE")]
    testbed: Option<PathBuf>,
    /// Also run the world in which the structure bends: needs a Python with MuJoCo, and some minutes more
    #[arg(long)]
    pub bending: bool,
}

/// Make the runs, then write page and figures; a run that failed is named in the page and here.
pub fn report(args: &ReportArgs) -> Result<Verdict> {
    let (system, base, verdict) = args.machine.load_without_path()?;
    let beside = system.path.with_file_name("Testbed.ssp");
    let testbed = args
        .testbed
        .clone()
        .or_else(|| beside.is_file().then_some(beside));
    let testbed = testbed.map(|path| args.machine.beside(&path)).transpose()?;
    let real = system.path.with_file_name(SYSTEM);
    let real = real
        .is_file()
        .then(|| args.machine.real(&real))
        .transpose()?;
    let bending = args.bending.then(|| {
        let path = find(BENDING_SYSTEM)?;
        args.machine.beside(&path)
    });
    let bending = bending.transpose()?;
    let electric = system.path.with_file_name(ELECTRIC);
    let electric = electric
        .is_file()
        .then(|| args.machine.beside(&electric))
        .transpose()?;
    let request = Request {
        electric: electric.as_ref(),
        system: &system,
        testbed: testbed.as_ref(),
        real: real.as_ref(),
        bending: bending.as_ref(),
        path: args.machine.on_path(&system, &base)?,
        base: &base,
    };
    let bar = bar(0, "runs", false);
    let report = Report::new(&request, |done, total| {
        bar.set_length(total);
        bar.set_position(done);
    });
    bar.finish_and_clear();
    let report = report?;
    print(report.summary())?;
    report.write(&args.out)?;
    print(format_args!("report written to {}\n", args.out.display()))?;
    if let Some(folder) = &args.figures {
        let files = figures::write(&report, folder)?;
        let count = files.len();
        print(format_args!(
            "{count} figures written to {}\n",
            folder.display()
        ))?;
    }
    Ok(verdict)
}
