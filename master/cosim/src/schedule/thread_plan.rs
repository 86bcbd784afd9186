//! Which thread has which component, and which components may be stepped side by side.

use std::num::NonZero;
use std::sync::Arc;
use std::thread::available_parallelism;

use anyhow::{Result, ensure};

use crate::instance::workers::Worker;
use crate::structure::system::System;
use crate::wiring::{Link, Wiring};

/// Threads beside this one, and the thread of each component: 0 is this one.
pub(crate) struct ThreadPlan {
    workers: Vec<Worker>,
    threads: Vec<usize>,
}

/// Cores that this process may use.
pub fn cores() -> usize {
    available_parallelism().map_or(1, NonZero::get)
}

impl ThreadPlan {
    /// For components that make up to `parts` steps at a time. Components of one kind go round, so
    /// that each thread has as many of them as another.
    pub fn new(system: &System, count: usize, parts: usize) -> Result<Self> {
        ensure!(count > 0, "{count} threads: there must be at least 1");
        let fmus = &system.fmus;
        let kind = |k: usize| fmus.iter().position(|fmu| Arc::ptr_eq(fmu, &fmus[k]));
        let count = count.min(fmus.len()).max(1);
        let mut order: Vec<usize> = (0..fmus.len()).collect();
        let mut threads = vec![0; fmus.len()];
        order.sort_by_cached_key(|k| kind(*k));
        for (place, k) in order.into_iter().enumerate() {
            threads[k] = place % count;
        }
        let start = |_| Worker::start(fmus.len() / count + 1, parts, count <= cores());
        let workers = (1..count).map(start).collect::<Result<_>>()?;
        Ok(Self { workers, threads })
    }

    /// The worker of a component, where it is not in this thread.
    pub fn worker(&self, component: usize) -> Option<&Worker> {
        let thread = self.threads[component].checked_sub(1)?;
        Some(&self.workers[thread])
    }

    /// Ranks of components: each comes after those before it in the order of the system from which
    /// it gets something over a `passing` link. This thread's own come first in a rank.
    pub fn ranks(&self, wiring: &Wiring, passing: impl Fn(&Link) -> bool) -> Vec<Vec<usize>> {
        let mut links: Vec<&Link> = wiring.links.iter().collect();
        links.retain(|l| l.from.component < l.to.component && passing(l));
        links.sort_by_key(|link| link.to.component);
        let mut of = vec![0; self.threads.len()];
        for link in links {
            of[link.to.component] = of[link.to.component].max(of[link.from.component] + 1);
        }
        let mut ranks = vec![Vec::new(); of.iter().max().map_or(0, |last| last + 1)];
        for (k, rank) in of.into_iter().enumerate() {
            ranks[rank].push(k);
        }
        for rank in &mut ranks {
            rank.sort_by_key(|k| self.threads[*k] > 0);
        }
        ranks
    }
}
