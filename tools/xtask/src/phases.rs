//! The phases of `demo`, `quick` and `test`: each is announced and timed; a table lists them all.

use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Instant;

use anyhow::{Context, Result, anyhow};

pub struct Phases {
    start: Instant,
    /// Name, begin and end since the start, s.
    times: Mutex<Vec<(String, f64, f64)>>,
}

impl Phases {
    /// No phases yet; time starts now.
    pub fn start() -> Self {
        Self {
            start: Instant::now(),
            times: Mutex::default(),
        }
    }

    /// Runs one phase; its error names it.
    pub fn run<T>(&self, name: &str, phase: impl FnOnce() -> Result<T>) -> Result<T> {
        println!("==> {name}");
        let begin = self.start.elapsed().as_secs_f64();
        let result = phase().with_context(|| format!("phase `{name}`"));
        let end = self.start.elapsed().as_secs_f64();
        let mut times = self.times.lock().unwrap_or_else(PoisonError::into_inner);
        times.push((name.to_string(), begin, end));
        result
    }

    /// Runs two sequences of phases at the same time, so that they share the processor's cores.
    /// Both end before an error is returned.
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

    /// The table of each phase's duration, begin and end. Phases that overlapped with an earlier
    /// one are marked, since their durations do not add up.
    pub fn table(&self) -> String {
        let times = self.times.lock().unwrap_or_else(PoisonError::into_inner);
        let mut times = times.clone();
        times.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut text = format!("{:<40}{:>9}{:>9}{:>9}\n", "phase, s", "took", "from", "to");
        let mut ended = 0.0;
        for (name, begin, end) in &times {
            let mark = if *begin < ended { "  in parallel" } else { "" };
            let took = end - begin;
            text += &format!("{name:<40}{took:>9.1}{begin:>9.1}{end:>9.1}{mark}\n");
            ended = end.max(ended);
        }
        let all = self.start.elapsed().as_secs_f64();
        text + &format!("{:<40}{all:>9.1}\n", "all")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::bail;

    fn names(phases: &Phases) -> Vec<String> {
        let table = phases.table();
        let name = |line: &str| line.split(' ').next().unwrap_or_default().to_string();
        table.lines().skip(1).map(name).collect()
    }

    #[test]
    fn a_phase_that_fails_is_named_and_listed() {
        let phases = Phases::start();
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
        let phases = Phases::start();
        let (a, b) = phases
            .both(|| phases.run("a", || Ok(1)), || phases.run("b", || Ok(2)))
            .unwrap();
        assert_eq!((a, b), (1, 2));
        let failing = || phases.run("c", || -> Result<()> { bail!("broken") });
        let error = phases.both(failing, || phases.run("d", || Ok(())));
        assert!(error.is_err());
        assert_eq!(phases.times.lock().unwrap().len(), 4);
    }

    #[test]
    fn what_ran_side_by_side_is_said() {
        let times = [("b", 1.0, 3.0), ("a", 0.0, 2.0), ("c", 3.0, 4.0)];
        let phases = Phases::start();
        *phases.times.lock().unwrap() =
            times.map(|(name, from, to)| (name.into(), from, to)).into();
        let table = phases.table();
        let marked = table.lines().filter(|line| line.ends_with("in parallel"));
        let marked: Vec<_> = marked.map(|line| &line[..1]).collect();
        assert_eq!(
            (names(&phases), marked),
            (["a", "b", "c", "all"].map(String::from).into(), vec!["b"])
        );
    }
}
