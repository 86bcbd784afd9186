//! A run that a Python script steps through `hdrm_fmu.System`. A thread of its own owns the running
//! system, because an FMU's instance belongs to one thread; the script's calls are sent to it, and
//! the interpreter's lock is free meanwhile.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;

use anyhow::{Result, anyhow};
use cosim::instance::under_way;
use cosim::{Experiment, Inputs, Master, Port, Signals, System};
use fmi_description::Kind;
use pyo3::prelude::*;

use crate::errors::to_exception;
use crate::run::INTERRUPT_EVERY;

type Work = Box<dyn FnOnce(&System, &mut Running) + Send>;

/// A running system, and the signals and inputs that were used before, by their names or ports.
struct Running {
    master: Master,
    signals: HashMap<Vec<String>, Signals>,
    inputs: HashMap<Vec<Port>, Inputs>,
    /// Whether the script has been interrupted since the present call.
    interrupted: Arc<AtomicBool>,
}

/// A run in progress.
#[pyclass(frozen)]
pub struct Session {
    work: Sender<Work>,
}

impl Session {
    /// Starts `experiment` in a thread of its own.
    pub fn start(py: Python<'_>, system: Arc<System>, experiment: Experiment) -> PyResult<Self> {
        let (work, queue) = channel::<Work>();
        let (started, has_started) = channel();
        thread::spawn(move || match experiment.start(&system) {
            Ok(master) => {
                let running = Running {
                    master,
                    signals: HashMap::new(),
                    inputs: HashMap::new(),
                    interrupted: Arc::default(),
                };
                let _ = started.send(Ok(()));
                serve(&system, running, &queue);
            }
            Err(error) => {
                let _ = started.send(Err(error));
            }
        });
        let answer = py.detach(move || has_started.recv().map_err(|_| gone()));
        answer.flatten().map_err(to_exception)?;
        Ok(Self { work })
    }

    /// Does `work` with the running system, in its thread.
    fn call<T: Send + 'static>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&System, &mut Running) -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        let (answer, mut answered) = channel();
        let interrupted = Arc::new(AtomicBool::new(false));
        let own = interrupted.clone();
        let work: Work = Box::new(move |system, running| {
            running.interrupted = own;
            // If the script was interrupted, nobody receives the answer.
            let _ = answer.send(work(system, running));
        });
        self.work.send(work).map_err(|_| to_exception(gone()))?;
        loop {
            let given;
            (given, answered) =
                py.detach(move || (answered.recv_timeout(INTERRUPT_EVERY), answered));
            match given {
                Ok(result) => return result.map_err(to_exception),
                Err(RecvTimeoutError::Disconnected) => return Err(to_exception(gone())),
                Err(RecvTimeoutError::Timeout) => py
                    .check_signals()
                    .inspect_err(|_| interrupted.store(true, Ordering::Relaxed))?,
            }
        }
    }
}

fn gone() -> anyhow::Error {
    anyhow!("the run has ended, because the native code failed in an unforeseen way")
}

fn serve(system: &System, mut running: Running, queue: &Receiver<Work>) {
    while let Ok(work) = queue.recv() {
        // Between two calls the script may have gone to another folder.
        under_way::remember();
        work(system, &mut running);
    }
    under_way::remember();
    // The script has dropped the session: nobody would see an error.
    let _ = running.master.terminate();
}

#[pymethods]
impl Session {
    /// Present time, s.
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.call(py, |_, running| Ok(running.master.time()))
    }

    /// Makes communication steps; returns the time then, s.
    fn step(&self, py: Python<'_>, steps: u64) -> PyResult<f64> {
        self.call(py, move |_, running| {
            for _ in 0..steps {
                if running.interrupted.load(Ordering::Relaxed) {
                    break;
                }
                running.master.step()?;
            }
            Ok(running.master.time())
        })
    }

    /// Present values of variables.
    fn get(&self, py: Python<'_>, names: Vec<String>) -> PyResult<Vec<f64>> {
        self.call(py, move |system, running| {
            let signals = match running.signals.get_mut(&names) {
                Some(signals) => signals,
                None => {
                    let ports = names.iter().map(|name| system.port(name));
                    let ports = ports.collect::<Result<Vec<_>>>()?;
                    let signals = Signals::new(system, &ports)?;
                    running.signals.entry(names).or_insert(signals)
                }
            };
            Ok(signals.read(&running.master)?.to_vec())
        })
    }

    /// Sets inputs that no connection drives, and tunable parameters; values as text, numbers with
    /// their shortest digits.
    fn set(&self, py: Python<'_>, values: Vec<(String, String)>) -> PyResult<()> {
        self.call(py, move |system, running| {
            let (mut ports, mut numbers, mut others) = (Vec::new(), Vec::new(), Vec::new());
            for (name, value) in &values {
                let port = system.port(name)?;
                if system.variable(port).kind == Kind::Real {
                    ports.push(port);
                    numbers.push(value.parse::<f64>()?);
                } else {
                    others.push((port, value));
                }
            }
            for (port, value) in others {
                let instance = &running.master.instances()[port.component];
                instance.set_from_text(&system.variable(port).name, value)?;
            }
            if !ports.is_empty() {
                let inputs = match running.inputs.get_mut(&ports) {
                    Some(inputs) => inputs,
                    None => {
                        let inputs = Inputs::new(system, &ports)?;
                        running.inputs.entry(ports).or_insert(inputs)
                    }
                };
                inputs.set(&running.master, &numbers)?;
            }
            running.master.pass()
        })
    }
}
