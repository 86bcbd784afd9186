//! The machines of the real world, drawn by seed within [`Bounds::REAL`], and the files that hold
//! them.
//!
//! Zeros of the joint encoders and errors of the other sensors are drawn by the same seed. The
//! actuators are those of the system, `Rig`, of whose friction, play, compliance, heat and drive
//! the controller knows nothing.

use std::fs;
use std::ops::Range;

use anyhow::{Context, Result};
use cosim::System;
use tempfile::TempDir;

use super::perturbation::{Bounds, draw};
use crate::grid::Case;
use crate::machine_file::MachineFile;

/// Packed system of the real world.
pub const SYSTEM: &str = "Real.ssp";
/// Its parameter set: what is changed in the controller, and in where the delay is, for this world.
pub const PARAMETERS: &str = "resources/real.ssv";
/// The same for shipped machines whose own differ.
const PARAMETERS_OF: [(&str, &str); 1] = [("hiab_xs031", "resources/real_hiab_xs031.ssv")];
/// Machines that are drawn where no number is asked for.
pub const SEEDS: u64 = 20;

/// The parameter set of the machine `name`, or of one that extends it; of any other machine that of
/// the reference machine.
pub fn parameters_of(name: Option<&str>) -> &'static str {
    let own = PARAMETERS_OF.iter().find(|(of, _)| name == Some(*of));
    own.map_or(PARAMETERS, |(_, file)| file)
}

/// Machines drawn within bounds; their files exist as long as this.
pub struct DrawnMachines {
    /// One case for each machine.
    pub cases: Vec<Case>,
    _folder: TempDir,
}

impl DrawnMachines {
    /// One case for each seed: the machine of the manipulator and the seed of the sensors.
    ///
    /// # Errors
    /// A system without `hdrm` or `sensors`, or no place for files.
    pub fn draw(system: &System, seeds: Range<u64>, bounds: &Bounds) -> Result<Self> {
        let nominal = MachineFile::of(system, &[])?.machine;
        let folder = TempDir::new().context("no folder for the machine files")?;
        let mut cases = Vec::new();
        for seed in seeds {
            let (machine, gravity) = draw(&nominal, seed, bounds)?;
            let path = folder.path().join(format!("machine_{seed}.json"));
            let text = serde_json::to_string_pretty(&machine)?;
            fs::write(&path, text).with_context(|| path.display().to_string())?;
            let mut settings = vec![
                system.setting("hdrm.machine_file", path.display())?,
                system.setting("sensors.seed", seed)?,
            ];
            for (axis, value) in (1..).zip(gravity) {
                settings.push(system.setting(&format!("hdrm.gravity[{axis}]"), value)?);
            }
            cases.push(Case::of_seed(seed, settings));
        }
        Ok(Self {
            cases,
            _folder: folder,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn a_parameter_set_of_a_machine_exists_and_is_found_by_its_name() {
        let system = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../system");
        for (name, file) in PARAMETERS_OF {
            assert!(machine::preset(name).is_some(), "{name}");
            assert!(system.join(file).is_file(), "{file}");
            assert_eq!(parameters_of(Some(name)), file);
        }
        for name in [None, Some("reference"), Some("sized")] {
            assert_eq!(parameters_of(name), PARAMETERS);
        }
    }
}
