//! From a fresh checkout to the coupled machine: builds, packs, runs the cubic trajectory with three controllers, and writes a report.

use anyhow::Result;

use crate::workspace::{Workspace, execute};
use crate::{libclang, pack};

/// Do it all, with CSV files, report and figures in `demo/` of the target directory.
pub fn run(workspace: &Workspace) -> Result<()> {
    println!("building and packing the three FMUs");
    pack::suite(workspace, &workspace.fmu_dir())?;
    println!("building the co-simulation master");
    let cosim = libclang::build_cosim(workspace)?;
    let system = workspace.fmu_dir().join("Manipulator.ssp");
    let out = workspace.target.join("demo");
    std::fs::create_dir_all(&out)?;
    println!("running the cubic trajectory: five coupled FMU instances, H = 1 ms");
    execute(
        workspace
            .command(&cosim)
            .args(["compare", "--trajectory", "cubic", "--system"])
            .arg(&system)
            .arg("--csv-dir")
            .arg(&out),
    )?;
    println!("\nwriting the report: both trajectories, the robustness table, testbed, energy");
    let report = out.join("report.html");
    execute(
        workspace
            .command(&cosim)
            .args(["report", "--system"])
            .arg(&system)
            .arg("--out")
            .arg(&report)
            .arg("--figures")
            .arg(out.join("figures")),
    )?;
    println!("open {} in a browser", report.display());
    Ok(())
}
