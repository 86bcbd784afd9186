//! Rows of a model with a clock: mistakes are named, and clocks follow all variables.

use std::cell::Cell;

use fmu_export::{
    Clock, Info, InputPolynomial, Model, ModelError, StepEnd, Variable, check, model_description3,
};
use serde::{Deserialize, Serialize};

thread_local! {
    /// The table that the model has just now.
    static CHOSEN: Cell<usize> = const { Cell::new(0) };
}

#[derive(Clone, Serialize, Deserialize)]
struct Clocked;

type Parameters = ();
type Input = ();

#[derive(Clone, Copy, Default)]
struct Output {
    a: f64,
    b: f64,
    n: i32,
}

type V = Variable<Clocked>;

const fn a() -> V {
    let a = V::output("a", "sum", |y| &y.a).discrete();
    a.clocks(&["tick"]).depends_on(&[])
}

const fn b() -> V {
    V::output("b", "sum before", |y| &y.b).depends_on(&[])
}

const fn n() -> V {
    let n = V::integer_output("n", "number", |y| &y.n);
    n.clocks(&["tick"]).depends_on(&[])
}

const PREVIOUS: &str = "it must belong to a clock, and";

/// Tables and what is said of them; the first two are right.
#[rustfmt::skip]
const TABLES: &[(&[V], &str)] = &[
    (&[a().previous("b"), b().discrete().clocks(&["tick"]), n()], ""),
    (&[a().at(7), n().at(3)], ""),
    (&[a().clocks(&["tock"])], "variable `a` belongs to `tock`, which is not a clock of the model"),
    (&[b().clocks(&["tick"])], "variable `b` belongs to a clock and is continuous; it must be discrete"),
    (&[a().previous("c"), n()], PREVIOUS),
    (&[a().previous("n"), n()], PREVIOUS),
    (&[a().previous("a"), n()], PREVIOUS),
    (&[a().previous("b"), b()], PREVIOUS),
    (&[b().discrete().previous("a"), a()], PREVIOUS),
];

#[test]
fn mistakes_with_clocks_are_named() {
    for (k, (_, said)) in TABLES.iter().enumerate() {
        CHOSEN.set(k);
        match (*said, &check::<Clocked>()[..]) {
            ("", found) => assert_eq!(found, [""; 0], "table {k}"),
            (said, [found]) => assert!(found.contains(said), "table {k}: `{found}`"),
            (said, found) => panic!("table {k}: {found:?}, must be: {said}"),
        }
    }
}

/// A clock has the first value reference behind all variables, also where the last one is in a gap.
#[test]
fn clocks_follow_all_variables() {
    CHOSEN.set(1);
    let xml = model_description3::<Clocked>().unwrap();
    assert!(
        xml.contains("<Clock name=\"tick\" valueReference=\"8\""),
        "{xml}"
    );
}

impl Model for Clocked {
    type Parameters = ();
    type Input = ();
    type Output = Output;
    type Evaluation = ();
    const INFO: Info = Info::new("Clocked", "tables with one mistake each");
    const CLOCKS: &'static [Clock<Self>] =
        &[Clock::constant("tick", "samples", 0.1, |_, _, _, _| Ok(()))];

    fn variables() -> &'static [V] {
        TABLES[CHOSEN.get()].0
    }

    fn defaults() -> ((), ()) {
        ((), ())
    }

    idle_model!();
}
