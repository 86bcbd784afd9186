//! Model Exchange: inputs whose derivative is an input, mean efforts of power bonds, and states that
//! are arrays, against closed forms.

use std::f64::consts::PI;
use std::fs;

use super::exchange_fmu::{Exchange, FOLLOW, ROD, run};
use super::support::scratch;

/// x' = u and u' = 2 from u = 3: x = 3 t + t², although the master never sets u.
#[test]
fn an_input_follows_its_derivative() {
    for version in [2, 3] {
        let test = format!("exchange-follow-{version}");
        let file = Exchange::new(version, FOLLOW, 0.0, &[0.0, 0.0]).pack(&test, "a");
        for step in ["0.3", "0.01"] {
            let given = [
                "--set",
                "a.u=3",
                "--set",
                "a.u_dot=2",
                "--signals",
                "a.x[1]",
            ];
            let until = [&*file, "--step", step, "--stop-time", "1.2"];
            let done = run(&test, &[&until[..], &given].concat());
            let columns = done.columns["time"].iter().zip(&done.columns["a.x[1]"]);
            for (t, x) in columns {
                assert!((x - (3.0 + t) * t).abs() < 1e-12, "{t}: {x}");
            }
        }
    }
}

/// a.u = t, by steps and by its derivative, so a.y = t + t²/2. Gauss–Seidel gives b.u its mean over
/// each step, hence b.x = ∫ y = t²/2 + t³/6, whatever the step; the effort at either end of a step
/// would be wrong by h/2 y(1). The residual counts the same mean.
#[test]
fn a_bond_passes_the_mean_effort_of_the_step() {
    let bond = r#"<ssd:Annotations><ssc:Annotation type="io.github.hdrm-fmu.power-bond"><PowerBond stepMean="y_mean" flow="u"/></ssc:Annotation></ssd:Annotations>"#;
    let component = |name: &str| {
        format!(
            r#"<ssd:Component name="{name}" source="{name}.fmu" implementation="ModelExchange"><ssd:Connectors><ssd:Connector name="u" kind="input"/>
            <ssd:Connector name="y" kind="output"/><ssd:Connector name="t" kind="output"/></ssd:Connectors></ssd:Component>"#
        )
    };
    let text = format!(
        r#"<ssd:SystemStructureDescription xmlns:ssd="d" xmlns:ssc="c" version="1.0" name="s"><ssd:System name="s"><ssd:Elements>{}{}</ssd:Elements>
        <ssd:Connections><ssd:Connection startElement="a" startConnector="y" endElement="b" endConnector="u">{bond}</ssd:Connection>
        <ssd:Connection startElement="b" startConnector="t" endElement="a" endConnector="u"/></ssd:Connections></ssd:System>
        </ssd:SystemStructureDescription>"#,
        component("a"),
        component("b")
    );
    for version in [2, 3] {
        let test = format!("exchange-mean-{version}");
        for name in ["a", "b"] {
            Exchange::new(version, FOLLOW, 0.0, &[0.0, 0.0]).pack(&test, name);
        }
        let file = scratch(&test).join("s.ssd");
        fs::write(&file, &text).unwrap();
        let file = file.display().to_string();
        for (step, h) in [("0.25", 0.25), ("0.01", 0.01)] {
            let until = [&*file, "--step", step, "--stop-time", "1"];
            let given = ["--set", "a.u_dot=1", "--signals", "a.y_mean,b.x[1]"];
            let done = run(&test, &[&until[..], &given].concat());
            let integral = |t: f64| t * t / 2.0 + t * t * t / 6.0;
            let mean = (integral(1.0) - integral(1.0 - h)) / h;
            assert!(
                (done.last("a.y_mean") - mean).abs() < 1e-11,
                "{}",
                done.last("a.y_mean")
            );
            let error = done.last("b.x[1]") - integral(1.0);
            assert!(error.abs() < 1e-11, "{step}: {error:e}");
        }
    }
}

/// The states are a matrix of 2 × rows, which a structural parameter sizes. Oracle as for the rod of
/// a thousand cells, in the order of rows.
#[test]
fn states_are_arrays_of_any_size() {
    let (test, zeros) = ("exchange-arrays", [0.0; 60]);
    let mut fmu = Exchange::new(3, ROD, 0.0, &zeros);
    let list = "0 ".repeat(59) + "0";
    let start = format!(r#"start="{list}"><Dimension start="60"/>"#);
    let matrix = r#"><Dimension start="2"/><Dimension valueReference="8000"/>"#;
    let edits = [
        [&*start, matrix],
        [
            r#"derivative="0"><Dimension start="60"/>"#,
            &format!(r#"derivative="0"{matrix}"#),
        ],
        [
            r#"<Int32 name="kind""#,
            r#"<UInt64 name="rows" valueReference="8000" causality="structuralParameter" variability="fixed" start="30" min="1"/><Int32 name="kind""#,
        ],
    ];
    fmu.edits = &edits;
    let file = fmu.pack(test, "a");
    for rows in [30, 7, 1] {
        let (n, set) = (2 * rows, format!("a.rows={rows}"));
        let last = format!("a.x[2,{rows}]");
        let until = [
            &*file,
            "--step",
            "0.01",
            "--stop-time",
            "0.1",
            "--set",
            &set,
        ];
        let done = run(
            test,
            &[&until[..], &["--signals", &format!("a.x[1,1],{last}")]].concat(),
        );
        let angle = PI / f64::from(n + 1);
        let rate = 4.0 * f64::from(n + 1).powi(2) * (0.5 * angle).sin().powi(2);
        for (name, i) in [("a.x[1,1]", 1), (&*last, n)] {
            let expected = (f64::from(i) * angle).sin() * (-rate * 0.1).exp();
            let error = (done.last(name) - expected).abs();
            assert!(error < 1e-5, "{rows} {name}: {error:e}");
        }
    }
}
