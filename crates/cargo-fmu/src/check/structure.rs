//! ModelStructure of FMI 2.0 (section 2.2.8), and what a model description says of the whole model.

use std::collections::BTreeSet;

use super::outcome::{Outcome, Promise, Report};
use super::variables::Variable;
use super::xml::Element;

const AREA: &str = "model description";
const WHOLE: Promise = Promise {
    text: "identity, default experiment and log categories make sense",
    why: "the guid ties description and library together; tools propose the default experiment to their users",
};
const OUTPUTS: Promise = Promise {
    text: "Outputs lists every output, each once, and nothing else",
    why: "importers sort their calls by it; what is not listed is thought not to exist",
};
const INITIAL: Promise = Promise {
    text: "InitialUnknowns lists exactly what is computed in initialization",
    why: "importers solve the initialization of a coupled system by it",
};
const DEPENDENCIES: Promise = Promise {
    text: "dependencies and derivatives name variables that are there, and dependenciesKind has one word for each",
    why: "importers look for algebraic loops along them",
};

/// Identifiers that an interface type may have.
pub fn identifiers<'a>(root: Element<'a>) -> Vec<&'a str> {
    let interfaces = ["CoSimulation", "ModelExchange", "ScheduledExecution"];
    let identifiers = interfaces
        .iter()
        .filter_map(|tag| root.child(tag)?.get("modelIdentifier"));
    let unique: BTreeSet<_> = identifiers.collect();
    unique.into_iter().collect()
}

/// Check what concerns the whole model, and its structure.
pub fn check(root: Element, variables: &[Variable], report: &mut Report) {
    report.push(AREA, WHOLE, whole(root));
    let structure = root.child("ModelStructure");
    let list = |tag: &str| -> Vec<Element> {
        let list = structure.and_then(|s| s.child(tag));
        list.map_or_else(Vec::new, |l| l.all("Unknown").collect())
    };
    let (outputs, derivatives, initial) = (
        list("Outputs"),
        list("Derivatives"),
        list("InitialUnknowns"),
    );
    let all = [outputs.as_slice(), &derivatives, &initial].concat();
    report.push(
        AREA,
        DEPENDENCIES,
        dependencies(&all, &derivatives, variables),
    );
    let is_output = |v: &Variable| v.causality == "output";
    report.push(AREA, OUTPUTS, exactly(&outputs, variables, is_output));
    let states = states(&derivatives, variables);
    let is_initial_unknown = |v: &Variable| {
        let is_computed = matches!(v.initial, "approx" | "calculated");
        let is_listed =
            matches!(v.causality, "output" | "calculatedParameter") || states.contains(v.name);
        is_computed && is_listed && v.variability != "constant"
    };
    report.push(
        AREA,
        INITIAL,
        exactly(&initial, variables, is_initial_unknown),
    );
}

fn whole(root: Element) -> Outcome {
    let mut outcome = Outcome::default();
    if root.get("guid").is_none_or(|guid| guid.trim().is_empty()) {
        outcome.fail("the guid is empty");
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
        let [start, stop, step, tolerance] =
            ["startTime", "stopTime", "stepSize", "tolerance"].map(|a| experiment.number(a));
        if stop.is_some_and(|stop| stop <= start.unwrap_or(0.0)) {
            outcome.fail("DefaultExperiment: stopTime must be after startTime");
        }
        if step.is_some_and(|step| step.is_nan() || step <= 0.0) {
            outcome.fail("DefaultExperiment: stepSize must be above 0");
        }
        if tolerance.is_some_and(|t| t.is_nan() || t <= 0.0) {
            outcome.fail("DefaultExperiment: tolerance must be above 0");
        }
    }
    let categories = root.child("LogCategories");
    let names = categories
        .into_iter()
        .flat_map(|l| l.all("Category").collect::<Vec<_>>());
    let mut seen = BTreeSet::new();
    for name in names.filter_map(|c| c.get("name")) {
        if !seen.insert(name) {
            outcome.fail(format!("log category `{name}` is there twice"));
        }
    }
    outcome
}

/// The variable that an index, counted from 1, names.
fn at<'v, 'a>(index: &str, variables: &'v [Variable<'a>]) -> Option<&'v Variable<'a>> {
    variables.get(index.trim().parse::<usize>().ok()?.checked_sub(1)?)
}

/// Names of the continuous states of co-simulation and model exchange, and their derivatives.
fn states<'a>(derivatives: &[Element], variables: &[Variable<'a>]) -> BTreeSet<&'a str> {
    let named = derivatives
        .iter()
        .filter_map(|d| at(d.get("index")?, variables));
    let pairs = named.flat_map(|derivative| {
        let state = derivative
            .typed
            .get("derivative")
            .and_then(|index| at(index, variables));
        [Some(derivative.name), state.map(|s| s.name)]
    });
    pairs.flatten().collect()
}

fn exactly(
    listed: &[Element],
    variables: &[Variable],
    belongs: impl Fn(&Variable) -> bool,
) -> Outcome {
    let mut outcome = Outcome::default();
    let mut seen = BTreeSet::new();
    for variable in listed.iter().filter_map(|u| at(u.get("index")?, variables)) {
        if !seen.insert(variable.name) {
            outcome.fail(format!("`{}` is listed twice", variable.name));
        }
        if !belongs(variable) {
            outcome.fail(format!(
                "`{}` is listed, but is {}, initial `{}`",
                variable.name, variable.causality, variable.initial
            ));
        }
    }
    for variable in variables
        .iter()
        .filter(|v| belongs(v) && !seen.contains(v.name))
    {
        outcome.fail(format!("`{}` is not listed", variable.name));
    }
    outcome
}

fn dependencies(all: &[Element], derivatives: &[Element], variables: &[Variable]) -> Outcome {
    let mut outcome = Outcome::default();
    for unknown in all {
        let index = unknown.get("index").unwrap_or("");
        let Some(variable) = at(index, variables) else {
            outcome.fail(format!("there is no variable number {index}"));
            continue;
        };
        let words = |attribute| {
            unknown
                .get(attribute)
                .map(|t| t.split_whitespace().collect::<Vec<_>>())
        };
        let known = words("dependencies");
        for index in known
            .iter()
            .flatten()
            .filter(|i| at(i, variables).is_none())
        {
            outcome.fail(format!(
                "`{}` depends on number {index}, which is not there",
                variable.name
            ));
        }
        if let Some(kinds) = words("dependenciesKind")
            && kinds.len() != known.map_or(0, |k| k.len())
        {
            outcome.fail(format!(
                "`{}`: dependenciesKind and dependencies differ in length",
                variable.name
            ));
        }
    }
    for derivative in derivatives
        .iter()
        .filter_map(|d| at(d.get("index")?, variables))
    {
        let state = derivative
            .typed
            .get("derivative")
            .map(|index| at(index, variables));
        match state {
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
