//! GUID and instantiation token differ where model descriptions differ, and only where tables say
//! something else.

use std::cell::Cell;

use fmu_export::{
    DisplayUnit, Enumeration, Info, InputPolynomial, Items, Model, ModelError, StepEnd, Unit,
    Variable, joined, model_description, model_description3,
};
use serde::{Deserialize, Serialize};

thread_local! {
    /// The table that the model has just now. A type for each would be compiled forty times.
    static CHOSEN: Cell<usize> = const { Cell::new(0) };
}

/// A model with the table that is chosen; its start values are of that table too.
#[derive(Clone, Serialize, Deserialize)]
struct Table;

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

type V = Variable<Table>;

const fn p() -> V {
    V::parameters("p", "parameter", |p| &p.p, |p| &mut p.p)
}

const fn n() -> V {
    V::integer_parameter("n", "number", |p| &p.n, |p| &mut p.n)
}

const fn u() -> V {
    V::inputs("u", "input", |u| &u.u, |u| &mut u.u)
}

const fn y() -> V {
    V::outputs("y", "output", |y| &y.y).depends_on(&["u"])
}

const YES: V = V::boolean_parameter("yes", "truth", |p| &p.yes, |p| &mut p.yes);
const TEXT: V = V::string_parameter(
    "text",
    "text",
    |p| &p.text,
    |p, text, _| {
        text.clone_into(&mut p.text);
        Ok(())
    },
);

const fn unit(unit: &'static Unit) -> V {
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

/// Tables by their number.
#[rustfmt::skip]
const TABLES: &[&[V]] = &[
    &[p(), n(), u(), y(), YES, TEXT], // 0
    &[n(), p(), u(), y(), YES, TEXT], // 1
    &[p().at(1), n(), u(), y(), YES, TEXT], // 2
    &[V::parameters("q", "parameter", |p| &p.p, |p| &mut p.p), n(), u(), y(), YES, TEXT], // 3
    &[V::parameters("p", "Parameter", |p| &p.p, |p| &mut p.p), n(), u(), y(), YES, TEXT], // 4
    &[V::parameter("p", "parameter", |p| &p.p[0], |p| &mut p.p[0]), n(), u(), y(), YES, TEXT], // 5
    &[p().tunable(), n(), u(), y(), YES, TEXT], // 6
    &[p().unit("m"), n(), u(), y(), YES, TEXT], // 7
    &[p().unit("m").display_unit("mm"), n(), u(), y(), YES, TEXT], // 8
    &[p().each_unit(&["m", "s"]), n(), u(), y(), YES, TEXT], // 9
    &[p().min(-3.0), n(), u(), y(), YES, TEXT], // 10
    &[p().max(30.0), n(), u(), y(), YES, TEXT], // 11
    &[p().nominal(3.0), n(), u(), y(), YES, TEXT], // 12
    &[p(), n().enumeration(&E), u(), y(), YES, TEXT], // 13
    &[p(), n().enumeration(&E_NAMED), u(), y(), YES, TEXT], // 14
    &[p(), n().enumeration(&E_TOLD), u(), y(), YES, TEXT], // 15
    &[p(), n().enumeration(&E_ITEM), u(), y(), YES, TEXT], // 16
    &[p(), n().enumeration(&E_ITEM_TOLD), u(), y(), YES, TEXT], // 17
    &[unit(&FURLONG), n(), u(), y(), YES, TEXT], // 18
    &[unit(&LONGER), n(), u(), y(), YES, TEXT], // 19
    &[unit(&SQUARED), n(), u(), y(), YES, TEXT], // 20
    &[unit(&SHIFTED), n(), u(), y(), YES, TEXT], // 21
    &[unit(&SHOWN), n(), u(), y(), YES, TEXT], // 22
    &[unit(&SHOWN_OTHERWISE), n(), u(), y(), YES, TEXT], // 23
    &[p(), n(), u().discrete(), y(), YES, TEXT], // 24
    &[p(), n(), u(), V::locals("y", "output", |y| &y.y), YES, TEXT], // 25
    &[p(), n(), u(), V::outputs("y", "output", |y| &y.y), YES, TEXT], // 26
    &[p(), n(), u(), y().depends_on(&["u[i]"]), YES, TEXT], // 27
    &[p(), n(), u(), y().each_depends_on(&[&["u"], &[]]), YES, TEXT], // 28
    &[p(), n(), u(), y().initially_depends_on(&["p"]), YES, TEXT], // 29
    &[p(), n(), u(), V::constants("y", "output", |_| &[1.0, 2.0]), YES, TEXT], // 30
    &[p(), n(), u(), V::constants("y", "output", |_| &[1.0, 2.5]), YES, TEXT], // 31
    // Start values.
    &[p(), n(), u(), y(), YES, TEXT], // 32
    &[p(), n(), u(), y(), YES, TEXT], // 33
    &[p(), n(), u(), y(), YES, TEXT], // 34
    &[p(), n(), u(), y(), YES, TEXT], // 35
    &[p(), n(), u(), y(), YES, TEXT], // 36
    // What the description does not say.
    &[p(), n(), u().not_in_evaluation().counted(|u| &mut u.sets), y(), YES, TEXT], // 37
    &[p().read_by_string_setters(), n(), u(), y(), YES, TEXT], // 38
    &[p(), n(), u(), y().initially_depends_on(&["u", "p"]), YES, TEXT], // 39
    // The same in other words.
    &[p(), n(), u(), y().initially_also_on(&["p"]), YES, TEXT], // 40
    &[p(), n(), u(), y().initially_depends_on(joined!(&["u"], &[], &["p"])), YES, TEXT], // 41
    &[p(), n().items(&ITEMS), u(), y(), YES, TEXT], // 42
    &[p(), n(), u().range(-3.0..=30.0), y(), YES, TEXT], // 43
    &[p(), n(), u().min(-3.0).max(30.0), y(), YES, TEXT], // 44
];

/// Descriptions of FMI 2.0 and 3.0 of each.
fn descriptions() -> Vec<[String; 2]> {
    let described = |k| {
        CHOSEN.set(k);
        [
            model_description::<Table>().unwrap(),
            model_description3::<Table>().unwrap(),
        ]
    };
    (0..TABLES.len()).map(described).collect()
}

impl Model for Table {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = ();
    const INFO: Info = Info::new("Table", "a table that differs from the others");

    fn variables() -> &'static [V] {
        TABLES[CHOSEN.get()]
    }

    fn defaults() -> (Parameters, Input) {
        let k = CHOSEN.get();
        let p = Parameters {
            p: [1.0, if k == 32 { 1.5 } else { 2.0 }],
            n: if k == 33 { 2 } else { 1 },
            yes: k == 34,
            text: if k == 35 { "yes" } else { "" }.to_owned(),
        };
        let u = Input {
            u: [0.0, if k == 36 { 0.5 } else { 0.0 }],
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
