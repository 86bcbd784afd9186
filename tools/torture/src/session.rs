//! The state of a batch of random calls: several instances of one FMU, and what they may be given.

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

/// Instances that take turns.
pub const INSTANCES: usize = 3;

/// How often each function was called: done, discarded, refused.
pub type Counts = BTreeMap<&'static str, [u64; 3]>;

/// Serialized bytes and what they hold; those of another FMU hold nothing.
pub struct Bytes {
    pub bytes: Vec<u8>,
    pub known: Option<KnownState>,
}

/// The state of a batch.
pub struct Session<'a> {
    pub fmu: &'a Fmu,
    pub random: Random,
    pub instances: Vec<Subject<'a>>,
    /// Serialized states that any instance may be given.
    pub bytes: Vec<Bytes>,
    /// Handles that are freed, or belong to no instance.
    pub stale: Vec<StateHandle>,
    /// What a new instance does in its first steps.
    pub new_bits: Vec<u64>,
    is_traced: bool,
    pub counts: Counts,
    /// Refused calls after which the instance was compared with before.
    pub compared: u64,
    /// Hash (FNV-1a) of all calls, their answers and what was observed before some of them.
    pub digest: u64,
}

impl<'a> Session<'a> {
    /// A batch; `foreign` is another FMU, whose states must be refused.
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

    /// A call whose refusal need not name a variable.
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
