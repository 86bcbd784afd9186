//! [`IsolatedInstance`]: an instance in a process of its own, which a master calls as one in its own
//! process, and whose calls it may begin before it needs their answers.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::ffi::CString;
use std::rc::Rc;

use anyhow::{Context, Error, Result, ensure};

use super::channel::{Answered, Channel, Due};
use super::protocol::{
    Hosting, Integrating, NamedBatch, Pass, ROOM, RareAnswer, RareRequest, Request, is_frequent,
};
use crate::Fmu;
use crate::Limits;
use crate::answer::{Answer, LateAnswer};
use crate::batch::Batch;
use crate::exchange::ExchangePlan;
use crate::fmi_instance::{Arguments, BegunCall, Call, FmiInstance, Integration};
use crate::value::Value;

/// Most batches that the process keeps of which nobody else does.
const BATCHES: usize = 256;

/// An instance in a process of its own, which ends with it.
pub struct IsolatedInstance(Rc<Hosted>);

struct Hosted {
    channel: Channel,
    batches: RefCell<Vec<Batch>>,
    /// Where the last batch was found.
    last_batch: Cell<usize>,
    /// Sets that were begun and not ended.
    sets: Cell<usize>,
    /// The first error of a set that was ended before its answer came.
    late: RefCell<Option<Error>>,
    ahead: RefCell<ReadAhead>,
}

/// Batches that are read right after a step, as they were after the last one: with the next step
/// they are read ahead, so that one answer is awaited instead of several.
#[derive(Default)]
struct ReadAhead {
    last: Vec<u32>,
    /// Those after the present step; counted while nothing but reads follows it.
    present: Vec<u32>,
    is_counting: bool,
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
    /// Starts a process and makes an instance of an FMU from the archive `file` in it, for Model Exchange
    /// if there is a plan of that; None if the FMU returns none. `sizes` are values of structural
    /// parameters by value reference, with which it has so many `variables`.
    ///
    /// # Errors
    /// There is no program for the process, or the library cannot be loaded.
    pub fn new(
        (file, fmu): (&str, &Fmu),
        (sizes, variables): (&HashMap<u32, String>, usize),
        exchange: Option<&ExchangePlan>,
        arguments: &Arguments,
        limits: Limits,
    ) -> Result<Option<Self>> {
        // A request may have the variables of a batch and their values.
        let most = ROOM / 2 - 64;
        ensure!(
            variables < most,
            "FMU `{file}` has {variables} variables; in a process of its own it may have {most}"
        );
        let unpacked = fmu.unpacked.as_ref().context("it was not unpacked here")?;
        let hosting = Hosting {
            file: file.to_string(),
            library: unpacked.path(),
            description: unpacked.folder().join("modelDescription.xml"),
            sizes: sizes.clone(),
            exchange: exchange.map(|plan| Integrating {
                choice: plan.choice,
                means: plan.means(),
            }),
            arguments: arguments.clone(),
            limits,
        };
        let name = arguments.name.to_string_lossy().into_owned();
        let hosted = Hosted {
            channel: Channel::start(name, limits).context("a process of its own")?,
            batches: RefCell::default(),
            last_batch: Cell::new(0),
            sets: Cell::new(0),
            late: RefCell::default(),
            ahead: RefCell::default(),
        };
        let made = hosted.rare(&RareRequest::Host(Box::new(hosting)))?;
        let hosted = Self(Rc::new(hosted));
        Ok(matches!(made, RareAnswer::Is(true)).then_some(hosted))
    }
}

impl Hosted {
    fn damaged(&self) -> Error {
        self.channel.damaged()
    }

    /// Takes the next wanted answer, with exactly these values.
    fn take(&self, values: &mut [f64]) -> Result<Answered> {
        let channel = &self.channel;
        self.take_unwanted()?;
        if channel.due.borrow_mut().pop_front().is_none() {
            return Err(self.damaged());
        }
        channel.wanted.set(channel.wanted.get() - 1);
        let taken = match self.late.take() {
            Some(late) => channel.skip().and(Err(late)),
            None => channel.answer(values),
        };
        if taken.is_err() {
            // What follows was left out, and is in the way of other calls.
            self.take_unwanted()?;
        }
        taken
    }

    /// Takes the answers before the next wanted one. The first error of a set is told by the call
    /// whose answer that is.
    fn take_unwanted(&self) -> Result<()> {
        let channel = &self.channel;
        loop {
            let next = channel.due.borrow().front().copied();
            let Some(next) = next.filter(|next| !matches!(next, Due::Wanted)) else {
                return Ok(());
            };
            channel.due.borrow_mut().pop_front();
            let Due::Late(number) = next else {
                channel.skip()?;
                continue;
            };
            if let Err(error) = channel.answer(&mut []) {
                if channel.is_over() {
                    return Err(error);
                }
                let batch = self.batches.borrow()[number as usize].clone();
                let error = match error.downcast::<Answer>() {
                    Ok(answer) => LateAnswer { answer, batch }.into(),
                    Err(error) => error,
                };
                self.late.borrow_mut().get_or_insert(error);
            }
        }
    }

    /// Takes all answers.
    fn settle(&self) {
        let channel = &self.channel;
        self.forget_ahead();
        while self.take_unwanted().is_ok() && channel.due.borrow_mut().pop_front().is_some() {
            channel.wanted.set(channel.wanted.get() - 1);
            let _ = channel.skip(); // if the process has ended, the next call says so
        }
    }

    /// Makes a rare call; those that are begun are awaited first.
    fn rare(&self, request: &RareRequest) -> Result<RareAnswer> {
        self.settle();
        self.channel.request_rare(request)?;
        self.channel.rare_answer(self.take(&mut [])?)
    }

    fn done(&self, request: &RareRequest) -> Result<()> {
        self.rare(request).map(drop)
    }

    /// Something else than a read follows a step: what was read ahead and is not wanted is dropped.
    fn forget_ahead(&self) {
        let ahead = &mut *self.ahead.borrow_mut();
        if !ahead.is_counting {
            return;
        }
        std::mem::swap(&mut ahead.last, &mut ahead.present);
        ahead.is_counting = false;
        for due in self.channel.due.borrow_mut().iter_mut() {
            if matches!(due, Due::Ahead(_)) {
                *due = Due::Dropped;
            }
        }
    }

    fn begin_call(&self, call: Call) {
        let channel = &self.channel;
        if channel.is_over() {
            return;
        }
        self.forget_ahead();
        let request = (&Request::Plain(call), Due::Wanted);
        channel.request(request, &[], (&[], 0), 0);
        if matches!(call, Call::Step(..)) {
            let ahead = &mut *self.ahead.borrow_mut();
            for number in &ahead.last {
                let read = (&Request::Pass(Pass::Get, *number), Due::Ahead(*number));
                let length = self.batches.borrow()[*number as usize].len();
                channel.request(read, &[], (&[], 0), length);
            }
            ahead.present.clear();
            ahead.is_counting = true;
        }
        channel.wake();
    }

    /// Whether a read of a batch was made ahead: it is wanted now.
    fn is_ahead(&self, number: u32) -> bool {
        let mut due = self.channel.due.borrow_mut();
        let first = due.iter_mut().find(|due| matches!(due, Due::Ahead(_)));
        let found = first.filter(|due| matches!(due, Due::Ahead(own) if *own == number));
        let is_ahead = found.map(|due| *due = Due::Wanted).is_some();
        let wanted = &self.channel.wanted;
        wanted.set(wanted.get() + usize::from(is_ahead));
        is_ahead
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

    /// Begins to pass values; with `is_late` the answer is awaited together with the next one.
    fn begin_pass(&self, pass: Pass, batch: &Batch, values: &[f64], is_late: bool) {
        if self.channel.is_over() {
            return;
        }
        let (number, is_new) = self.number(batch);
        let is_after_step = matches!(pass, Pass::Get) && self.ahead.borrow().is_counting;
        if is_after_step {
            self.ahead.borrow_mut().present.push(number);
            if !is_new && self.is_ahead(number) {
                return;
            }
        } else {
            self.forget_ahead();
        }
        let new = if is_new { &batch.variables[..] } else { &[] };
        let expected = match pass {
            Pass::Get | Pass::GetDerivatives => batch.len(),
            Pass::Set | Pass::SetDerivatives => 0,
        };
        let due = match is_late {
            true => Due::Late(number),
            false => Due::Wanted,
        };
        let request = (&Request::Pass(pass, number), due);
        (self.channel).request(request, new, (values, values.len()), expected);
    }

    /// Passes values: ends the call that was begun first, or makes it.
    fn pass(&self, pass: Pass, batch: &Batch, given: &[f64], read: &mut [f64]) -> Result<()> {
        if self.channel.wanted.get() == 0 {
            self.begin_pass(pass, batch, given, false);
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

impl FmiInstance for IsolatedInstance {
    fn begin(&self, ahead: BegunCall) {
        let hosted = &self.0;
        match ahead {
            BegunCall::Plain(call) => hosted.begin_call(call),
            BegunCall::Get(batch) => hosted.begin_pass(Pass::Get, batch, &[], false),
            BegunCall::Set(batch, values) => {
                hosted.begin_pass(Pass::Set, batch, values, true);
                hosted.sets.set(hosted.sets.get() + 1);
            }
        }
    }

    fn drain(&self) {
        if self.0.channel.wanted.get() == 0 && self.0.sets.get() == 0 {
            return; // What was read ahead is wanted soon.
        }
        self.0.settle();
        self.0.sets.set(0);
        self.0.late.take();
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
            self.0.channel.choose_spins();
        }
        if self.0.channel.wanted.get() == 0 {
            self.0.begin_call(call);
        }
        if is_frequent(call) {
            return self.0.take(&mut [])?.map_err(|_| self.0.damaged());
        }
        let answered = self.0.take(&mut [])?;
        match self.0.channel.rare_answer(answered)? {
            RareAnswer::Number(number) => Ok(number),
            _ => Err(self.0.damaged()),
        }
    }

    fn get(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        self.0.pass(Pass::Get, batch, &[], values)
    }

    /// One that was begun ends at once: the call after it, mostly a step, awaits its answer too.
    fn set(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        let begun = self.0.sets.get();
        if begun > 0 {
            self.0.sets.set(begun - 1);
            return Ok(());
        }
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
