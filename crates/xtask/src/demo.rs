//! From a fresh checkout to the coupled machine: builds, packs, and runs the cubic trajectory with three controllers.

use anyhow::Result;

use crate::workspace::{Workspace, execute};
use crate::{libclang, pack};

/// Do it all, with the CSV files in `demo/` of the target directory.
pub fn run(workspace: &Workspace) -> Result<()> {
    println!("building and packing the three FMUs");
    pack::suite(workspace, &workspace.fmu_dir())?;
    println!("building the co-simulation master");
    let cosim = libclang::build_cosim(workspace)?;
    let system = workspace.fmu_dir().join("Manipulator.ssp");
    let out = workspace.target.join("demo");
    std::fs::create_dir_all(&out)?;
    println!("running the cubic trajectory: five coupled FMU instances, H = 1 ms");
    let mut command = workspace.command(cosim);
    execute(
        command
            .args(["compare", "--trajectory", "cubic", "--system"])
            .arg(system)
            .arg("--csv-dir")
            .arg(out),
    )
}
