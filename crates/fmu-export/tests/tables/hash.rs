//! GUID and instantiation token differ where model descriptions differ, and only where tables say
//! something else.

use fmu_export::{
    DisplayUnit, Enumeration, Info, InputPolynomial, Items, Model, ModelError, StepEnd, Unit,
    Variable, joined, model_description, model_description3,
};
use serde::{Deserialize, Serialize};

/// A model with the `K`-th table; its start values are those of `K` too.
#[derive(Clone, Serialize, Deserialize)]
struct Table<const K: usize>;

#[derive(Clone, Serialize, Deserialize)]
struct Parameters {
    p: [f64; 2],
    n: i32,
    yes: bool,
    text: String,
}

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Input {
    u: [f64; 2],
    sets: u32,
}

#[derive(Clone, Copy, Default)]
struct Output {
    y: [f64; 2],
}

type V<const K: usize> = Variable<Table<K>>;

const fn p<const K: usize>() -> V<K> {
    V::parameters("p", "parameter", |p| &p.p, |p| &mut p.p)
}

const fn n<const K: usize>() -> V<K> {
    V::integer_parameter("n", "number", |p| &p.n, |p| &mut p.n)
}

const fn u<const K: usize>() -> V<K> {
    V::inputs("u", "input", |u| &u.u, |u| &mut u.u)
}

const fn y<const K: usize>() -> V<K> {
    V::outputs("y", "output", |y| &y.y).depends_on(&["u"])
}

const fn rest<const K: usize>() -> [V<K>; 2] {
    [
        V::boolean_parameter("yes", "truth", |p| &p.yes, |p| &mut p.yes),
        V::string_parameter(
            "text",
            "text",
            |p| &p.text,
            |p, text, _| {
                text.clone_into(&mut p.text);
                Ok(())
            },
        ),
    ]
}

const fn unit<const K: usize>(unit: &'static Unit) -> V<K> {
    p().own_unit(unit)
}

const E: Enumeration = Enumeration::new("E", "items", &[("a", "first"), ("b", "second")]);
const E_NAMED: Enumeration = Enumeration::new("F", "items", &[("a", "first"), ("b", "second")]);
const E_TOLD: Enumeration = Enumeration::new("E", "others", &[("a", "first"), ("b", "second")]);
const E_ITEM: Enumeration = Enumeration::new("E", "items", &[("a", "first"), ("c", "second")]);
const E_ITEM_TOLD: Enumeration = Enumeration::new("E", "items", &[("a", "first"), ("b", "other")]);
static ITEMS: Items<bool, 2> =
    Items::new("E", "items", [(true, "a", "first"), (false, "b", "second")]);
const FURLONG: Unit = Unit::new("furlong").m(1).factor(201.168);
const LONGER: Unit = Unit::new("furlong").m(1).factor(201.169);
const SQUARED: Unit = Unit::new("furlong").m(2).factor(201.168);
const SHIFTED: Unit = Unit::new("furlong").m(1).factor(201.168).offset(1.0);
const SHOWN: Unit = Unit::new("furlong")
    .m(1)
    .factor(201.168)
    .display(&[DisplayUnit::new("chain", 10.0)]);
const SHOWN_OTHERWISE: Unit = Unit::new("furlong")
    .m(1)
    .factor(201.168)
    .display(&[DisplayUnit::new("chain", 10.5)]);

macro_rules! tables {
    ($($k:literal [$($row:expr),*])*) => {
        impl<const K: usize> Table<K> {
            fn rows() -> &'static [V<K>] {
                match K {
                    $($k => const {
                        let [yes, text] = rest();
                        &[$($row,)* yes, text]
                    },)*
                    _ => unreachable!(),
                }
            }
        }

        /// Descriptions of FMI 2.0 and 3.0 of each.
        fn descriptions() -> Vec<[String; 2]> {
            vec![$([
                model_description::<Table<$k>>().unwrap(),
                model_description3::<Table<$k>>().unwrap(),
            ]),*]
        }
    };
}

#[rustfmt::skip]
tables! {
    0  [p(), n(), u(), y()]
    1  [n(), p(), u(), y()]
    2  [p().at(1), n(), u(), y()]
    3  [V::parameters("q", "parameter", |p| &p.p, |p| &mut p.p), n(), u(), y()]
    4  [V::parameters("p", "Parameter", |p| &p.p, |p| &mut p.p), n(), u(), y()]
    5  [V::parameter("p", "parameter", |p| &p.p[0], |p| &mut p.p[0]), n(), u(), y()]
    6  [p().tunable(), n(), u(), y()]
    7  [p().unit("m"), n(), u(), y()]
    8  [p().unit("m").display_unit("mm"), n(), u(), y()]
    9  [p().each_unit(&["m", "s"]), n(), u(), y()]
    10 [p().min(-3.0), n(), u(), y()]
    11 [p().max(30.0), n(), u(), y()]
    12 [p().nominal(3.0), n(), u(), y()]
    13 [p(), n().enumeration(&E), u(), y()]
    14 [p(), n().enumeration(&E_NAMED), u(), y()]
    15 [p(), n().enumeration(&E_TOLD), u(), y()]
    16 [p(), n().enumeration(&E_ITEM), u(), y()]
    17 [p(), n().enumeration(&E_ITEM_TOLD), u(), y()]
    18 [unit(&FURLONG), n(), u(), y()]
    19 [unit(&LONGER), n(), u(), y()]
    20 [unit(&SQUARED), n(), u(), y()]
    21 [unit(&SHIFTED), n(), u(), y()]
    22 [unit(&SHOWN), n(), u(), y()]
    23 [unit(&SHOWN_OTHERWISE), n(), u(), y()]
    24 [p(), n(), u().discrete(), y()]
    25 [p(), n(), u(), V::locals("y", "output", |y| &y.y)]
    26 [p(), n(), u(), V::outputs("y", "output", |y| &y.y)]
    27 [p(), n(), u(), y().depends_on(&["u[i]"])]
    28 [p(), n(), u(), y().each_depends_on(&[&["u"], &[]])]
    29 [p(), n(), u(), y().initially_depends_on(&["p"])]
    30 [p(), n(), u(), V::constants("y", "output", |_| &[1.0, 2.0])]
    31 [p(), n(), u(), V::constants("y", "output", |_| &[1.0, 2.5])]
    // Start values.
    32 [p(), n(), u(), y()]
    33 [p(), n(), u(), y()]
    34 [p(), n(), u(), y()]
    35 [p(), n(), u(), y()]
    36 [p(), n(), u(), y()]
    // What the description does not say.
    37 [p(), n(), u().beside_evaluation().counted(|u| &mut u.sets), y()]
    38 [p().read_by_texts(), n(), u(), y()]
    39 [p(), n(), u(), y().initially_depends_on(&["u", "p"])]
    // The same in other words.
    40 [p(), n(), u(), y().initially_also_on(&["p"])]
    41 [p(), n(), u(), y().initially_depends_on(joined!(&["u"], &[], &["p"]))]
    42 [p(), n().items(&ITEMS), u(), y()]
    43 [p(), n(), u().range(-3.0..=30.0), y()]
    44 [p(), n(), u().min(-3.0).max(30.0), y()]
}

impl<const K: usize> Model for Table<K> {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = ();
    const INFO: Info = Info::new("Table", "a table that differs from the others");

    fn variables() -> &'static [V<K>] {
        Self::rows()
    }

    fn defaults() -> (Parameters, Input) {
        let p = Parameters {
            p: [1.0, if K == 32 { 1.5 } else { 2.0 }],
            n: if K == 33 { 2 } else { 1 },
            yes: K == 34,
            text: if K == 35 { "yes" } else { "" }.to_owned(),
        };
        let u = Input {
            u: [0.0, if K == 36 { 0.5 } else { 0.0 }],
            sets: 0,
        };
        (p, u)
    }

    idle_model!();
}

/// The value of the attribute, and the text without it.
fn split(xml: &str, attribute: &str) -> (String, String) {
    let (before, rest) = xml.split_once(&format!("{attribute}=\"")).unwrap();
    let (hash, after) = rest.split_once('"').unwrap();
    (hash.to_owned(), format!("{before}{after}"))
}

#[test]
fn the_hash_tells_descriptions_apart() {
    let descriptions = descriptions();
    for (version, attribute) in ["guid", "instantiationToken"].into_iter().enumerate() {
        let all: Vec<_> = (descriptions.iter())
            .map(|texts| split(&texts[version], attribute))
            .collect();
        for (i, (hash, text)) in all.iter().enumerate() {
            for (k, (other_hash, other)) in all.iter().enumerate() {
                assert!(
                    hash != other_hash || text == other,
                    "tables {i}, {k}:\n{text}"
                );
            }
        }
        let like_the_first: Vec<_> = (0..all.len()).filter(|&k| all[k].0 == all[0].0).collect();
        assert_eq!(like_the_first, [0, 37, 38], "{attribute}");
    }
}

#[test]
fn short_forms_of_rows_mean_what_the_long_ones_do() {
    let descriptions = descriptions();
    for (long, short) in [(39, 40), (39, 41), (13, 42), (44, 43)] {
        assert_eq!(descriptions[long], descriptions[short], "{long}, {short}");
    }
}
