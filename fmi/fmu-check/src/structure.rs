//! Checks ModelStructure (FMI 2.0, section 2.2.8; FMI 3.0, section 2.4.8), and what the model
//! description says about the whole model, for `fmu_check::check`.

use std::collections::BTreeSet;

use fmi_description::Version;
use fmi_description::xml::Element;

use super::outcome::{Outcome, Promise, Report};
use super::variables::Variable;

const AREA: &str = "model description";
const WHOLE: Promise = Promise {
    text: "identity, default experiment and log categories make sense",
    why: "the guid ties description and library together; tools propose the default experiment to their users [FMI 2.0, 2.2.1, 2.2.4, 3.3.1, 4.3.1; FMI 3.0, 2.4.1, 2.4.2, 2.4.5]",
};
const OUTPUTS: Promise = Promise {
    text: "Outputs lists every output, each once, and nothing else",
    why: "importers sort their calls by it; what is not listed does not exist for them [FMI 2.0, 2.2.8; FMI 3.0, 2.4.8]",
};
const INITIAL: Promise = Promise {
    text: "InitialUnknowns lists exactly what is computed in initialization",
    why: "importers solve the initialization of a coupled system by it [FMI 2.0, 2.2.8; FMI 3.0, 2.4.8]",
};
const DEPENDENCIES: Promise = Promise {
    text: "dependencies and derivatives name variables that are there, and dependenciesKind has one word for each",
    why: "importers look for algebraic loops along them [FMI 2.0, 2.2.8; FMI 3.0, 2.4.8]",
};

/// Values of dependenciesKind, the same in both versions.
const KINDS: [&str; 5] = ["dependent", "constant", "fixed", "tunable", "discrete"];

/// The model identifiers of all interfaces.
pub fn identifiers(root: &Element) -> Vec<&str> {
    let interfaces = ["CoSimulation", "ModelExchange", "ScheduledExecution"];
    let identifiers = interfaces
        .iter()
        .filter_map(|tag| root.child(tag)?.get("modelIdentifier"));
    let unique: BTreeSet<_> = identifiers.collect();
    unique.into_iter().collect()
}

struct Structure<'a> {
    outputs: Vec<&'a Element>,
    derivatives: Vec<&'a Element>,
    initial: Vec<&'a Element>,
    /// Clocked states and event indicators of FMI 3.0.
    others: Vec<&'a Element>,
    version: Version,
}

impl<'a> Structure<'a> {
    fn new(root: &'a Element, version: Version) -> Self {
        let structure = root.child("ModelStructure");
        let elements = |parent: Option<&'a Element>, tag: &str| {
            parent.map_or_else(Vec::new, |p| p.all(tag).collect())
        };
        let list = |list: &str, tag: &str| match version {
            Version::Fmi2 => elements(structure.and_then(|s| s.child(list)), "Unknown"),
            Version::Fmi3 => elements(structure, tag),
        };
        Self {
            outputs: list("Outputs", "Output"),
            derivatives: list("Derivatives", "ContinuousStateDerivative"),
            initial: list("InitialUnknowns", "InitialUnknown"),
            others: [
                elements(structure, "ClockedState"),
                elements(structure, "EventIndicator"),
            ]
            .concat(),
            version,
        }
    }

    /// The index or value reference by which an entry names its variable.
    fn key(&self, entry: &'a Element) -> &'a str {
        let attribute = match self.version {
            Version::Fmi2 => "index",
            Version::Fmi3 => "valueReference",
        };
        entry.get(attribute).unwrap_or("")
    }

    /// The variable with this index, counted from 1, or with this value reference.
    fn at<'v>(&self, key: &str, variables: &'v [Variable<'a>]) -> Option<&'v Variable<'a>> {
        match self.version {
            Version::Fmi2 => variables.get(key.trim().parse::<usize>().ok()?.checked_sub(1)?),
            Version::Fmi3 => variables.iter().find(|v| v.reference == key.trim()),
        }
    }

    fn all<'v>(
        &self,
        list: &[&'a Element],
        variables: &'v [Variable<'a>],
    ) -> Vec<&'v Variable<'a>> {
        let found = list.iter().map(|entry| self.at(self.key(entry), variables));
        found.flatten().collect()
    }
}

/// Checks what concerns the whole model, and its structure.
pub fn check(root: &Element, variables: &[Variable], version: Version, report: &mut Report) {
    report.push(AREA, WHOLE, whole(root, version));
    let structure = Structure::new(root, version);
    report.push(AREA, DEPENDENCIES, dependencies(&structure, variables));
    let is_output = |v: &Variable| v.causality == "output";
    let outputs = structure.all(&structure.outputs, variables);
    report.push(
        AREA,
        OUTPUTS,
        compare_list(&outputs, variables, is_output, is_output),
    );
    let states = states(&structure, variables);
    let is_ticking = |v: &Variable| v.is_clocked() || v.typed.tag.as_str() == "Clock";
    let is_initial_unknown = |v: &Variable| {
        let is_computed = matches!(v.initial, "approx" | "calculated");
        let is_listed =
            matches!(v.causality, "output" | "calculatedParameter") || states.contains(v.name);
        is_computed && is_listed && v.variability != "constant" && !is_ticking(v)
    };
    let may_be = |v: &Variable| is_initial_unknown(v) || is_ticking(v);
    let initial = structure.all(&structure.initial, variables);
    report.push(
        AREA,
        INITIAL,
        compare_list(&initial, variables, is_initial_unknown, may_be),
    );
}

fn whole(root: &Element, version: Version) -> Outcome {
    let mut outcome = Outcome::default();
    let token = match version {
        Version::Fmi2 => "guid",
        Version::Fmi3 => "instantiationToken",
    };
    if root.get(token).is_none_or(|value| value.trim().is_empty()) {
        outcome.fail(format!("the {token} is empty"));
    }
    for identifier in identifiers(root) {
        let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let is_c = identifier.chars().all(is_word)
            && !identifier.starts_with(|c: char| c.is_ascii_digit());
        if !is_c || identifier.is_empty() {
            outcome.fail(format!(
                "modelIdentifier `{identifier}` must be a C identifier"
            ));
        }
    }
    if let Some(experiment) = root.child("DefaultExperiment") {
        let [start, stop, step, tolerance] = ["startTime", "stopTime", "stepSize", "tolerance"]
            .map(|a| experiment.number(a).ok().flatten());
        if stop.is_some_and(|stop| stop <= start.unwrap_or(0.0)) {
            outcome.remark("DefaultExperiment: stopTime must be after startTime");
        }
        if step.is_some_and(|step| step.is_nan() || step <= 0.0) {
            outcome.remark("DefaultExperiment: stepSize must be above 0");
        }
        if tolerance.is_some_and(|t| t.is_nan() || t <= 0.0) {
            outcome.remark("DefaultExperiment: tolerance must be above 0");
        }
    }
    let categories = root.listed("LogCategories", "Category");
    let mut seen = BTreeSet::new();
    for name in categories.filter_map(|category| category.get("name")) {
        if !seen.insert(name) {
            outcome.fail(format!("log category `{name}` is there twice"));
        }
    }
    outcome
}

/// Names of the continuous states and of their derivatives.
fn states<'a>(structure: &Structure<'a>, variables: &[Variable<'a>]) -> BTreeSet<&'a str> {
    let named = structure.all(&structure.derivatives, variables);
    let pairs = named.into_iter().flat_map(|derivative| {
        let state = derivative.typed.get("derivative");
        let state = state.and_then(|key| structure.at(key, variables));
        [Some(derivative.name), state.map(|s| s.name)]
    });
    pairs.flatten().collect()
}

/// Compares a list with the variables that must and may be in it.
fn compare_list(
    listed: &[&Variable],
    variables: &[Variable],
    must_be: impl Fn(&Variable) -> bool,
    may_be: impl Fn(&Variable) -> bool,
) -> Outcome {
    let mut outcome = Outcome::default();
    let mut seen = BTreeSet::new();
    for variable in listed {
        if !seen.insert(variable.name) {
            outcome.fail(format!("`{}` is listed twice", variable.name));
        }
        if !may_be(variable) {
            outcome.fail(format!(
                "`{}` is listed, but is {}, initial `{}`",
                variable.name, variable.causality, variable.initial
            ));
        }
    }
    let missing = |v: &&Variable| must_be(v) && !seen.contains(v.name);
    for variable in variables.iter().filter(missing) {
        outcome.fail(format!("`{}` is not listed", variable.name));
    }
    outcome
}

fn dependencies(structure: &Structure, variables: &[Variable]) -> Outcome {
    let mut outcome = Outcome::default();
    let Structure {
        outputs,
        derivatives,
        initial,
        others,
        ..
    } = structure;
    for unknown in [outputs, derivatives, initial, others]
        .into_iter()
        .flatten()
    {
        let key = structure.key(unknown);
        let Some(variable) = structure.at(key, variables) else {
            outcome.fail(format!("there is no variable {key}"));
            continue;
        };
        let name = variable.name;
        let words = |attribute| {
            let text = unknown.get(attribute);
            text.map(|t| t.split_whitespace().collect::<Vec<_>>())
        };
        let known = words("dependencies");
        let is_missing = |key: &&&str| structure.at(key, variables).is_none();
        for key in known.iter().flatten().filter(is_missing) {
            outcome.fail(format!("`{name}` depends on {key}, which is not there"));
        }
        let Some(kinds) = words("dependenciesKind") else {
            continue;
        };
        if kinds.len() != known.map_or(0, |k| k.len()) {
            outcome.fail(format!(
                "`{name}`: dependenciesKind and dependencies differ in length"
            ));
        }
        for kind in kinds.iter().filter(|kind| !KINDS.contains(*kind)) {
            outcome.fail(format!("`{name}`: there is no dependenciesKind `{kind}`"));
        }
    }
    for derivative in structure.all(derivatives, variables) {
        let state = derivative.typed.get("derivative");
        match state.map(|key| structure.at(key, variables)) {
            None => outcome.fail(format!(
                "`{}` is listed as a derivative, but does not say of what",
                derivative.name
            )),
            Some(None) => outcome.fail(format!(
                "`{}` is the derivative of a variable that is not there",
                derivative.name
            )),
            Some(Some(_)) => {}
        }
    }
    outcome
}
