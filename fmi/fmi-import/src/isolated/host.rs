//! The process of an isolated instance: loads the FMU, makes the instance, and answers requests
//! until the program that started it asks it to end, or ends itself.

use std::any::Any;
use std::collections::{BTreeMap, HashMap};
use std::ffi::c_void;
use std::fs;
use std::io::{self, Read, Write};
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

use anyhow::{Context, Result, anyhow};
use fmi_description::{Description, Interface};

use super::ARGUMENT;
use super::protocol::{
    BYTES, ERROR, FIRST, Failed, HEADER, Hosting, Layout as Memory, NUMBERS, NamedBatch, Pass,
    RareAnswer, RareRequest, Reason, Request, WORDS, is_frequent,
};
use super::segment::{Patience, Segment};
use crate::Limits;
use crate::batch::{Batch, Layout};
use crate::calls::Offered;
use crate::clocks::ClockPlan;
use crate::exchange::{ExchangePlan, as_component};
use crate::fmi_instance::FmiInstance;
use crate::functions::Functions;
use crate::library::load_named;
use crate::value::Value;
use crate::{instantiate, messages, output, process, under_way};

/// Answers requests, if this process was started for that: to be called before anything else.
/// Returns the exit code when all is done.
pub fn serve_if_asked() -> Option<ExitCode> {
    super::program::serves();
    serve_with(None)
}

/// Makes ready what is in a file, within limits, and returns the C functions of FMI 3.0 for it by
/// name.
pub type Load = fn(&Path, Limits) -> Result<fn(&str) -> Option<*const c_void>>;

/// The same for a program that calls something else than shared libraries.
pub fn serve_with(load: Option<Load>) -> Option<ExitCode> {
    let asked = std::env::args_os().nth(1)?;
    (asked == ARGUMENT).then(|| serve(load))
}

/// Answers requests; standard input is the socket, standard output the shared memory.
fn serve(load: Option<Load>) -> ExitCode {
    let served = || -> Result<()> {
        let socket = io::stdin().as_fd().try_clone_to_owned()?;
        let memory = io::stdout().as_fd().try_clone_to_owned()?;
        let memory = Segment::open(&memory, WORDS);
        let memory = memory.context("it is for programs that isolate FMUs")?;
        process::replace_streams()?;
        // Prints of the FMU go to standard error.
        output::separate()?;
        Host::new(memory.forever(), socket, load)?.run()
    };
    output::end(match served() {
        Ok(()) => 0,
        Err(error) => {
            eprintln!("error: the process of an FMU: {error:#}");
            1
        }
    })
}

/// An FMU that is loaded in this process, as far as its batches need it.
struct Loaded {
    description: Description,
    layout: Layout,
    functions: Arc<Functions>,
}

struct Host {
    load: Option<Load>,
    memory: Memory<'static>,
    socket: UnixStream,
    /// Instances are freed before their library.
    states: BTreeMap<usize, Box<dyn Any>>,
    instance: Option<Box<dyn FmiInstance>>,
    batches: Vec<Batch>,
    loaded: Option<Loaded>,
    values: Vec<f64>,
    /// A call failed: those begun behind it are left out.
    has_failed: bool,
    /// Where the next answer is written.
    place: usize,
    /// Threads that there were before the FMU was loaded.
    threads: usize,
    is_over: bool,
}

fn count_threads() -> usize {
    fs::read_dir("/proc/self/task").map_or(0, Iterator::count)
}

/// What a request brings about.
enum Outcome {
    /// A number, and as many of the values as are asked for.
    Numbers(f64, usize),
    Rare(RareAnswer),
}

impl Host {
    fn new(memory: &'static [AtomicU64], socket: OwnedFd, load: Option<Load>) -> Result<Self> {
        let memory = Memory(memory);
        under_way::keep_last_words(memory.last_words());
        Ok(Self {
            load,
            memory,
            socket: socket.into(),
            states: BTreeMap::new(),
            instance: None,
            batches: Vec::new(),
            loaded: None,
            values: Vec::new(),
            has_failed: false,
            place: 0,
            threads: 0,
            is_over: false,
        })
    }

    fn run(mut self) -> Result<()> {
        let (mut number, patience) = (0_u32, Patience::default());
        while !self.is_over {
            number = number.wrapping_add(1);
            let requested = self.memory.requested();
            let most = self.memory.spins().load(Relaxed);
            if most == 0 || patience.spins.get() == 0 {
                patience.spins.set(most);
            }
            if !requested.spin(number, &patience) {
                while !requested.has_reached(number) {
                    requested.sleep(number, None);
                }
            }
            let place = self.memory.place(number).load(Relaxed);
            self.has_failed &= place & FIRST == 0;
            let place = (place & !FIRST) as usize;
            if place == 0 {
                self.place = 0;
            }
            process::begin_call();
            let done = match self.has_failed {
                true => Err(anyhow!("a call that was begun before it failed")),
                false => self.carry_out(place),
            };
            process::end_call();
            self.has_failed |= done.is_err();
            self.answer(number, done)?;
        }
        if count_threads() > self.threads {
            // Their code must stay: the process ends with them.
            process::exit_now(0);
        }
        Ok(())
    }

    fn answer(&mut self, number: u32, done: Result<Outcome>) -> Result<()> {
        let (kind, count, word, bytes) = match done {
            Ok(Outcome::Numbers(value, count)) => (NUMBERS, count, value.to_bits(), Vec::new()),
            Ok(Outcome::Rare(answer)) => {
                let bytes = postcard::to_stdvec(&(answer, messages::take()))?;
                (BYTES, 0, bytes.len() as u64, bytes)
            }
            Err(error) => {
                let (reason, messages) = (Reason::from(&error), messages::take());
                let bytes = postcard::to_stdvec(&Failed { reason, messages })?;
                (ERROR, 0, bytes.len() as u64, bytes)
            }
        };
        let room = &self.memory.answers()[self.place..];
        room[0].store(kind | (count as u64) << 2, Relaxed);
        room[1].store(word, Relaxed);
        for (to, value) in room[2..].iter().zip(&self.values[..count]) {
            to.store(value.to_bits(), Relaxed);
        }
        self.place += 2 + count;
        self.memory.answered().set(number);
        self.memory.answered().wake();
        if !bytes.is_empty() {
            self.socket.write_all(&bytes)?;
        }
        Ok(())
    }

    fn instance(&self) -> Result<&dyn FmiInstance> {
        self.instance.as_deref().context("there is no instance")
    }

    fn carry_out(&mut self, place: usize) -> Result<Outcome> {
        let room = &self.memory.requests()[place..];
        let mut header = [0; 8 * HEADER];
        for (to, word) in header.chunks_mut(8).zip(room) {
            to.copy_from_slice(&word.load(Relaxed).to_le_bytes());
        }
        let (request, _): (Request, _) = postcard::take_from_bytes(&header)?;
        let word = |k: usize| room[HEADER + k].load(Relaxed) as usize;
        let (variables, count) = (word(0), word(1));
        match request {
            Request::Rare => {
                let mut bytes = vec![0; count];
                self.socket.read_exact(&mut bytes)?;
                self.rare(postcard::from_bytes(&bytes)?).map(Outcome::Rare)
            }
            Request::Plain(call) => {
                let number = self.instance()?.call(call)?;
                Ok(match is_frequent(call) {
                    true => Outcome::Numbers(number, 0),
                    false => Outcome::Rare(RareAnswer::Number(number)),
                })
            }
            Request::Pass(pass, batch) => {
                if variables > 0 {
                    let new = (2..2 + variables).map(word).collect();
                    self.learn(batch, new)?;
                }
                let values = &room[HEADER + 2 + variables..][..count];
                self.values.clear();
                let values = values.iter().map(|v| f64::from_bits(v.load(Relaxed)));
                self.values.extend(values);
                self.pass(pass, batch as usize)
            }
        }
    }

    fn pass(&mut self, pass: Pass, batch: usize) -> Result<Outcome> {
        let batch = &self.batches[batch];
        let read = match pass {
            Pass::Get | Pass::GetDerivatives => batch.len(),
            Pass::Set | Pass::SetDerivatives => 0,
        };
        let mut values = std::mem::take(&mut self.values);
        if read > 0 {
            values.resize(read, 0.0);
        }
        let done = self.instance().and_then(|instance| match pass {
            Pass::Get => instance.get(batch, &mut values),
            Pass::Set => instance.set(batch, &values),
            Pass::GetDerivatives => instance.get_derivatives(batch, &mut values),
            Pass::SetDerivatives => instance.set_derivatives(batch, &values),
        });
        self.values = values;
        done.map(|()| Outcome::Numbers(0.0, read))
    }

    /// Plans a batch of these variables, under this number.
    fn learn(&mut self, number: u32, variables: Vec<usize>) -> Result<()> {
        let loaded = self.loaded.as_ref().context("there is no FMU")?;
        let batch = Batch::new(&loaded.description, &loaded.layout, variables);
        match self.batches.get_mut(number as usize) {
            Some(old) => *old = batch,
            None => self.batches.push(batch),
        }
        Ok(())
    }

    fn batch(&mut self, named: NamedBatch) -> Result<Batch> {
        let NamedBatch(number, new) = named;
        new.map_or(Ok(()), |variables| self.learn(number, variables))?;
        Ok(self.batches[number as usize].clone())
    }

    fn keep(&mut self, state: Box<dyn Any>) -> RareAnswer {
        let key = self.states.keys().last().map_or(0, |last| last + 1);
        self.states.insert(key, state);
        RareAnswer::State(key)
    }

    fn rare(&mut self, request: RareRequest) -> Result<RareAnswer> {
        let done = |()| RareAnswer::Done;
        match request {
            RareRequest::Host(hosting) => self.host(&hosting),
            RareRequest::LogOnly(names) => self.instance()?.log_only(&names).map(done),
            RareRequest::GetValues(batch) => {
                let batch = self.batch(batch)?;
                let mut values = vec![Value::empty(batch.access); batch.len()];
                self.instance()?.get_values(&batch, &mut values)?;
                Ok(RareAnswer::Values(values))
            }
            RareRequest::SetValues(batch, values) => {
                let batch = self.batch(batch)?;
                self.instance()?.set_values(&batch, &values).map(done)
            }
            RareRequest::Directional([of, along], seeds) => {
                let of = [self.batch(of)?, self.batch(along)?];
                let mut rates = vec![0.0; of[0].len()];
                let instance = self.instance()?;
                instance.directional(of.each_ref(), &seeds, &mut rates)?;
                Ok(RareAnswer::Numbers(rates))
            }
            RareRequest::Integration => self.instance()?.integration().map(RareAnswer::Integration),
            RareRequest::Save => {
                let state = self.instance()?.save()?;
                Ok(self.keep(state))
            }
            RareRequest::Restore(key) => self.instance()?.restore(&*self.states[&key]).map(done),
            RareRequest::Forget(key) => {
                self.states.remove(&key);
                Ok(RareAnswer::Done)
            }
            RareRequest::StateToBytes(key) => {
                let bytes = self.instance()?.state_to_bytes(&*self.states[&key]);
                bytes.map(RareAnswer::Bytes)
            }
            RareRequest::StateFromBytes(bytes) => {
                let state = self.instance()?.state_from_bytes(&bytes)?;
                Ok(self.keep(state))
            }
            RareRequest::Reset => Ok(RareAnswer::Is(self.instance()?.reset())),
            RareRequest::End => {
                self.states.clear();
                self.instance = None;
                self.is_over = true;
                self.tell_threads();
                Ok(RareAnswer::Done)
            }
        }
    }

    /// Says how many threads are left of an instance that was freed: those that end by themselves
    /// get a moment.
    fn tell_threads(&self) {
        let left = || count_threads().saturating_sub(self.threads);
        let mut waits = (0..20).map(|_| std::thread::sleep(std::time::Duration::from_millis(1)));
        while left() > 0 && waits.next().is_some() {}
        let (left, Some(loaded)) = (left(), &self.loaded) else {
            return;
        };
        if left > 0 {
            let threads = if left == 1 { "thread" } else { "threads" };
            let free = loaded.functions.name("fmi2FreeInstance");
            let text =
                format!("{left} {threads} still ran after {free}; they ended with its process");
            messages::add(&self.name(), crate::status::WARNING, &text);
        }
    }

    fn name(&self) -> String {
        std::env::args().nth(2).unwrap_or_default()
    }

    fn host(&mut self, hosting: &Hosting) -> Result<RareAnswer> {
        if self.loaded.is_none() {
            // What handles signals of its own comes after what tells of crashes.
            under_way::Slot::fresh();
            // It takes time of the machine, not of the FMU.
            let load = |load: Load| load(&hosting.library, hosting.limits);
            let offered = self.load.map(load).transpose()?;
            process::watch(
                hosting.limits,
                Some(self.socket.as_fd().try_clone_to_owned()?),
            );
            self.threads = count_threads();
            self.loaded = Some(self::load(hosting, offered.map(Offered))?);
        }
        let loaded = self.loaded.as_ref().context("there is no FMU")?;
        let Loaded {
            description,
            layout,
            functions,
        } = loaded;
        let plan = Arc::new(ClockPlan::new(description, layout));
        let exchange = hosting.exchange.as_ref().map(|given| {
            let mut plan = ExchangePlan::new(description, layout)?;
            plan.choice = given.choice;
            plan.take_means(description, layout, &given.means);
            anyhow::Ok(Arc::new(plan))
        });
        let exchange = exchange.transpose()?;
        let who = hosting.arguments.name.to_string_lossy();
        let who = format!("{who} (FMU `{}`)", hosting.file);
        let made = output::named(&who, || {
            instantiate(
                functions,
                layout,
                &plan,
                exchange.as_ref(),
                &hosting.arguments,
            )
        });
        self.instance = made?;
        Ok(RareAnswer::Is(self.instance.is_some()))
    }
}

fn load(hosting: &Hosting, offered: Option<Offered>) -> Result<Loaded> {
    let read = |path: &Path| fs::read(path).with_context(|| path.display().to_string());
    let text = fmi_description::text(&read(&hosting.description)?)?;
    let wanted = match hosting.exchange.is_some() {
        true => &[Interface::ModelExchange][..],
        false => &[Interface::CoSimulation, Interface::ScheduledExecution],
    };
    let declared = Description::parse_as(&text, wanted, &HashMap::new())?;
    let description = as_component(&Description::parse_as(&text, wanted, &hosting.sizes)?);
    let who = format!("FMU `{}`", hosting.file);
    Ok(Loaded {
        layout: Layout::new(&description),
        functions: match offered {
            Some(offered) => Functions::load(offered, &declared),
            None => Functions::load(load_named(&who, &hosting.library)?, &declared),
        },
        description,
    })
}
