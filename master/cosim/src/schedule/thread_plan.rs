//! Distributes the components of a run over threads, and sorts them into ranks that may be stepped
//! at the same time. The master makes this plan for `--threads`.

use std::collections::HashMap;
use std::num::NonZero;
use std::sync::Arc;
use std::thread::available_parallelism;

use anyhow::{Result, ensure};

use crate::instance::workers::Worker;
use crate::structure::system::System;
use crate::wiring::{Link, Wiring};

/// The thread of a component that lives in a process of its own, which the calling thread awaits.
const ISOLATED: usize = usize::MAX;

/// The further threads of a run, and the thread of each component: 0 is the calling one.
pub(crate) struct ThreadPlan {
    workers: Vec<Worker>,
    threads: Vec<usize>,
}

/// Cores that this process may use.
pub fn cores() -> usize {
    available_parallelism().map_or(1, NonZero::get)
}

impl ThreadPlan {
    /// Start `count` threads, the calling one included, for components that make up to `parts`
    /// steps at a time. The components of one FMU are distributed evenly.
    pub fn new(system: &System, count: usize, parts: usize) -> Result<Self> {
        ensure!(count > 0, "{count} threads: there must be at least 1");
        let fmus = &system.fmus;
        let mut kinds = HashMap::new();
        let firsts = fmus.iter().enumerate();
        let firsts = firsts.map(|(k, fmu)| *kinds.entry(Arc::as_ptr(fmu)).or_insert(k));
        let firsts: Vec<usize> = firsts.collect();
        let is_isolated = |k: &usize| fmus[*k].isolation.is_some();
        let mut order: Vec<usize> = (0..fmus.len()).filter(|k| !is_isolated(k)).collect();
        let count = count.min(order.len()).max(1);
        let mut threads = vec![ISOLATED; fmus.len()];
        order.sort_by_key(|k| firsts[*k]);
        for (place, k) in order.into_iter().enumerate() {
            threads[k] = place % count;
        }
        let start = |_| Worker::start(fmus.len() / count + 1, parts, count <= cores());
        let workers = (1..count).map(start).collect::<Result<_>>()?;
        Ok(Self { workers, threads })
    }

    /// The worker of a component; None for those of the calling thread, and isolated ones.
    pub fn worker(&self, component: usize) -> Option<&Worker> {
        let thread = self.threads[component].checked_sub(1)?;
        self.workers.get(thread)
    }

    /// Ranks of components: a component comes after the earlier components of the system from which
    /// it gets values over a `passing` link. Those of the calling thread come first in a rank.
    pub fn ranks(&self, wiring: &Wiring, passing: impl Fn(&Link) -> bool) -> Vec<Vec<usize>> {
        let mut links: Vec<&Link> = wiring.links.iter().collect();
        links.retain(|l| l.from.component < l.to.component && passing(l));
        links.sort_by_key(|link| link.to.component);
        let mut rank_of = vec![0; self.threads.len()];
        for Link { from, to, .. } in links {
            rank_of[to.component] = rank_of[to.component].max(rank_of[from.component] + 1);
        }
        let mut ranks = vec![Vec::new(); rank_of.iter().max().map_or(0, |last| last + 1)];
        for (k, rank) in rank_of.into_iter().enumerate() {
            ranks[rank].push(k);
        }
        for rank in &mut ranks {
            rank.sort_by_key(|k| self.threads[*k] > 0);
        }
        ranks
    }
}
