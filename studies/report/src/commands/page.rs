//! Subcommand `report`.

use std::path::Path;

use crate::evaluation::{Recorded, Report, Request, figures};
use anyhow::Result;
use cosim::Verdict;
use cosim::cli::{bar, find, print};
use experiments::commands::pictures::ReportArgs;
use experiments::setup::run_setup::RunSetup;
use experiments::worlds::{BENDING_SYSTEM, SYSTEM, World};

/// The packed machine that a battery feeds, shown where it lies beside the system.
const ELECTRIC: &str = "Electric.ssp";

/// Make the runs, then write page and figures; a run that failed is named in the page and here.
pub fn report(args: &ReportArgs) -> Result<Verdict> {
    let recorded = Recorded::read(args.tournament.as_deref(), args.margins.as_deref())?;
    let setup = args.machine.setup().without_path().build()?;
    let path = args.machine.on_path(&setup)?;
    let packed = |path: &Path| args.machine.setup().packed(path);
    let beside = |name: &str| Some(setup.sibling_path(name)).filter(|path| path.is_file());
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
    let RunSetup {
        system,
        base,
        verdict,
    } = setup;
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
