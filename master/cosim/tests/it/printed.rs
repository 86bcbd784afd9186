//! What the program prints of FMUs, systems and faults.

use std::fs;

use super::program::{cosim, fmus, packed};
use super::support::{assert_contains, edited, oscillator, scratch};

/// The JSON of `cosim info` has the names that docs/master/cosim-options.md lists, for FMUs and for systems.
#[test]
fn info_is_there_for_programs_too() {
    let ([spring, _], package) = (fmus("told"), packed("told-packed"));
    let (code, text, error) = cosim(&["info", "--json", &spring, &package]);
    assert_eq!(code, 0, "{error}");
    let told: serde_json::Value = serde_json::from_str(&text).unwrap();
    let (fmu, system) = (&told[0], &told[1]);
    let keys = |value: &serde_json::Value| -> Vec<String> {
        let keys = value.as_object().unwrap().keys();
        keys.cloned().collect()
    };
    assert_eq!(
        keys(fmu),
        [
            "capabilities",
            "default_experiment",
            "file",
            "fmi",
            "identifier",
            "interfaces",
            "kind",
            "model",
            "platforms",
            "remarks",
            "sources_only",
            "token",
            "tool",
            "units",
            "variables",
            "version"
        ]
    );
    let variable = |name: &str| {
        let all = fmu["variables"].as_array().unwrap();
        all.iter().find(|v| v["name"] == name).unwrap().clone()
    };
    let force = variable("F");
    assert_eq!(
        keys(&force),
        [
            "causality",
            "depends_on",
            "description",
            "dimensions",
            "display_unit",
            "items",
            "max",
            "min",
            "name",
            "nominal",
            "start",
            "type",
            "unit",
            "variability"
        ]
    );
    assert_eq!(force["depends_on"][0], "x");
    assert_eq!(
        (&variable("k")["min"], &variable("k")["start"]),
        (&0.0.into(), &3.0.into())
    );
    assert_eq!(variable("off")["start"], false);
    assert_eq!(fmu["capabilities"]["saves_state"], true);
    assert_eq!(fmu["platforms"].as_array().unwrap().len(), 1);
    assert_eq!(
        keys(system),
        [
            "components",
            "connections",
            "file",
            "fmus",
            "inputs",
            "kind",
            "name",
            "outputs",
            "start",
            "step",
            "stop"
        ]
    );
    assert_eq!(
        (&system["start"], &system["stop"]),
        (&0.5.into(), &2.5.into())
    );
    assert_eq!(system["connections"][0]["to"], "spring.x");
    assert_eq!(system["fmus"][0]["variables"], fmu["variables"]);
    let (_, text, _) = cosim(&["info", &package]);
    assert_contains(
        &text,
        &[
            "component mass: resources/Mass.fmu",
            "connection mass.x -> spring.x",
            "resources/Spring.fmu: Spring, FMI 2.0",
        ],
    );
}

/// What acts at once is found by trying, products with zero too: the force depends on the stage
/// only where x is not 0. What is declared stands beside it.
#[test]
fn wiring_shows_what_is_read_when_and_tries_what_acts_at_once() {
    let bare = |example: &str, text: &str| match example {
        "spring" => text.replace("dependencies=\"4 5 6 7 8\"", ""),
        _ => text.to_string(),
    };
    edited("tried", &oscillator(), bare).unwrap();
    let file = scratch("tried").join("system.ssp").display().to_string();
    let (code, text, error) = cosim(&["wiring", "--system", &file, "--try"]);
    assert_eq!(code, 0, "{error}");
    assert_contains(
        &text,
        &[
            "outputs read at once, after the inputs that they depend on: mass.x, mass.x_dot\n",
            "because they do not declare what they depend on: spring.F\n",
            "  spring.F: changed by x, off, stage (nothing is declared)\n",
            "  mass.x: changed by nothing (as declared)\n",
            "  mass.x_ddot: changed by f (as declared)\n",
        ],
    );
    let (_, text, _) = cosim(&["wiring", "--system", &packed("tried-declared"), "--try"]);
    let declared =
        "  spring.F: changed by x, off, stage (declared: x, x_dot, x_ddot, off, stage)\n";
    assert!(text.contains(declared), "{text}");
}

/// Faults and scenarios by the command line: what they do is in the verdict, and what is wrong is
/// told with the option.
#[test]
fn faults_and_scenarios_are_told() {
    let package = packed("faulty");
    let scenario = scratch("faulty.json");
    let text = r#"{"events": [{"time": 1, "model": "spring", "variable": "stage", "action": "override", "value": 2}], "end": 1.5}"#;
    fs::write(&scenario, text).unwrap();
    let scenario = scenario.display().to_string();
    let run =
        |more: &[&str]| cosim(&[&["run", &package, "--quiet", "--step", "0.1"], more].concat());
    let (code, text, error) = run(&[
        "--fault",
        "spring.x=bias:0.5@1..1.5",
        "--noise",
        "mass.f=2",
        "--scenario",
        &scenario,
    ]);
    assert_eq!(code, 0, "{error}");
    assert_contains(
        &text,
        &[
            "on the wire mass.x -> spring.x: bias of 0.5 m, from t = 1 s until t = 1.5 s",
            "on the wire spring.F -> mass.f: noise of standard deviation 2 N\n",
            "on the input spring.stage: override by 2, from t = 1.5 s until t = 2 s",
            "faulty.json`: 1 events; what it alters ends at t = 2 s",
        ],
    );
    let (code, _, error) = run(&["--noise", "spring.x"]);
    assert!(
        code == 1
            && error.contains("--noise spring.x: noise of `spring.x` needs a standard deviation"),
        "{error}"
    );
}
