//! Subcommand `report`.

use std::path::Path;

use crate::report::{Recorded, Report, Request, figures};
use anyhow::Result;
use cosim::Verdict;
use cosim::cli::{bar, find, print};
use experiments::bench::Bench;
use experiments::commands::pictures::ReportArgs;
use experiments::worlds::{BENDING_SYSTEM, SYSTEM, World};

/// The packed machine that a battery feeds, shown where it lies beside the system.
const ELECTRIC: &str = "Electric.ssp";

/// Make the runs, then write page and figures; a run that failed is named in the page and here.
pub fn report(args: &ReportArgs) -> Result<Verdict> {
    let recorded = Recorded::read(args.tournament.as_deref(), args.margins.as_deref())?;
    let bench = args.machine.bench().without_path().build()?;
    let path = args.machine.on_path(&bench)?;
    let packed = |path: &Path| args.machine.bench().packed(path);
    let beside = |name: &str| Some(bench.beside(name)).filter(|path| path.is_file());
    let testbed = args.testbed.clone().or_else(|| beside("Testbed.ssp"));
    let testbed = testbed.map(|path| packed(&path).system()).transpose()?;
    let real = beside(SYSTEM).map(|path| packed(&path).world(World::Real).system());
    let real = real.transpose()?;
    let bending = args
        .bending
        .then(|| packed(&find(BENDING_SYSTEM)?).system());
    let bending = bending.transpose()?;
    let electric = beside(ELECTRIC).map(|path| packed(&path).system());
    let electric = electric.transpose()?;
    let Bench {
        system,
        base,
        verdict,
    } = bench;
    let request = Request {
        electric: electric.as_ref(),
        system: &system,
        testbed: testbed.as_ref(),
        real: real.as_ref(),
        bending: bending.as_ref(),
        recorded,
        path,
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
