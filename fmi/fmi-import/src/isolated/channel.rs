//! [`Channel`]: the end that a program has of the connection to the process of an isolated instance:
//! requests, their answers, and how the process ended, for `instance`.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::process::{ExitStatus, Stdio};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::atomic::{AtomicU64, AtomicUsize};
use std::time::{Duration, Instant};

use anyhow::{Context, Error, Result, anyhow, bail};
use serde::de::DeserializeOwned;

use super::program::command;
use super::protocol::{
    BYTES, CALLS, ERROR, FIRST, Failed, HEADER, Layout, NUMBERS, ROOM, RareAnswer, RareRequest,
    Request, WORDS,
};
use super::segment::{Patience, SPINS, Segment};
use crate::Limits;
use crate::messages::{self, Message};
use crate::process::Process;
use crate::status::FATAL;
use crate::under_way::last_words;

/// How long a thread sleeps before it looks whether the process is still there.
const NAP: Duration = Duration::from_millis(20);
/// The process ends itself at the limit of a call; if it cannot, it is killed so long after.
const GRACE: Duration = Duration::from_secs(2);

/// Processes of isolated instances that this program has.
static PROCESSES: AtomicUsize = AtomicUsize::new(0);

/// What is done with an answer.
#[derive(Clone, Copy)]
pub enum Due {
    Wanted,
    /// To a set of the batch of this number, which was ended before.
    Late(u32),
    /// To a read of the batch of this number, which is made ahead.
    Ahead(u32),
    Dropped,
}

/// A number, with the values of the answer; or bytes.
pub type Answered = std::result::Result<f64, Vec<u8>>;

/// The connection to a process, which ends with it.
pub struct Channel {
    name: String,
    limits: Limits,
    process: RefCell<Process>,
    socket: UnixStream,
    segment: Segment,
    /// Requests that were made, and answers that were taken.
    requested: Cell<u32>,
    taken: Cell<u32>,
    /// Where the next request and the next answer are, and where answers that are due may end.
    places: Cell<[usize; 3]>,
    /// What is done with the answers that were not asked for yet, in their order, and how many of
    /// them are wanted.
    pub due: RefCell<VecDeque<Due>>,
    pub wanted: Cell<usize>,
    /// Answers that were taken to make room before they were asked for.
    early: RefCell<VecDeque<(Vec<u64>, Vec<u8>)>>,
    /// What was requested, by number, in words.
    names: RefCell<[&'static str; CALLS]>,
    patience: Patience,
    /// The process must be woken.
    wakes: Cell<bool>,
    /// Why the process has ended.
    end: RefCell<Option<String>>,
}

impl Channel {
    /// Starts the process of the instance `name`.
    pub fn start(name: String, limits: Limits) -> Result<Self> {
        let (segment, file) = Segment::new(WORDS)?;
        let (socket, other) = UnixStream::pair()?;
        let mut command = command(&name)?;
        command.stdin(Stdio::from(OwnedFd::from(other)));
        command.stdout(Stdio::from(file));
        let process = Process::start(&mut command)
            .with_context(|| format!("{:?} cannot be started", command.get_program()))?;
        socket.set_read_timeout(limits.time.map(|time| time + GRACE))?;
        PROCESSES.fetch_add(1, Relaxed);
        Ok(Self {
            name,
            limits,
            process: RefCell::new(process),
            socket,
            segment,
            requested: Cell::new(0),
            taken: Cell::new(0),
            places: Cell::new([0; 3]),
            due: RefCell::new(VecDeque::with_capacity(CALLS)),
            wanted: Cell::new(0),
            early: RefCell::default(),
            names: RefCell::new([""; CALLS]),
            patience: Patience::default(),
            wakes: Cell::new(false),
            end: RefCell::new(None),
        })
    }

    fn memory(&self) -> Layout<'_> {
        Layout(self.segment.words())
    }

    /// Whether the process has ended.
    pub fn is_over(&self) -> bool {
        self.end.borrow().is_some()
    }

    /// Spinning pays where each process has a core: from when all instances have been made.
    pub fn choose_spins(&self) {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let spins = match PROCESSES.load(Relaxed) < cores {
            true => SPINS,
            false => 0,
        };
        self.patience.spins.set(spins);
        self.memory().spins().store(spins, Relaxed);
    }

    /// Writes a request with the variables of a new batch, and values, of which there are `count`:
    /// those of a rare request follow in the socket. The answer has up to `expected` values.
    pub fn request(
        &self,
        (request, due): (&Request, Due),
        new: &[usize],
        (values, count): (&[f64], usize),
        expected: usize,
    ) {
        let length = HEADER + 2 + new.len() + values.len();
        let [_, _, end] = self.places.get();
        let is_full = self.places.get()[0] + length > ROOM || end + 2 + expected > ROOM;
        if is_full || self.under_way() as usize == CALLS {
            self.take_early();
        }
        if self.under_way() == 0 {
            self.places.set([0; 3]);
        }
        let [at, answer, end] = self.places.get();
        let is_first = self.due.borrow().is_empty();
        self.due.borrow_mut().push_back(due);
        let is_wanted = matches!(due, Due::Wanted);
        self.wanted.set(self.wanted.get() + usize::from(is_wanted));
        let (memory, number) = (self.memory(), self.requested.get().wrapping_add(1));
        let place = at as u64 | if is_first { FIRST } else { 0 };
        memory.place(number).store(place, Relaxed);
        let mut header = [0; 8 * HEADER];
        postcard::to_slice(request, &mut header).expect("requests are short");
        let word = |bytes: &[u8]| u64::from_le_bytes(bytes.try_into().expect("8 bytes"));
        let words = header.chunks(8).map(word);
        let words = words.chain([new.len() as u64, count as u64]);
        let words = words.chain(new.iter().map(|variable| *variable as u64));
        let words = words.chain(values.iter().map(|value| value.to_bits()));
        let room = &memory.requests()[at..];
        (room.iter().zip(words)).for_each(|(to, word)| to.store(word, Relaxed));
        self.names.borrow_mut()[number as usize % CALLS] = request.name();
        self.places.set([at + length, answer, end + 2 + expected]);
        self.requested.set(number);
        memory.requested().set(number);
        self.wakes.set(true);
    }

    /// Wakes the process for what was requested.
    pub fn wake(&self) {
        if self.wakes.replace(false) {
            self.memory().requested().wake();
        }
    }

    /// Requests whose answers were not taken.
    fn under_way(&self) -> u32 {
        self.requested.get().wrapping_sub(self.taken.get())
    }

    /// Takes all answers that are due, so that there is room for further calls.
    #[cold]
    fn take_early(&self) {
        while self.under_way() > 0 {
            let Ok([kind, number, values @ ..]) = self.await_answer() else {
                return; // The next call says why.
            };
            let [kind, number] = [kind, number].map(|word| word.load(Relaxed));
            let values = values.iter().take((kind >> 2) as usize);
            let mut words = vec![kind, number];
            words.extend(values.map(|word| word.load(Relaxed)));
            self.pass_answer(words.len());
            let bytes = self.read_bytes(kind, number).unwrap_or_default();
            self.early.borrow_mut().push_back((words, bytes));
        }
    }

    /// Awaits the next answer; returns its words, and those behind it.
    fn await_answer(&self) -> Result<&[AtomicU64]> {
        if let Some(end) = &*self.end.borrow() {
            bail!("{end}");
        }
        self.wake();
        let number = self.taken.get().wrapping_add(1);
        let answered = self.memory().answered();
        let found = answered.spin(number, &self.patience);
        let begun = (!found).then(Instant::now);
        while !answered.has_reached(number) {
            // Once for all that is under way.
            answered.sleep(self.requested.get(), Some(NAP));
            if !answered.has_reached(number) {
                self.look(begun)?;
            }
        }
        let [_, place, _] = self.places.get();
        Ok(self.memory().answers().get(place..).unwrap_or_default())
    }

    fn pass_answer(&self, length: usize) {
        let [request, answer, end] = self.places.get();
        self.places.set([request, answer + length, end]);
        self.taken.set(self.taken.get().wrapping_add(1));
    }

    /// What the process says of its end: what it told itself, without the name of the instance, else
    /// what it was asked for.
    fn reason(&self, status: ExitStatus) -> String {
        let own = [format!("{}: ", self.name), "FMU `".into()];
        match last_words(self.memory().last_words()) {
            Some(told) if told.starts_with(&own[0]) => told[own[0].len()..].to_string(),
            Some(told) if told.starts_with(&own[1]) => {
                let call = told.split_once("`: ").map(|(_, call)| call.to_string());
                call.unwrap_or(told)
            }
            Some(told) => told,
            None => {
                let names = self.names.borrow();
                let name = names[self.taken.get().wrapping_add(1) as usize % CALLS];
                format!("its process ended in {name} ({status})")
            }
        }
    }

    /// Looks whether the process is still there, and has time left for the calls that are under way,
    /// of which the first was `begun`.
    #[cold]
    fn look(&self, begun: Option<Instant>) -> Result<()> {
        let mut process = self.process.borrow_mut();
        if let Some(status) = process.status()? {
            // It may have answered just before.
            let number = self.taken.get().wrapping_add(1);
            if self.memory().answered().has_reached(number) {
                return Ok(());
            }
            return Err(self.over(self.reason(status)));
        }
        let (Some(time), Some(begun)) = (self.limits.time, begun) else {
            return Ok(());
        };
        if begun.elapsed() > (time + GRACE) * self.under_way().max(1) {
            process.kill()?;
            let seconds = time.as_secs_f64();
            return Err(self.over(format!("it gave no answer within {seconds} s")));
        }
        Ok(())
    }

    /// From now on there is no process, for this reason.
    #[cold]
    fn over(&self, reason: String) -> Error {
        let reason = format!("{reason} (in a process of its own)");
        self.early.borrow_mut().clear();
        self.due.borrow_mut().clear();
        self.wanted.set(0);
        self.taken.set(self.requested.get());
        self.end.borrow_mut().get_or_insert(reason.clone());
        anyhow!(reason)
    }

    /// What the process has answered is missing or cannot be read.
    #[cold]
    pub fn damaged(&self) -> Error {
        if let Some(end) = &*self.end.borrow() {
            return anyhow!("{end}");
        }
        // It has mostly ended; else it cannot be trusted.
        let ended = self.process.borrow_mut().wait(Duration::ZERO);
        match ended {
            Ok(Some(status)) => self.over(self.reason(status)),
            _ => self.over("its process answers nonsense, and was killed".into()),
        }
    }

    fn read_bytes(&self, kind: u64, count: u64) -> Result<Vec<u8>> {
        if kind & 3 == NUMBERS {
            return Ok(Vec::new());
        }
        let mut bytes = Vec::new();
        let read = (&self.socket).take(count).read_to_end(&mut bytes);
        match read {
            Ok(read) if read as u64 == count => Ok(bytes),
            _ => Err(self.damaged()),
        }
    }

    fn parse<T: DeserializeOwned>(&self, bytes: &[u8]) -> Result<T> {
        postcard::from_bytes(bytes).map_err(|_| self.damaged())
    }

    /// Takes the next answer of all, with exactly these values.
    pub fn answer(&self, values: &mut [f64]) -> Result<Answered> {
        let early = self.early.borrow_mut().pop_front();
        let (kind, number, bytes) = match early {
            Some((words, bytes)) => {
                let given = words[2..].iter().map(|word| f64::from_bits(*word));
                (values.iter_mut().zip(given)).for_each(|(to, value)| *to = value);
                (words[0], words[1], Some(bytes))
            }
            None => {
                let [kind, number, given @ ..] = self.await_answer()? else {
                    return Err(self.damaged());
                };
                let [kind, number] = [kind, number].map(|word| word.load(Relaxed));
                let given = given.iter().map(|word| f64::from_bits(word.load(Relaxed)));
                (values.iter_mut().zip(given)).for_each(|(to, value)| *to = value);
                self.pass_answer(2 + (kind >> 2) as usize);
                (kind, number, None)
            }
        };
        match (kind & 3, (kind >> 2) as usize) {
            (NUMBERS, count) if count == values.len() => Ok(Ok(f64::from_bits(number))),
            (kind @ (BYTES | ERROR), 0) => {
                let bytes = bytes.map_or_else(|| self.read_bytes(kind, number), Ok)?;
                if kind == BYTES {
                    return Ok(Err(bytes));
                }
                let Failed { reason, messages } = self.parse(&bytes)?;
                messages::extend(messages);
                Err(reason.into())
            }
            _ => Err(self.damaged()),
        }
    }

    /// Takes the next answer of all, whatever it is.
    pub fn skip(&self) -> Result<()> {
        if self.early.borrow_mut().pop_front().is_some() {
            return Ok(());
        }
        let [kind, number, ..] = self.await_answer()? else {
            return Err(self.damaged());
        };
        let [kind, number] = [kind, number].map(|word| word.load(Relaxed));
        self.pass_answer(2 + (kind >> 2) as usize);
        self.read_bytes(kind, number).map(drop)
    }

    /// Makes a rare request, while no answer is due.
    pub fn request_rare(&self, request: &RareRequest) -> Result<()> {
        if let Some(end) = &*self.end.borrow() {
            bail!("{end}");
        }
        let bytes = postcard::to_stdvec(request)?;
        let rare = (&Request::Rare, Due::Wanted);
        self.request(rare, &[], (&[], bytes.len()), 0);
        self.wake();
        match (&self.socket).write_all(&bytes) {
            Ok(()) => Ok(()),
            Err(_) => Err(self.damaged()),
        }
    }

    /// The answer in bytes to a rare request or call, whose messages become those of this thread.
    pub fn rare_answer(&self, answered: Answered) -> Result<RareAnswer> {
        let Err(bytes) = answered else {
            return Err(self.damaged());
        };
        let (answer, messages): (RareAnswer, Vec<Message>) = self.parse(&bytes)?;
        messages::extend(messages);
        Ok(answer)
    }
}

impl Drop for Channel {
    fn drop(&mut self) {
        PROCESSES.fetch_sub(1, Relaxed);
        if self.is_over() {
            return;
        }
        let say = |text: &str| messages::add(&self.name, FATAL, text);
        let freed = self.request_rare(&RareRequest::End);
        let freed = freed.and_then(|()| self.answer(&mut []));
        let freed = freed.and_then(|answered| self.rare_answer(answered));
        let limit = self.limits.time.unwrap_or(5 * GRACE);
        let ended = freed.and_then(|_| Ok(self.process.borrow_mut().wait(limit)?));
        match ended {
            Err(error) => say(&error.to_string()),
            Ok(Some(status)) if status.success() => {}
            Ok(Some(status)) => say(&self.reason(status)),
            Ok(None) => say("its process did not end, and was killed"),
        }
    }
}
