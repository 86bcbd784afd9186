//! Snapshots: a run at a communication point as bytes, from which another process resumes it with
//! bit-identical results. `simulate` writes and reads them (`--snapshot`, `--resume`).

use anyhow::{Context, Result, bail, ensure};
use serde::{Deserialize, Serialize};

use crate::master::{Master, Saved};
use crate::run::divergence::Watch;
use crate::run::run_key::{RunKey, STOP_TIME};
use crate::run::supervision::Supervision;
use crate::stepping::{Progress, Steps};

/// First bytes of a snapshot, with the version of the format; a checksum follows.
const MAGIC: &[u8] = b"cosim snapshot 3\n";
const HEADER: usize = MAGIC.len() + 4;

#[derive(Deserialize, Serialize)]
struct Snapshot {
    key: RunKey,
    progress: Progress,
    watch: Watch,
    raised: Vec<Option<[f64; 2]>>,
    master: Saved<Vec<u8>>,
}

/// A run in progress: its key and all that changes from one communication point to the next.
pub struct RunState<'a> {
    /// What the run depends on; snapshots need it.
    pub key: Option<&'a RunKey>,
    /// The running system.
    pub master: Master,
    /// The steps, made and to come.
    pub steps: Steps,
    /// The findings so far.
    pub supervision: Supervision,
}

impl RunState<'_> {
    fn key(&self) -> Result<&RunKey> {
        self.key.context("snapshots need the key of the run")
    }

    /// The run as bytes; every FMU must be able to serialize its state.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let snapshot = postcard::to_stdvec(&Snapshot {
            key: self.key()?.clone(),
            progress: self.steps.progress(),
            watch: self.supervision.watch.clone(),
            raised: self.supervision.alarms.raised.clone(),
            master: self.master.save_bytes()?,
        })?;
        let sum = crc32fast::hash(&snapshot).to_le_bytes();
        Ok([MAGIC, &sum, &snapshot].concat())
    }

    /// Resumes from the bytes of a snapshot, which must be of the same run; only its stop time may
    /// be another.
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
        let difference = (self.key()?).difference(&snapshot.key, "in the snapshot", STOP_TIME);
        if let Some(difference) = difference {
            bail!(
                "the snapshot is of another run: {difference}. Resume with what the run was saved with, or start anew without --resume"
            );
        }
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
