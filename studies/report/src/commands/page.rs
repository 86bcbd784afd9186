//! The command `report`, which `main` calls: finds the systems that the report covers, makes their
//! runs, and writes the page and its figures.

use std::path::{Path, PathBuf};

use crate::evaluation::{RecordedStudies, Report, Request, figures};
use anyhow::Result;
use cosim::Verdict;
use cosim::cli::{bar, find, print};
use experiments::commands::pictures::ReportArgs;
use experiments::worlds::{BENDING_SYSTEM, SYSTEM, World};

/// The packed machine that a battery feeds, reported where its file lies next to the system's.
const ELECTRIC: &str = "Electric.ssp";

/// Makes the runs, then writes page and figures; a failed run is named in the page and printed.
pub fn report(args: &ReportArgs) -> Result<Verdict> {
    let recorded = RecordedStudies::read(args.tournament.as_deref(), args.margins.as_deref())?;
    let setup = args.machine.setup().without_path().build()?;
    let path = args.machine.on_path(&setup)?;
    let packed = |path: &Path| args.machine.setup().packed(path);
    let beside = |name: &str| Some(setup.sibling_path(name)).filter(|path| path.is_file());
    let load = |path: Option<PathBuf>| path.map(|path| packed(&path).system()).transpose();
    let testbed = load(args.testbed.clone().or_else(|| beside("Testbed.ssp")))?;
    let electric = load(beside(ELECTRIC))?;
    let bending = args.bending.then(|| find(BENDING_SYSTEM));
    let bending = load(bending.transpose()?)?;
    let real = beside(SYSTEM).map(|path| packed(&path).world(World::Real).system());
    let real = real.transpose()?;
    let request = Request {
        electric: electric.as_ref(),
        system: &setup.system,
        testbed: testbed.as_ref(),
        real: real.as_ref(),
        bending: bending.as_ref(),
        recorded,
        path,
        base: &setup.base,
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
        let (count, folder_name) = (figures::write(&report, folder)?.len(), folder.display());
        print(format_args!("{count} figures written to {folder_name}\n"))?;
    }
    Ok(setup.verdict)
}
