//! Phases of a long command: each is announced, timed, and listed in a table at the end.

use std::time::Instant;

use anyhow::{Context, Result};

/// The phases so far.
#[derive(Default)]
pub struct Phases {
    /// Name and duration in s.
    times: Vec<(String, f64)>,
}

impl Phases {
    /// Run one phase; its error names it.
    pub fn run<T>(&mut self, name: &str, phase: impl FnOnce() -> Result<T>) -> Result<T> {
        println!("==> {name}");
        let clock = Instant::now();
        let result = phase().with_context(|| format!("phase `{name}`"));
        self.times
            .push((name.to_string(), clock.elapsed().as_secs_f64()));
        result
    }

    /// What each phase took, and all together.
    pub fn table(&self) -> String {
        let total = self.times.iter().map(|(_, seconds)| seconds).sum();
        let all = std::iter::once(("all", total));
        let rows = self.times.iter().map(|(name, s)| (name.as_str(), *s));
        let line = |(name, seconds): (&str, f64)| format!("{name:<40} {seconds:>7.1} s\n");
        rows.chain(all).map(line).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_phase_that_fails_is_named_and_listed() {
        let mut phases = Phases::default();
        assert_eq!(phases.run("first", || Ok(7)).unwrap(), 7);
        let error = phases.run("second", || -> Result<()> { anyhow::bail!("broken") });
        assert_eq!(
            format!("{:#}", error.unwrap_err()),
            "phase `second`: broken"
        );
        let table = phases.table();
        let names: Vec<_> = table
            .lines()
            .map(|l| l.split(' ').next().unwrap())
            .collect();
        assert_eq!(names, ["first", "second", "all"]);
    }
}
