//! Instances in other threads. A worker makes, steps and frees instances in its thread, each with a
//! library that is a copy for this thread alone, and does what it is told through a queue. The master
//! has the other end of each instance: a call may be begun, so that several threads are at work, and
//! is ended by making it. Queues have room for all that is begun, so nothing is allocated in a step.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::ffi::CString;
use std::hint::spin_loop;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::thread::{Builder, JoinHandle};

use anyhow::{Context, Result, anyhow, bail};

use super::border::{Ahead, Arguments, Border};
use super::instance;
use super::messages::{self, Message};
use crate::batch::Batch;
use crate::fmu::{Api, Fmu};
use crate::value::Value;

/// How often an empty queue is looked at, at most and at least, before the thread sleeps: the most
/// are some 50 µs. Fewer times where that was in vain, as on a busy machine.
const SPINS: [usize; 2] = [2000, 20];

/// Calls of one instance that may be begun: batches are of one type each, with the same clocks.
fn room(fmu: &Fmu) -> usize {
    8 + 16 * (1 + fmu.plan.clocks.len())
}

type Given = Box<dyn Any + Send>;
type Make = Box<dyn FnOnce(&mut Copies) -> Result<Option<Box<dyn Border>>> + Send>;

/// What a worker is to do with an instance.
enum Task {
    /// Up to two numbers in, one out.
    Numbers(fn(&dyn Border, [f64; 2]) -> Result<f64>, [f64; 2]),
    /// Values in or out.
    Values(
        fn(&dyn Border, &Batch, &mut [f64]) -> Result<()>,
        Batch,
        Vec<f64>,
    ),
    /// First derivatives in or out.
    Derivatives(
        fn(&dyn Border, &Batch, &[i32], &mut [f64]) -> Result<()>,
        Batch,
        Vec<i32>,
        Vec<f64>,
    ),
    /// What is rare, and may allocate.
    Any(Box<dyn FnOnce(&mut Seat) -> Result<Given> + Send>),
    /// A new instance; true where there is one.
    Make(Make, SyncSender<Done>),
    Free,
}

/// What became of it.
struct Done {
    result: Result<f64>,
    values: Vec<f64>,
    ones: Vec<i32>,
    given: Option<Given>,
    /// What the FMUs of the thread have said, where it failed or is asked for.
    messages: Vec<Message>,
}

/// A task for the instance with a number. After one that failed, those begun behind it are left out.
struct Order {
    number: usize,
    is_first: bool,
    task: Task,
}

/// Libraries of a thread, by the address of their FMU, which the master holds.
type Copies = BTreeMap<usize, (Arc<Fmu>, Api)>;

/// An instance in its thread.
struct Seat {
    border: Option<Box<dyn Border>>,
    states: BTreeMap<usize, Box<dyn Any>>,
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
    let (mut all, mut copies): (Vec<Seat>, Copies) = Default::default();
    while let Some(order) = next(orders, spins) {
        if let Task::Make(_, answers) = &order.task {
            all.push(Seat {
                border: None,
                states: BTreeMap::new(),
                answers: answers.clone(),
                has_failed: false,
            });
        }
        let seat = &mut all[order.number];
        seat.has_failed &= !order.is_first;
        if let Some(done) = seat.carry_out(order.task, &mut copies) {
            seat.has_failed |= done.result.is_err();
            // Nobody may be waiting any more.
            let _ = seat.answers.send(done);
        }
    }
}

impl Seat {
    fn carry_out(&mut self, task: Task, copies: &mut Copies) -> Option<Done> {
        let mut done = Done {
            result: Ok(0.0),
            values: Vec::new(),
            ones: Vec::new(),
            given: None,
            messages: Vec::new(),
        };
        let live = |border: &Option<Box<dyn Border>>, has_failed: bool| match border {
            Some(_) if !has_failed => Ok(()),
            _ => bail!("not done, because what was begun before it failed"),
        };
        done.result = match task {
            Task::Free => {
                self.states.clear();
                self.border = None;
                return None;
            }
            Task::Make(make, _) => make(copies).map(|border| {
                self.border = border;
                f64::from(u8::from(self.border.is_some()))
            }),
            Task::Any(call) => call(self).map(|given| {
                done.given = Some(given);
                0.0
            }),
            task => live(&self.border, self.has_failed).and_then(|()| {
                let border = self.border.as_deref().context("no instance")?;
                match task {
                    Task::Numbers(call, numbers) => call(border, numbers),
                    Task::Values(call, batch, mut values) => {
                        let result = call(border, &batch, &mut values);
                        done.values = values;
                        result.map(|()| 0.0)
                    }
                    Task::Derivatives(call, batch, ones, mut values) => {
                        let result = call(border, &batch, &ones, &mut values);
                        (done.values, done.ones) = (values, ones);
                        result.map(|()| 0.0)
                    }
                    _ => Ok(0.0),
                }
            }),
        };
        if done.result.is_err() {
            done.messages = messages::take();
        }
        Some(done)
    }
}

/// The master's end of a worker. The thread ends with the last instance, state and copy of this.
#[derive(Clone)]
pub struct Worker(Rc<Thread>);

struct Thread {
    orders: Option<SyncSender<Order>>,
    handle: Option<JoinHandle<()>>,
    count: Cell<usize>,
    spins: Cell<usize>,
}

impl Worker {
    /// Start a thread for `count` instances at most; it spins before it sleeps where it has a core
    /// for itself.
    pub fn start(count: usize, spins: bool) -> Result<Self> {
        let spins = if spins { SPINS[0] } else { 0 };
        // Room for some calls of each; where there is more, the master waits until it is done.
        let (orders, received) = sync_channel(32 * count.max(1));
        let thread = Builder::new().name("cosim".into());
        let handle = thread.spawn(move || work(&received, &Cell::new(spins)));
        Ok(Self(Rc::new(Thread {
            orders: Some(orders),
            handle: Some(handle.context("a thread cannot be started")?),
            count: Cell::new(0),
            spins: Cell::new(spins),
        })))
    }

    /// An instance in the thread, of a library of its own; none where the FMU gives none.
    pub fn make(&self, fmu: &Arc<Fmu>, arguments: &Arguments) -> Result<Option<Box<dyn Border>>> {
        let (answers, received) = sync_channel(room(fmu));
        let number = self.0.count.get();
        self.0.count.set(number + 1);
        let there = Rc::new(There {
            thread: self.0.clone(),
            number,
            answers: received,
            begun: Cell::new(0),
            saved: Cell::new(0),
            spare: RefCell::default(),
        });
        let [name, token, resources] =
            [arguments.name, arguments.token, arguments.resources].map(CString::from);
        let (has_events, returns_early) = (arguments.has_events, arguments.returns_early);
        let fmu = fmu.clone();
        let make = move |copies: &mut Copies| {
            let key = Arc::as_ptr(&fmu).addr();
            if let std::collections::btree_map::Entry::Vacant(free) = copies.entry(key) {
                free.insert((fmu.clone(), fmu.copied()?));
            }
            let arguments = Arguments {
                name: &name,
                token: &token,
                resources: &resources,
                has_events,
                returns_early,
            };
            instance::make(&fmu, &copies[&key].1, &arguments)
        };
        there.send(Task::Make(Box::new(make), answers));
        let is_made = there.wait()?.result? != 0.0;
        Ok(is_made.then(|| Box::new(Remote(there)) as Box<dyn Border>))
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
struct There {
    thread: Rc<Thread>,
    number: usize,
    answers: Receiver<Done>,
    /// Calls that are begun and not ended.
    begun: Cell<usize>,
    /// States saved so far.
    saved: Cell<usize>,
    /// Buffers for values and for ones.
    spare: RefCell<(Vec<Vec<f64>>, Vec<Vec<i32>>)>,
}

impl Drop for There {
    fn drop(&mut self) {
        self.send(Task::Free);
    }
}

impl There {
    fn send(&self, task: Task) {
        let order = Order {
            number: self.number,
            is_first: self.begun.get() == 0,
            task,
        };
        // Where the thread has ended, the answer is missed.
        let orders = self.thread.orders.as_ref();
        let _ = orders.map(|orders| orders.send(order));
    }

    fn wait(&self) -> Result<Done> {
        let done = next(&self.answers, &self.thread.spins);
        let mut done = done.ok_or_else(|| anyhow!("its thread has ended"))?;
        if !done.messages.is_empty() {
            messages::extend(std::mem::take(&mut done.messages));
        }
        Ok(done)
    }

    /// End what is begun, else make it.
    fn end(&self, task: impl FnOnce() -> Task) -> Result<Done> {
        match self.begun.get() {
            0 => self.send(task()),
            begun => self.begun.set(begun - 1),
        }
        let mut done = self.wait()?;
        match std::mem::replace(&mut done.result, Ok(0.0)) {
            Ok(number) => done.result = Ok(number),
            Err(error) => return Err(error),
        }
        Ok(done)
    }

    fn number(
        &self,
        call: fn(&dyn Border, [f64; 2]) -> Result<f64>,
        numbers: [f64; 2],
    ) -> Result<f64> {
        self.end(|| Task::Numbers(call, numbers))?.result
    }

    fn buffer(&self, values: &[f64]) -> Vec<f64> {
        let mut buffer = self.spare.borrow_mut().0.pop().unwrap_or_default();
        buffer.clear();
        buffer.extend_from_slice(values);
        buffer
    }

    fn room_for(&self, count: usize) -> Vec<f64> {
        let mut buffer = self.buffer(&[]);
        buffer.resize(count, 0.0);
        buffer
    }

    fn keep(&self, done: Done) {
        let mut spare = self.spare.borrow_mut();
        spare.0.push(done.values);
        if done.ones.capacity() > 0 {
            spare.1.push(done.ones);
        }
    }

    /// What is rare: nothing else may be begun.
    fn any<T: Send + 'static>(
        &self,
        call: impl FnOnce(&mut Seat, &dyn Border) -> Result<T> + Send + 'static,
    ) -> Result<T> {
        debug_assert_eq!(self.begun.get(), 0);
        let task = move |seat: &mut Seat| {
            let border = seat.border.take().context("no instance")?;
            let result = call(seat, &*border);
            seat.border = Some(border);
            result.map(|given| Box::new(given) as Given)
        };
        let done = self.end(|| Task::Any(Box::new(task)))?;
        let given = done.given.and_then(|given| given.downcast().ok());
        given.map(|given| *given).context("nothing was given")
    }

    fn derivatives(
        &self,
        call: fn(&dyn Border, &Batch, &[i32], &mut [f64]) -> Result<()>,
        batch: &Batch,
        ones: &[i32],
        values: &[f64],
    ) -> Result<Done> {
        self.end(|| {
            let mut own = self.spare.borrow_mut().1.pop().unwrap_or_default();
            own.clear();
            own.extend_from_slice(&ones[..batch.len()]);
            Task::Derivatives(call, batch.clone(), own, self.buffer(values))
        })
    }
}

/// An instance in another thread.
struct Remote(Rc<There>);

/// A state that is kept in the thread of its instance.
struct SavedThere {
    there: Rc<There>,
    key: usize,
}

impl Drop for SavedThere {
    fn drop(&mut self) {
        let key = self.key;
        // Where the thread has ended, the state has, too.
        let _ = self
            .there
            .any(move |seat, _| Ok(seat.states.remove(&key).map(drop)));
    }
}

fn none(done: Result<()>) -> Result<f64> {
    done.map(|()| 0.0)
}

impl There {
    /// A new state, which stays in the thread.
    fn kept(
        self: &Rc<Self>,
        save: impl FnOnce(&dyn Border) -> Result<Box<dyn Any>> + Send + 'static,
    ) -> Result<Box<dyn Any>> {
        let key = self.saved.get();
        self.saved.set(key + 1);
        self.any(move |seat, border| {
            seat.states.insert(key, save(border)?);
            Ok(())
        })?;
        let there = self.clone();
        Ok(Box::new(SavedThere { there, key }))
    }

    fn key(self: &Rc<Self>, state: &dyn Any) -> Result<usize> {
        let own = state.downcast_ref::<SavedThere>();
        let own = own.filter(|s| Rc::ptr_eq(&s.there, self));
        Ok(own.context("a state of another instance")?.key)
    }

    fn task(&self, ahead: Ahead) -> Task {
        match ahead {
            Ahead::EnterInitialization(t) => {
                Task::Numbers(|b, [t, _]| none(b.enter_initialization(t)), [t, 0.0])
            }
            Ahead::ExitInitialization => {
                Task::Numbers(|b, _| none(b.exit_initialization()), [0.0; 2])
            }
            Ahead::Step(t, h) => Task::Numbers(|b, [t, h]| none(b.step(t, h)), [t, h]),
            Ahead::EnterEvents => Task::Numbers(|b, _| none(b.enter_events()), [0.0; 2]),
            Ahead::UpdateEvents => Task::Numbers(
                |b, _| b.update_events().map(|c| f64::from(u8::from(c))),
                [0.0; 2],
            ),
            Ahead::LeaveEvents => Task::Numbers(|b, _| none(b.leave_events()), [0.0; 2]),
            Ahead::Get(batch) => {
                let room = self.room_for(batch.len());
                Task::Values(|b, batch, v| b.get(batch, v), batch.clone(), room)
            }
            Ahead::Set(batch, values) => {
                let values = self.buffer(values);
                Task::Values(|b, batch, v| b.set(batch, v), batch.clone(), values)
            }
        }
    }

    fn made(&self, ahead: Ahead) -> Result<f64> {
        self.end(|| self.task(ahead))?.result
    }
}

impl Border for Remote {
    fn is_elsewhere(&self) -> bool {
        true
    }

    fn begin(&self, ahead: Ahead) {
        self.0.send(self.0.task(ahead));
        self.0.begun.set(self.0.begun.get() + 1);
    }

    fn log_only(&self, categories: &[CString]) -> Result<()> {
        let categories = categories.to_vec();
        self.0.any(move |_, border| border.log_only(&categories))
    }

    fn get_whole(&self, batch: &Batch, values: &mut [Value]) -> Result<()> {
        let (batch, mut own) = (batch.clone(), values.to_vec());
        let read = self.0.any(move |_, border| {
            border.get_whole(&batch, &mut own)?;
            Ok(own)
        });
        values.clone_from_slice(&read?);
        Ok(())
    }

    fn set_whole(&self, batch: &Batch, values: &[Value]) -> Result<()> {
        let (batch, own) = (batch.clone(), values.to_vec());
        self.0.any(move |_, border| border.set_whole(&batch, &own))
    }

    fn set_up(&self, start: f64) -> Result<()> {
        self.0.any(move |_, border| border.set_up(start))
    }

    fn enter_initialization(&self, start: f64) -> Result<()> {
        self.0.made(Ahead::EnterInitialization(start)).map(drop)
    }

    fn exit_initialization(&self) -> Result<()> {
        self.0.made(Ahead::ExitInitialization).map(drop)
    }

    fn get(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        let done = self.0.end(|| self.0.task(Ahead::Get(batch)))?;
        values.copy_from_slice(&done.values);
        self.0.keep(done);
        Ok(())
    }

    fn set(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        let done = self.0.end(|| self.0.task(Ahead::Set(batch, values)))?;
        self.0.keep(done);
        Ok(())
    }

    fn get_derivatives(&self, batch: &Batch, ones: &[i32], values: &mut [f64]) -> Result<()> {
        let call = |b: &dyn Border, batch: &Batch, ones: &[i32], v: &mut [f64]| {
            b.get_derivatives(batch, ones, v)
        };
        let done = self.0.derivatives(call, batch, ones, values)?;
        values.copy_from_slice(&done.values);
        self.0.keep(done);
        Ok(())
    }

    fn set_derivatives(&self, batch: &Batch, ones: &[i32], values: &[f64]) -> Result<()> {
        let call = |b: &dyn Border, batch: &Batch, ones: &[i32], v: &mut [f64]| {
            b.set_derivatives(batch, ones, v)
        };
        let done = self.0.derivatives(call, batch, ones, values)?;
        self.0.keep(done);
        Ok(())
    }

    fn step(&self, t: f64, h: f64) -> Result<()> {
        self.0.made(Ahead::Step(t, h)).map(drop)
    }

    fn time(&self) -> Result<f64> {
        self.0.number(|b, _| b.time(), [0.0; 2])
    }

    fn enter_events(&self) -> Result<()> {
        self.0.made(Ahead::EnterEvents).map(drop)
    }

    fn update_events(&self) -> Result<bool> {
        Ok(self.0.made(Ahead::UpdateEvents)? != 0.0)
    }

    fn leave_events(&self) -> Result<()> {
        self.0.made(Ahead::LeaveEvents).map(drop)
    }

    fn settle(&self) -> Result<()> {
        self.0.number(|b, _| none(b.settle()), [0.0; 2]).map(drop)
    }

    /// Where the thread has ended, the next call says so.
    fn next_event(&self) -> f64 {
        let next = self.0.number(|b, _| Ok(b.next_event()), [0.0; 2]);
        next.unwrap_or(f64::INFINITY)
    }

    fn tick(&self, t: f64, tolerance: f64) -> Result<()> {
        let tick = self
            .0
            .number(|b, [t, by]| none(b.tick(t, by)), [t, tolerance]);
        tick.map(drop)
    }

    /// What the FMUs of the thread have said comes along.
    fn terminate(&self) -> Result<()> {
        let ended = self
            .0
            .any(|_, border| Ok((border.terminate(), messages::take())));
        let (result, said) = ended?;
        messages::extend(said);
        result
    }

    fn save(&self) -> Result<Box<dyn Any>> {
        self.0.kept(|border| border.save())
    }

    fn restore(&self, state: &dyn Any) -> Result<()> {
        let key = self.0.key(state)?;
        self.0
            .any(move |seat, border| border.restore(&*seat.states[&key]))
    }

    fn state_to_bytes(&self, state: &dyn Any) -> Result<Vec<u8>> {
        let key = self.0.key(state)?;
        self.0
            .any(move |seat, border| border.state_to_bytes(&*seat.states[&key]))
    }

    fn state_from_bytes(&self, bytes: &[u8]) -> Result<Box<dyn Any>> {
        let bytes = bytes.to_vec();
        self.0.kept(move |border| border.state_from_bytes(&bytes))
    }

    fn stop_early(&self, stops: bool) {
        // Where the thread has ended, the next call says so.
        let _ = self.0.any(move |_, border| Ok(border.stop_early(stops)));
    }

    /// The thread ends with its run.
    fn reset(&self) -> bool {
        false
    }
}
