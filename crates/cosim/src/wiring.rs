//! Who must be read before whom: connections resolved against the model descriptions and put in the
//! order of direct feedthrough.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use crate::batch::{Batch, Layout};
use crate::structure::{Connection, Power, Structure};
use crate::transformation::{Linear, Transformation, along, unit_of};
use anyhow::{Context, Result, bail};
use fmu_description::{Access, Causality, Description, Kind, Variable, Version};
use serde::{Deserialize, Serialize};
use system_structure::DataType;

/// A variable of a component: both as indices.
#[derive(Clone, Copy, Debug, Deserialize, Eq, Hash, Ord, PartialEq, PartialOrd, Serialize)]
pub struct Port {
    /// Index of the component in the structure.
    pub component: usize,
    /// Index of the variable in its description.
    pub variable: usize,
}

/// A resolved connection.
#[derive(Clone, Debug)]
pub struct Link {
    /// Output.
    pub from: Port,
    /// Input.
    pub to: Port,
    /// What becomes of a value on its way.
    pub transformation: Transformation,
    /// Passed in initialization only.
    pub is_initial: bool,
    /// Power bond of which it carries the effort.
    pub bond: Option<BondPorts>,
}

/// The other variables of a power bond whose effort a [`Link`] carries.
#[derive(Clone, Copy, Debug)]
pub struct BondPorts {
    /// Mean effort over the last step: an output of the component that exerts the effort.
    pub step_mean: Port,
    /// Conjugate flow: an input of the same component.
    pub flow: Port,
    /// Direction of the power effort times flow.
    pub power: Power,
}

/// What breaks an algebraic loop.
const REMEDY: &str = "no order of exchange resolves it. One of these components must have a state, or a delay of a communication step, between \
     its input and its output, and must not list that input among the output's dependencies; or one of the connections must go; or it is solved, which --solve-loops asks for";

/// The system's connections with everything that is needed to order them.
pub struct Wiring<'a> {
    components: Vec<(&'a str, &'a Description)>,
    /// The connections, in file order.
    pub links: Vec<Link>,
    /// What is odd about them, but does no harm.
    pub remarks: Vec<String>,
    driver: HashMap<Port, usize>,
    /// Components of which outputs may be read again after inputs were set although they declare no
    /// dependencies.
    trusted: Vec<bool>,
    /// Algebraic loops are solved.
    solves_loops: bool,
}

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

impl<'a> Wiring<'a> {
    /// Resolve the connections of `structure`; `descriptions` has one entry per component.
    pub fn new(structure: &'a Structure, descriptions: &[&'a Description]) -> Result<Self> {
        let names = structure.components.iter().map(|c| c.name.as_str());
        let mut wiring = Self {
            components: names.zip(descriptions.iter().copied()).collect(),
            links: Vec::new(),
            remarks: Vec::new(),
            driver: HashMap::new(),
            solves_loops: structure.solves_loops,
            trusted: (structure.components.iter())
                .map(|c| structure.feedthrough.contains(&c.name))
                .collect(),
        };
        for c in &structure.connections {
            let link = wiring.resolve(structure, c);
            let link = match c.place.is_empty() {
                true => link?,
                false => link.with_context(|| c.place.clone())?,
            };
            wiring.driver.insert(link.to, wiring.links.len());
            wiring.links.push(link);
        }
        Ok(wiring)
    }

    fn resolve(&mut self, structure: &Structure, c: &Connection) -> Result<Link> {
        let from = self.port(structure, &c.start, Side::Start)?;
        let to = self.port(structure, &c.end, Side::End)?;
        let [start, end] = [from, to].map(|p| self.variable(p));
        if start.kind.name() != end.kind.name() && !(is_whole(start) && is_whole(end)) {
            bail!(
                "{} must be of type {}, input, to be connected; it is of type {}, input",
                self.name(to),
                start.kind.name(),
                end.kind.name()
            );
        }
        if start.kind == Kind::Clock {
            bail!(
                "connection {c} connects clocks, which is not supported: only the clocks tick whose FMU says when"
            );
        }
        // An end without a declared unit has that of its FMU.
        let [unit_of_start, unit_of_end] =
            [from, to].map(|p| unit_of(self.description(p.component), self.variable(p)));
        let mut way = c.way.clone();
        if let Some(last) = way.last_mut()
            && last.unit.is_none()
        {
            last.unit = unit_of_end;
        }
        let is_declared = c.unit.is_some() || c.way.iter().any(|hop| hop.unit.is_some());
        let unit = c.unit.clone().or(unit_of_start);
        let mut lone = None;
        let transformation = along(&way, unit, [Some(start), Some(end)], &mut lone);
        let transformation = transformation.map_err(|error| {
            let text = match is_declared {
                true => error.to_string(),
                false => error.to_string().replace("the units", "the FMUs' units"),
            };
            anyhow::anyhow!("connection {c}: {text}")
        })?;
        if start.kind != Kind::Real && transformation.linear() != Linear::NONE {
            bail!(
                "connection {c}: a LinearTransformation is for Real, not for {}",
                start.kind.name()
            );
        }
        if let Some(unit) = lone {
            self.remarks.push(format!(
                "connection {c}: only one end has a unit, {unit}; values pass unchanged"
            ));
        }
        let bond = match &c.bond {
            None => None,
            Some(b) => {
                let of_start = |variable: &str, side| {
                    let end = (c.start.0.clone(), variable.to_string());
                    let port = self.port(structure, &end, side);
                    port.with_context(|| {
                        format!(
                            "power bond of {}.{}: {}.{variable}",
                            c.start.0, c.start.1, c.start.0
                        )
                    })
                };
                Some(BondPorts {
                    step_mean: of_start(&b.step_mean, Side::Start)?,
                    flow: of_start(&b.flow, Side::End)?,
                    power: b.power,
                })
            }
        };
        Ok(Link {
            from,
            to,
            transformation,
            is_initial: c.is_initial,
            bond,
        })
    }

    /// The variable at one end of a connection, of the type that is declared for it.
    fn port(
        &self,
        structure: &Structure,
        (component, variable): &(String, String),
        side: Side,
    ) -> Result<Port> {
        let Some(k) = structure.component(component) else {
            bail!("the system has no component `{component}`")
        };
        let description = self.components[k].1;
        let v = description.variable(variable)?;
        let connectors = &structure.components[k].connectors;
        let connector = connectors.iter().find(|c| c.name == *variable);
        let declared = connector.and_then(|c| c.data_type);
        let kind = v.kind.name();
        let fits = declared.is_none_or(|t| {
            t.name() == kind
                || is_whole(v) && matches!(t, DataType::Integer | DataType::Enumeration)
        });
        if !fits || !side.takes(v.causality) {
            bail!(
                "{component}.{variable} must be of type {}, {}, to be connected; it is of type {kind}, {}",
                declared.map_or(kind, DataType::name),
                side.name(),
                in_words(v.causality)
            );
        }
        Ok(Port {
            component: k,
            variable: description.index(variable).unwrap_or_default(),
        })
    }

    pub(crate) fn variable(&self, p: Port) -> &'a Variable {
        &self.components[p.component].1.variables[p.variable]
    }

    /// `component.variable`.
    pub fn name(&self, p: Port) -> String {
        let (component, description) = self.components[p.component];
        format!("{component}.{}", description.variables[p.variable].name)
    }

    /// Number of components.
    pub fn component_count(&self) -> usize {
        self.components.len()
    }

    /// Name of a component.
    pub fn component(&self, index: usize) -> &str {
        self.components[index].0
    }

    /// The functions that read and write a variable.
    pub fn access(&self, p: Port) -> Access {
        self.description(p.component).variables[p.variable].access()
    }

    /// The clocks at whose ticks alone a variable is exchanged.
    pub fn clocks(&self, p: Port) -> &[u32] {
        &self.description(p.component).variables[p.variable].clocks
    }

    /// Variables of a component that are read or written together.
    pub fn batch(&self, component: usize, variables: impl Iterator<Item = usize>) -> Batch {
        let description = self.description(component);
        Batch::new(description, &Layout::new(description), variables.collect())
    }

    /// Description of a component.
    pub fn description(&self, component: usize) -> &Description {
        self.components[component].1
    }

    /// Index of the connection that drives an input.
    pub fn driver(&self, input: Port) -> Option<usize> {
        self.driver.get(&input).copied()
    }

    /// Whether an output can be read once only at a communication point, right after the step and
    /// before any input is set: its dependencies are not declared, or its FMU is of FMI 3.0 and has
    /// no Event Mode, outside of which no output may be read after an input was set.
    pub fn is_read_once(&self, output: Port) -> bool {
        let description = self.description(output.component);
        let has_events = description.fmi == Version::Fmi2 || description.capabilities.event_mode;
        let is_declared = || {
            description
                .declared_feedthrough(output.variable, false)
                .is_some()
        };
        !has_events || !(self.trusted[output.component] || is_declared())
    }

    /// The inputs on which an output depends at once.
    fn dependencies(
        &self,
        output: Port,
        initialization: bool,
        undeclared: Undeclared,
    ) -> Vec<usize> {
        let description = self.components[output.component].1;
        let is_over_step = undeclared == Undeclared::AllOverStep;
        if !initialization && !is_over_step && self.is_read_once(output) {
            return Vec::new();
        }
        match undeclared {
            Undeclared::All | Undeclared::AllOverStep => {
                description.feedthrough(output.variable, initialization)
            }
            Undeclared::None => description
                .declared_feedthrough(output.variable, initialization)
                .unwrap_or_default(),
        }
    }

    /// Level of the output of each connection: 0 where it depends on no connected input, else one
    /// more than the highest level it depends on; outputs that no other one waits for come with the
    /// last ones of their component. All outputs of one level can be read together after the inputs
    /// from all lower levels are set.
    ///
    /// # Errors
    /// An algebraic loop, by the names along it.
    pub fn levels(&self, initialization: bool, undeclared: Undeclared) -> Result<Vec<usize>> {
        let loops = self.loops(initialization, undeclared);
        let mut search = Search {
            wiring: self,
            initialization,
            undeclared,
            loops: &loops,
            known: HashMap::new(),
            path: Vec::new(),
        };
        let links = self.links.iter();
        let mut levels = links
            .map(|l| search.level(l.from))
            .collect::<Result<Vec<_>>>()?;
        // What no connected output waits for is read with the component's last ones, which saves
        // the component an evaluation of its own.
        for (k, link) in self.links.iter().enumerate() {
            let is_free = initialization || !self.is_read_once(link.from);
            if is_free && !self.is_awaited(link.to, initialization, undeclared) {
                let same = self.links.iter().zip(&levels);
                let last = same.filter(|(other, _)| other.from.component == link.from.component);
                levels[k] = last.map(|(_, level)| *level).max().unwrap_or(levels[k]);
            }
        }
        Ok(levels)
    }

    /// Outputs that depend on each other at once, loop by loop; none where loops are not solved.
    pub fn loops(&self, initialization: bool, undeclared: Undeclared) -> Vec<Vec<Port>> {
        let mut outputs: Vec<Port> = self.links.iter().map(|link| link.from).collect();
        outputs.sort();
        outputs.dedup();
        if !self.solves_loops {
            outputs.clear();
        }
        let needed = |output: Port| {
            let inputs = self.dependencies(output, initialization, undeclared);
            let inputs = inputs
                .into_iter()
                .map(move |variable| Port { variable, ..output });
            inputs.filter_map(|input| self.driver(input).map(|k| self.links[k].from))
        };
        let all_needed = |output: Port| {
            let (mut found, mut rest) = (BTreeSet::new(), vec![output]);
            while let Some(next) = rest.pop() {
                rest.extend(needed(next).filter(|output| found.insert(*output)));
            }
            found
        };
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
    fn is_awaited(&self, input: Port, initialization: bool, undeclared: Undeclared) -> bool {
        self.links.iter().any(|link| {
            link.from.component == input.component
                && self
                    .dependencies(link.from, initialization, undeclared)
                    .contains(&input.variable)
        })
    }
}

/// The search for the level of each output.
struct Search<'a> {
    wiring: &'a Wiring<'a>,
    initialization: bool,
    undeclared: Undeclared,
    /// Those that are solved: all outputs of one are on one level.
    loops: &'a [Vec<Port>],
    known: HashMap<Port, usize>,
    /// Outputs and the inputs between them, each depending on the next one.
    path: Vec<Port>,
}

impl Search<'_> {
    fn is_solved_with(&self, one: Port, other: Port) -> bool {
        let mut loops = self.loops.iter();
        loops.any(|own| own.contains(&one) && own.contains(&other))
    }

    fn level(&mut self, output: Port) -> Result<usize> {
        if let Some(level) = self.known.get(&output) {
            return Ok(*level);
        }
        if let Some(start) = self.path.iter().position(|p| *p == output) {
            let along = self.path[start..].iter().chain([&output]).rev();
            let names: Vec<_> = along.map(|p| self.wiring.name(*p)).collect();
            let when = match self.initialization {
                true => " in initialization",
                false => "",
            };
            bail!("algebraic loop{when}: {}; {REMEDY}", names.join(" -> "));
        }
        let alone = [output];
        let together = self.loops.iter().find(|own| own.contains(&output));
        let together = together.map_or(&alone[..], Vec::as_slice);
        let mut level = 0;
        for member in together {
            let inputs = (self.wiring).dependencies(*member, self.initialization, self.undeclared);
            for variable in inputs {
                let input = Port {
                    variable,
                    ..*member
                };
                let driver = self.wiring.driver(input).map(|k| self.wiring.links[k].from);
                if let Some(driver) = driver.filter(|d| !self.is_solved_with(*d, output)) {
                    self.path.extend([output, input]);
                    level = level.max(1 + self.level(driver)?);
                    self.path.truncate(self.path.len() - 2);
                }
            }
        }
        self.known
            .extend(together.iter().map(|member| (*member, level)));
        Ok(level)
    }
}

/// An end of a connection.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Start,
    End,
}

impl Side {
    fn name(self) -> &'static str {
        match self {
            Self::Start => "output",
            Self::End => "input",
        }
    }

    /// Whether a variable of this causality may stand there.
    fn takes(self, causality: Causality) -> bool {
        use Causality::{CalculatedParameter, Input, Local, Output, Parameter};
        match self {
            Self::Start => matches!(causality, Output | CalculatedParameter | Local),
            Self::End => matches!(causality, Input | Parameter),
        }
    }
}

/// Integers and enumerations, which pass as the same numbers.
fn is_whole(v: &Variable) -> bool {
    matches!(v.kind, Kind::Integer | Kind::Enumeration(_))
}

fn in_words(causality: Causality) -> String {
    format!("{causality:?}").to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A component with inputs u, v and outputs y, z; y depends on `y_on`, z on nothing.
    fn description(model: &str, y_on: &str) -> Description {
        Description::parse(&format!(
            r#"<fmiModelDescription fmiVersion="2.0" modelName="{model}" guid="g"><CoSimulation modelIdentifier="{model}"/><ModelVariables>
            <ScalarVariable name="u" valueReference="0" causality="input"><Real unit="N"/></ScalarVariable>
            <ScalarVariable name="v" valueReference="1" causality="input"><Real unit="N"/></ScalarVariable>
            <ScalarVariable name="y" valueReference="2" causality="output"><Real unit="N"/></ScalarVariable>
            <ScalarVariable name="z" valueReference="3" causality="output"><Real unit="N"/></ScalarVariable>
            </ModelVariables><ModelStructure><Outputs><Unknown index="3" {y_on}/><Unknown index="4" dependencies=""/></Outputs></ModelStructure>
            </fmiModelDescription>"#
        ))
        .unwrap()
    }

    fn structure(links: &[(&str, &str)]) -> Structure {
        let split = |text: &str| {
            text.split_once('.')
                .map(|(c, v)| (c.to_string(), v.to_string()))
                .unwrap()
        };
        let mut structure = Structure {
            components: ["a", "b", "c"]
                .map(|name| crate::structure::Component {
                    name: name.into(),
                    source: String::new(),
                    connectors: Vec::new(),
                    parameters: Vec::new(),
                })
                .to_vec(),
            ..Structure::default()
        };
        for (y, u) in links {
            structure.connect(split(y), split(u));
        }
        structure
    }

    #[test]
    fn levels_follow_the_feedthrough() {
        let (u, none, all) = (
            description("U", "dependencies=\"1\""),
            description("N", "dependencies=\"\""),
            description("A", "dependencies=\"1 2\""),
        );
        // a.y <- a.u <- b.y <- (nothing); c.y <- c.u, c.v <- a.y; b is fed by c.y, which is no loop
        // because b.y has no feedthrough.
        let s = structure(&[
            ("b.y", "a.u"),
            ("a.y", "c.v"),
            ("c.y", "b.u"),
            ("c.z", "a.v"),
        ]);
        let wiring = Wiring::new(&s, &[&u, &none, &all]).unwrap();
        // Nothing waits for what c.z feeds: it is read together with c.y.
        assert_eq!(wiring.levels(false, Undeclared::All).unwrap(), [0, 1, 2, 2]);
    }

    #[test]
    fn a_loop_is_named_in_signal_order() {
        let (u, all) = (
            description("U", "dependencies=\"1\""),
            description("A", "dependencies=\"1 2\""),
        );
        let s = structure(&[("c.z", "b.u"), ("a.y", "b.v"), ("b.y", "a.u")]);
        let error = Wiring::new(&s, &[&u, &all, &all])
            .unwrap()
            .levels(false, Undeclared::All)
            .unwrap_err()
            .to_string();
        assert_eq!(
            error,
            format!("algebraic loop: a.y -> b.v -> b.y -> a.u -> a.y; {REMEDY}")
        );
    }

    #[test]
    fn wrong_ends_are_named() {
        let d = description("U", "");
        let s = structure(&[("a.y", "b.z")]);
        let error = Wiring::new(&s, &[&d, &d, &d]).err().unwrap().to_string();
        assert_eq!(
            error,
            "b.z must be of type Real, input, to be connected; it is of type Real, output"
        );
    }
}
