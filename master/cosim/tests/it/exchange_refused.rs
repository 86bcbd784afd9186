//! Bad FMUs for Model Exchange, each refused by name: what its description says, what its library
//! lacks, what its functions do. The FMU, `exchange.c`, has a fault for each.

use super::exchange_fmu::{BALL, DECAY, Exchange, TICKS, refused, run};
use super::support::assert_contains;

/// What a row runs, until 1 s with steps of 0.1 s.
type Row<'a> = (u32, u32, &'a [&'a str]);

/// Faults of functions: kind, fault in `exchange.c`, parts of the message in both versions.
const BEHAVIOUR: [Row; 21] = [
    (BALL, 8, &["event indicator 1 is NaN at t = "]),
    (
        DECAY,
        9,
        &["nominal value of the state `x[1]` is inf", "t = 0 s"],
    ),
    (
        DECAY,
        10,
        &["nominal value of the state `x[1]` is NaN", "t = 0 s"],
    ),
    (
        TICKS,
        11,
        &["next time event, at 0.05 s, is in the past at t = 0.1 s"],
    ),
    (DECAY, 12, &["still change after 100 passes", "t = 0 s"]),
    (
        DECAY,
        13,
        &["changes the state `x[1]` from 1 to 2; it must only compute"],
    ),
    (DECAY, 14, &["CompletedIntegratorStep at t = 0.3", "Error"]),
    (
        DECAY,
        16,
        &["Derivatives writes 3 values; its description has 2"],
    ),
    (
        DECAY,
        17,
        &["Derivatives writes no value 2; its description has 2"],
    ),
    (
        BALL,
        18,
        &["GetEventIndicators writes 2 values; its description has 1"],
    ),
    (
        BALL,
        19,
        &["GetEventIndicators writes no value 1; its description has 1"],
    ),
    (DECAY, 22, &["SetContinuousStates at t = 0.", "Error"]),
    (DECAY, 23, &["SetTime at t = 0.", "Error"]),
    (BALL, 24, &["GetEventIndicators at t = 0.", "Error"]),
    (BALL, 25, &["EnterEventMode at t = 0.", "Error"]),
    (DECAY, 26, &["GetNominalsOfContinuousStates", "Error"]),
    (DECAY, 27, &["the state `x[1]` is NaN", "t = 0 s"]),
    (BALL, 28, &["DiscreteStates at t = 0.", "Error"]),
    (DECAY, 29, &["the derivative of `x[2]` is inf at t = 0.3"]),
    (BALL, 30, &["EnterContinuousTimeMode at t = 0.", "Error"]),
    (DECAY, 1, &["Derivatives at t = 0.", "Error"]),
];

#[test]
fn functions_that_do_wrong_are_named() {
    for version in [2, 3] {
        let test = format!("exchange-wrong-{version}");
        for (kind, fault, parts) in BEHAVIOUR {
            let mut fmu = Exchange::new(version, kind, 0.9, &[1.0, 0.0]);
            fmu.fault = fault;
            let file = fmu.pack(&test, "a");
            let arguments = [&*file, "--stop-time", "1", "--step", "0.1"];
            refused(&test, &arguments, &[&["a"][..], parts].concat());
        }
        // It may do so, and the run has no step.
        let mut fmu = Exchange::new(version, DECAY, 0.0, &[1.0, 0.0]);
        fmu.fault = 15;
        let file = fmu.pack(&test, "a");
        refused(
            &test,
            &[&file, "--stop-time", "1"],
            &["asks to end the simulation at t = 0 s"],
        );
    }
}

/// FMI 3.0 says how many states and indicators there are.
#[test]
fn other_numbers_than_described_are_named() {
    for (fault, part) in [
        (20, "its library has 3 continuous states, its description 2"),
        (21, "its library has 1 event indicators, its description 0"),
    ] {
        let mut fmu = Exchange::new(3, DECAY, 0.0, &[1.0, 0.0]);
        fmu.fault = fault;
        let file = fmu.pack("exchange-numbers", "a");
        refused("exchange-numbers", &[&file], &["a", part]);
    }
}

#[test]
fn functions_that_lack_are_named() {
    let lacking = [
        "SetTime",
        "SetContinuousStates",
        "GetContinuousStates",
        "GetNominalsOfContinuousStates",
        "EnterContinuousTimeMode",
    ];
    for version in [2, 3] {
        let test = format!("exchange-lacks-{version}");
        for name in lacking {
            let own = format!("fmi{version}{name}");
            let define = format!("-D{own}=other");
            let mut fmu = Exchange::new(version, DECAY, 0.0, &[1.0, 0.0]);
            let defines = [&*define];
            fmu.defines = &defines;
            let file = fmu.pack(&test, "a");
            let part = format!("its library does not export {own}");
            refused(&test, &[&file, "--stop-time", "1"], &["a", &part]);
        }
    }
}

#[test]
fn descriptions_that_do_not_say_the_states_are_refused() {
    let der = r#"name="der(x[1])" valueReference="2000"><Real derivative="11"/>"#;
    let list = "<Derivatives><Unknown index=\"13\" dependencies=\"11 12 1\"/><Unknown index=\"14\" dependencies=\"11 12 1\"/></Derivatives>";
    let other = |real: &str| format!(r#"name="der(x[1])" valueReference="2000">{real}"#);
    let count = r#"numberOfEventIndicators="0""#;
    let rows: [(u32, [&str; 2], &[&str]); 17] = [
        (
            2,
            [der, &other("<Real/>")],
            &["`der(x[1])`", "does not say of which state"],
        ),
        (
            2,
            [der, &other(r#"<Real derivative="99"/>"#)],
            &["`der(x[1])`", "not there"],
        ),
        (
            2,
            [der, &other(r#"<Real derivative="0"/>"#)],
            &["`der(x[1])`", "not there"],
        ),
        (
            2,
            [der, &other(r#"<Real derivative="12"/>"#)],
            &["`der(x[2])` and `der(x[1])` are both the derivative of `x[2]`"],
        ),
        (
            2,
            [der, &other(r#"<Real derivative="1"/>"#)],
            &["`der(x[1])` is the derivative of `u`, which is no state"],
        ),
        (
            2,
            [der, &other(r#"<Real derivative="7"/>"#)],
            &["`der(x[1])` is the derivative of `count`, which is no state"],
        ),
        (
            2,
            [der, &other("<Integer/>")],
            &["`der(x[1])`", "is no Real"],
        ),
        (
            2,
            [list, ""],
            &[
                "`der(x[1])` is the derivative of `x[1]`",
                "lists no derivatives",
            ],
        ),
        (
            2,
            [r#"<Unknown index="13""#, r#"<Unknown index="77""#],
            &["variable number 77"],
        ),
        (2, [r#"<Unknown index="13""#, r#"<Unknown"#], &["index"]),
        (
            2,
            [count, r#"numberOfEventIndicators="-1""#],
            &["numberOfEventIndicators", "-1"],
        ),
        (
            2,
            [count, r#"numberOfEventIndicators="99999999999""#],
            &["99999999999 event indicators"],
        ),
        (
            2,
            [r#"name="x[1]" valueReference="0""#, r#"name="x[1]""#],
            &["valueReference"],
        ),
        (
            3,
            [r#"derivative="0""#, ""],
            &["`der(x)[1]`", "does not say of which state"],
        ),
        (
            3,
            [r#"derivative="0""#, r#"derivative="4""#],
            &["`der(x)[1]`", "not there"],
        ),
        (
            3,
            [
                r#"<Float64 name="der(x)" valueReference="2000" derivative="0"><Dimension start="2"/>"#,
                r#"<Float64 name="der(x)" valueReference="2000" derivative="0"><Dimension start="3"/>"#,
            ],
            &["`der(x)[3]`", "`x` does not have"],
        ),
        (
            3,
            [
                r#"<ContinuousStateDerivative valueReference="2000"/>"#,
                r#"<ContinuousStateDerivative valueReference="2000"/><EventIndicator valueReference="7001"/>"#,
            ],
            &["`count`", "event indicator"],
        ),
    ];
    for (version, edit, parts) in rows {
        let test = format!("exchange-described-{version}");
        let mut fmu = Exchange::new(version, DECAY, 0.0, &[1.0, 0.0]);
        fmu.edits = std::slice::from_ref(&edit);
        let file = fmu.pack(&test, "a");
        refused(&test, &[&file, "--stop-time", "1"], parts);
    }
}

/// The verdict names the method; a fixed one makes as many steps as are asked for.
#[test]
fn the_method_is_chosen_or_refused() {
    let test = "exchange-method";
    let file = Exchange::new(2, DECAY, 0.0, &[1.0, 1.0]).pack(test, "a");
    let until = [&*file, "--step", "0.1", "--stop-time", "1", "--solver"];
    for (method, text, error) in [
        ("explicit", "(Model Exchange, explicit): ", 1e-5),
        ("*=stiff", "(Model Exchange, stiff): ", 1e-5),
        // 40 steps of RK4: h^4/120.
        (
            "a=fixed:0.03",
            "(Model Exchange, fixed:0.03): 40 steps, 0 rejected",
            2e-9,
        ),
    ] {
        let done = run(test, &[&until[..], &[method]].concat());
        assert_contains(&done.text, &[text]);
        assert!(
            (done.last("a.y") - (-1.0_f64).exp()).abs() < error,
            "{}",
            done.last("a.y")
        );
    }
    for (method, part) in [
        (
            "b=stiff",
            "--solver b=stiff: the system has no component of this name",
        ),
        ("a=euler", "`euler` must be explicit, stiff, or fixed:STEP"),
        (
            "fixed:0",
            "`fixed:0` must be explicit, stiff, or fixed:STEP",
        ),
    ] {
        refused(test, &[&until[..], &[method]].concat(), &[part]);
    }
}
