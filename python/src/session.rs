//! A run that a Python script steps through `hdrm_fmu.System`. It lives in the thread that started
//! it, because an FMU's instance belongs to one thread: Python holds handles, by which calls of that
//! thread find the run; calls of other threads and of forked processes are refused.

use std::cell::RefCell;
use std::mem;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

use anyhow::{Context, Error, Result, bail, ensure};
use cosim::instance::messages::{self, Message};
use cosim::instance::under_way;
use cosim::io::csv::stride;
use cosim::master::Saved;
use cosim::run::supervision::Supervision;
use cosim::{Experiment, Inputs, Master, Port as Variable, Recording, Signals, System, Verdict};
use experiments::measures::metrics::{Metrics, add_residuals, tip_metrics};
use experiments::measures::run::MachineWatch;
use experiments::setup::machine_choice::MachineFile;
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};

use crate::errors::{WrongThread, to_exception};
use crate::run::{INTERRUPT_EVERY, RunResult, bytes_of_numbers};

/// Numbers for sessions and saved states, each given once in a process.
static NUMBERS: AtomicU64 = AtomicU64::new(0);
/// How often this process was forked from another.
static FORKS: AtomicU64 = AtomicU64::new(0);

thread_local! {
    /// The runs of this thread, by number; one that a call uses is not in its place.
    static RUNS: RefCell<Vec<(u64, Option<Box<Running>>)>> = const { RefCell::new(Vec::new()) };
}

/// What changes with the steps, apart from the instances.
#[derive(Clone)]
struct Watched {
    supervision: Supervision,
    machine: Option<MachineWatch>,
    recording: Recording,
    messages: Vec<Message>,
    failure: Option<String>,
    elapsed: Duration,
}

/// A running system, with what scripts read and set.
struct Running {
    system: Arc<System>,
    start: f64,
    master: Master,
    watched: Watched,
    /// Findings from before the run.
    findings: Verdict,
    recorded: Vec<Variable>,
    /// Communication points between two recorded ones.
    stride: u64,
    reads: Vec<Signals>,
    writes: Vec<Inputs>,
    /// The numbers of saved states; they belong to the present instances.
    saved: Vec<(u64, Saved, Watched)>,
}

/// Finds a run.
#[derive(Clone, Copy)]
struct Handle {
    number: u64,
    thread: ThreadId,
    forks: u64,
}

/// A run in progress.
#[pyclass(frozen)]
pub struct Session {
    handle: Handle,
}

/// Variables of a run that are read and set together.
#[pyclass(frozen)]
pub struct Port {
    handle: Handle,
    read: usize,
    write: Option<usize>,
}

/// A state of a run.
#[pyclass(frozen)]
pub struct SavedState {
    handle: Handle,
    number: u64,
}

/// A process that was forked calls this: the runs belong to the one that it was forked from.
#[pyfunction]
pub fn was_forked() {
    FORKS.fetch_add(1, Relaxed);
}

impl Handle {
    /// Works with the run.
    fn with<T>(self, work: impl FnOnce(&mut Running) -> Result<T>) -> PyResult<T> {
        if self.forks != FORKS.load(Relaxed) {
            return Err(WrongThread::new_err(
                "the system was being stepped when this process was forked: it belongs to the process that started it",
            ));
        }
        let place = |runs: &mut Vec<(u64, Option<Box<Running>>)>| {
            runs.iter().position(|(number, _)| *number == self.number)
        };
        let taken = RUNS.with_borrow_mut(|runs| place(runs).map(|k| (k, runs[k].1.take())));
        let mut running = match taken {
            Some((_, Some(running))) => running,
            Some((_, None)) => {
                let text = "the system is making a step, or has ended";
                return Err(to_exception(Error::msg(text)));
            }
            None if thread::current().id() == self.thread => {
                return Err(to_exception(Error::msg("the run has ended")));
            }
            None => {
                return Err(WrongThread::new_err(
                    "a system that is stepped belongs to the thread that started it; this is another one",
                ));
            }
        };
        let done = work(&mut running);
        RUNS.with_borrow_mut(|runs| {
            if let Some(k) = place(runs) {
                runs[k].1 = Some(running);
            }
        });
        done.map_err(to_exception)
    }

    /// Ends the run, if this is its thread and its process.
    fn end(self) {
        if self.forks != FORKS.load(Relaxed) {
            return;
        }
        let ended = RUNS.try_with(|runs| {
            let mut runs = runs.try_borrow_mut().ok()?;
            let place = runs.iter().position(|(number, _)| *number == self.number)?;
            runs.swap_remove(place).1
        });
        if let Some(running) = ended.ok().flatten() {
            under_way::remember();
            // The states belong to the instances, and nobody would see an error.
            drop(running.saved);
            let _ = running.master.terminate();
        }
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.handle.end();
    }
}

impl Watched {
    fn new(
        system: &System,
        experiment: &Experiment,
        master: &Master,
        file: Option<Option<MachineFile>>,
    ) -> Result<Self> {
        let machine = file.map(|file| MachineWatch::new(system, experiment, master, file.as_ref()));
        Ok(Self {
            supervision: Supervision::new(system, master, Verdict::default())?,
            machine: machine.transpose()?,
            recording: Recording::new(system, &[])?,
            messages: Vec::new(),
            failure: None,
            elapsed: Duration::ZERO,
        })
    }
}

impl Running {
    /// Starts `experiment`; `is_machine` as in a whole run.
    fn start(
        system: Arc<System>,
        (experiment, findings): (Experiment, Verdict),
        is_machine: bool,
    ) -> Result<Self> {
        let file = is_machine.then(|| MachineFile::from_plant(&system, &experiment.settings));
        let file = file.transpose()?;
        let master = experiment.start(&system)?;
        let watched = Watched::new(&system, &experiment, &master, file)?;
        let mut running = Self {
            start: master.time(),
            watched,
            master,
            system,
            findings,
            recorded: Vec::new(),
            stride: 1,
            reads: Vec::new(),
            writes: Vec::new(),
            saved: Vec::new(),
        };
        if let Some(machine) = &mut running.watched.machine {
            machine.add(&running.master)?;
        }
        running.watched.messages = messages::take();
        Ok(running)
    }

    /// The present communication point, for the verdict and the recording.
    fn observe(&mut self) -> Result<()> {
        let (watched, master) = (&mut self.watched, &self.master);
        if !self.recorded.is_empty() && master.steps().is_multiple_of(self.stride) {
            watched.recording.add(master)?;
        }
        if let Some(machine) = &mut watched.machine {
            machine.add(master)?;
        }
        watched.supervision.add(master)
    }

    /// Makes steps until one has failed, or this has taken so long that Ctrl-C must be looked for;
    /// returns how many are left.
    fn step(&mut self, mut steps: u64) -> Result<u64> {
        under_way::remember();
        // Those that differ only in numbers are counted.
        let messages = mem::take(&mut self.watched.messages);
        if !messages.is_empty() {
            messages::extend(messages);
        }
        let begun = Instant::now();
        let mut made = || -> Result<u64> {
            while steps > 0 && begun.elapsed() < INTERRUPT_EVERY {
                self.master.step()?;
                self.observe()?;
                steps -= 1;
            }
            Ok(steps)
        };
        let done = made();
        let watched = &mut self.watched;
        watched.elapsed += begun.elapsed();
        watched.messages = messages::take();
        done.map_err(|error| {
            let error = (watched.supervision).explain(error, &self.system, &self.master);
            watched.failure = Some(format!("{error:#}"));
            error
        })
    }

    /// Begins the recording anew, with the present communication point.
    fn record(&mut self) -> Result<()> {
        self.watched.recording = Recording::new(&self.system, &self.recorded)?;
        match self.recorded.is_empty() {
            true => Ok(()),
            false => self.watched.recording.add(&self.master),
        }
    }

    /// What a whole run would return that had ended here.
    fn result(&self, max_error: Option<f64>) -> Result<RunResult> {
        let machine = &self.watched.machine;
        let mut recording = self.watched.recording.clone();
        if recording.times.last() != Some(&self.master.time()) {
            recording.add(&self.master)?;
        }
        let mut metrics = machine
            .as_ref()
            .map_or_else(Metrics::new, |m| tip_metrics(&m.tip));
        add_residuals(&mut metrics, self.master.residuals());
        let watched = &self.watched;
        let messages = watched.messages.clone();
        let mut verdict = (watched.supervision).so_far(&self.system, &self.master, messages);
        if let Some(failure) = &watched.failure {
            verdict.object(failure.clone());
        }
        if let Some(machine) = machine {
            verdict.extend(machine.verdict(&self.system, watched.failure.is_none()));
            verdict.extend(machine.tip.verdict(max_error));
        }
        Ok(RunResult {
            recording,
            ports: self.recorded.clone(),
            metrics,
            verdict,
            simulated: self.master.time() - self.start,
            elapsed: watched.elapsed.as_secs_f64(),
        })
    }
}

impl Session {
    /// Starts an experiment, with the findings so far, in this thread.
    pub fn start(
        system: Arc<System>,
        experiment: (Experiment, Verdict),
        is_machine: bool,
    ) -> Result<Self> {
        under_way::remember();
        let running = Running::start(system, experiment, is_machine)?;
        let number = NUMBERS.fetch_add(1, Relaxed);
        RUNS.with_borrow_mut(|runs| runs.push((number, Some(Box::new(running)))));
        let (thread, forks) = (thread::current().id(), FORKS.load(Relaxed));
        let handle = Handle {
            number,
            thread,
            forks,
        };
        Ok(Self { handle })
    }

    /// Starts it anew, from the start time; what ports mean and what is recorded stays.
    pub fn restart(&self, experiment: (Experiment, Verdict), is_machine: bool) -> PyResult<()> {
        self.handle.with(|running| {
            under_way::remember();
            running.saved.clear();
            let fresh = Running::start(running.system.clone(), experiment, is_machine)?;
            (running.watched, running.findings) = (fresh.watched, fresh.findings);
            let before = mem::replace(&mut running.master, fresh.master);
            running.record()?;
            before.terminate()
        })
    }
}

#[pymethods]
impl Session {
    /// Present time, s.
    fn time(&self) -> PyResult<f64> {
        self.handle.with(|running| Ok(running.master.time()))
    }

    /// Makes communication steps; returns the time then, s.
    fn step(&self, py: Python<'_>, mut steps: u64) -> PyResult<f64> {
        let handle = self.handle;
        loop {
            steps = py.detach(|| handle.with(|running| running.step(steps)))?;
            if steps == 0 {
                return self.time();
            }
            py.check_signals()?;
        }
    }

    /// The variables of these names, to be set too if they `can_be_set`.
    fn port(&self, names: Vec<String>, can_be_set: bool) -> PyResult<Port> {
        self.handle.with(|running| {
            let system = &running.system;
            let ports = names.iter().map(|name| system.port(name));
            let ports = ports.collect::<Result<Vec<_>>>()?;
            running.reads.push(Signals::new(system, &ports)?);
            let write = match can_be_set {
                true => {
                    running.writes.push(Inputs::new(system, &ports)?);
                    Some(running.writes.len() - 1)
                }
                false => None,
            };
            let (handle, read) = (self.handle, running.reads.len() - 1);
            Ok(Port {
                handle,
                read,
                write,
            })
        })
    }

    /// Sets an input or a tunable parameter of any type from text.
    fn set_text(&self, name: &str, text: &str) -> PyResult<()> {
        self.handle.with(|running| {
            let port = running.system.port(name)?;
            let instance = &running.master.instances()[port.component];
            instance.set_from_text(&running.system.variable(port).name, text)?;
            running.master.pass()
        })
    }

    /// From now on these signals are recorded, and the present communication point.
    fn record(&self, names: Vec<String>, interval: Option<f64>) -> PyResult<()> {
        self.handle.with(|running| {
            let ports = names.iter().map(|name| running.system.port(name));
            running.recorded = ports.collect::<Result<_>>()?;
            running.stride = stride(interval, running.master.stepping().step)?;
            running.record()
        })
    }

    /// What a whole run would return that had ended here.
    fn result(&self, py: Python<'_>, max_error: Option<f64>) -> PyResult<Py<PyDict>> {
        let made = |running: &mut Running| {
            let (system, findings) = (running.system.clone(), running.findings.clone());
            Ok((running.result(max_error)?, system, findings))
        };
        let (result, system, findings) = self.handle.with(made)?;
        result.into_python(py, &system, findings)
    }

    /// Saves the state of the run.
    fn save(&self) -> PyResult<SavedState> {
        self.handle.with(|running| {
            let number = NUMBERS.fetch_add(1, Relaxed);
            let state = running.master.save()?;
            running.saved.push((number, state, running.watched.clone()));
            let handle = self.handle;
            Ok(SavedState { handle, number })
        })
    }

    /// Restores a saved state.
    fn restore(&self, state: &SavedState) -> PyResult<()> {
        self.handle.with(|running| {
            let mut saved = running.saved.iter();
            let (_, state, watched) = saved
                .find(|(number, ..)| *number == state.number)
                .context("the state is of another run, or was saved before the reset")?;
            running.master.restore(state)?;
            running.watched.clone_from(watched);
            Ok(())
        })
    }
}

#[pymethods]
impl Port {
    /// Present value of the only variable.
    fn get(&self) -> PyResult<f64> {
        let Self { handle, read, .. } = *self;
        handle.with(|running| Ok(running.reads[read].read(&running.master)?[0]))
    }

    /// Bytes of the present values.
    fn get_all<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyByteArray>> {
        let Self { handle, read, .. } = *self;
        let get = |running: &mut Running| Ok(running.reads[read].read(&running.master)?.to_vec());
        bytes_of_numbers(py, &handle.with(get)?)
    }

    /// Sets the only variable.
    fn set(&self, value: f64) -> PyResult<()> {
        self.put(&[value])
    }

    /// Sets all variables to values from their bytes.
    fn set_all(&self, bytes: &[u8]) -> PyResult<()> {
        let values = bytes.as_chunks::<8>().0.iter();
        self.put(
            &values
                .map(|bytes| f64::from_ne_bytes(*bytes))
                .collect::<Vec<_>>(),
        )
    }
}

impl Port {
    fn put(&self, values: &[f64]) -> PyResult<()> {
        let Self { handle, write, .. } = *self;
        handle.with(|running| {
            let Some(write) = write else {
                bail!("these variables cannot be set");
            };
            let count = running.reads[self.read].ports().len();
            ensure!(values.len() == count, "{} values for {count}", values.len());
            running.writes[write].set(&running.master, values)?;
            if let Some(machine) = &mut running.watched.machine {
                // The script drives the machine.
                machine.reference = Verdict::default();
            }
            running.master.pass()
        })
    }
}

impl Drop for SavedState {
    fn drop(&mut self) {
        let number = self.number;
        // In another thread, or while a call uses the run, the state stays until the run ends.
        let _ = self.handle.with(|running| {
            running.saved.retain(|(other, ..)| *other != number);
            Ok(())
        });
    }
}
