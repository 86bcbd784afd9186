//! Steps of the schedule `standard` in several threads: each thread sets the inputs of its
//! components, steps them and reads their outputs, without waiting for the others in between.
//! The master uses it where nothing else happens within a step.

use anyhow::{Error, Result};

use crate::exchange::Read;
use crate::exchange::coupling::Coupling;
use crate::instance::step_calls::{FailedCall, StepCalls};
use crate::instance::workers::Worker;
use crate::instance::{At, Failure, Instance};

/// The plan of the steps.
pub(crate) struct WholeSteps {
    /// That of the calling thread comes first.
    shares: Vec<Share>,
    /// Share and place of the values of each write.
    places: Vec<(usize, usize)>,
    /// Values read, which are those of the exchange once all have been read.
    next: Vec<f64>,
}

/// The components of a thread.
struct Share {
    worker: Option<Worker>,
    members: Vec<Member>,
    /// Values that are set and read, of one component after the other.
    values: Vec<f64>,
}

struct Member {
    component: usize,
    calls: StepCalls,
    /// Place of its values.
    start: usize,
    /// The read of mean efforts, if it has any.
    mean: Option<Read>,
    reads: Vec<Read>,
}

impl WholeSteps {
    /// The plan for a coupling; None if there is one thread, or something else happens within its steps.
    pub fn new(coupling: &Coupling) -> Option<Self> {
        let (exchange, instances) = (&coupling.exchange, &coupling.instances);
        let [stage] = &exchange.stages[..] else {
            return None;
        };
        let is_apart = |instance: &Instance| instance.is_elsewhere() != instance.host().is_some();
        let is_plain = coupling.timed.is_empty()
            && coupling.rates.is_none()
            && coupling.balance.is_none()
            && exchange.over_step.is_none()
            && exchange.exact.is_empty();
        if !is_plain || !exchange.is_multi_threaded || instances.iter().any(is_apart) {
            return None;
        }
        let mut shares = vec![Share::new(None)];
        let mut places = vec![(0, 0); stage.writes.len()];
        for (component, instance) in instances.iter().enumerate() {
            let worker = instance.host().map(|(worker, _)| worker);
            let found = shares.iter().position(|s| s.worker.as_ref() == worker);
            let share = found.unwrap_or_else(|| {
                shares.push(Share::new(worker.cloned()));
                shares.len() - 1
            });
            let start = shares[share].values.len();
            let (mut end, mut calls) = (start, StepCalls::default());
            for (place, write) in places.iter_mut().zip(&stage.writes) {
                if write.instance == component {
                    *place = (share, end);
                    end += write.batch.len();
                    calls.sets.push(write.batch.clone());
                }
            }
            let mean = coupling.means.reads[component].clone();
            let reads = stage.reads.iter().filter(|r| r.instance == component);
            let reads: Vec<Read> = reads.cloned().collect();
            let gets = mean.iter().chain(&reads);
            calls.gets.extend(gets.map(|read| read.batch.clone()));
            let length = start + calls.len();
            shares[share].values.resize(length, 0.0);
            shares[share].members.push(Member {
                component,
                calls,
                start,
                mean,
                reads,
            });
        }
        for share in &shares {
            let host = |member: &Member| instances[member.component].host();
            let calls = share.members.iter().filter_map(|member| {
                let (_, number) = host(member)?;
                Some((*number, member.calls.clone()))
            });
            if let Some(worker) = &share.worker {
                worker.plan_steps(calls.collect());
            }
        }
        Some(Self {
            shares,
            places,
            next: exchange.values.clone(),
        })
    }

    /// Set all inputs, step all components from `t` by `h` and read all outputs at `end`, all s.
    pub fn advance(&mut self, coupling: &mut Coupling, [t, h, end]: [f64; 3]) -> Result<()> {
        self.gather(coupling, t)?;
        let [own, others @ ..] = &mut self.shares[..] else {
            return Ok(());
        };
        for share in others.iter_mut() {
            if let Some(worker) = &share.worker {
                worker.begin_steps([t, h], std::mem::take(&mut share.values));
            }
        }
        let mut failed = own.make(&coupling.instances, [t, h]);
        for share in others {
            let members = &share.members;
            let Some(worker) = &share.worker else {
                continue;
            };
            let done = worker.end_steps()?;
            share.values = done.values;
            let done = done.failed.into_iter();
            failed.extend(done.map(|(k, call)| (members[k].component, call)));
        }
        let mut failure = Failure::default();
        for share in &mut self.shares {
            for member in &share.members {
                let values = &mut share.values[member.start..];
                let own = failed.iter().position(|(k, _)| *k == member.component);
                let own = own.map(|k| failed.swap_remove(k).1);
                let done = member.end(coupling, (values, &mut self.next), own, [t, end]);
                let phases = coupling.instances.len();
                let add =
                    |(phase, error)| failure.add(phase * phases + member.component, Err(error));
                done.unwrap_or_else(add);
            }
        }
        Result::from(failure)?;
        coupling.record_bonds(h, false);
        std::mem::swap(&mut coupling.exchange.values, &mut self.next);
        coupling.account(h);
        coupling.watch_unconnected(end)
    }

    /// Gather all values that are set, in the order of one thread.
    fn gather(&mut self, coupling: &mut Coupling, t: f64) -> Result<()> {
        let (exchange, instances, at) = (&mut coupling.exchange, &coupling.instances, At::Time(t));
        let mut faults = exchange.faults.as_mut();
        if let Some(faults) = &mut faults {
            faults.begin(t);
        }
        let writes = &mut exchange.stages[0].writes;
        for k in 0..writes.len() {
            let faults = faults.as_deref_mut();
            match writes[k].gathered(instances, &exchange.values, faults, at) {
                Ok(values) => {
                    let (share, place) = self.places[k];
                    self.shares[share].values[place..][..values.len()].copy_from_slice(values);
                }
                Err(error) => {
                    let mut before = writes[..k].iter();
                    before.try_for_each(|write| write.set(instances, at))?;
                    return Err(error);
                }
            }
        }
        Ok(())
    }
}

impl Share {
    fn new(worker: Option<Worker>) -> Self {
        Self {
            worker,
            members: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Make the steps of this thread's components.
    fn make(&mut self, instances: &[Instance], time: [f64; 2]) -> Vec<(usize, FailedCall)> {
        let mut failed = Vec::new();
        for member in &self.members {
            let values = &mut self.values[member.start..];
            let done = instances[member.component].make_step(&member.calls, values, time);
            failed.extend(done.err().map(|call| (member.component, call)));
        }
        failed
    }
}

impl Member {
    /// Take what was read of its values in a step from `t` to `end`, both s, or tell why a call
    /// failed, and in which phase of the step: the setting, stepping or reading of all.
    fn end(
        &self,
        coupling: &mut Coupling,
        (values, next): (&mut [f64], &mut [f64]),
        mut failed: Option<FailedCall>,
        [t, end]: [f64; 2],
    ) -> Result<(), (usize, Error)> {
        let StepCalls { sets, .. } = &self.calls;
        let values = &mut values[sets.iter().map(|batch| batch.len()).sum()..];
        let mut is_late = false;
        if let Some(call) = failed.take_if(|call| call.place <= sets.len()) {
            let (place, error) = (call.place, call.into_error());
            let instance = &coupling.instances[self.component];
            if let Some(batch) = sets.get(place) {
                return Err((0, instance.error(error, Some(batch), At::Time(t))));
            }
            let error = instance.step_error(error, t);
            let done = coupling.end_after(self.component, error, end);
            done.map_err(|error| (1, error))?;
            is_late = true;
        }
        let instance = &coupling.instances[self.component];
        let mut first = 0;
        for (k, read) in self.mean.iter().chain(&self.reads).enumerate() {
            let is_mean = self.mean.is_some() && k == 0;
            let [phase, at] = if is_mean { [1.0, t] } else { [2.0, end] };
            let (phase, at) = (phase as usize, At::Time(at));
            let found = &mut values[first..][..read.batch.len()];
            first += found.len();
            let done = match failed.take_if(|call| call.place == sets.len() + 1 + k) {
                Some(call) => Err(instance.error(call.into_error(), Some(&read.batch), at)),
                None if is_late => instance.get_finite(&read.batch, found, at),
                None => instance.check_read(&read.batch, found, at),
            };
            done.map_err(|error| (phase, error))?;
            let to = match is_mean {
                true => &mut coupling.means.values[read.slots()],
                false => &mut next[read.slots()],
            };
            to.copy_from_slice(found);
        }
        Ok(())
    }
}
