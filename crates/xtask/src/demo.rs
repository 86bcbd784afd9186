//! From a fresh checkout to the coupled machine: builds, packs, runs the cubic trajectory with three controllers, and writes a report.

use anyhow::Result;
use cargo_fmu::process::execute;

use crate::phases::Phases;
use crate::workspace::Workspace;
use crate::{libclang, pack};

/// Do it all, with CSV files, report and figures in `demo/` of the target directory.
pub fn run(workspace: &Workspace) -> Result<()> {
    let phases = Phases::default();
    let fmus = || {
        phases.run("build and pack the FMUs", || {
            pack::suite(workspace, &workspace.fmu_dir())
        })
    };
    let program = || {
        phases.run("build the program of the experiments", || {
            libclang::build_hdrm_fmu(workspace)
        })
    };
    let (_, hdrm_fmu) = phases.both(fmus, program)?;
    let system = workspace.fmu_dir().join("Manipulator.ssp");
    let out = workspace.target.join("demo");
    std::fs::create_dir_all(&out)?;
    phases.run("run the cubic trajectory", || {
        let mut compare = workspace.command(&hdrm_fmu);
        compare.args([
            "compare",
            "--trajectory",
            "cubic",
            "--interval",
            "0.01",
            "--system",
        ]);
        execute(compare.arg(&system).arg("--csv-dir").arg(&out))
    })?;
    let report = out.join("report.html");
    phases.run("write the report", || {
        let mut command = workspace.command(&hdrm_fmu);
        command.args(["report", "--system"]).arg(&system);
        command.arg("--out").arg(&report);
        execute(command.arg("--figures").arg(out.join("figures")))
    })?;
    print!("\n{}", phases.table());
    println!("open {} in a browser", report.display());
    Ok(())
}
