//! The master's side of an instance in another thread: each call becomes a task of its worker, and
//! may be begun before it is made.

use std::any::Any;
use std::collections::btree_map::Entry;
use std::ffi::CString;
use std::rc::Rc;
use std::sync::Arc;

use anyhow::{Context, Result};

use fmi_import::batch::Batch;
use fmi_import::fmi_instance::{Arguments, BegunCall, Call, FmiInstance};
use fmi_import::value::Value;

use super::workers::{Copies, Pass, RemoteInstance, Task, Worker};
use crate::fmu::Fmu;

/// An instance in another thread.
struct Remote(Rc<RemoteInstance>);

/// Calls of one instance that may be begun: batches are of one type each, with the same clocks.
fn room(fmu: &Fmu) -> usize {
    8 + 16 * (1 + fmu.plan.clocks.len())
}

/// An instance in the thread of a worker, of a library of its own; none where the FMU gives none.
pub fn make(
    worker: &Worker,
    fmu: &Arc<Fmu>,
    arguments: &Arguments,
) -> Result<Option<Box<dyn FmiInstance>>> {
    let (own, arguments) = (fmu.clone(), arguments.clone());
    let make = move |copies: &mut Copies| {
        let key = Arc::as_ptr(&own).addr();
        if let Entry::Vacant(free) = copies.entry(key) {
            let copy = own.loaded.load_copy();
            let what = || format!("a copy of the library of FMU `{}`", own.file);
            free.insert((own.clone(), copy.with_context(what)?));
        }
        own.make(&copies[&key].1, &arguments)
    };
    let made = RemoteInstance::new(worker, room(fmu), Box::new(make))?;
    Ok(made.map(|there| Box::new(Remote(there)) as Box<dyn FmiInstance>))
}

/// A state that is kept in the thread of its instance.
struct RemoteState {
    there: Rc<RemoteInstance>,
    key: usize,
}

impl Drop for RemoteState {
    fn drop(&mut self) {
        let key = self.key;
        // Where the thread has ended, the state has, too.
        let _ = self
            .there
            .any(move |_, states| Ok(states.remove(&key).map(drop)));
    }
}

const GET: Pass = |b, batch, values| b.get(batch, values);
const SET: Pass = |b, batch, values| b.set(batch, values);

impl Remote {
    /// A new state, which stays in the thread.
    fn kept(
        &self,
        save: impl FnOnce(&dyn FmiInstance) -> Result<Box<dyn Any>> + Send + 'static,
    ) -> Result<Box<dyn Any>> {
        let key = self.0.any(move |instance, states| {
            let key = states.keys().last().map_or(0, |last| last + 1);
            states.insert(key, save(instance)?);
            Ok(key)
        })?;
        let there = self.0.clone();
        Ok(Box::new(RemoteState { there, key }))
    }

    fn key(&self, state: &dyn Any) -> Result<usize> {
        let own = state.downcast_ref::<RemoteState>();
        let own = own.filter(|s| Rc::ptr_eq(&s.there, &self.0));
        Ok(own.context("a state of another instance")?.key)
    }

    fn task(&self, ahead: BegunCall) -> Task {
        match ahead {
            BegunCall::Plain(call) => Task::Plain(call),
            BegunCall::Get(batch) => self.reading(GET, batch),
            BegunCall::Set(batch, values) => self.writing(SET, batch, values),
        }
    }

    fn reading(&self, pass: Pass, batch: &Batch) -> Task {
        Task::Values(pass, batch.clone(), self.0.buffer(batch.len()))
    }

    fn writing(&self, pass: Pass, batch: &Batch, values: &[f64]) -> Task {
        let mut own = self.0.buffer(values.len());
        own.copy_from_slice(values);
        Task::Values(pass, batch.clone(), own)
    }

    fn read(&self, pass: Pass, batch: &Batch, values: &mut [f64]) -> Result<()> {
        let done = self.0.end(|| self.reading(pass, batch))?;
        values.copy_from_slice(&done.values);
        self.0.keep(done);
        Ok(())
    }

    fn write(&self, pass: Pass, batch: &Batch, values: &[f64]) -> Result<()> {
        self.0
            .keep(self.0.end(|| self.writing(pass, batch, values))?);
        Ok(())
    }
}

impl FmiInstance for Remote {
    fn begin(&self, ahead: BegunCall) {
        self.0.send(self.task(ahead));
        self.0.begun.set(self.0.begun.get() + 1);
    }

    fn drain(&self) {
        self.0.drain();
    }

    fn log_only(&self, categories: &[CString]) -> Result<()> {
        let categories = categories.to_vec();
        self.0
            .any(move |instance, _| instance.log_only(&categories))
    }

    fn get_values(&self, batch: &Batch, values: &mut [Value]) -> Result<()> {
        let (batch, mut own) = (batch.clone(), values.to_vec());
        let read = self.0.any(move |instance, _| {
            instance.get_values(&batch, &mut own)?;
            Ok(own)
        });
        values.clone_from_slice(&read?);
        Ok(())
    }

    fn set_values(&self, batch: &Batch, values: &[Value]) -> Result<()> {
        let (batch, own) = (batch.clone(), values.to_vec());
        self.0
            .any(move |instance, _| instance.set_values(&batch, &own))
    }

    /// What is rare brings along what the FMU has said.
    fn call(&self, call: Call) -> Result<f64> {
        match call {
            Call::SetUp(_) | Call::StopEarly(_) | Call::Terminate => {
                self.0.any(move |instance, _| instance.call(call))
            }
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
        self.read(|b, batch, v| b.get_derivatives(batch, v), batch, values)
    }

    fn set_derivatives(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        self.write(|b, batch, v| b.set_derivatives(batch, v), batch, values)
    }

    fn directional(&self, of: [&Batch; 2], seeds: &[f64], rates: &mut [f64]) -> Result<()> {
        let of = of.map(Batch::clone);
        let (seeds, mut own) = (seeds.to_vec(), rates.to_vec());
        let found = self.0.any(move |instance, _| {
            instance.directional(of.each_ref(), &seeds, &mut own)?;
            Ok(own)
        });
        rates.copy_from_slice(&found?);
        Ok(())
    }

    fn save(&self) -> Result<Box<dyn Any>> {
        self.kept(|instance| instance.save())
    }

    fn restore(&self, state: &dyn Any) -> Result<()> {
        let key = self.key(state)?;
        self.0
            .any(move |instance, states| instance.restore(&*states[&key]))
    }

    fn state_to_bytes(&self, state: &dyn Any) -> Result<Vec<u8>> {
        let key = self.key(state)?;
        self.0
            .any(move |instance, states| instance.state_to_bytes(&*states[&key]))
    }

    fn state_from_bytes(&self, bytes: &[u8]) -> Result<Box<dyn Any>> {
        let bytes = bytes.to_vec();
        self.kept(move |instance| instance.state_from_bytes(&bytes))
    }

    /// The thread ends with its run.
    fn reset(&self) -> bool {
        false
    }
}
