//! Components with steps of their own (`--rate`), a whole part or multiple of the communication
//! step, and continuous inputs between communication points (`--between`), for `coupling`.

use std::collections::{BTreeMap, HashMap};

use anyhow::{Result, anyhow, bail, ensure};
use serde::{Deserialize, Serialize};

use super::choice::{Between, Schedule, Stepping};
use crate::exchange::faults::Alteration;
use crate::exchange::{Exchange, Read, Write, reads, writes};
use crate::instance::{At, BegunCall, Call, Instance};
use crate::structure::Structure;
use crate::wiring::{Link, Wiring};
use fmi_import::digits::short;

/// The steps and inputs of all components.
pub(crate) struct Rates {
    /// Communication step, s.
    step: f64,
    between: Between,
    pub components: Vec<ComponentRate>,
    pub known: PastValues,
}

/// Values remembered from one communication point to the next.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub(crate) struct PastValues {
    /// Values at the communication point before.
    before: Vec<f64>,
    /// Length of the step from there, s; 0 if there is none.
    length: f64,
    /// Time that each component has reached, s.
    pub reached: Vec<f64>,
}

/// The steps and inputs of one component.
#[derive(Default)]
pub(crate) struct ComponentRate {
    /// Steps in a communication step.
    parts: usize,
    /// Communication steps in a step.
    every: usize,
    /// Reads of the values at the end, from components that were stepped before.
    reads: Vec<Read>,
    pub writes: Vec<Write>,
    /// Slots of the inputs' values in the exchange.
    sources: Vec<usize>,
    /// Values at the end of the step.
    ends: Vec<f64>,
    /// Workspace: values within the step, and sums of the mean efforts.
    mixed: Vec<f64>,
    sums: Vec<f64>,
}

/// Steps of length `own` in a communication step, and communication steps in one of these, both s.
fn step_ratio(step: f64, own: f64, name: &str) -> Result<[usize; 2]> {
    let is_whole = |ratio: f64| (ratio - ratio.round()).abs() <= 1e-9 * ratio && ratio < 1e6;
    if own > 0.0 && own <= step && is_whole(step / own) {
        return Ok([(step / own).round() as usize, 1]);
    }
    if own > step && is_whole(own / step) {
        return Ok([1, (own / step).round() as usize]);
    }
    bail!(
        "the step of `{name}`, {} s, must be a whole part or a whole multiple of the communication step, {} s",
        short(own),
        short(step)
    )
}

impl Rates {
    /// The rates of a system; None if every component makes each communication step with held
    /// inputs.
    pub fn new(
        structure: &Structure,
        wiring: &Wiring,
        exchange: &Exchange,
        stepping: Stepping,
    ) -> Result<Option<Self>> {
        let (step, schedule, between) = (stepping.step, stepping.schedule, stepping.between);
        if structure.rates.is_empty() && matches!(between, Between::Held | Between::Balanced) {
            return Ok(None);
        }
        let is_sequential = schedule == Schedule::GaussSeidel;
        let needs_order = matches!(between, Between::Interpolated | Between::End);
        ensure!(
            is_sequential || !needs_order,
            "inputs can be {between:?} with the schedule gauss-seidel only: no component is stepped before another"
        );
        ensure!(
            schedule != Schedule::JacobiDerivatives,
            "input derivatives say what inputs are between communication points: components have no other steps or inputs then"
        );
        let mut components = Vec::new();
        let own_steps = structure.rates.iter();
        let own_steps: HashMap<&str, f64> = own_steps.map(|(name, h)| (&**name, *h)).collect();
        let mut driving: Vec<Vec<&Link>> = vec![Vec::new(); structure.components.len()];
        for link in &wiring.links {
            driving[link.to.component].push(link);
        }
        for (k, component) in structure.components.iter().enumerate() {
            let name = component.name.as_str();
            let own = own_steps.get(name);
            let [parts, every] = own.map_or(Ok([1, 1]), |own| step_ratio(step, *own, name))?;
            ensure!(
                every == 1
                    || wiring
                        .clocks
                        .iter()
                        .flatten()
                        .all(|port| port.component != k),
                "`{name}`, whose clocks are connected, must have a communication point wherever the others have one: its step must not be longer than theirs"
            );
            let is_taken = |link: &Link| {
                let is_before = is_sequential && link.from.component < k;
                !link.is_initial
                    && wiring.is_continuous(link.from)
                    && wiring.is_continuous(link.to)
                    && !(is_before && link.bond.is_some())
                    && (is_before || !needs_order)
            };
            let mut rate = ComponentRate {
                parts,
                every,
                ..ComponentRate::default()
            };
            if between != Between::Held && (every == 1 || between == Between::End) {
                let links = driving[k]
                    .iter()
                    .copied()
                    .filter(|link| wiring.terms(link.to).all(is_taken));
                rate.plan(wiring, exchange, links, needs_order);
            }
            components.push(rate);
        }
        let known = PastValues {
            before: exchange.values.clone(),
            length: 0.0,
            reached: vec![stepping.start; components.len()],
        };
        Ok(Some(Self {
            step,
            between,
            components,
            known,
        }))
    }

    /// Most steps of a component in a communication step.
    pub fn most_parts(structure: &Structure, step: f64) -> usize {
        let parts = structure.rates.iter().map(|(_, own)| step / own);
        parts.fold(1.0, f64::max).round().min(1e6) as usize
    }

    /// Whether the component makes a step to `end`, s.
    pub fn is_due(&self, component: usize, end: f64) -> bool {
        let every = self.components[component].every as f64;
        every == 1.0 || end - self.known.reached[component] > (every - 0.5) * self.step
    }

    /// Before a step to `end`, s: components that make no step to there are left out of the
    /// exchange.
    pub fn rest(&self, resting: &mut Vec<bool>, end: f64) {
        if self.components.iter().any(|rate| rate.every > 1) {
            resting.clear();
            resting.extend((0..self.components.len()).map(|k| !self.is_due(k, end)));
        }
    }

    /// Remember the values before the exchange after a step by `h`, s.
    pub fn remember(&mut self, values: &[f64], h: f64) {
        self.known.before.copy_from_slice(values);
        self.known.length = h;
    }

    /// Estimate the inputs of a component at the end of a step from `t` by `h`, both s.
    fn look_ahead(
        &mut self,
        component: usize,
        instances: &[Instance],
        values: &[f64],
        [t, h]: [f64; 2],
    ) -> Result<()> {
        let (own, at) = (&mut self.components[component], At::Time(t + h));
        if !own.reads.is_empty() {
            let (mut reads, ends) = (own.reads.iter(), &mut own.ends);
            return reads.try_for_each(|read| read.run(instances, ends, at));
        }
        let PastValues { before, length, .. } = &self.known;
        let share = if *length > 0.0 { h / length } else { 0.0 };
        for (end, slot) in own.ends.iter_mut().zip(&own.sources) {
            *end = values[*slot] + share * (values[*slot] - before[*slot]);
        }
        Ok(())
    }

    /// Make the steps of a component from `t` by `h`, both s, or only begin them in its thread. The
    /// mean efforts are those over all of the steps.
    pub fn step(&mut self, step: ComponentStep, [t, h]: [f64; 2]) -> Result<()> {
        let (k, at) = (step.component, At::Time(t));
        // Only once, where the steps are begun in another thread.
        if step.begins || !step.instances[k].is_elsewhere() {
            self.look_ahead(k, step.instances, step.values, [t, h])?;
        }
        if !self.is_due(k, t + h) {
            return Ok(());
        }
        let ComponentStep {
            instances,
            values,
            mean,
            means,
            mut faults,
            begins,
            ..
        } = step;
        let start = self.known.reached[k];
        let rate = &mut self.components[k];
        let (start, length, parts) = match rate.every {
            1 => (t, h / rate.parts as f64, rate.parts),
            _ => (start, t + h - start, 1),
        };
        let slots = mean.map_or(0..0, Read::slots);
        rate.sums.clear();
        rate.sums.resize(slots.len(), 0.0);
        for part in 0..=parts {
            let share = match self.between {
                Between::End if part == 0 => Some(1.0),
                Between::Held | Between::End | Between::Balanced => None,
                _ => Some(((part as f64 + 0.5) / parts as f64).min(1.0)),
            };
            if let Some(share) = share {
                rate.set(share, instances, values, faults.as_deref_mut(), begins, at)?;
            }
            if part == parts {
                break;
            }
            let from = start + part as f64 * length;
            if begins {
                instances[k].begin(BegunCall::Plain(Call::Step(from, length)));
                mean.into_iter().for_each(|read| read.begin(instances));
                continue;
            }
            instances[k].step(from, length)?;
            if let Some(read) = mean {
                read.run(instances, means, at)?;
                let sums = rate.sums.iter_mut().zip(&means[slots.clone()]);
                sums.for_each(|(sum, new)| *sum += new);
            }
        }
        if !begins {
            self.known.reached[k] = t + h;
            let all = means[slots].iter_mut().zip(&rate.sums);
            all.for_each(|(mean, sum)| *mean = sum / parts as f64);
        }
        Ok(())
    }
}

/// The arguments of the steps of a component.
pub(crate) struct ComponentStep<'a> {
    pub component: usize,
    pub instances: &'a [Instance],
    /// Values last passed.
    pub values: &'a [f64],
    /// Read of the mean efforts, and their values.
    pub mean: Option<&'a Read>,
    pub means: &'a mut [f64],
    pub faults: Option<&'a mut Alteration>,
    /// Calls are only begun.
    pub begins: bool,
}

impl ComponentRate {
    /// Plan the reads and writes of the inputs that `links` drive.
    fn plan<'a>(
        &mut self,
        wiring: &Wiring,
        exchange: &Exchange,
        links: impl Iterator<Item = &'a Link> + Clone,
        reads_ends: bool,
    ) {
        let mut slots = BTreeMap::new();
        let planned = reads(wiring, links.clone().map(|link| link.from), &mut slots);
        let targets = links.map(|l| (l.to, slots[&l.from], l.transformation.clone()));
        self.writes = writes(wiring, targets);
        self.sources = vec![0; slots.len()];
        for (port, slot) in &slots {
            self.sources[*slot] = exchange.slot(*port).unwrap_or_default();
        }
        self.ends = vec![0.0; slots.len()];
        self.mixed = self.ends.clone();
        if reads_ends {
            self.reads = planned;
        }
    }

    /// Set the inputs to their values at this fraction of the step.
    fn set(
        &mut self,
        share: f64,
        instances: &[Instance],
        values: &[f64],
        mut faults: Option<&mut Alteration>,
        begins: bool,
        at: At,
    ) -> Result<()> {
        for ((mixed, end), slot) in self.mixed.iter_mut().zip(&self.ends).zip(&self.sources) {
            let now = values[*slot];
            *mixed = match share == 1.0 {
                true => *end,
                false => now + share * (end - now),
            };
        }
        for write in &mut self.writes {
            let faults = faults.as_deref_mut();
            match begins {
                true => write.begin(instances, &self.mixed, faults, at)?,
                false => write.run(instances, &self.mixed, faults, at)?,
            }
        }
        Ok(())
    }
}

/// Parse `COMPONENT=TIME`: a pattern for the names of components, and their step, `0.25ms`, `60s`
/// or `0.001` in s.
pub fn parse_rate(text: &str) -> Result<(&str, f64)> {
    let parsed = text.rsplit_once('=').and_then(|(name, length)| {
        let length = length.trim();
        let units = [("us", 1e-6), ("ms", 1e-3), ("s", 1.0), ("", 1.0)];
        let mut units = units.iter();
        let (number, unit) =
            units.find_map(|(unit, scale)| Some((length.strip_suffix(unit)?, scale)))?;
        let number: f64 = number.trim().parse().ok()?;
        (number.is_finite() && number > 0.0).then_some((name.trim(), number * unit))
    });
    parsed.ok_or_else(|| {
        anyhow!("`{text}` must be COMPONENT=TIME with a time in us, ms or s that is greater than 0")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_whole_parts_and_multiples() {
        assert_eq!(parse_rate("emla_*= 0.25ms").unwrap(), ("emla_*", 0.25e-3));
        assert_eq!(parse_rate("a=60s").unwrap(), ("a", 60.0));
        assert!(parse_rate("a=0ms").is_err() && parse_rate("a").is_err());
        assert_eq!(step_ratio(1e-3, 0.25e-3, "a").unwrap(), [4, 1]);
        assert_eq!(step_ratio(0.1, 0.3, "a").unwrap(), [1, 3]);
        assert!(step_ratio(1e-3, 0.3e-3, "a").is_err() && step_ratio(1e-3, 1.5e-3, "a").is_err());
    }
}
