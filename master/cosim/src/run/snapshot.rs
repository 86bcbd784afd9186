//! Snapshots: a run at a communication point as bytes, from which another process resumes it with
//! bit-identical results. `simulate` writes and reads them (`--snapshot`, `--resume`).

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};

use crate::master::{Master, Saved, Stepping};
use crate::run::divergence::Watch;
use crate::run::supervision::Supervision;
use crate::stepping::{Progress, StepControl, Steps};
use crate::structure::system::System;

/// First bytes of a snapshot, with the version of the format; a checksum follows.
const MAGIC: &[u8] = b"cosim snapshot 3\n";
const HEADER: usize = MAGIC.len() + 4;

#[derive(Deserialize, Serialize)]
struct Snapshot {
    /// Name of each component, and the token of its FMU.
    components: Vec<[String; 2]>,
    stepping: Stepping,
    control: StepControl,
    progress: Progress,
    watch: Watch,
    raised: Vec<Option<[f64; 2]>>,
    master: Saved<Vec<u8>>,
}

/// A run in progress: its system and all that changes from one communication point to the next.
pub struct RunState<'a> {
    /// The system.
    pub system: &'a System,
    /// How the lengths of its steps are chosen.
    pub control: StepControl,
    /// The running system.
    pub master: Master,
    /// The steps, made and to come.
    pub steps: Steps,
    /// The findings so far.
    pub supervision: Supervision,
}

impl RunState<'_> {
    fn components(&self) -> Vec<[String; 2]> {
        let all = self.system.structure.components.iter();
        let all = all.zip(&self.system.fmus);
        all.map(|(c, fmu)| [c.name.clone(), fmu.description.guid.clone()])
            .collect()
    }

    /// The run as bytes; every FMU must be able to serialize its state.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let snapshot = postcard::to_stdvec(&Snapshot {
            components: self.components(),
            stepping: self.master.stepping(),
            control: self.control,
            progress: self.steps.progress(),
            watch: self.supervision.watch.clone(),
            raised: self.supervision.alarms.raised.clone(),
            master: self.master.save_bytes()?,
        })?;
        let sum = crc32fast::hash(&snapshot).to_le_bytes();
        Ok([MAGIC, &sum, &snapshot].concat())
    }

    /// Resumes from the bytes of a snapshot, which must be of a run of the same components and
    /// steps.
    pub fn resume(&mut self, bytes: &[u8]) -> Result<()> {
        ensure!(
            bytes.len() >= HEADER && bytes.starts_with(MAGIC),
            "not a snapshot of this version of cosim"
        );
        let (sum, bytes) = bytes[MAGIC.len()..].split_at(4);
        ensure!(
            crc32fast::hash(bytes).to_le_bytes() == sum,
            "the snapshot is damaged: its checksum is wrong"
        );
        let snapshot: Snapshot = postcard::from_bytes(bytes).context("the snapshot is damaged")?;
        for (own, [name, token]) in self.components().iter().zip(&snapshot.components) {
            ensure!(
                own[0] == *name && own[1] == *token,
                "the snapshot has the component `{name}` of the FMU {token} where this system has `{}` of {}",
                own[0],
                own[1]
            );
        }
        let [own, saved] = [self.components().len(), snapshot.components.len()];
        ensure!(
            own == saved,
            "the snapshot is of {saved} components, this system has {own}"
        );
        let (own, saved) = (self.master.stepping(), snapshot.stepping);
        ensure!(
            own == saved && self.control == snapshot.control,
            "the snapshot is of a run with other steps: {saved:?}, {:?}, where this one has {own:?}, {:?}",
            snapshot.control,
            self.control
        );
        self.master.restore_bytes(snapshot.master)?;
        self.steps.resume(&self.master, snapshot.progress)?;
        ensure!(
            self.supervision.alarms.raised.len() == snapshot.raised.len(),
            "the snapshot is of a run with other alarms"
        );
        self.supervision.watch = snapshot.watch;
        self.supervision.alarms.raised = snapshot.raised;
        Ok(())
    }
}
