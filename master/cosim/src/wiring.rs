//! The connections of a system, resolved against its FMUs' model descriptions: types, units and
//! causalities are checked here. The master plans its exchanges from them, in the order of
//! `order`; `cosim wiring`, pages and the studies read them.

mod order;
pub mod probing;
mod strong_parts;
pub(crate) mod transformation;

use std::collections::{HashMap, HashSet};
use std::ptr::from_ref;
use std::sync::{Arc, OnceLock};

use crate::structure::{Connection, Power, Structure, check_mime_types};
use crate::wiring::transformation::{Transformation, compose, unit_of};
use anyhow::{Context, Result, anyhow, bail, ensure};
use fmi_description::{
    Access, Causality, ClockInterval, Description, Interface, Kind, Variability, Variable, Version,
};
use fmi_import::batch::{Batch, Layout};
use serde::{Deserialize, Serialize};
use system_structure::{Connector, DataType};

pub use order::{Feedthrough, Undeclared};

/// A variable of a component, by indices.
#[derive(Clone, Copy, Debug, Deserialize, Eq, Hash, Ord, PartialEq, PartialOrd, Serialize)]
pub struct Port {
    /// Index of the component in the structure.
    pub component: usize,
    /// Index of the variable in its description.
    pub variable: usize,
}

impl Port {
    /// The variable with this index of the component with this index.
    pub fn new(component: usize, variable: usize) -> Self {
        Self {
            component,
            variable,
        }
    }
}

/// A resolved connection from an output to an input.
#[derive(Clone, Debug)]
pub struct Link {
    /// Output.
    pub from: Port,
    /// Input.
    pub to: Port,
    /// Transformation of the values.
    pub transformation: Transformation,
    /// Passed in initialization only.
    pub is_initial: bool,
    /// Power bond whose effort it carries.
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

/// The connections of a system, with what is needed to order them.
pub struct Wiring<'a> {
    /// Name and description of each component.
    pub(crate) components: Vec<(&'a str, &'a Description)>,
    /// The connections, in file order.
    pub links: Vec<Link>,
    /// The connections from output clocks to input clocks, in file order.
    pub clocks: Vec<[Port; 2]>,
    /// Oddities that do no harm, for the user.
    pub remarks: Vec<String>,
    /// Both ends of connections with a clocked variable at one of them.
    clocked: HashSet<Port>,
    driver: HashMap<Port, usize>,
    /// Further connections of inputs that are sums, in file order.
    further: HashMap<Port, Vec<usize>>,
    /// Connected inputs of each component, in the order of its variables.
    driven: Vec<Vec<Port>>,
    /// Layout of each component, which those of one FMU share; made when it is needed.
    layouts: Vec<Arc<OnceLock<Layout>>>,
    structure: &'a Structure,
}

/// Places by name: of the components, and of their connectors.
struct Names<'a> {
    components: HashMap<&'a str, usize>,
    connectors: HashMap<(usize, &'a str), &'a Connector>,
}

impl<'a> Wiring<'a> {
    /// Resolve the connections of `structure`; `descriptions` has one entry per component.
    pub fn new(structure: &'a Structure, descriptions: &[&'a Description]) -> Result<Self> {
        let names = structure.components.iter().map(|c| c.name.as_str());
        let mut layouts: HashMap<_, Arc<OnceLock<Layout>>> = HashMap::new();
        let mut layout = |d: &&Description| layouts.entry(from_ref(*d)).or_default().clone();
        let mut wiring = Self {
            layouts: descriptions.iter().map(&mut layout).collect(),
            components: names.zip(descriptions.iter().copied()).collect(),
            links: Vec::new(),
            clocks: Vec::new(),
            remarks: Vec::new(),
            clocked: HashSet::new(),
            driver: HashMap::new(),
            further: HashMap::new(),
            driven: vec![Vec::new(); descriptions.len()],
            structure,
        };
        // Of two of the same name the first counts.
        let components = structure.components.iter().enumerate().rev();
        let connectors = components.clone().flat_map(|(k, c)| {
            let own = c.connectors.iter().rev();
            own.map(move |connector| ((k, connector.name.as_str()), connector))
        });
        let names = Names {
            connectors: connectors.collect(),
            components: components.map(|(k, c)| (c.name.as_str(), k)).collect(),
        };
        for c in &structure.connections {
            let link = wiring.resolve(c, &names);
            let link = match c.place.is_empty() {
                true => link?,
                false => link.with_context(|| c.place.clone())?,
            };
            let Some(link) = link else { continue };
            let place = wiring.links.len();
            if *wiring.driver.entry(link.to).or_insert(place) != place {
                wiring.further.entry(link.to).or_default().push(place);
            }
            wiring.driven[link.to.component].push(link.to);
            let ends = [link.from, link.to];
            if ends
                .iter()
                .any(|port| !wiring.variable(*port).clocks.is_empty())
            {
                wiring.clocked.extend(ends);
            }
            wiring.links.push(link);
        }
        for inputs in &mut wiring.driven {
            inputs.sort();
            inputs.dedup();
        }
        Ok(wiring)
    }

    /// The link of a connection, or None if it connects clocks.
    fn resolve(&mut self, c: &Connection, names: &Names) -> Result<Option<Link>> {
        let from = self.port(&c.start, true, names)?;
        let to = self.port(&c.end, false, names)?;
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
            return self.connect_clocks(c, [from, to]).map(|()| None);
        }
        let declared = [from, to].map(|port| &self.variable(port).mime_type);
        check_mime_types(
            &format!("connection {c}"),
            [from, to].map(|p| self.name(p)),
            declared,
        )?;
        // An end without a declared unit has the unit of its FMU.
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
        let mut single_unit = None;
        let transformation = compose(&way, unit, [Some(start), Some(end)], &mut single_unit);
        let transformation = transformation.map_err(|error| {
            let mut text = error.to_string();
            if !is_declared {
                text = text.replace("the units", "the FMUs' units");
            }
            anyhow!("connection {c}: {text}")
        })?;
        if start.kind != Kind::Real && transformation.has_linear() {
            bail!(
                "connection {c}: a LinearTransformation is for Real, not for {}",
                start.kind.name()
            );
        }
        if let Some(unit) = single_unit {
            self.remarks.push(format!(
                "connection {c}: only one end has a unit, `{unit}`; values pass unchanged"
            ));
        }
        let bond = c.bond.as_ref().map(|bond| {
            let ((component, effort), [step_mean, flow]) =
                (&c.start, [&bond.step_mean, &bond.flow]);
            let port_of_start = |variable: &String, is_start| {
                let port = self.port(&(component.clone(), variable.clone()), is_start, names);
                port.with_context(|| {
                    format!("power bond of {component}.{effort}: {component}.{variable}")
                })
            };
            anyhow::Ok(BondPorts {
                step_mean: port_of_start(step_mean, true)?,
                flow: port_of_start(flow, false)?,
                power: bond.power,
            })
        });
        let bond = bond.transpose()?;
        ensure!(
            !c.is_term || start.kind == Kind::Real,
            "connection {c}: a sum is of Reals, not of {}",
            start.kind.name()
        );
        Ok(Some(Link {
            from,
            to,
            transformation,
            is_initial: c.is_initial,
            bond,
        }))
    }

    /// Adds a connection between clocks: from a triggered output clock to a triggered input clock,
    /// which no other one reaches.
    fn connect_clocks(&mut self, c: &Connection, ends: [Port; 2]) -> Result<()> {
        for (port, needed) in ends.into_iter().zip([Causality::Output, Causality::Input]) {
            let (name, v) = (self.name(port), self.variable(port));
            ensure!(
                v.causality == needed && v.element.is_none(),
                "connection {c}: `{name}` must be a single clock, {}, to be connected",
                format!("{needed:?}").to_lowercase()
            );
            let timing = v.timing.map_or(ClockInterval::Triggered, |t| t.interval);
            ensure!(
                timing == ClockInterval::Triggered,
                "connection {c}: the clock `{name}` ticks by time (intervalVariability {}); only triggered clocks can be connected",
                format!("{timing:?}").to_lowercase()
            );
            let description = self.description(port.component);
            ensure!(
                description.interface != Interface::ModelExchange
                    && description.capabilities.event_mode,
                "connection {c}: `{}` must be used by Co-Simulation with Event Mode (hasEventMode), in which alone its clock `{}` can tick",
                self.component(port.component),
                v.name
            );
        }
        ensure!(
            c.way.iter().all(|hop| hop.transformation.is_none()) && !c.is_term,
            "connection {c}: ticks of clocks pass as they are, without transformations and sums"
        );
        if let Some([other, _]) = self.clocks.iter().find(|[_, to]| *to == ends[1]) {
            let [input, first, second] = [ends[1], *other, ends[0]].map(|port| self.name(port));
            bail!("input {input} is driven twice, by {first} and by {second}");
        }
        self.clocks.push(ends);
        Ok(())
    }

    /// The variable at the start or the end of a connection; checks its declared type and its
    /// causality.
    fn port(
        &self,
        (component, variable): &(String, String),
        is_start: bool,
        names: &Names,
    ) -> Result<Port> {
        use Causality::{CalculatedParameter, Input, Local, Output, Parameter};
        let Some(k) = names.components.get(component.as_str()).copied() else {
            bail!("the system has no component `{component}`")
        };
        let description = self.components[k].1;
        let v = description.variable(variable)?;
        let connector = names.connectors.get(&(k, variable.as_str()));
        let declared = connector.and_then(|c| c.data_type);
        let kind = v.kind.name();
        let mime = connector.map_or(&None, |connector| &connector.mime_type);
        let name = format!("{component}.{variable}");
        let ends = [format!("connector {name}"), name];
        check_mime_types("in the FMU", ends, [mime, &v.mime_type])?;
        let fits = declared.is_none_or(|t| {
            t.name() == kind
                || is_whole(v) && matches!(t, DataType::Integer | DataType::Enumeration)
        });
        let is_output = matches!(v.causality, Output | CalculatedParameter | Local);
        let (needed, is_taken) = match is_start {
            true => ("output", is_output),
            false => ("input", matches!(v.causality, Input | Parameter)),
        };
        ensure!(
            fits && is_taken,
            "{component}.{variable} must be of type {}, {needed}, to be connected; it is of type {kind}, {}",
            declared.map_or(kind, DataType::name),
            format!("{:?}", v.causality).to_lowercase()
        );
        Ok(Port::new(
            k,
            description.index(variable).unwrap_or_default(),
        ))
    }

    pub(crate) fn variable(&self, p: Port) -> &'a Variable {
        &self.components[p.component].1.variables[p.variable]
    }

    /// Whether a connection of this variable has a clocked one at an end.
    pub(crate) fn passes_at_ticks(&self, p: Port) -> bool {
        self.clocked.contains(&p)
    }

    /// `component.variable`.
    pub fn name(&self, p: Port) -> String {
        format!("{}.{}", self.component(p.component), self.variable(p).name)
    }

    /// Name of a component.
    pub(crate) fn component(&self, index: usize) -> &str {
        self.components[index].0
    }

    /// The functions that read and write a variable.
    pub(crate) fn access(&self, p: Port) -> Access {
        self.variable(p).access()
    }

    /// Whether a variable is a continuous Real.
    pub(crate) fn is_continuous(&self, p: Port) -> bool {
        let v = self.variable(p);
        v.kind == Kind::Real && v.variability == Variability::Continuous
    }

    /// A batch that reads or writes variables of a component together.
    pub(crate) fn batch(&self, component: usize, variables: impl Iterator<Item = usize>) -> Batch {
        let description = self.description(component);
        let layout = self.layouts[component].get_or_init(|| Layout::new(description));
        Batch::new(description, layout, variables.collect())
    }

    /// Description of a component.
    pub(crate) fn description(&self, component: usize) -> &Description {
        self.components[component].1
    }

    /// Index in [`Wiring::links`] of the connection that drives an input.
    pub fn driver(&self, input: Port) -> Option<usize> {
        self.driver.get(&input).copied()
    }

    /// The connections of an input: more than one if it is their sum.
    pub(crate) fn terms(&self, input: Port) -> impl Iterator<Item = &Link> {
        let further = self.further.get(&input).into_iter().flatten();
        let all = self.driver.get(&input).into_iter().chain(further);
        all.map(|link| &self.links[*link])
    }

    /// The output that drives an input.
    pub fn source(&self, input: Port) -> Option<Port> {
        self.driver(input).map(|link| self.links[link].from)
    }

    /// Whether an output can be read only once at a communication point, right after the step and
    /// before inputs are set: because its dependencies are not declared, or because its FMU of
    /// FMI 3.0 has no Event Mode, without which an output cannot be read after an input was set.
    pub fn is_read_once(&self, output: Port) -> bool {
        let description = self.description(output.component);
        let has_events = description.fmi == Version::Fmi2 || description.capabilities.event_mode;
        let depends = || description.dependence(output.variable, false);
        let mut trusted = self.structure.feedthrough.iter();
        let mut is_trusted = || trusted.any(|name| name == self.component(output.component));
        !(has_events && (depends().is_some() || is_trusted()))
    }
}

/// Integers and enumerations, which pass as integers.
fn is_whole(v: &Variable) -> bool {
    matches!(v.kind, Kind::Integer | Kind::Enumeration(_))
}

#[cfg(test)]
mod tests {
    use super::order::REMEDY;
    use super::*;

    const FEEDTHROUGH: Feedthrough = Feedthrough {
        is_initial: false,
        undeclared: Undeclared::All,
    };

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
        assert_eq!(wiring.levels(FEEDTHROUGH).unwrap(), [0, 1, 2, 2]);
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
            .levels(FEEDTHROUGH)
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
