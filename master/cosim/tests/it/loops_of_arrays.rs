//! Algebraic loops of elements of arrays, which FMI 3.0 passes whole.

use std::fs;
use std::path::PathBuf;

use cosim::master::Master;
use cosim::structure::FmuUse;
use cosim::structure::system::System;

use super::foreign::compiled;
use super::loops::{SCHEDULES, numbers, started};
use super::support::{pack, scratch};

/// The FMU of `arrays.c` as a file `component.fmu`.
fn arrays(component: &str) -> PathBuf {
    let folder = scratch("loop_arrays");
    fs::create_dir_all(&folder).unwrap();
    let library = compiled(&folder, "arrays.so", &["arrays.c"], &[]);
    let text = r#"<fmiModelDescription fmiVersion="3.0" modelName="arrays" instantiationToken="t">
        <CoSimulation modelIdentifier="arrays" hasEventMode="true" providesDirectionalDerivatives="true"/><ModelVariables>
        <Float64 name="k" valueReference="1" causality="parameter" variability="tunable" start="1"/>
        <Float64 name="u" valueReference="2" causality="input" start="0 0 0"><Dimension start="3"/></Float64>
        <Float64 name="y" valueReference="3" causality="output"><Dimension start="3"/></Float64>
        <Float64 name="asked" valueReference="4" causality="output"/><Float64 name="sets" valueReference="5" causality="output"/>
        </ModelVariables><ModelStructure><Output valueReference="3" dependencies="2"/><Output valueReference="4" dependencies=""/>
        <Output valueReference="5" dependencies=""/></ModelStructure></fmiModelDescription>"#;
    let file = folder.join(format!("{component}.fmu"));
    pack(&file, text, "x86_64-linux", &[&library]);
    file
}

/// `y = k G u + b (1 + t)`, of which some elements are in a loop, not in the order of their numbers.
/// Newton's method solves linear equations in one iteration if the derivatives are right. Then an
/// FMU is asked twice for them, once for each element that it gets, and its inputs are set twice:
/// to the values before, and to the solution. One more iteration would set them once more, and ask
/// twice. Wrong would be seeds of other elements than those that change, or rates of others. No value
/// is above 9, and a solution is one to 1e-14 beside 1 and the value.
#[test]
fn directional_derivatives_of_elements_are_those_of_their_arrays() {
    let connections = [
        ("a.y[3]", "b.u[1]"),
        ("b.y[2]", "a.u[3]"),
        ("a.y[1]", "b.u[3]"),
        ("b.y[3]", "a.u[2]"),
    ];
    let texts = connections.map(|(from, to)| format!("{from}={to}"));
    let mut system =
        System::from_fmus(&["a", "b"].map(arrays), &texts, &FmuUse::default()).unwrap();
    system.structure.solves_loops = true;
    let gains = [[0.3, -0.7, 0.2], [0.5, 0.1, -0.4], [-0.2, 0.6, 0.8]];
    let starts = ["a.u[1]=0.7", "b.u[2]=-0.3", "b.k=0.5"];
    for schedule in SCHEDULES {
        let mut master = started(&system, &starts, schedule).unwrap();
        let number = |master: &Master, name: &str| numbers(&system, master, [name])[0];
        let counts = |master: &Master, name: &str| {
            ["asked", "sets"].map(|count| number(master, &format!("{name}.{count}")))
        };
        for _ in 0..10 {
            let before = ["a", "b"].map(|name| counts(&master, name));
            master.step().unwrap();
            for (from, to) in connections {
                let [from, to] = [from, to].map(|end| number(&master, end));
                assert!((from - to).abs() < 1e-13, "{from} {to}");
            }
            for (name, before) in ["a", "b"].into_iter().zip(before) {
                let of = |end: &str, k| number(&master, &format!("{name}.{end}[{k}]"));
                let (k, t) = (number(&master, &format!("{name}.k")), master.time());
                for (i, (gains, b)) in gains.iter().zip([1.0, -2.0, 3.0]).enumerate() {
                    let sum: f64 = (1..).zip(gains).map(|(j, gain)| gain * of("u", j)).sum();
                    let exact = k * sum + b * (1.0 + t);
                    assert!((of("y", i + 1) - exact).abs() < 1e-13, "{name} {i}");
                }
                let [asked, sets] = counts(&master, name);
                assert_eq!([asked - before[0], sets - before[1]], [2.0, 2.0], "{name}");
            }
        }
    }
}
