//! Compares which outputs and derivatives move at once with an input or a state with what
//! ModelStructure declares, for the probes of `values` and `exchange`.

use fmi_description::Description;

use crate::outcome::Outcome;

/// Values of computed variables: the index of the variable, and the value as its bits or a text.
pub type Computed<T> = Vec<(usize, T)>;

/// Reports the variables that differ `after` the variable with the index `known` was moved, and
/// are as `before` `again`, once it has moved back, but do not declare that they depend on it.
/// Returns their number, with those that declare it.
pub fn compare<T: PartialEq>(
    description: &Description,
    known: usize,
    [before, after, again]: [&Computed<T>; 3],
    initially: bool,
    outcome: &mut Outcome,
) -> usize {
    let variables = &description.variables;
    let place = |k: usize| (variables[k].access(), variables[k].reference);
    let is_declared = |unknown: usize| {
        let mut derivatives = description.derivatives.iter();
        let known_of = match derivatives.find(|d| d.variable == unknown) {
            Some(derivative) if !initially => derivative.dependencies.as_deref(),
            _ => description.dependence(unknown, initially),
        };
        known_of.is_none_or(|list| list.iter().any(|k| place(*k) == place(known)))
    };
    let mut acting = 0;
    for ((before, after), again) in before.iter().zip(after).zip(again) {
        // An output that is a state need not say that it depends on itself.
        if before == after || before != again || place(before.0) == place(known) {
            continue;
        }
        acting += 1;
        if !is_declared(before.0) {
            let when = if initially { " in initialization" } else { "" };
            let [known, unknown] = [known, before.0].map(|k| &variables[k].name);
            outcome.fail(format!(
                "`{known}` acts on `{unknown}`{when}, which does not list it"
            ));
        }
    }
    outcome.fails.dedup();
    acting
}
