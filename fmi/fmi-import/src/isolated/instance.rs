//! [`IsolatedInstance`]: an instance in a process of its own, which a master calls as one in its own
//! process, and whose calls it may begin before it needs their answers.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::collections::{HashMap, VecDeque};
use std::ffi::CString;
use std::hint::spin_loop;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::process::Stdio;
use std::rc::Rc;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use serde::de::DeserializeOwned;

use super::program::command;
use super::protocol::{
    BYTES, CALLS, ERROR, FIRST, Failed, HEADER, Hosting, Layout, NUMBERS, NamedBatch, Pass, ROOM,
    RareAnswer, RareRequest, Request, WORDS, is_frequent,
};
use super::segment::Segment;
use crate::Limits;
use crate::batch::Batch;
use crate::fmi_instance::{Arguments, BegunCall, Call, FmiInstance, Integration};
use crate::messages::{self, Message};
use crate::process::{Process, reason};
use crate::status::FATAL;
use crate::under_way::last_words;
use crate::value::Value;

/// Most and fewest times that an answer is looked for before this thread sleeps: the most take some
/// 50 µs. The number falls while looking is in vain.
const SPINS: [u64; 2] = [2000, 20];
/// How long a thread sleeps before it looks whether the process is still there.
const NAP: Duration = Duration::from_millis(20);
/// The process ends itself at the limit of a call; if it cannot, it is killed so long after.
const GRACE: Duration = Duration::from_secs(2);
/// Most batches that the process keeps of which nobody else does.
const BATCHES: usize = 256;

/// Processes of isolated instances that this program has.
static PROCESSES: AtomicUsize = AtomicUsize::new(0);

/// What instances are made of: an unpacked FMU.
#[derive(Clone, Debug)]
pub struct Source {
    /// Name of the FMU for messages.
    pub file: String,
    /// Path of its library.
    pub library: PathBuf,
    /// Its model description.
    pub description: PathBuf,
    /// It is for Model Exchange.
    pub is_exchange: bool,
}

/// An instance in a process of its own, which ends with it.
pub struct IsolatedInstance(Rc<Hosted>);

struct Hosted {
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
    /// Answers that were taken to make room before they were asked for.
    early: RefCell<VecDeque<(Vec<u64>, Vec<u8>)>>,
    spins: Cell<u64>,
    batches: RefCell<Vec<Batch>>,
    /// Where the last batch was found.
    last_batch: Cell<usize>,
    /// Why the process has ended.
    end: RefCell<Option<String>>,
}

/// A saved state, which stays in the process.
struct State {
    hosted: Rc<Hosted>,
    key: usize,
}

impl Drop for State {
    fn drop(&mut self) {
        // If the process has ended, the state is gone, too.
        let _ = self.hosted.rare(&RareRequest::Forget(self.key));
    }
}

impl IsolatedInstance {
    /// Starts a process and makes an instance in it; None if the FMU returns none. `sizes` are values
    /// of structural parameters by value reference, with which it has so many `variables`.
    ///
    /// # Errors
    /// There is no program for the process, or the library cannot be loaded.
    pub fn new(
        source: Source,
        (sizes, variables): (&HashMap<u32, String>, usize),
        arguments: &Arguments,
        limits: Limits,
    ) -> Result<Option<Self>> {
        let Source {
            file,
            library,
            description,
            is_exchange,
        } = source;
        // A request may have the variables of a batch and their values.
        let most = ROOM / 2 - 64;
        ensure!(
            variables < most,
            "FMU `{file}` has {variables} variables; in a process of its own it may have {most}"
        );
        let name = arguments.name.to_string_lossy().into_owned();
        let hosted = Hosted::start(name, limits).context("a process of its own")?;
        let hosting = Hosting {
            file,
            library,
            description,
            sizes: sizes.clone(),
            is_exchange,
            arguments: arguments.clone(),
            limits,
        };
        let made = hosted.rare(&RareRequest::Host(Box::new(hosting)))?;
        let hosted = Self(Rc::new(hosted));
        Ok(matches!(made, RareAnswer::Is(true)).then_some(hosted))
    }
}

impl Hosted {
    fn start(name: String, limits: Limits) -> Result<Self> {
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
            early: RefCell::default(),
            spins: Cell::new(SPINS[0]),
            batches: RefCell::default(),
            last_batch: Cell::new(0),
            end: RefCell::new(None),
        })
    }

    fn memory(&self) -> Layout<'_> {
        Layout(self.segment.words())
    }

    /// Whether a call is under way.
    fn is_busy(&self) -> bool {
        self.requested.get() != self.taken.get() || !self.early.borrow().is_empty()
    }

    /// Spinning pays where each process has a core: from when all instances have been made.
    fn choose_spins(&self) {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let spins = match PROCESSES.load(Relaxed) < cores {
            true => SPINS[0],
            false => 0,
        };
        self.spins.set(spins);
        self.memory().spins().store(spins, Relaxed);
    }

    /// Writes a request with the variables of a batch and values; the answer may have up to
    /// `expected` values.
    fn request(&self, request: &Request, new: &[usize], values: &[f64], expected: usize) {
        self.request_words(request, new, values.len(), expected, |room| {
            for (to, value) in room.iter().zip(values) {
                to.store(value.to_bits(), Relaxed);
            }
        });
    }

    fn request_words(
        &self,
        request: &Request,
        new: &[usize],
        count: usize,
        expected: usize,
        write: impl FnOnce(&[AtomicU64]),
    ) {
        let length = HEADER + 2 + new.len();
        let [mut at, _, due] = self.places.get();
        let under_way = self.requested.get().wrapping_sub(self.taken.get()) as usize;
        // Values of a rare request pass through the socket.
        let values = if matches!(request, Request::Rare) {
            0
        } else {
            count
        };
        let is_full = at + length + values > ROOM || due + 2 + expected > ROOM;
        if is_full || under_way == CALLS {
            self.take_early();
        }
        let first = if self.is_busy() { 0 } else { FIRST };
        if self.requested.get() == self.taken.get() {
            self.places.set([0; 3]);
            at = 0;
        }
        let memory = self.memory();
        let number = self.requested.get().wrapping_add(1);
        memory.place(number).store(at as u64 | first, Relaxed);
        let room = &memory.requests()[at..];
        let mut header = [0; 8 * HEADER];
        postcard::to_slice(request, &mut header).expect("requests are short");
        for (to, bytes) in room.iter().zip(header.chunks(8)) {
            let bytes = bytes.try_into().expect("a word has 8 bytes");
            to.store(u64::from_le_bytes(bytes), Relaxed);
        }
        room[HEADER].store(new.len() as u64, Relaxed);
        room[HEADER + 1].store(count as u64, Relaxed);
        for (to, variable) in room[HEADER + 2..].iter().zip(new) {
            to.store(*variable as u64, Relaxed);
        }
        write(&room[length..]);
        let [_, answer, due] = self.places.get();
        self.places
            .set([at + length + values, answer, due + 2 + expected]);
        self.requested.set(number);
        memory.requested().set(number);
    }

    /// Takes all answers that are due, so that there is room for further calls.
    #[cold]
    fn take_early(&self) {
        while self.requested.get() != self.taken.get() {
            let Ok(words) = self.await_answer() else {
                return; // The next call says why.
            };
            let count = (words[0].load(Relaxed) >> 2) as usize;
            let words = words.iter().take(2 + count);
            let words: Vec<u64> = words.map(|word| word.load(Relaxed)).collect();
            self.pass_answer(words.len());
            let bytes = self.read_bytes(words[0], words[1]).unwrap_or_default();
            self.early.borrow_mut().push_back((words, bytes));
        }
    }

    /// Awaits the next answer; returns its words.
    fn await_answer(&self) -> Result<&[AtomicU64]> {
        if let Some(end) = &*self.end.borrow() {
            bail!("{end}");
        }
        let number = self.taken.get().wrapping_add(1);
        let answered = self.memory().answered();
        let spins = self.spins.get();
        let mut found = answered.has_reached(number);
        for _ in 0..spins {
            if found {
                break;
            }
            spin_loop();
            found = answered.has_reached(number);
        }
        if spins > 0 {
            self.spins.set(match found {
                true => (spins + spins / 4 + 1).min(SPINS[0]),
                false => (spins - spins / 4).max(SPINS[1]),
            });
        }
        let begun = (!found).then(Instant::now);
        while !answered.has_reached(number) {
            answered.sleep(number, Some(NAP));
            if !answered.has_reached(number) {
                self.look(begun)?;
            }
        }
        let [_, place, _] = self.places.get();
        let words = self.memory().answers().get(place..place + 2);
        Ok(words.map_or(&[], |_| &self.memory().answers()[place..]))
    }

    fn pass_answer(&self, length: usize) {
        let [request, answer, due] = self.places.get();
        self.places.set([request, answer + length, due]);
        self.taken.set(self.taken.get().wrapping_add(1));
    }

    /// Looks whether the process is still there, and has time left for the call that was `begun`.
    #[cold]
    fn look(&self, begun: Option<Instant>) -> Result<()> {
        let mut process = self.process.borrow_mut();
        if let Some(status) = process.status()? {
            // It may have answered just before.
            let number = self.taken.get().wrapping_add(1);
            if self.memory().answered().has_reached(number) {
                return Ok(());
            }
            let told = last_words(self.memory().last_words());
            let own = format!("{}: ", self.name);
            let told = told.map(|told| match told.strip_prefix(&own) {
                Some(told) => told.to_string(),
                None => told,
            });
            return Err(self.over(reason(status, told)));
        }
        let is_over = |time| begun.is_some_and(|begun: Instant| begun.elapsed() > time + GRACE);
        if let Some(time) = self.limits.time.filter(|time| is_over(*time)) {
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
        self.taken.set(self.requested.get());
        self.end.borrow_mut().get_or_insert(reason.clone());
        anyhow!(reason)
    }

    /// What the process wrote to the socket is missing or cannot be read.
    #[cold]
    fn damaged(&self) -> Error {
        // It has mostly ended.
        let ended = self.process.borrow_mut().wait(Duration::ZERO);
        match ended {
            Ok(_) => match self.look(None) {
                Err(error) => error,
                Ok(()) => self.over("its process answers nonsense".into()),
            },
            Err(error) => self.over(error.to_string()),
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

    /// Takes the next answer, with exactly these values; None if it is in bytes.
    fn take(&self, values: &mut [f64]) -> Result<std::result::Result<f64, Vec<u8>>> {
        let early = self.early.borrow_mut().pop_front();
        let (kind, number, bytes) = match early {
            Some((words, bytes)) => {
                let given = words[2..].iter().map(|word| f64::from_bits(*word));
                values
                    .iter_mut()
                    .zip(given)
                    .for_each(|(to, value)| *to = value);
                (words[0], words[1], Some(bytes))
            }
            None => {
                let words = self.await_answer()?;
                let [kind, number, given @ ..] = words else {
                    return Err(self.damaged());
                };
                let kind = kind.load(Relaxed);
                let count = (kind >> 2) as usize;
                if kind & 3 == NUMBERS && count == values.len() {
                    for (to, value) in values.iter_mut().zip(given) {
                        *to = f64::from_bits(value.load(Relaxed));
                    }
                }
                let number = number.load(Relaxed);
                self.pass_answer(2 + count.min(ROOM));
                (kind, number, None)
            }
        };
        match (kind & 3, (kind >> 2) as usize) {
            (NUMBERS, count) if count == values.len() => Ok(Ok(f64::from_bits(number))),
            (BYTES | ERROR, 0) => {
                let bytes = bytes.map_or_else(|| self.read_bytes(kind, number), Ok)?;
                if kind & 3 == BYTES {
                    return Ok(Err(bytes));
                }
                let Failed { reason, messages } = self.parse(&bytes)?;
                messages::extend(messages);
                Err(reason.into())
            }
            _ => Err(self.damaged()),
        }
    }

    /// Makes a rare call; those that are begun are awaited first.
    fn rare(&self, request: &RareRequest) -> Result<RareAnswer> {
        self.drain();
        if let Some(end) = &*self.end.borrow() {
            bail!("{end}");
        }
        let bytes = postcard::to_stdvec(request)?;
        self.request_words(&Request::Rare, &[], bytes.len(), 0, |_| ());
        if (&self.socket).write_all(&bytes).is_err() {
            return Err(self.damaged());
        }
        self.take_rare()
    }

    fn take_rare(&self) -> Result<RareAnswer> {
        let Err(bytes) = self.take(&mut [])? else {
            return Err(self.damaged());
        };
        let (answer, messages): (RareAnswer, Vec<Message>) = self.parse(&bytes)?;
        messages::extend(messages);
        Ok(answer)
    }

    fn done(&self, request: &RareRequest) -> Result<()> {
        self.rare(request).map(drop)
    }

    fn drain(&self) {
        while self.is_busy() {
            let done = self.take_any();
            if done.is_err() && self.end.borrow().is_some() {
                return;
            }
        }
    }

    /// Takes the next answer, whatever it is.
    fn take_any(&self) -> Result<()> {
        if self.early.borrow_mut().pop_front().is_some() {
            return Ok(());
        }
        let words = self.await_answer()?;
        let [kind, number, ..] = words else {
            return Err(self.damaged());
        };
        let [kind, number] = [kind, number].map(|word| word.load(Relaxed));
        self.pass_answer(2 + (kind >> 2) as usize);
        self.read_bytes(kind, number).map(drop)
    }

    /// The number of a batch in the process, and whether it must be told its variables.
    fn number(&self, batch: &Batch) -> (u32, bool) {
        let mut all = self.batches.borrow_mut();
        let (count, last) = (all.len(), self.last_batch.get());
        // Steps use the same ones in the same order.
        let order = (last..count).chain(0..last.min(count));
        let found = order.into_iter().find(|k| all[*k].is_same(batch));
        let number = found.unwrap_or_else(|| {
            let unused = all
                .iter()
                .position(Batch::is_last)
                .filter(|_| count >= BATCHES);
            match unused {
                Some(k) => all[k] = batch.clone(),
                None => all.push(batch.clone()),
            }
            unused.unwrap_or(count)
        });
        self.last_batch.set(number + 1);
        (number as u32, found.is_none())
    }

    fn named(&self, batch: &Batch) -> NamedBatch {
        let (number, is_new) = self.number(batch);
        NamedBatch(number, is_new.then(|| batch.variables.clone()))
    }

    fn begin_pass(&self, pass: Pass, batch: &Batch, values: &[f64]) {
        if self.end.borrow().is_some() {
            return;
        }
        let (number, is_new) = self.number(batch);
        let new = if is_new { &batch.variables[..] } else { &[] };
        let expected = match pass {
            Pass::Get | Pass::GetDerivatives => batch.len(),
            Pass::Set | Pass::SetDerivatives => 0,
        };
        self.request(&Request::Pass(pass, number), new, values, expected);
    }

    /// Passes values: ends the call that was begun first, or makes it.
    fn pass(&self, pass: Pass, batch: &Batch, given: &[f64], read: &mut [f64]) -> Result<()> {
        if !self.is_busy() {
            self.begin_pass(pass, batch, given);
        }
        self.take(read).map(drop)
    }

    fn keep(self: &Rc<Self>, saved: RareAnswer) -> Result<Box<dyn Any>> {
        let RareAnswer::State(key) = saved else {
            return Err(self.damaged());
        };
        let hosted = self.clone();
        Ok(Box::new(State { hosted, key }))
    }

    fn key(self: &Rc<Self>, state: &dyn Any) -> Result<usize> {
        let own = state.downcast_ref::<State>();
        let own = own.filter(|state| Rc::ptr_eq(&state.hosted, self));
        Ok(own.context("a state of another instance")?.key)
    }
}

impl Drop for Hosted {
    fn drop(&mut self) {
        let say = |text: &str| messages::add(&self.name, FATAL, text);
        let is_over = self.end.borrow().is_some();
        if !is_over {
            let ended = self.done(&RareRequest::End);
            let limit = self.limits.time.unwrap_or(5 * GRACE);
            let ended = ended.and_then(|()| Ok(self.process.borrow_mut().wait(limit)?));
            match ended {
                Err(error) => say(&error.to_string()),
                Ok(Some(status)) if status.success() => {}
                Ok(Some(status)) => {
                    say(&reason(status, last_words(self.memory().last_words())));
                }
                Ok(None) => say("its process did not end, and was killed"),
            }
        }
        PROCESSES.fetch_sub(1, Relaxed);
    }
}

impl FmiInstance for IsolatedInstance {
    fn begin(&self, ahead: BegunCall) {
        let hosted = &self.0;
        match ahead {
            BegunCall::Plain(call) if hosted.end.borrow().is_none() => {
                hosted.request(&Request::Plain(call), &[], &[], 0);
            }
            BegunCall::Plain(_) => {}
            BegunCall::Get(batch) => hosted.begin_pass(Pass::Get, batch, &[]),
            BegunCall::Set(batch, values) => hosted.begin_pass(Pass::Set, batch, values),
        }
    }

    fn drain(&self) {
        self.0.drain();
    }

    fn log_only(&self, categories: &[CString]) -> Result<()> {
        self.0.done(&RareRequest::LogOnly(categories.to_vec()))
    }

    fn get_values(&self, batch: &Batch, values: &mut [Value]) -> Result<()> {
        match self.0.rare(&RareRequest::GetValues(self.0.named(batch)))? {
            RareAnswer::Values(read) if read.len() == values.len() => {
                values.clone_from_slice(&read);
                Ok(())
            }
            _ => Err(self.0.damaged()),
        }
    }

    fn set_values(&self, batch: &Batch, values: &[Value]) -> Result<()> {
        let batch = self.0.named(batch);
        self.0.done(&RareRequest::SetValues(batch, values.to_vec()))
    }

    fn call(&self, call: Call) -> Result<f64> {
        if matches!(call, Call::EnterInitialization(_)) {
            self.0.choose_spins();
        }
        if !self.0.is_busy() {
            self.begin(BegunCall::Plain(call));
        }
        if is_frequent(call) {
            return self.0.take(&mut [])?.map_err(|_| self.0.damaged());
        }
        match self.0.take_rare()? {
            RareAnswer::Number(number) => Ok(number),
            _ => Err(self.0.damaged()),
        }
    }

    fn get(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        self.0.pass(Pass::Get, batch, &[], values)
    }

    fn set(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        self.0.pass(Pass::Set, batch, values, &mut [])
    }

    fn get_derivatives(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        self.0.pass(Pass::GetDerivatives, batch, &[], values)
    }

    fn set_derivatives(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        self.0.pass(Pass::SetDerivatives, batch, values, &mut [])
    }

    fn directional(&self, of: [&Batch; 2], seeds: &[f64], rates: &mut [f64]) -> Result<()> {
        let of = of.map(|batch| self.0.named(batch));
        match self.0.rare(&RareRequest::Directional(of, seeds.to_vec()))? {
            RareAnswer::Numbers(found) if found.len() == rates.len() => {
                rates.copy_from_slice(&found);
                Ok(())
            }
            _ => Err(self.0.damaged()),
        }
    }

    fn integration(&self) -> Result<Option<Integration>> {
        match self.0.rare(&RareRequest::Integration)? {
            RareAnswer::Integration(integration) => Ok(integration),
            _ => Err(self.0.damaged()),
        }
    }

    fn save(&self) -> Result<Box<dyn Any>> {
        self.0.keep(self.0.rare(&RareRequest::Save)?)
    }

    fn restore(&self, state: &dyn Any) -> Result<()> {
        let key = self.0.key(state)?;
        self.0.done(&RareRequest::Restore(key))
    }

    fn state_to_bytes(&self, state: &dyn Any) -> Result<Vec<u8>> {
        let key = self.0.key(state)?;
        match self.0.rare(&RareRequest::StateToBytes(key))? {
            RareAnswer::Bytes(bytes) => Ok(bytes),
            _ => Err(self.0.damaged()),
        }
    }

    fn state_from_bytes(&self, bytes: &[u8]) -> Result<Box<dyn Any>> {
        let bytes = bytes.to_vec();
        self.0
            .keep(self.0.rare(&RareRequest::StateFromBytes(bytes))?)
    }

    fn reset(&self) -> bool {
        matches!(self.0.rare(&RareRequest::Reset), Ok(RareAnswer::Is(true)))
    }
}
