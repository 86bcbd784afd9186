//! Mistakes in a table of variables are found before an FMU is made, and named.

use fmu_export::{
    Enumeration, Info, InputPolynomial, Model, ModelError, StepEnd, Unit, Variable, check,
};
use serde::{Deserialize, Serialize};

/// A model with the `K`-th wrong table.
#[derive(Clone, Serialize, Deserialize)]
struct Wrong<const K: usize>;

#[derive(Clone, Serialize, Deserialize)]
struct Parameters {
    p: f64,
    text: String,
    n: i32,
}

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Input {
    u: [f64; 2],
}

#[derive(Clone, Copy, Default)]
struct Output {
    y: [f64; 3],
    n: i32,
}

type V<const K: usize> = Variable<Wrong<K>>;
const ENUMERATION: Enumeration =
    Enumeration::new("E", "two items", &[("a", "first"), ("b", "second")]);

const OTHER: Enumeration = Enumeration::new("E", "one item", &[("a", "first")]);
const TWICE: Enumeration = Enumeration::new("E", "one name", &[("a", "first"), ("a", "second")]);
const EMPTY: Enumeration = Enumeration::new("Empty", "nothing", &[]);
const FURLONG: Unit = Unit::new("furlong").m(1).factor(201.168);
const LONGER: Unit = Unit::new("furlong").m(1).factor(201.169);

const fn u<const K: usize>(name: &'static str) -> V<K> {
    V::inputs(name, "input", |u| &u.u, |u| &mut u.u)
}

const fn y<const K: usize>() -> V<K> {
    V::outputs("y", "output", |y| &y.y)
}

const fn p<const K: usize>() -> V<K> {
    V::parameter("p", "parameter", |p| &p.p, |p| &mut p.p)
}

const fn n<const K: usize>() -> V<K> {
    V::integer_parameter("n", "number", |p| &p.n, |p| &mut p.n)
}

const fn text<const K: usize>() -> V<K> {
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
macro_rules! tables {
    ($($k:literal $rows:expr, $said:literal;)*) => {
        impl<const K: usize> Wrong<K> {
            fn table() -> &'static [V<K>] {
                match K {
                    $($k => const { &$rows },)*
                    _ => &[],
                }
            }
        }

        #[test]
        fn mistakes_are_named() {
            $(match ($said, &check::<Wrong<$k>>()[..]) {
                ("", found) => assert_eq!(found, [""; 0]),
                (said, [found]) => {
                    assert!(found.contains(said), "`{found}` lacks `{said}`");
                    // The row is named.
                    assert!(found.starts_with("variable `") || found.starts_with('`'), "{found}");
                }
                (said, found) => panic!("table {}: {found:?}, must be: {said}", $k),
            })*
        }
    };
}

#[rustfmt::skip]
tables! {
    0  [u("u"), y().depends_on(&["u[2]"]).initially_depends_on(&["u", "p"]), p(), n().enumeration(&ENUMERATION), text()], "";
    1  [u("u"), p(), u("u")],                            "variable `u[1]`: is in the table twice";
    2  [u("a b")],                                       "variable `a b[1]`: is not a structured name";
    3  [u("u").unit("furlong")],                         "unit `furlong` is neither in KNOWN_UNITS nor in Info::units";
    4  [u("u").unit("rad").display_unit("mm")],          "display unit `mm` is not one of unit `rad`";
    5  [u("u").display_unit("mm")],                      "display unit `mm` without a unit";
    6  [p().min(2.0)],                                   "variable `p`: start value 1 must be finite and at least 2";
    7  [p().min(2.0).max(1.0)],                          "min = 2 and max = 1 are no bounds";
    8  [n().max(2.5)],                                   "min = -inf and max = 2.5 are no bounds";
    9  [u("u").nominal(0.0)],                            "nominal = 0 must be finite and > 0";
    10 [u("u").tunable()],                               "only numeric parameters can be tunable";
    11 [text().tunable()],                               "only numeric parameters can be tunable";
    12 [p().discrete()],                                 "only a Real that is not a parameter can be declared discrete";
    13 [p().enumeration(&ENUMERATION)],                  "only an Integer row can have an enumeration";
    14 [n().unit("m")],                                  "only a Real has a unit or a nominal value";
    15 [u("u"), y().depends_on(&["v"])],                 "variable `y[1]`: depends on `v`; it must be an input of the table";
    16 [u("u"), p(), y().depends_on(&["p"])],            "depends on `p`; it must be an input of the table";
    17 [u("u"), y().depends_on(&["u[i]"])],              "variable `y[3]`: depends on `u[i]`";
    18 [u("u"), y().depends_on(&["u[0]"])],              "depends on `u[0]`";
    19 [y().initially_depends_on(&["y"])],               "depends on `y`; it must be an input or parameter of the table";
    20 [u("u"), y().each_depends_on(&[&["u"], &[]])],    "variable `y[3]`: has 2 lists of dependencies, fewer than elements";
    21 [u("u").depends_on(&[])],                         "only outputs have dependencies";
    22 [V::integer_output("n", "", |y| &y.n)],           "variable `n`: has no description";
    23 [u("u").each_unit(&["m"])],                       "variable `u[2]`: has units for 1 elements only";
    24 [p().at(7), n(), u("u").at(8)],                   "variable `u[1]`: value reference 8 is already that of `n`";
    25 [p().at(70000)],                                  "variable `p`: value reference 70000 must be at most 65535";
    26 [u("u").at(65535)],                               "variable `u[2]`: value reference 65536 must be at most 65535";
    27 [p().own_unit(&FURLONG), u("u").own_unit(&LONGER)], "variable `u[1]`: unit `furlong` is defined otherwise for `p`";
    28 [V::inputs("none", "of length 0", |_| &[], |_| &mut [])], "variable `none`: has no elements";
    29 [n().enumeration(&TWICE)],                        "variable `n`: enumeration `E` has the item `a` twice";
    30 [n().enumeration(&ENUMERATION), V::integer_output("m", "other", |y| &y.n).enumeration(&OTHER)], "variable `m`: enumeration `E` is defined otherwise for `n`";
    31 [n().enumeration(&EMPTY)],                        "variable `n`: enumeration `Empty` has no items";
    32 [V::integer_output("m", "no item", |y| &y.n).enumeration(&ENUMERATION)], "`m` = 0 with the start values must be 1 (a) or 2 (b)";
    33 [V::string_parameter("text", "kept nowhere", |p| &p.text, |_, _, _| Ok(()))], "`text`: its accessors are of different fields";
    34 [text(), V::string_parameter("z", "the same", |p| &p.text, |p, text, _| { text.clone_into(&mut p.text); Ok(()) })], "`text` and `z` share a field";
    35 [V::calculated_parameter("c", "calculated", |y| &y.y[0]).depends_on(&[])], "variable `c`: only outputs have dependencies";
    36 [V::constant("g", "gravity", |_| &9.80665).tunable()], "variable `g`: only numeric parameters can be tunable";
    37 [V::constant("g", "gravity", |_| &9.80665).discrete()], "variable `g`: only a Real that is not a parameter can be declared discrete";
    38 [n().min(2.0)],                                   "variable `n`: start value 1 must be finite and at least 2";
}

impl<const K: usize> Model for Wrong<K> {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = ();
    const INFO: Info = Info::new("Wrong", "tables with one mistake each");

    fn variables() -> &'static [V<K>] {
        Self::table()
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
