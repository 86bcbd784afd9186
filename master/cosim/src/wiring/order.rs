//! Sorts the connections by direct feedthrough: which outputs can be read together after which
//! inputs are set, and which form algebraic loops. The plans in [`crate::exchange`] use this order.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use anyhow::{Result, bail};

use super::{Port, Wiring};

/// What the user can do about an algebraic loop.
pub(super) const REMEDY: &str = "no order of exchange resolves it. One of these components must have a state, or a delay of a communication step, between \
     its input and its output, and must not list that input among the output's dependencies; or one of the connections must go; or it is solved, which --solve-loops asks for";

/// Which dependencies an output has that declares none.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Undeclared {
    /// All inputs, as the standards say.
    All,
    /// None: only declared dependencies count.
    None,
    /// All inputs, and outputs that are read right after the step depend on the inputs over it.
    AllOverStep,
}

/// Which dependencies count.
#[derive(Clone, Copy, Debug)]
pub struct Feedthrough {
    /// Dependencies in Initialization Mode; else at a communication point.
    pub is_initial: bool,
    /// Dependencies of an output that declares none.
    pub undeclared: Undeclared,
}

impl Wiring<'_> {
    /// The inputs on which an output depends directly.
    fn dependencies(&self, output: Port, which: Feedthrough) -> Vec<usize> {
        let (variable, is_initial) = (output.variable, which.is_initial);
        let description = self.description(output.component);
        let is_over_step = which.undeclared == Undeclared::AllOverStep;
        if !is_initial && !is_over_step && self.is_read_once(output) {
            return Vec::new();
        }
        match which.undeclared {
            Undeclared::None => description.declared_feedthrough(variable, is_initial),
            _ => Some(description.feedthrough(variable, is_initial)),
        }
        .unwrap_or_default()
    }

    /// The connected inputs on which an output depends directly, each with the output that drives
    /// it.
    fn needed(&self, output: Port, which: Feedthrough) -> impl Iterator<Item = [Port; 2]> {
        let inputs = self.dependencies(output, which).into_iter();
        let inputs = inputs.map(move |variable| Port { variable, ..output });
        inputs.filter_map(|input| Some([input, self.source(input)?]))
    }

    /// Level of the output of each connection: 0 if it depends on no connected input, else one more
    /// than the highest level it depends on. An output that no other one depends on has the last
    /// level of its component. All outputs of a level can be read together once the inputs fed by
    /// lower levels are set. An algebraic loop is an error that names it.
    pub(crate) fn levels(&self, which: Feedthrough) -> Result<Vec<usize>> {
        let mut search = Search {
            wiring: self,
            which,
            loops: &self.loops(which),
            known: HashMap::new(),
            path: Vec::new(),
        };
        let levels = self.links.iter().map(|link| search.level(link.from));
        let mut levels: Vec<usize> = levels.collect::<Result<_>>()?;
        // Saves the component an evaluation for outputs that no connected output depends on.
        for (k, link) in self.links.iter().enumerate() {
            let is_free = which.is_initial || !self.is_read_once(link.from);
            if is_free && !self.is_awaited(link.to, which) {
                let same = self.links.iter().zip(&levels);
                let last = same.filter(|(other, _)| other.from.component == link.from.component);
                levels[k] = last.map(|(_, level)| *level).max().unwrap_or(levels[k]);
            }
        }
        Ok(levels)
    }

    /// Outputs that depend on each other directly, loop by loop; empty if loops are not solved.
    pub(crate) fn loops(&self, which: Feedthrough) -> Vec<Vec<Port>> {
        if !self.structure.solves_loops {
            return Vec::new();
        }
        let all_needed = |output: Port| {
            let (mut found, mut rest) = (BTreeSet::new(), vec![output]);
            while let Some(next) = rest.pop() {
                let needed = self.needed(next, which).map(|[_, driver]| driver);
                rest.extend(needed.filter(|driver| found.insert(*driver)));
            }
            found
        };
        let outputs: BTreeSet<Port> = self.links.iter().map(|link| link.from).collect();
        let needed: BTreeMap<_, _> = outputs.iter().map(|o| (*o, all_needed(*o))).collect();
        let mut loops: Vec<Vec<Port>> = Vec::new();
        for (output, own) in needed.iter().filter(|(output, own)| own.contains(output)) {
            if loops.iter().any(|known| known.contains(output)) {
                continue;
            }
            let mutual = own.iter().filter(|other| needed[other].contains(output));
            loops.push(mutual.copied().collect());
        }
        loops
    }

    /// Whether a connected output depends directly on an input.
    fn is_awaited(&self, input: Port, which: Feedthrough) -> bool {
        let outputs = self.links.iter().map(|link| link.from);
        let mut own = outputs.filter(|output| output.component == input.component);
        own.any(|output| self.dependencies(output, which).contains(&input.variable))
    }
}

/// The search for the level of each output.
struct Search<'a> {
    wiring: &'a Wiring<'a>,
    which: Feedthrough,
    /// Loops that are solved: all outputs of one have the same level.
    loops: &'a [Vec<Port>],
    known: HashMap<Port, usize>,
    /// Outputs and the inputs between them; each depends on the next one.
    path: Vec<Port>,
}

impl Search<'_> {
    fn level(&mut self, output: Port) -> Result<usize> {
        if let Some(level) = self.known.get(&output) {
            return Ok(*level);
        }
        if let Some(start) = self.path.iter().position(|p| *p == output) {
            let along = self.path[start..].iter().chain([&output]).rev();
            let names: Vec<_> = along.map(|p| self.wiring.name(*p)).collect();
            let when = match self.which.is_initial {
                true => " in initialization",
                false => "",
            };
            bail!("algebraic loop{when}: {}; {REMEDY}", names.join(" -> "));
        }
        let (wiring, alone) = (self.wiring, [output]);
        let own = self.loops.iter().find(|own| own.contains(&output));
        let together = own.map_or(&alone[..], Vec::as_slice);
        let mut level = 0;
        for member in together {
            for [input, driver] in wiring.needed(*member, self.which) {
                if own.is_some_and(|own| own.contains(&driver)) {
                    continue;
                }
                self.path.extend([output, input]);
                level = level.max(1 + self.level(driver)?);
                self.path.truncate(self.path.len() - 2);
            }
        }
        self.known
            .extend(together.iter().map(|member| (*member, level)));
        Ok(level)
    }
}
