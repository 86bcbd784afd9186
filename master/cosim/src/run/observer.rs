//! Observers: what `run::simulate` calls at every communication point. Recordings, log files and
//! measures of the studies implement the trait [`Observer`].

use anyhow::Result;

use crate::master::Master;
use crate::run::recording::Recording;

/// Is called at every communication point of a run.
pub trait Observer {
    /// Observes a communication point; the first is the start of the run. An error ends the run.
    fn observe(&mut self, master: &Master) -> Result<()>;

    /// The run is over, at the communication point that was observed last; not called after a failed
    /// step.
    fn end(&mut self, _master: &Master) -> Result<()> {
        Ok(())
    }

    /// True once it needs no further communication point: the run then ends.
    fn is_done(&self) -> bool {
        false
    }
}

/// A function as an observer.
pub struct Function<F>(pub F);

impl<F: FnMut(&Master) -> Result<()>> Observer for Function<F> {
    fn observe(&mut self, master: &Master) -> Result<()> {
        (self.0)(master)
    }
}

/// Several observers, called in their order; the run ends once one of them is done.
pub struct Observers<'a>(pub Vec<&'a mut dyn Observer>);

impl Observer for Observers<'_> {
    fn observe(&mut self, master: &Master) -> Result<()> {
        self.0.iter_mut().try_for_each(|o| o.observe(master))
    }

    fn end(&mut self, master: &Master) -> Result<()> {
        self.0.iter_mut().try_for_each(|o| o.end(master))
    }

    fn is_done(&self) -> bool {
        self.0.iter().any(|o| o.is_done())
    }
}

/// An optional observer.
impl<O: Observer> Observer for Option<O> {
    fn observe(&mut self, master: &Master) -> Result<()> {
        self.as_mut().map_or(Ok(()), |o| o.observe(master))
    }

    fn end(&mut self, master: &Master) -> Result<()> {
        self.as_mut().map_or(Ok(()), |o| o.end(master))
    }

    fn is_done(&self) -> bool {
        self.as_ref().is_some_and(Observer::is_done)
    }
}

impl Observer for Recording {
    fn observe(&mut self, master: &Master) -> Result<()> {
        self.add(master)
    }
}
