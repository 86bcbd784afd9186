//! Runs instances in threads that `thread_plan` starts: several cores share a communication step.
//!
//! A worker thread makes, steps and frees its instances; it has its own copy of each FMU's library.
//! It takes orders from one queue and answers through a queue for each instance. The master begins
//! calls of several instances and ends them one by one. The queues hold all calls that are begun at
//! a time, so a step allocates nothing.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;
use std::thread::{self, Builder, JoinHandle};

use anyhow::{Context, Result, anyhow};

use fmi_import::Functions;
use fmi_import::batch::Batch;
use fmi_import::fmi_instance::{Call, FmiInstance};
use fmi_import::messages::{self, Message};

use super::queue::{Receiver, SPINS, Sender};
use super::step_calls::{FailedCall, StepCalls, StepsDone};
use crate::fmu::Fmu;

/// Passes the values of a batch.
pub(super) type Pass = fn(&dyn FmiInstance, &Batch, &mut [f64]) -> Result<()>;
type RareCall = Box<dyn FnOnce(&mut HostedInstance, &mut Copies) -> Result<Given> + Send>;
type Given = Box<dyn Any + Send>;
/// A thread's copies of libraries, by the address of their FMU, which the master holds.
pub(super) type Copies = BTreeMap<usize, (Arc<Fmu>, Arc<Functions>)>;

/// A call of an instance in another thread.
pub(super) enum Task {
    /// A call without values.
    Plain(Call),
    /// Values or derivatives in or out.
    Values(Pass, Batch, Vec<f64>),
    /// A rare call, which may allocate.
    Rare(RareCall),
}

/// The answer to a task.
pub(super) struct Done {
    pub result: Result<f64>,
    pub values: Vec<f64>,
    given: Option<Given>,
    /// Messages of the thread's FMUs, after a failed or a rare call.
    messages: Vec<Message>,
}

/// What a worker is sent; instances are numbered in the order in which they are hosted.
enum Order {
    /// A new instance, not made yet, which answers here.
    Host(Sender<Done>),
    /// A task for an instance. If a task fails, those begun behind it are left out, up to the next
    /// that is first.
    Task {
        number: usize,
        is_first: bool,
        task: Task,
    },
    Free(usize),
    /// The instances that make steps together, with their calls.
    Plan(Vec<(usize, StepCalls)>),
    /// A step of these, from a time by a length, both s, with the values of all.
    Steps([f64; 2], Vec<f64>),
}

/// An instance in its thread.
pub(super) struct HostedInstance {
    pub instance: Option<Box<dyn FmiInstance>>,
    /// Saved states, by number.
    pub states: BTreeMap<usize, Box<dyn Any>>,
    answers: Sender<Done>,
    has_failed: bool,
}

/// The loop of a worker thread.
fn work(orders: &Receiver<Order>, steps: &Sender<StepsDone>, spins: &Cell<usize>) {
    let (mut all, mut copies): (Vec<HostedInstance>, Copies) = Default::default();
    let mut planned = Vec::new();
    while let Some(order) = orders.next(spins) {
        match order {
            Order::Host(answers) => all.push(HostedInstance {
                instance: None,
                states: BTreeMap::new(),
                answers,
                has_failed: false,
            }),
            Order::Task {
                number,
                is_first,
                task,
            } => {
                let hosted = &mut all[number];
                hosted.has_failed &= !is_first;
                let done = hosted.carry_out(task, &mut copies);
                hosted.has_failed |= done.result.is_err();
                // The master may no longer be waiting.
                hosted.answers.send(done);
            }
            Order::Free(number) => {
                all[number].states.clear();
                all[number].instance = None;
            }
            Order::Plan(plan) => planned = plan,
            Order::Steps(time, values) => {
                steps.send(make_steps(&all, &planned, time, values));
            }
        }
    }
}

fn make_steps(
    all: &[HostedInstance],
    planned: &[(usize, StepCalls)],
    time: [f64; 2],
    mut values: Vec<f64>,
) -> StepsDone {
    let (mut failed, mut rest) = (Vec::new(), &mut values[..]);
    for (place, (number, calls)) in planned.iter().enumerate() {
        let own = rest.split_off_mut(..calls.len()).unwrap_or_default();
        let instance = all[*number]
            .instance()
            .map_err(|error| FailedCall::new(0, error));
        let done = instance.and_then(|instance| calls.make(instance, own, time));
        failed.extend(done.err().map(|call| (place, call)));
    }
    StepsDone { values, failed }
}

impl HostedInstance {
    pub fn instance(&self) -> Result<&dyn FmiInstance> {
        self.instance.as_deref().context("there is no instance")
    }

    fn carry_out(&mut self, task: Task, copies: &mut Copies) -> Done {
        let (mut values, mut given) = (Vec::new(), None);
        let result = match task {
            _ if self.has_failed => Err(anyhow!("a call that was begun before it failed")),
            Task::Plain(call) => self.instance().and_then(|instance| instance.call(call)),
            Task::Values(pass, batch, own) => {
                values = own;
                let passed = |instance| pass(instance, &batch, &mut values);
                self.instance().and_then(passed).map(|()| 0.0)
            }
            Task::Rare(call) => call(self, copies).map(|done| {
                given = Some(done);
                0.0
            }),
        };
        let is_quiet = result.is_ok() && given.is_none();
        let messages = match is_quiet {
            true => Vec::new(),
            false => messages::take(),
        };
        Done {
            result,
            values,
            given,
            messages,
        }
    }
}

/// The master's handle of a worker thread, which ends once the last handle, instance and state are
/// dropped.
#[derive(Clone)]
pub struct Worker(Rc<Thread>);

struct Thread {
    orders: Option<Sender<Order>>,
    steps: Receiver<StepsDone>,
    handle: Option<JoinHandle<()>>,
    count: Cell<usize>,
    parts: usize,
    spins: Cell<usize>,
}

impl Worker {
    /// Starts a thread for at most `count` instances, which make up to `parts` steps at a time.
    /// With `spins`, for a thread with a core to itself, it polls its queue before it sleeps.
    pub fn start(count: usize, parts: usize, spins: bool) -> Result<Self> {
        let spins = if spins { SPINS[0] } else { 0 };
        // Holds some calls of each instance; beyond that, the master waits.
        let (orders, received) = Receiver::new((32 + 4 * parts) * count.max(1));
        let (made, steps) = Receiver::new(1);
        let made = Sender::new(made, thread::current());
        let handle = Builder::new()
            .name("cosim".into())
            .spawn(move || work(&received, &made, &Cell::new(spins)))
            .context("a thread cannot be started")?;
        Ok(Self(Rc::new(Thread {
            orders: Some(Sender::new(orders, handle.thread().clone())),
            steps,
            handle: Some(handle),
            count: Cell::new(0),
            parts,
            spins: Cell::new(spins),
        })))
    }

    /// The number of the instance that was made last.
    pub fn last(&self) -> usize {
        self.0.count.get().saturating_sub(1)
    }

    /// From now on these instances, by number, make steps together.
    pub fn plan_steps(&self, plan: Vec<(usize, StepCalls)>) {
        self.0.order(Order::Plan(plan));
    }

    /// Begins a step from a time by a length, both s, with the values of all.
    pub fn begin_steps(&self, time: [f64; 2], values: Vec<f64>) {
        self.0.order(Order::Steps(time, values));
    }

    /// Ends the step that was begun.
    pub fn end_steps(&self) -> Result<StepsDone> {
        let done = self.0.steps.next(&self.0.spins);
        done.context("a thread of this run has ended")
    }
}

impl PartialEq for Worker {
    fn eq(&self, other: &Self) -> bool {
        Rc::ptr_eq(&self.0, &other.0)
    }
}

impl Thread {
    fn order(&self, order: Order) {
        // If the thread has ended, the missing answer is noticed.
        if let Some(orders) = &self.orders {
            orders.send(order);
        }
    }
}

impl Drop for Thread {
    fn drop(&mut self) {
        self.orders = None;
        // A panic in the thread was reported where its answer was missing.
        self.handle.take().map(JoinHandle::join);
    }
}

/// The master's end of an instance's queues.
pub(super) struct Channel {
    thread: Rc<Thread>,
    number: usize,
    answers: Receiver<Done>,
    /// Calls that are begun and not ended.
    begun: Cell<usize>,
    /// Buffers for values, used again.
    pub buffers: RefCell<Vec<Vec<f64>>>,
}

impl Drop for Channel {
    fn drop(&mut self) {
        self.thread.order(Order::Free(self.number));
    }
}

impl Channel {
    /// Queues of a new instance, which is not made yet; up to `calls` may be begun at a time.
    pub fn new(worker: &Worker, calls: usize) -> Rc<Self> {
        let (answers, received) = Receiver::new(calls + 4 * worker.0.parts);
        let answers = Sender::new(answers, thread::current());
        let thread = worker.0.clone();
        let number = thread.count.get();
        thread.count.set(number + 1);
        let channel = Self {
            thread,
            number,
            answers: received,
            begun: Cell::new(0),
            buffers: RefCell::default(),
        };
        channel.thread.order(Order::Host(answers));
        Rc::new(channel)
    }

    fn send(&self, task: Task) {
        self.thread.order(Order::Task {
            number: self.number,
            is_first: self.begun.get() == 0,
            task,
        });
    }

    /// Begins a call; the same call, made later, ends it.
    pub fn begin(&self, task: Task) {
        self.send(task);
        self.begun.set(self.begun.get() + 1);
    }

    /// Ends the call that was begun first; makes it if none was begun.
    pub fn end(&self, task: impl FnOnce() -> Task) -> Result<Done> {
        match self.begun.get() {
            0 => self.send(task()),
            begun => self.begun.set(begun - 1),
        }
        let done = self.answers.next(&self.thread.spins);
        let mut done = done.ok_or_else(|| anyhow!("its thread has ended"))?;
        if !done.messages.is_empty() {
            messages::extend(std::mem::take(&mut done.messages));
        }
        match done.result {
            Err(error) => Err(error),
            Ok(_) => Ok(done),
        }
    }

    /// Awaits all calls that are begun and drops their answers.
    pub fn drain(&self) {
        while self.begun.get() > 0 {
            let _ = self.end(|| unreachable!("a call is begun"));
        }
    }

    /// Makes a rare call, while no other is begun.
    pub fn rare<T: Send + 'static>(
        &self,
        call: impl FnOnce(&mut HostedInstance, &mut Copies) -> Result<T> + Send + 'static,
    ) -> Result<T> {
        debug_assert_eq!(self.begun.get(), 0);
        let task = move |hosted: &mut HostedInstance, copies: &mut Copies| {
            call(hosted, copies).map(|given| Box::new(given) as Given)
        };
        let done = self.end(|| Task::Rare(Box::new(task)))?;
        let given = done.given.and_then(|given| given.downcast().ok());
        given.map(|given| *given).context("nothing was given")
    }
}
