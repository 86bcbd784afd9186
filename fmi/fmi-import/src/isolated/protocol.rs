//! What a program and the process of an isolated instance say to each other: the layout of the
//! memory that they share, requests, answers and errors.
//!
//! Numbers pass through the memory, from its beginning whenever no call is under way; all else
//! passes through a socket. A request is its text in [`HEADER`] words, the number of variables of a
//! new batch, the number of values, the variables, the values. An answer is its kind and the number
//! of values, a number, the values.

use std::collections::{BTreeSet, HashMap};
use std::ffi::CString;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::AtomicU64;

use anyhow::{Error, anyhow};
use fmu_solver::Choice;
use serde::{Deserialize, Serialize};

use super::segment::Count;
use crate::Limits;
use crate::answer::{Answer, Ended, Stopped};
use crate::fmi_instance::{Arguments, Call, Integration};
use crate::messages::Message;
use crate::standard::Function;
use crate::value::Value;

/// Most calls that are begun at a time.
pub const CALLS: usize = 64;
/// Words of a request before the number of its variables.
pub const HEADER: usize = 8;
/// Words for all requests, and for all answers, that are under way.
pub const ROOM: usize = 1 << 22;
/// Where requests begin, and answers.
const REQUESTS: usize = 256;
const ANSWERS: usize = REQUESTS + ROOM;
/// Words of the memory.
pub const WORDS: usize = ANSWERS + ROOM;
/// In the place of a request: no call was under way before it.
pub const FIRST: u64 = 1 << 63;

/// The memory, in its parts. Those that different processes write have cache lines of their own.
#[derive(Clone, Copy)]
pub struct Layout<'a>(pub &'a [AtomicU64]);

impl<'a> Layout<'a> {
    /// Requests that were made.
    pub fn requested(self) -> Count<'a> {
        Count::new([&self.0[0], &self.0[1]], &self.0[8])
    }

    /// Answers that were given.
    pub fn answered(self) -> Count<'a> {
        Count::new([&self.0[16], &self.0[17]], &self.0[24])
    }

    /// How often the process looks for a request before it sleeps.
    pub fn spins(self) -> &'a AtomicU64 {
        &self.0[32]
    }

    /// Where the request of this number begins.
    pub fn place(self, number: u32) -> &'a AtomicU64 {
        &self.0[64 + number as usize % CALLS]
    }

    /// What the process says when it is ended: see
    /// [`keep_last_words`](crate::under_way::keep_last_words).
    pub fn last_words(self) -> &'a [AtomicU64] {
        &self.0[128..REQUESTS]
    }

    pub fn requests(self) -> &'a [AtomicU64] {
        &self.0[REQUESTS..ANSWERS]
    }

    pub fn answers(self) -> &'a [AtomicU64] {
        &self.0[ANSWERS..WORDS]
    }
}

/// Kinds of answers: a number and values, or bytes in the socket, or an error in the socket.
pub const NUMBERS: u64 = 0;
pub const BYTES: u64 = 1;
pub const ERROR: u64 = 2;

/// How the values of a batch are passed.
#[derive(Clone, Copy, Deserialize, Serialize)]
pub enum Pass {
    Get,
    Set,
    GetDerivatives,
    SetDerivatives,
}

/// A request in the memory.
#[derive(Deserialize, Serialize)]
pub enum Request {
    Plain(Call),
    /// With the number of the batch.
    Pass(Pass, u32),
    /// A [`RareRequest`] follows in the socket.
    Rare,
}

impl Request {
    /// What it is, for messages.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Plain(Call::Step(..)) => "a step",
            Self::Plain(Call::EnterInitialization(_) | Call::ExitInitialization) => {
                "its initialization"
            }
            Self::Plain(Call::Terminate) => "its termination",
            Self::Plain(_) => "a call",
            Self::Pass(Pass::Get | Pass::GetDerivatives, _) => "a read of values",
            Self::Pass(Pass::Set | Pass::SetDerivatives, _) => "a set of values",
            Self::Rare => "a rare call, such as loading, instantiation or freeing",
        }
    }
}

/// A batch by its number; with its variables if the process does not know it.
#[derive(Deserialize, Serialize)]
pub struct NamedBatch(pub u32, pub Option<Vec<usize>>);

/// A request in the socket.
#[derive(Deserialize, Serialize)]
pub enum RareRequest {
    Host(Box<Hosting>),
    LogOnly(Vec<CString>),
    GetValues(NamedBatch),
    SetValues(NamedBatch, Vec<Value>),
    Directional([NamedBatch; 2], Vec<f64>),
    Integration,
    Save,
    Restore(usize),
    Forget(usize),
    StateToBytes(usize),
    StateFromBytes(Vec<u8>),
    Reset,
    /// Free the instance and end.
    End,
}

/// The answer to a [`RareRequest`] or a rare call.
#[derive(Deserialize, Serialize)]
pub enum RareAnswer {
    Done,
    Is(bool),
    Number(f64),
    Numbers(Vec<f64>),
    Values(Vec<Value>),
    Integration(Option<Integration>),
    State(usize),
    Bytes(Vec<u8>),
}

/// The instance that a process hosts.
#[derive(Deserialize, Serialize)]
pub struct Hosting {
    /// Name of the FMU for messages.
    pub file: String,
    /// Path of its library.
    pub library: PathBuf,
    /// Its model description, and values of structural parameters.
    pub description: PathBuf,
    pub sizes: HashMap<u32, String>,
    /// How it is integrated, if it is for Model Exchange.
    pub exchange: Option<Integrating>,
    pub arguments: Arguments,
    pub limits: Limits,
}

/// What an [`ExchangePlan`](crate::ExchangePlan) has besides the description: the method, and the
/// outputs of which means are wanted with the variables that get them.
#[derive(Deserialize, Serialize)]
pub struct Integrating {
    #[serde(with = "ChoiceDef")]
    pub choice: Choice,
    pub means: Vec<[usize; 2]>,
}

#[derive(Deserialize, Serialize)]
#[serde(remote = "Choice")]
enum ChoiceDef {
    Automatic,
    Explicit,
    Stiff,
    Fixed(f64),
}

/// An error of an instance with the messages before it.
#[derive(Deserialize, Serialize)]
pub struct Failed {
    pub reason: Reason,
    pub messages: Vec<Message>,
}

#[derive(Deserialize, Serialize)]
pub enum Reason {
    Answer { status: i32, call: String },
    Ended { call: String, time: f64 },
    Stopped { name: String, time: Option<f64> },
    Text(String),
}

impl From<&Error> for Reason {
    fn from(error: &Error) -> Self {
        if let Some(Ended { call, time }) = error.downcast_ref() {
            let (call, time) = (call.to_string(), *time);
            Self::Ended { call, time }
        } else if let Some(Stopped { name, time }) = error.downcast_ref() {
            let (name, time) = (name.clone(), *time);
            Self::Stopped { name, time }
        } else if let Some(Answer { status, call }) = error.downcast_ref() {
            let (status, call) = (*status, call.to_string());
            Self::Answer { status, call }
        } else {
            Self::Text(format!("{error:#}"))
        }
    }
}

impl From<Reason> for Error {
    fn from(reason: Reason) -> Self {
        match reason {
            Reason::Answer { status, call } => {
                let call = constant(call);
                Answer { status, call }.into()
            }
            Reason::Ended { call, time } => {
                let call = constant(call);
                Ended { call, time }.into()
            }
            Reason::Stopped { name, time } => Stopped { name, time }.into(),
            Reason::Text(text) => anyhow!(text),
        }
    }
}

/// The name of a function, as those of this process are kept. There are few that are no functions
/// of FMI.
fn constant(name: String) -> &'static str {
    static OTHERS: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    if let Some(function) = Function::named(&name) {
        return function.name;
    }
    let Ok(mut others) = OTHERS.lock() else {
        return "a function";
    };
    if let Some(known) = others.get(&*name) {
        return known;
    }
    let new: &'static str = name.leak();
    others.insert(new);
    new
}

/// Whether a call is made so often that the FMU's messages wait for another one.
pub fn is_frequent(call: Call) -> bool {
    !matches!(
        call,
        Call::SetUp(_)
            | Call::EnterConfiguration
            | Call::ExitConfiguration
            | Call::EnterInitialization(_)
            | Call::ExitInitialization
            | Call::StopEarly(_)
            | Call::Terminate
    )
}
