//! The state of a batch of random calls, which `turns` and the modules of calls share: several
//! instances of one FMU, and saved states that they may be given.

use crate::oracle::{Call, Expect};
use crate::random::Random;
use crate::subject::{KnownState, Subject, first_steps};
use anyhow::Result;
use fmi_import::Fmu;
use fmi_import::raw::StateHandle;
use fmi_import::standard::is_allowed;
use std::collections::BTreeMap;
use std::ffi::c_int;
use std::fmt::Arguments;

/// Number of instances in a batch.
pub const INSTANCES: usize = 3;

/// Number of calls of each function that were done, discarded and refused.
pub type Counts = BTreeMap<&'static str, [u64; 3]>;

/// Bytes of a serialized state, and what it is known to hold; None if it is of another FMU.
pub struct Bytes {
    pub bytes: Vec<u8>,
    pub known: Option<KnownState>,
}

/// A batch of random calls.
pub struct Session<'a> {
    pub fmu: &'a Fmu,
    pub random: Random,
    pub instances: Vec<Subject<'a>>,
    /// Serialized states that any instance may be given.
    pub bytes: Vec<Bytes>,
    /// Handles that are freed, or belong to no instance.
    pub stale: Vec<StateHandle>,
    /// Outputs of a new instance in its first steps.
    pub new_bits: Vec<u64>,
    is_traced: bool,
    pub counts: Counts,
    /// Refused calls after which the instance was compared with before.
    pub compared: u64,
    /// Hash (FNV-1a) of all calls, their answers and what was observed before some of them.
    pub digest: u64,
}

impl<'a> Session<'a> {
    /// Starts a batch; `foreign` is another FMU, whose states must be refused.
    pub fn new(fmu: &'a Fmu, foreign: Option<&Fmu>, seed: u64, is_traced: bool) -> Result<Self> {
        let own = Subject::new(fmu, "own")?;
        let mut bytes = vec![Bytes {
            bytes: own.bytes()?,
            known: Some(own.known),
        }];
        if let Some(foreign) = foreign {
            bytes.push(Bytes {
                bytes: Subject::new(foreign, "other")?.bytes()?,
                known: None,
            });
        }
        let new_bits = first_steps(&mut Subject::new(fmu, "new")?)?;
        let names = (0..INSTANCES).map(|k| Subject::new(fmu, &format!("instance {k}")));
        Ok(Self {
            fmu,
            random: Random::new(seed),
            instances: names.collect::<Result<_, _>>()?,
            bytes,
            stale: vec![StateHandle::NULL, StateHandle::INVENTED],
            new_bits,
            is_traced,
            counts: Counts::new(),
            compared: 0,
            digest: 0xcbf2_9ce4_8422_2325,
        })
    }

    /// Prints a call before it is made, when replaying.
    pub fn trace(&self, i: usize, call: Arguments) {
        if self.is_traced {
            eprintln!("instance {i}: {call}");
        }
    }

    /// `Refused` where the standard does not allow the call in the present state.
    pub fn in_order(&self, i: usize, name: &str, expect: Expect) -> Expect {
        match is_allowed(name, self.instances[i].known.mode) {
            true => expect,
            false => Expect::Refused,
        }
    }

    /// The record of a call whose refusal need not name a variable.
    pub fn plain(&self, i: usize, name: &'static str, status: c_int, expect: Expect) -> Call {
        Call {
            name,
            status,
            expect: self.in_order(i, name, expect),
            variables: Vec::new(),
            without_instance: false,
        }
    }
}
