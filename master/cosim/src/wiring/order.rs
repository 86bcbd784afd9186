//! The order of direct feedthrough: which outputs can be read together, and which depend on each
//! other.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use anyhow::{Result, bail};

use super::{Port, Wiring};

/// What breaks an algebraic loop.
pub(super) const REMEDY: &str = "no order of exchange resolves it. One of these components must have a state, or a delay of a communication step, between \
     its input and its output, and must not list that input among the output's dependencies; or one of the connections must go; or it is solved, which --solve-loops asks for";

/// Which dependencies count where an output declares none.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Undeclared {
    /// All inputs, as the standards have it.
    All,
    /// None: the order is that of what is declared.
    None,
    /// All inputs, also of outputs that are read right after the step: they depend on what inputs
    /// are over it.
    AllOverStep,
}

/// Which dependencies count.
#[derive(Clone, Copy, Debug)]
pub struct Feedthrough {
    /// Those in initialization mode; else those at a communication point.
    pub is_initial: bool,
    /// Of an output that declares none.
    pub undeclared: Undeclared,
}

impl Wiring<'_> {
    /// The inputs on which an output depends at once.
    fn dependencies(&self, output: Port, which: Feedthrough) -> Vec<usize> {
        let Feedthrough {
            is_initial,
            undeclared,
        } = which;
        let description = self.description(output.component);
        let is_over_step = undeclared == Undeclared::AllOverStep;
        if !is_initial && !is_over_step && self.is_read_once(output) {
            return Vec::new();
        }
        if undeclared == Undeclared::None {
            let declared = description.declared_feedthrough(output.variable, is_initial);
            return declared.unwrap_or_default();
        }
        description.feedthrough(output.variable, is_initial)
    }

    /// The connected inputs on which an output depends at once, each with the output that drives it.
    fn needed(&self, output: Port, which: Feedthrough) -> impl Iterator<Item = [Port; 2]> {
        let inputs = self.dependencies(output, which).into_iter();
        let inputs = inputs.map(move |variable| Port { variable, ..output });
        inputs.filter_map(|input| Some([input, self.source(input)?]))
    }

    /// Level of the output of each connection: 0 where it depends on no connected input, else one
    /// more than the highest level it depends on; outputs that no other one waits for come with the
    /// last ones of their component. All outputs of one level can be read together after the inputs
    /// from all lower levels are set.
    ///
    /// # Errors
    /// An algebraic loop, by the names along it.
    pub fn levels(&self, which: Feedthrough) -> Result<Vec<usize>> {
        let mut search = Search {
            wiring: self,
            which,
            loops: &self.loops(which),
            known: HashMap::new(),
            path: Vec::new(),
        };
        let levels = self.links.iter().map(|link| search.level(link.from));
        let mut levels: Vec<usize> = levels.collect::<Result<_>>()?;
        // What no connected output waits for is read with the component's last ones, which saves
        // the component an evaluation of its own.
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

    /// Outputs that depend on each other at once, loop by loop; none where loops are not solved.
    pub fn loops(&self, which: Feedthrough) -> Vec<Vec<Port>> {
        if !self.solves_loops {
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

    /// Whether a connected output depends on an input at once.
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
    /// Those that are solved: all outputs of one are on one level.
    loops: &'a [Vec<Port>],
    known: HashMap<Port, usize>,
    /// Outputs and the inputs between them, each depending on the next one.
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
