//! Connections of a system of the Open Simulation Platform, of variables and groups, also through
//! functions, as connections between variables for [`super::convert`].

use std::collections::{BTreeMap, HashSet};

use fmi_description::xml::{Element, XmlError};
use fmi_description::{Causality, Kind, Unit};

use super::groups::Group;
use super::simulator::{Simulator, parts, unknown};

/// A simulator and a variable of it.
type End = (usize, String);

/// A connection of two variables.
pub(super) struct Wire {
    pub from: End,
    pub to: End,
    /// Factor and offset.
    pub linear: Option<[f64; 2]>,
    /// Its values are added to those of the other connections of the same input.
    pub is_term: bool,
}

/// A variable with the unit that a group gives it.
type Variable = (End, Option<Unit>);

/// Ends of the connections of one signal of a function, each with its element.
type Ends<'a> = Vec<(Vec<Variable>, &'a Element)>;

struct Connections<'a> {
    simulators: &'a [Simulator],
    wires: Vec<Wire>,
    /// Inputs that a variable or a function drives.
    driven: HashSet<End>,
    remarks: &'a mut Vec<String>,
}

/// Reads `Functions` and `Connections` of the structure.
pub(super) fn read(
    root: &Element,
    simulators: &[Simulator],
    remarks: &mut Vec<String>,
) -> Result<Vec<Wire>, XmlError> {
    let kinds = ["Variable", "Signal", "VariableGroup", "SignalGroup"];
    let kinds = kinds.map(|kind| format!("{kind}Connection"));
    let mut read = Connections {
        simulators,
        wires: Vec::new(),
        driven: HashSet::new(),
        remarks,
    };
    let mut signals: BTreeMap<(String, String), Ends> = BTreeMap::new();
    for node in parts(root, "Connections", &kinds.each_ref().map(|kind| &**kind))? {
        let is_group = node.tag.contains("Group");
        let (of_variables, of_signals) = match is_group {
            true => ("VariableGroup", "SignalGroup"),
            false => ("Variable", "Signal"),
        };
        let tags = node.children.iter().map(|child| child.tag.as_str());
        let mut tags: Vec<&str> = tags.collect();
        tags.sort_unstable();
        let expected = match node.tag.starts_with("Signal") {
            true => [of_signals, of_variables],
            false => [of_variables; 2],
        };
        if tags != expected {
            let [a, b] = expected;
            let text = format!("{} must have two ends, {a} and {b}", node.tag);
            return Err(node.error(text));
        }
        let mut variables = node.all(of_variables);
        let ends = variables.clone().map(|end| read.end(end, is_group));
        let ends = ends.collect::<Result<Vec<_>, _>>()?;
        if let (Some(signal), Some(end)) = (node.child(of_signals), ends.first()) {
            let key = (signal.required("function")?, signal.required("name")?);
            let all = signals.entry(key).or_default();
            all.push((end.clone(), signal));
        } else if let ([a, b], Some(first), Some(second)) =
            (&ends[..], variables.next(), variables.next())
        {
            if is_group {
                read.check_groups(node, first, second)?;
            }
            for (a, b) in a.iter().zip(b) {
                let [a, b] = match read.gives(a, node)? {
                    true => [a, b],
                    false => [b, a],
                };
                read.drive(b, node)?;
                read.connect(a, b, None, false, node)?;
            }
        }
    }
    let functions = ["LinearTransformation", "Sum", "VectorSum"];
    for function in parts(root, "Functions", &functions)? {
        read.function(function, &mut signals)?;
    }
    match signals.iter().next() {
        None => Ok(read.wires),
        Some(((function, name), ends)) => Err(ends[0]
            .1
            .error(format!("no function `{function}` has a signal `{name}`"))),
    }
}

impl Connections<'_> {
    /// The variables at an end of a connection.
    fn end(&self, node: &Element, is_group: bool) -> Result<Vec<Variable>, XmlError> {
        let (owner, name) = (node.required("simulator")?, node.required("name")?);
        let place = self.simulators.iter().position(|s| s.name == owner);
        let Some(k) = place else {
            let names = self.simulators.iter().map(|s| &*s.name);
            return Err(node.error(format!(
                "the system has no simulator `{owner}`, only {}",
                names.collect::<Vec<_>>().join(", ")
            )));
        };
        let simulator = &self.simulators[k];
        if !is_group {
            simulator.variable(&name, node)?;
            return Ok(vec![((k, name), None)]);
        }
        let group = self.group(node)?;
        let all = group.all().into_iter().map(|(variable, unit)| {
            simulator.variable(variable, node)?;
            Ok(((k, variable.clone()), unit.clone()))
        });
        all.collect()
    }

    fn group(&self, node: &Element) -> Result<&Group, XmlError> {
        let (owner, name) = (node.text("simulator"), node.text("name"));
        let mut simulators = self.simulators.iter();
        let own = simulators.find(|s| s.name == owner);
        let groups = own.map_or(&[][..], |simulator| &simulator.groups);
        Group::find(groups, &name).ok_or_else(|| {
            let model = own.map_or("", |simulator| &simulator.model.description.model);
            node.error(match groups {
                [] => format!(
                    "simulator `{owner}` has no groups: there is no `{model}_OspModelDescription.xml` next to its FMU, next to the structure or in the FMU"
                ),
                _ => format!(
                    "simulator `{owner}` has no group `{name}`, only {}",
                    Group::names(groups).join(", ")
                ),
            })
        })
    }

    fn check_groups(&self, node: &Element, a: &Element, b: &Element) -> Result<(), XmlError> {
        let [first, second] = [self.group(a)?, self.group(b)?];
        match first.is_like(second) {
            true => Ok(()),
            false => Err(node.error(format!(
                "the groups `{}` of `{}` and `{}` of `{}` differ in the number of their variables or groups",
                first.name,
                a.text("simulator"),
                second.name,
                b.text("simulator")
            ))),
        }
    }

    /// Whether a variable gives values.
    fn gives(&self, (end, _): &Variable, node: &Element) -> Result<bool, XmlError> {
        use Causality::{CalculatedParameter, Output};
        let variable = self.simulators[end.0].variable(&end.1, node)?;
        Ok(matches!(variable.causality, Output | CalculatedParameter))
    }

    /// Notes that something drives an input, which nothing else may.
    fn drive(&mut self, (end, _): &Variable, node: &Element) -> Result<(), XmlError> {
        let (owner, name) = (&self.simulators[end.0].name, &end.1);
        match self.driven.insert(end.clone()) {
            true => Ok(()),
            false => Err(node.error(format!("input `{owner}.{name}` has two connections"))),
        }
    }

    fn connect(
        &mut self,
        from: &Variable,
        to: &Variable,
        linear: Option<[f64; 2]>,
        is_term: bool,
        node: &Element,
    ) -> Result<(), XmlError> {
        let name =
            |((k, variable), _): &Variable| format!("{}.{variable}", self.simulators[*k].name);
        let (a, b) = (name(from), name(to));
        let variable = |((k, name), _): &Variable| self.simulators[*k].variable(name, node);
        let (start, end) = (variable(from)?, variable(to)?);
        if !self.gives(from, node)?
            || !matches!(end.causality, Causality::Input | Causality::Parameter)
        {
            let [x, y] = [start, end].map(|v| format!("{:?}", v.causality).to_lowercase());
            return Err(node.error(format!(
                "`{a}` is {x} and `{b}` is {y}; a connection needs an output and an input"
            )));
        }
        let whole = |kind: &Kind| matches!(kind, Kind::Integer | Kind::Enumeration(_));
        let [x, y] = [&start.kind, &end.kind];
        let is_real = *x == Kind::Real && *y == Kind::Real;
        let is_function = linear.is_some() || is_term;
        if x.name() != y.name() && !(whole(x) && whole(y)) || is_function && !is_real {
            let [x, y] = [x.name(), y.name()];
            let needed = match is_function {
                true => "functions are for Reals",
                false => "both ends of a connection must have one type",
            };
            return Err(node.error(format!("`{a}` is {x} and `{b}` is {y}; {needed}")));
        }
        let unit = |((k, _), unit): &Variable, v: &fmi_description::Variable| {
            let own = v.unit.as_ref();
            let own = own.map(|name| self.simulators[*k].model.description.unit(name));
            unit.clone().or(own)
        };
        if let (Some(x), Some(y)) = (unit(from, start), unit(to, end))
            && (x.factor, x.offset, x.exponents) != (y.factor, y.offset, y.exponents)
            && x.exponents.is_some()
            && y.exponents.is_some()
            && !is_function
        {
            self.remarks.push(format!(
                "connection {a} -> {b}: the units differ, `{}` and `{}`; values pass unchanged, as in the Open Simulation Platform",
                x.name, y.name
            ));
        }
        self.wires.push(Wire {
            from: from.0.clone(),
            to: to.0.clone(),
            linear,
            is_term,
        });
        Ok(())
    }

    /// Connects the ends of a function's signals, and takes these out of `signals`.
    fn function(
        &mut self,
        node: &Element,
        signals: &mut BTreeMap<(String, String), Ends>,
    ) -> Result<(), XmlError> {
        let name = node.required("name")?;
        let mut linear = None;
        let inputs = match node.tag.as_str() {
            "LinearTransformation" => {
                let (factor, offset) = (node.finite("factor")?, node.finite("offset")?);
                linear = Some([factor.unwrap_or(1.0), offset.unwrap_or(0.0)]);
                vec!["in".to_string()]
            }
            "Sum" | "VectorSum" => {
                let count: u16 = node.must("inputCount", node.whole("inputCount")?)?;
                if count == 0 {
                    return Err(node.wrong("has inputCount = 0; it must have inputs"));
                }
                (0..count).map(|k| format!("in[{k}]")).collect()
            }
            _ => return Err(unknown(node)),
        };
        let mut size = 1;
        if node.tag == "VectorSum" {
            size = node.must("dimension", node.whole("dimension")?)?;
        }
        let mut take = |signal: &str| {
            let missing = || node.wrong(format!("has no connection to its signal `{signal}`"));
            let ends = signals.remove(&(name.clone(), signal.to_string()));
            let ends = ends.ok_or_else(missing)?;
            for (end, place) in &ends {
                if end.len() != size || (place.tag == "SignalGroup") != (node.tag == "VectorSum") {
                    return Err(place.error(format!(
                        "signal `{signal}` of the {} `{name}` takes {size} variables, as a {}; this has {}, as a {}",
                        node.tag,
                        if node.tag == "VectorSum" { "SignalGroup" } else { "Signal" },
                        end.len(),
                        place.tag
                    )));
                }
            }
            Ok(ends)
        };
        let mut sources = Vec::new();
        for signal in &inputs {
            let ends = take(signal)?;
            let [(end, place)] = &ends[..] else {
                let text = format!(
                    "signal `{signal}` of `{name}` has {} connections",
                    ends.len()
                );
                return Err(ends[1].1.error(text));
            };
            sources.push((end.clone(), *place));
        }
        for (targets, place) in take("out")? {
            for (k, target) in targets.iter().enumerate() {
                self.drive(target, place)?;
                let is_term = linear.is_none() && sources.len() > 1;
                for (source, place) in &sources {
                    self.connect(&source[k], target, linear, is_term, place)?;
                }
            }
        }
        Ok(())
    }
}
