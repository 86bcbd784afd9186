//! Mistakes in a table of variables are found before an FMU is made, and named.

use std::cell::Cell;

use fmu_export::{
    Enumeration, Info, InputPolynomial, Model, ModelError, StepEnd, Unit, Variable, check,
};
use serde::{Deserialize, Serialize};

thread_local! {
    /// The table that the model has just now. A type for each would be compiled forty times.
    static CHOSEN: Cell<usize> = const { Cell::new(0) };
}

/// A model with the wrong table that is chosen.
#[derive(Clone, Serialize, Deserialize)]
struct Wrong;

#[derive(Clone, Serialize, Deserialize)]
struct Parameters {
    p: f64,
    text: String,
    n: i32,
}

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Input {
    u: [f64; 2],
    v: f64,
    w: f64,
}

#[derive(Clone, Copy, Default)]
struct Output {
    y: [f64; 3],
    n: i32,
}

type V = Variable<Wrong>;
const ENUMERATION: Enumeration =
    Enumeration::new("E", "two items", &[("a", "first"), ("b", "second")]);

const OTHER: Enumeration = Enumeration::new("E", "one item", &[("a", "first")]);
const TWICE: Enumeration = Enumeration::new("E", "one name", &[("a", "first"), ("a", "second")]);
const EMPTY: Enumeration = Enumeration::new("Empty", "nothing", &[]);
const FURLONG: Unit = Unit::new("furlong").m(1).factor(201.168);
const LONGER: Unit = Unit::new("furlong").m(1).factor(201.169);

const fn u(name: &'static str) -> V {
    V::inputs(name, "input", |u| &u.u, |u| &mut u.u)
}

const fn y() -> V {
    V::outputs("y", "output", |y| &y.y)
}

const fn p() -> V {
    V::parameter("p", "parameter", |p| &p.p, |p| &mut p.p)
}

const fn n() -> V {
    V::integer_parameter("n", "number", |p| &p.n, |p| &mut p.n)
}

const fn text() -> V {
    V::string_parameter(
        "text",
        "text",
        |p| &p.text,
        |p, text, _| {
            text.clone_into(&mut p.text);
            Ok(())
        },
    )
}

/// Tables and what is said of them; the first is right.
#[rustfmt::skip]
const TABLES: &[(&[V], &str)] = &[
    (&[u("u"), y().depends_on(&["u[2]"]).initially_depends_on(&["u", "p"]), p(), n().enumeration(&ENUMERATION), text()], ""),
    (&[u("u"), p(), u("u")],                            "variable `u[1]`: is in the table twice"),
    (&[u("a b")],                                       "variable `a b[1]`: is not a structured name"),
    (&[u("u").unit("furlong")],                         "unit `furlong` is no expression of units such as `m3/(s.Pa)`, and not in Info::units"),
    (&[u("u").unit("rad").display_unit("mm")],          "display unit `mm` is not one of unit `rad`"),
    (&[u("u").display_unit("mm")],                      "display unit `mm` without a unit"),
    (&[p().min(2.0)],                                   "variable `p`: start value 1 must be finite and at least 2"),
    (&[p().min(2.0).max(1.0)],                          "min = 2 and max = 1 are not valid bounds"),
    (&[n().max(2.5)],                                   "min = -inf and max = 2.5 are not valid bounds"),
    (&[u("u").nominal(0.0)],                            "nominal = 0 must be finite and > 0"),
    (&[u("u").tunable()],                               "only parameters can be tunable, except String parameters with a setter"),
    (&[text().tunable()],                               "only parameters can be tunable, except String parameters with a setter"),
    (&[p().discrete()],                                 "only a Real that is not a parameter can be declared discrete"),
    (&[p().enumeration(&ENUMERATION)],                  "only an Integer row can have an enumeration"),
    (&[n().unit("m")],                                  "only a Real has a unit or a nominal value"),
    (&[u("u"), y().depends_on(&["v"])],                 "variable `y[1]`: depends on `v`; it must be an input of the table"),
    (&[u("u"), p(), y().depends_on(&["p"])],            "depends on `p`; it must be an input of the table"),
    (&[u("u"), y().depends_on(&["u[i]"])],              "variable `y[3]`: depends on `u[i]`"),
    (&[u("u"), y().depends_on(&["u[0]"])],              "depends on `u[0]`"),
    (&[y().initially_depends_on(&["y"])],               "depends on `y`; it must be an input or parameter of the table"),
    (&[u("u"), y().each_depends_on(&[&["u"], &[]])],    "variable `y[3]`: has 2 lists of dependencies, fewer than elements"),
    (&[u("u").depends_on(&[])],                         "only outputs have dependencies"),
    (&[V::integer_output("n", "", |y| &y.n)],           "variable `n`: has no description"),
    (&[u("u").each_unit(&["m"])],                       "variable `u[2]`: has units for 1 elements only"),
    (&[u("u").each_unit(&["m"; 257])],                  "variable `u`: is a long row, which must be a vector with one unit"),
    (&[p().at(7), n(), u("u").at(8)],                   "variable `u[1]`: value reference 8 is already that of `n`"),
    (&[p().at(70000)],                                  "variable `p`: value reference 70000 must be at most 65535"),
    (&[u("u").at(65535)],                               "variable `u[2]`: value reference 65536 must be at most 65535"),
    (&[p().own_unit(&FURLONG), u("u").own_unit(&LONGER)], "variable `u[1]`: unit `furlong` is defined differently for `p`"),
    (&[V::inputs("none", "of length 0", |_| &[], |_| &mut [])], "variable `none`: has no elements"),
    (&[n().enumeration(&TWICE)],                        "variable `n`: enumeration `E` has the item `a` twice"),
    (&[n().enumeration(&ENUMERATION), V::integer_output("m", "other", |y| &y.n).enumeration(&OTHER)], "variable `m`: enumeration `E` is defined differently for `n`"),
    (&[n().enumeration(&EMPTY)],                        "variable `n`: enumeration `Empty` has no items"),
    (&[V::integer_output("m", "no item", |y| &y.n).enumeration(&ENUMERATION)], "`m` = 0 with the start values must be 1 (a) or 2 (b)"),
    (&[V::string_parameter("text", "kept nowhere", |p| &p.text, |_, _, _| Ok(()))], "`text`: its accessors are of different fields"),
    (&[text(), V::string_parameter("z", "the same", |p| &p.text, |p, text, _| { text.clone_into(&mut p.text); Ok(()) })], "`text` and `z` share a field"),
    (&[V::calculated_parameter("c", "calculated", |y| &y.y[0]).depends_on(&[])], "variable `c`: only outputs have dependencies"),
    (&[V::constant("g", "gravity", |_| &9.80665).tunable()], "variable `g`: only parameters can be tunable, except String parameters with a setter"),
    (&[V::constant("g", "gravity", |_| &9.80665).discrete()], "variable `g`: only a Real that is not a parameter can be declared discrete"),
    (&[u("u"), V::input("v", "input", |u| &u.v, |u| &mut u.v), V::input("w", "its rate", |u| &u.w, |u| &mut u.w).rate_of("v")], ""),
    (&[u("u"), V::input("w", "its rate", |u| &u.w, |u| &mut u.w).rate_of("u")], "variable `w`: it is the rate of `u`, which must be a continuous Real of the same causality and length"),
    (&[V::integer_output("n", "number", |y| &y.n), V::input("w", "its rate", |u| &u.w, |u| &mut u.w).rate_of("n")], "it is the rate of `n`"),
    (&[n().min(2.0)],                                   "variable `n`: start value 1 must be finite and at least 2"),
];

#[test]
fn mistakes_are_named() {
    for (k, (_, said)) in TABLES.iter().enumerate() {
        CHOSEN.set(k);
        match (*said, &check::<Wrong>()[..]) {
            ("", found) => assert_eq!(found, [""; 0]),
            (said, [found]) => {
                assert!(found.contains(said), "`{found}` lacks `{said}`");
                // The row is named.
                assert!(
                    found.starts_with("variable `") || found.starts_with('`'),
                    "{found}"
                );
            }
            (said, found) => panic!("table {k}: {found:?}, must be: {said}"),
        }
    }
}

impl Model for Wrong {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = ();
    const INFO: Info = Info::new("Wrong", "tables with one mistake each");

    fn variables() -> &'static [V] {
        TABLES[CHOSEN.get()].0
    }

    fn defaults() -> (Parameters, Input) {
        (
            Parameters {
                p: 1.0,
                text: String::new(),
                n: 1,
            },
            Input::default(),
        )
    }

    idle_model!();
}
