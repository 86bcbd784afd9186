//! Sorts the connections by direct feedthrough: which outputs can be read together after which
//! inputs are set, and which form algebraic loops. The plans in [`crate::exchange`] use this order.

use std::collections::{HashMap, HashSet};

use anyhow::{Result, anyhow};

use super::strong_parts::strong_parts;
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

/// What identifies the inputs on which an output depends: its component, and the list of the
/// description. Outputs that share them need not be looked at one by one.
type Key = (usize, *const usize, usize);

/// Connected outputs, the sets of inputs on which they depend, and which depends on which.
struct Graph {
    outputs: Vec<Port>,
    /// The inputs of each set that are connected.
    sets: Vec<Vec<Port>>,
    /// Nodes that each node needs: of an output, the first nodes, the set of its inputs; of a set
    /// the outputs that drive these inputs.
    edges: Vec<Vec<usize>>,
    /// The node of each output.
    places: HashMap<Port, usize>,
    /// Groups of nodes that need each other, each after those that it needs.
    parts: Vec<Vec<usize>>,
    /// The group of each node.
    part_of: Vec<usize>,
}

impl Graph {
    fn new(wiring: &Wiring, which: Feedthrough) -> Self {
        let (mut outputs, mut places) = (Vec::new(), HashMap::new());
        for link in &wiring.links {
            places.entry(link.from).or_insert_with(|| {
                outputs.push(link.from);
                outputs.len() - 1
            });
        }
        let (mut sets, mut known) = (Vec::new(), HashMap::new());
        let (mut edges, mut set_edges) = (Vec::new(), Vec::new());
        for output in &outputs {
            let set = known.entry(wiring.key(*output, which)).or_insert_with(|| {
                let (inputs, drivers): (Vec<_>, Vec<_>) = wiring.needed(*output, which).unzip();
                set_edges.push(drivers.iter().map(|driver| places[driver]).collect());
                sets.push(inputs);
                outputs.len() + sets.len() - 1
            });
            edges.push(vec![*set]);
        }
        edges.append(&mut set_edges);
        let parts = strong_parts(&edges);
        let mut part_of = vec![0; edges.len()];
        for (k, part) in parts.iter().enumerate() {
            part.iter().for_each(|node| part_of[*node] = k);
        }
        Self {
            outputs,
            sets,
            edges,
            places,
            parts,
            part_of,
        }
    }

    fn is_set(&self, node: usize) -> bool {
        node >= self.outputs.len()
    }

    /// Level of each output, and of each set that of the outputs which need it. A loop is an error
    /// unless it `is_solved`: then all its outputs have the same level.
    fn levels(&self, is_solved: bool) -> Result<Vec<usize>, &[usize]> {
        let mut levels = vec![0; self.edges.len()];
        let above = |levels: &[usize], nodes: &mut dyn Iterator<Item = &usize>| {
            nodes.map(|node| 1 + levels[*node]).max().unwrap_or(0)
        };
        for (k, part) in self.parts.iter().enumerate() {
            if part.len() > 1 && !is_solved {
                return Err(part);
            }
            let sets = || part.iter().filter(|node| self.is_set(**node));
            let needed = sets().flat_map(|set| &self.edges[*set]);
            let mut others = needed.filter(|node| self.part_of[**node] != k);
            let level = match part[..] {
                [output] if !self.is_set(output) => levels[self.edges[output][0]],
                _ => above(&levels, &mut others),
            };
            part.iter().for_each(|node| levels[*node] = level);
            // Outputs that need these inputs but are not in the loop come after it.
            for set in sets() {
                levels[*set] = above(&levels, &mut self.edges[*set].iter());
            }
        }
        Ok(levels)
    }

    /// The outputs and inputs along a loop, in the order of the signals.
    fn along(&self, part: &[usize]) -> Vec<Port> {
        let is_own = |node: &&usize| self.part_of[**node] == self.part_of[part[0]];
        let inside = |set: usize| {
            let found = self.edges[set].iter().position(|node| is_own(&node));
            let place = found.expect("a loop goes on");
            (self.edges[set][place], place)
        };
        let mut node = match self.is_set(part[0]) {
            true => inside(part[0]).0,
            false => part[0],
        };
        let (mut path, mut seen) = (Vec::new(), HashMap::new());
        while !seen.contains_key(&node) {
            seen.insert(node, path.len());
            let set = self.edges[node][0];
            let (next, place) = inside(set);
            path.extend([
                self.outputs[node],
                self.sets[set - self.outputs.len()][place],
            ]);
            node = next;
        }
        path.drain(..seen[&node]);
        path.push(self.outputs[node]);
        path.reverse();
        path
    }
}

impl Wiring<'_> {
    /// The inputs on which an output depends directly; None for all of its component.
    fn dependencies(&self, output: Port, which: Feedthrough) -> Option<&[usize]> {
        let is_over_step = which.undeclared == Undeclared::AllOverStep;
        if !which.is_initial && !is_over_step && self.is_read_once(output) {
            return Some(&[]);
        }
        let description = self.description(output.component);
        match description.dependence(output.variable, which.is_initial) {
            None if which.undeclared == Undeclared::None => Some(&[]),
            known => known,
        }
    }

    fn key(&self, output: Port, which: Feedthrough) -> Key {
        let list = self.dependencies(output, which);
        let list = list.map_or((std::ptr::null(), 0), |list| (list.as_ptr(), list.len()));
        (output.component, list.0, list.1)
    }

    /// The connected inputs on which an output depends directly, each with the output that drives
    /// it.
    fn needed(&self, output: Port, which: Feedthrough) -> impl Iterator<Item = (Port, Port)> {
        let list = self.dependencies(output, which);
        let all = match list {
            Some(_) => &[],
            None => &self.driven[output.component][..],
        };
        let own = list.into_iter().flatten();
        let own = own.map(move |variable| Port::new(output.component, *variable));
        let inputs = all.iter().copied().chain(own);
        let inputs = inputs.filter(|input| self.variable(*input).is_input());
        inputs.flat_map(|input| self.terms(input).map(move |link| (input, link.from)))
    }

    /// Level of the output of each connection: 0 if it depends on no connected input, else one more
    /// than the highest level it depends on. An output that no other one depends on has the last
    /// level of its component. All outputs of a level can be read together once the inputs fed by
    /// lower levels are set. An algebraic loop is an error that names it.
    pub(crate) fn levels(&self, which: Feedthrough) -> Result<Vec<usize>> {
        let graph = Graph::new(self, which);
        let levels = graph.levels(self.structure.solves_loops);
        let levels = levels.map_err(|part| {
            let along = graph.along(part).into_iter();
            let names: Vec<_> = along.map(|port| self.name(port)).collect();
            let when = match which.is_initial {
                true => " in initialization",
                false => "",
            };
            anyhow!("algebraic loop{when}: {}; {REMEDY}", names.join(" -> "))
        })?;
        let links = self.links.iter();
        let mut levels: Vec<usize> = links.map(|l| levels[graph.places[&l.from]]).collect();
        // Saves the component an evaluation for outputs that no connected output depends on.
        let mut last = vec![0; self.components.len()];
        for (link, level) in self.links.iter().zip(&levels) {
            let last: &mut usize = &mut last[link.from.component];
            *last = (*last).max(*level);
        }
        let inputs: HashSet<Port> = graph.sets.into_iter().flatten().collect();
        // An output with several connections is read once.
        let awaited = self.links.iter().filter(|link| inputs.contains(&link.to));
        let awaited: HashSet<Port> = awaited.map(|link| link.from).collect();
        for (link, level) in self.links.iter().zip(&mut levels) {
            let is_free = which.is_initial || !self.is_read_once(link.from);
            if is_free && !awaited.contains(&link.from) {
                *level = last[link.from.component];
            }
        }
        Ok(levels)
    }

    /// Outputs that depend on each other directly, loop by loop; empty if loops are not solved.
    pub(crate) fn loops(&self, which: Feedthrough) -> Vec<Vec<Port>> {
        if !self.structure.solves_loops {
            return Vec::new();
        }
        let graph = Graph::new(self, which);
        let loops = graph.parts.iter().filter(|part| part.len() > 1);
        let outputs = loops.map(|part| {
            let own = part.iter().filter(|node| !graph.is_set(**node));
            let mut own: Vec<Port> = own.map(|node| graph.outputs[*node]).collect();
            own.sort();
            own
        });
        let mut loops: Vec<Vec<Port>> = outputs.collect();
        loops.sort();
        loops
    }
}
