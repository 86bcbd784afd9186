//! Phases of a long command: each is announced, timed, and listed in a table at the end.

use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Instant;

use anyhow::{Context, Result, anyhow};

/// The phases so far.
pub struct Phases {
    start: Instant,
    /// Name and duration in s.
    times: Mutex<Vec<(String, f64)>>,
}

impl Default for Phases {
    fn default() -> Self {
        Self {
            start: Instant::now(),
            times: Mutex::default(),
        }
    }
}

impl Phases {
    /// Run one phase; its error names it.
    pub fn run<T>(&self, name: &str, phase: impl FnOnce() -> Result<T>) -> Result<T> {
        println!("==> {name}");
        let clock = Instant::now();
        let result = phase().with_context(|| format!("phase `{name}`"));
        let seconds = clock.elapsed().as_secs_f64();
        let mut times = self.times.lock().unwrap_or_else(PoisonError::into_inner);
        times.push((name.to_string(), seconds));
        result
    }

    /// Run two sequences of phases at the same time: what one leaves of the processor, the other uses. Both end before an error is
    /// returned.
    pub fn both<A: Send, B>(
        &self,
        first: impl FnOnce() -> Result<A> + Send,
        second: impl FnOnce() -> Result<B>,
    ) -> Result<(A, B)> {
        thread::scope(|scope| {
            let first = scope.spawn(first);
            let second = second();
            let first = first.join().map_err(|_| anyhow!("a phase panicked"))?;
            Ok((first?, second?))
        })
    }

    /// What each phase took, and all together, which is less than the sum where phases ran at the same time.
    pub fn table(&self) -> String {
        let times = self.times.lock().unwrap_or_else(PoisonError::into_inner);
        let all = ("all".to_string(), self.start.elapsed().as_secs_f64());
        let line = |(name, seconds): &(String, f64)| format!("{name:<40} {seconds:>7.1} s\n");
        times.iter().chain([&all]).map(line).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::bail;

    fn names(phases: &Phases) -> Vec<String> {
        let table = phases.table();
        let name = |line: &str| line.split(' ').next().unwrap_or_default().to_string();
        table.lines().map(name).collect()
    }

    #[test]
    fn a_phase_that_fails_is_named_and_listed() {
        let phases = Phases::default();
        assert_eq!(phases.run("first", || Ok(7)).unwrap(), 7);
        let error = phases.run("second", || -> Result<()> { bail!("broken") });
        assert_eq!(
            format!("{:#}", error.unwrap_err()),
            "phase `second`: broken"
        );
        assert_eq!(names(&phases), ["first", "second", "all"]);
    }

    #[test]
    fn of_two_at_a_time_both_end() {
        let phases = Phases::default();
        let (a, b) = phases
            .both(|| phases.run("a", || Ok(1)), || phases.run("b", || Ok(2)))
            .unwrap();
        assert_eq!((a, b), (1, 2));
        let failing = || phases.run("c", || -> Result<()> { bail!("broken") });
        let error = phases.both(failing, || phases.run("d", || Ok(())));
        assert!(error.is_err());
        assert_eq!(phases.times.lock().unwrap().len(), 4);
    }
}
