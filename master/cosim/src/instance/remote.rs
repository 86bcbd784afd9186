//! An instance in another thread, which `Instance` calls like one in its own: each call is sent to
//! the instance's worker as a task, and may be begun before its answer is needed.

use std::any::Any;
use std::collections::btree_map::Entry;
use std::ffi::CString;
use std::rc::Rc;
use std::sync::Arc;

use anyhow::{Context, Result};

use fmi_import::batch::Batch;
use fmi_import::fmi_instance::{Arguments, BegunCall, Call, FmiInstance, Integration};
use fmi_import::value::Value;

use super::workers::{Channel, Pass, Task, Worker};
use crate::fmu::Fmu;

struct RemoteInstance(Rc<Channel>);

/// Makes an instance in the thread of a worker, of that thread's copy of the library; None if the
/// FMU returns none.
pub fn make(
    worker: &Worker,
    fmu: &Arc<Fmu>,
    arguments: &Arguments,
) -> Result<Option<Box<dyn FmiInstance>>> {
    // A call a batch: batches are of one type each, with the same clocks.
    let channel = Channel::new(worker, 8 + 16 * (1 + fmu.plan.count()));
    let (own, arguments) = (fmu.clone(), arguments.clone());
    let is_made = channel.rare(move |hosted, copies| {
        let key = Arc::as_ptr(&own).addr();
        if let Entry::Vacant(free) = copies.entry(key) {
            let copy = own.loaded.load_copy();
            let what = || format!("a copy of the library of FMU `{}`", own.file);
            free.insert((own.clone(), copy.with_context(what)?));
        }
        hosted.instance = own.make(&copies[&key].1, &arguments)?;
        Ok(hosted.instance.is_some())
    })?;
    Ok(is_made.then(|| Box::new(RemoteInstance(channel)) as Box<dyn FmiInstance>))
}

/// A saved state, which stays in the thread of its instance.
struct RemoteState {
    channel: Rc<Channel>,
    key: usize,
}

impl Drop for RemoteState {
    fn drop(&mut self) {
        let key = self.key;
        // If the thread has ended, the state is gone, too.
        let _ = (self.channel).rare(move |hosted, _| Ok(hosted.states.remove(&key).map(drop)));
    }
}

const GET: Pass = |instance, batch, values| instance.get(batch, values);
const SET: Pass = |instance, batch, values| instance.set(batch, values);

impl RemoteInstance {
    fn keep_state(
        &self,
        save: impl FnOnce(&dyn FmiInstance) -> Result<Box<dyn Any>> + Send + 'static,
    ) -> Result<Box<dyn Any>> {
        let key = self.0.rare(move |hosted, _| {
            let key = hosted.states.keys().last().map_or(0, |last| last + 1);
            let state = save(hosted.instance()?)?;
            hosted.states.insert(key, state);
            Ok(key)
        })?;
        let channel = self.0.clone();
        Ok(Box::new(RemoteState { channel, key }))
    }

    fn key(&self, state: &dyn Any) -> Result<usize> {
        let own = state.downcast_ref::<RemoteState>();
        let own = own.filter(|s| Rc::ptr_eq(&s.channel, &self.0));
        Ok(own.context("a state of another instance")?.key)
    }

    /// Passes values that are `given`, or reads them into a buffer.
    fn task(&self, pass: Pass, batch: &Batch, given: Option<&[f64]>) -> Task {
        let mut own = self.0.buffers.borrow_mut().pop().unwrap_or_default();
        own.resize(given.map_or(batch.len(), <[f64]>::len), 0.0);
        if let Some(given) = given {
            own.copy_from_slice(given);
        }
        Task::Values(pass, batch.clone(), own)
    }

    fn read(&self, pass: Pass, batch: &Batch, values: &mut [f64]) -> Result<()> {
        let done = self.0.end(|| self.task(pass, batch, None))?;
        values.copy_from_slice(&done.values);
        self.0.buffers.borrow_mut().push(done.values);
        Ok(())
    }

    fn write(&self, pass: Pass, batch: &Batch, values: &[f64]) -> Result<()> {
        let done = self.0.end(|| self.task(pass, batch, Some(values)))?;
        self.0.buffers.borrow_mut().push(done.values);
        Ok(())
    }
}

impl FmiInstance for RemoteInstance {
    fn begin(&self, ahead: BegunCall) {
        self.0.begin(match ahead {
            BegunCall::Plain(call) => Task::Plain(call),
            BegunCall::Get(batch) => self.task(GET, batch, None),
            BegunCall::Set(batch, values) => self.task(SET, batch, Some(values)),
        });
    }

    fn drain(&self) {
        self.0.drain();
    }

    fn log_only(&self, categories: &[CString]) -> Result<()> {
        let categories = categories.to_vec();
        (self.0).rare(move |hosted, _| hosted.instance()?.log_only(&categories))
    }

    fn get_values(&self, batch: &Batch, values: &mut [Value]) -> Result<()> {
        let (batch, mut own) = (batch.clone(), values.to_vec());
        let read = self.0.rare(move |hosted, _| {
            hosted.instance()?.get_values(&batch, &mut own)?;
            Ok(own)
        });
        values.clone_from_slice(&read?);
        Ok(())
    }

    fn set_values(&self, batch: &Batch, values: &[Value]) -> Result<()> {
        let (batch, own) = (batch.clone(), values.to_vec());
        (self.0).rare(move |hosted, _| hosted.instance()?.set_values(&batch, &own))
    }

    /// Calls that are made once a run bring along the FMU's messages.
    fn call(&self, call: Call) -> Result<f64> {
        match call {
            Call::SetUp(_)
            | Call::EnterConfiguration
            | Call::ExitConfiguration
            | Call::StopEarly(_)
            | Call::Terminate => (self.0).rare(move |hosted, _| hosted.instance()?.call(call)),
            _ => self.0.end(|| Task::Plain(call))?.result,
        }
    }

    fn get(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        self.read(GET, batch, values)
    }

    fn set(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        self.write(SET, batch, values)
    }

    fn get_derivatives(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        self.read(|i, batch, v| i.get_derivatives(batch, v), batch, values)
    }

    fn set_derivatives(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        self.write(|i, batch, v| i.set_derivatives(batch, v), batch, values)
    }

    fn directional(&self, of: [&Batch; 2], seeds: &[f64], rates: &mut [f64]) -> Result<()> {
        let of = of.map(Batch::clone);
        let (seeds, mut own) = (seeds.to_vec(), rates.to_vec());
        let found = self.0.rare(move |hosted, _| {
            let instance = hosted.instance()?;
            instance.directional(of.each_ref(), &seeds, &mut own)?;
            Ok(own)
        });
        rates.copy_from_slice(&found?);
        Ok(())
    }

    fn integration(&self) -> Result<Option<Integration>> {
        (self.0).rare(|hosted, _| hosted.instance()?.integration())
    }

    fn save(&self) -> Result<Box<dyn Any>> {
        self.keep_state(|instance| instance.save())
    }

    fn restore(&self, state: &dyn Any) -> Result<()> {
        let key = self.key(state)?;
        (self.0).rare(move |hosted, _| hosted.instance()?.restore(&*hosted.states[&key]))
    }

    fn state_to_bytes(&self, state: &dyn Any) -> Result<Vec<u8>> {
        let key = self.key(state)?;
        (self.0).rare(move |hosted, _| hosted.instance()?.state_to_bytes(&*hosted.states[&key]))
    }

    fn state_from_bytes(&self, bytes: &[u8]) -> Result<Box<dyn Any>> {
        let bytes = bytes.to_vec();
        self.keep_state(move |instance| instance.state_from_bytes(&bytes))
    }

    /// No: the thread ends with its run.
    fn reset(&self) -> bool {
        false
    }
}
