//! Instances in other threads. A worker makes, steps and frees instances in its thread, each with a
//! library that is a copy for this thread alone, and does what it is told through a queue. The master
//! has the other end of each instance: a call may be begun, so that several threads are at work, and
//! is ended by making it. Queues have room for all that is begun, so nothing is allocated in a step.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::hint::spin_loop;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::thread::{Builder, JoinHandle};

use anyhow::{Context, Result, anyhow};

use fmi_import::Functions;
use fmi_import::batch::Batch;
use fmi_import::fmi_instance::{Call, FmiInstance};
use fmi_import::messages::{self, Message};

use crate::fmu::Fmu;

/// How often an empty queue is looked at, at most and at least, before the thread sleeps: the most
/// are some 50 µs. Fewer times where that was in vain, as on a busy machine.
const SPINS: [usize; 2] = [2000, 20];

/// Passes the values of a batch.
pub(super) type Pass = fn(&dyn FmiInstance, &Batch, &mut [f64]) -> Result<()>;
type AnyCall = Box<dyn FnOnce(&dyn FmiInstance, &mut States) -> Result<Given> + Send>;
/// Saved states, by number.
pub(super) type States = BTreeMap<usize, Box<dyn Any>>;
type Given = Box<dyn Any + Send>;
type Make = Box<dyn FnOnce(&mut Copies) -> Result<Option<Box<dyn FmiInstance>>> + Send>;

/// What a worker is to do with an instance.
pub(super) enum Task {
    /// A call without values.
    Plain(Call),
    /// Values or derivatives in or out.
    Values(Pass, Batch, Vec<f64>),
    /// What is rare, and may allocate.
    Any(AnyCall),
    /// A new instance; true where there is one.
    Make(Make, SyncSender<Done>),
    Free,
}

/// What became of it.
pub(super) struct Done {
    pub result: Result<f64>,
    pub values: Vec<f64>,
    given: Option<Given>,
    /// What the FMUs of the thread have said, where it failed or was rare.
    messages: Vec<Message>,
}

/// A task for the instance with a number. After one that failed, those begun behind it are left out.
struct Order {
    number: usize,
    is_first: bool,
    task: Task,
}

/// Libraries of a thread, by the address of their FMU, which the master holds.
pub(super) type Copies = BTreeMap<usize, (Arc<Fmu>, Arc<Functions>)>;

/// An instance in its thread.
struct HostedInstance {
    border: Option<Box<dyn FmiInstance>>,
    states: States,
    answers: SyncSender<Done>,
    has_failed: bool,
}

/// Next of a queue: none at its end.
fn next<T>(queue: &Receiver<T>, spins: &Cell<usize>) -> Option<T> {
    let present = spins.get();
    for _ in 0..present {
        match queue.try_recv() {
            Ok(found) => {
                spins.set((present + present / 4 + 1).min(SPINS[0]));
                return Some(found);
            }
            Err(TryRecvError::Empty) => spin_loop(),
            Err(TryRecvError::Disconnected) => return None,
        }
    }
    if present > 0 {
        spins.set((present - present / 4).max(SPINS[1]));
    }
    queue.recv().ok()
}

/// All that a worker does.
fn work(orders: &Receiver<Order>, spins: &Cell<usize>) {
    let (mut all, mut copies): (Vec<HostedInstance>, Copies) = Default::default();
    while let Some(order) = next(orders, spins) {
        if let Task::Make(_, answers) = &order.task {
            all.push(HostedInstance {
                border: None,
                states: States::new(),
                answers: answers.clone(),
                has_failed: false,
            });
        }
        let instance = &mut all[order.number];
        instance.has_failed &= !order.is_first;
        if let Some(done) = instance.carry_out(order.task, &mut copies) {
            instance.has_failed |= done.result.is_err();
            // Nobody may be waiting any more.
            let _ = instance.answers.send(done);
        }
    }
}

impl HostedInstance {
    fn carry_out(&mut self, task: Task, copies: &mut Copies) -> Option<Done> {
        let (mut values, mut given) = (Vec::new(), None);
        let (border, has_failed) = (&mut self.border, self.has_failed);
        let result = match task {
            Task::Free => {
                self.states.clear();
                *border = None;
                return None;
            }
            Task::Make(make, _) => make(copies).map(|made| {
                *border = made;
                f64::from(u8::from(border.is_some()))
            }),
            _ if has_failed || border.is_none() => Err(anyhow!("what was begun before it failed")),
            Task::Plain(call) => border.as_deref()?.call(call),
            Task::Values(call, batch, own) => {
                values = own;
                let done = call(border.as_deref()?, &batch, &mut values);
                done.map(|()| 0.0)
            }
            Task::Any(call) => call(border.as_deref()?, &mut self.states).map(|done| {
                given = Some(done);
                0.0
            }),
        };
        let is_quiet = result.is_ok() && given.is_none();
        let messages = match is_quiet {
            true => Vec::new(),
            false => messages::take(),
        };
        Some(Done {
            result,
            values,
            given,
            messages,
        })
    }
}

/// The master's end of a worker. The thread ends with the last instance, state and copy of this.
#[derive(Clone)]
pub struct Worker(Rc<Thread>);

struct Thread {
    orders: Option<SyncSender<Order>>,
    handle: Option<JoinHandle<()>>,
    count: Cell<usize>,
    parts: usize,
    spins: Cell<usize>,
}

impl Worker {
    /// Start a thread for `count` instances at most that make `parts` steps at a time; it spins
    /// before it sleeps where it has a core for itself.
    pub fn start(count: usize, parts: usize, spins: bool) -> Result<Self> {
        let spins = if spins { SPINS[0] } else { 0 };
        // Room for some calls of each; where there is more, the master waits until it is done.
        let (orders, received) = sync_channel((32 + 4 * parts) * count.max(1));
        let thread = Builder::new().name("cosim".into());
        let handle = thread.spawn(move || work(&received, &Cell::new(spins)));
        Ok(Self(Rc::new(Thread {
            orders: Some(orders),
            handle: Some(handle.context("a thread cannot be started")?),
            count: Cell::new(0),
            parts,
            spins: Cell::new(spins),
        })))
    }
}

impl Drop for Thread {
    fn drop(&mut self) {
        self.orders = None;
        // A panic in it has been told where its answer was missed.
        self.handle.take().map(JoinHandle::join);
    }
}

/// The master's end of an instance.
pub(super) struct RemoteInstance {
    thread: Rc<Thread>,
    number: usize,
    answers: Receiver<Done>,
    /// Calls that are begun and not ended.
    pub begun: Cell<usize>,
    /// Buffers for values.
    spare: RefCell<Vec<Vec<f64>>>,
}

impl Drop for RemoteInstance {
    fn drop(&mut self) {
        self.send(Task::Free);
    }
}

impl RemoteInstance {
    /// The end of a new instance that `make` makes, with room for so many begun calls.
    pub fn new(worker: &Worker, room: usize, make: Make) -> Result<Option<Rc<Self>>> {
        let (answers, received) = sync_channel(room + 4 * worker.0.parts);
        let thread = worker.0.clone();
        let number = thread.count.get();
        thread.count.set(number + 1);
        let there = Rc::new(Self {
            thread,
            number,
            answers: received,
            begun: Cell::new(0),
            spare: RefCell::default(),
        });
        there.send(Task::Make(make, answers));
        let is_made = there.wait()?.result? != 0.0;
        Ok(is_made.then_some(there))
    }

    /// Await and forget what is begun.
    pub fn drain(&self) {
        while self.begun.get() > 0 {
            let _ = self.end(|| Task::Free);
        }
    }

    pub fn send(&self, task: Task) {
        let order = Order {
            number: self.number,
            is_first: self.begun.get() == 0,
            task,
        };
        // Where the thread has ended, the answer is missed.
        let orders = self.thread.orders.as_ref();
        let _ = orders.map(|orders| orders.send(order));
    }

    pub fn wait(&self) -> Result<Done> {
        let done = next(&self.answers, &self.thread.spins);
        let mut done = done.ok_or_else(|| anyhow!("its thread has ended"))?;
        if !done.messages.is_empty() {
            messages::extend(std::mem::take(&mut done.messages));
        }
        Ok(done)
    }

    /// End what is begun, else make it.
    pub fn end(&self, task: impl FnOnce() -> Task) -> Result<Done> {
        match self.begun.get() {
            0 => self.send(task()),
            begun => self.begun.set(begun - 1),
        }
        let done = self.wait()?;
        match done.result {
            Err(error) => Err(error),
            Ok(_) => Ok(done),
        }
    }

    /// With any values.
    pub fn buffer(&self, count: usize) -> Vec<f64> {
        let mut buffer = self.spare.borrow_mut().pop().unwrap_or_default();
        buffer.resize(count, 0.0);
        buffer
    }

    pub fn keep(&self, done: Done) {
        self.spare.borrow_mut().push(done.values);
    }

    /// What is rare: nothing else may be begun.
    pub fn any<T: Send + 'static>(
        &self,
        call: impl FnOnce(&dyn FmiInstance, &mut States) -> Result<T> + Send + 'static,
    ) -> Result<T> {
        debug_assert_eq!(self.begun.get(), 0);
        let task = move |border: &dyn FmiInstance, states: &mut States| {
            call(border, states).map(|given| Box::new(given) as Given)
        };
        let done = self.end(|| Task::Any(Box::new(task)))?;
        let given = done.given.and_then(|given| given.downcast().ok());
        given.map(|given| *given).context("nothing was given")
    }
}
