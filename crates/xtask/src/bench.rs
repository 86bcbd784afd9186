//! Measurements: the crates' benches and the coupled real-time factor.

use anyhow::Result;

use crate::workspace::{Workspace, execute};
use crate::{libclang, pack};

/// Run the benches of the crates, then the coupled system.
pub fn run(workspace: &Workspace) -> Result<()> {
    let environment = libclang::provide(workspace)?;
    execute(
        workspace
            .cargo(["bench", "--workspace", "--benches"])
            .envs(environment),
    )?;
    pack::suite(workspace, &workspace.fmu_dir())?;
    let cosim = libclang::build_cosim(workspace)?;
    let system = workspace.fmu_dir().join("Manipulator.ssp");
    execute(
        workspace
            .command(cosim)
            .args(["bench", "--system"])
            .arg(system),
    )
}
