//! [`Exchange`]: an FMU for Model Exchange that is compiled from `exchange.c`, with its description,
//! and runs of it.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::fs;

use super::foreign::compiled;
use super::program::cosim;
use super::support::{assert_contains, pack, scratch};

/// Kinds and faults in `exchange.c`.
pub(super) const BALL: u32 = 0;
pub(super) const BELT: u32 = 1;
pub(super) const VAN_DER_POL: u32 = 2;
pub(super) const ROD: u32 = 3;
pub(super) const CHATTER: u32 = 4;
pub(super) const TICKS: u32 = 5;
pub(super) const DECAY: u32 = 6;
pub(super) const STEPPED: u32 = 7;
pub(super) const FOLLOW: u32 = 8;
pub(super) const ERROR_RATE: u32 = 1;
pub(super) const NAN_RATE: u32 = 2;
pub(super) const ENDLESS: u32 = 3;
pub(super) const NAN_STATE: u32 = 4;
pub(super) const END_STEP: u32 = 5;
pub(super) const END_EVENT: u32 = 6;
pub(super) const DISCARD_RATE: u32 = 7;
pub(super) const G: f64 = 9.81;

/// An FMU of this kind.
pub(super) struct Exchange<'a> {
    version: u32,
    kind: u32,
    pub fault: u32,
    p: f64,
    x: &'a [f64],
    /// Attributes of the interface.
    pub flags: &'a str,
    pub defines: &'a [&'a str],
    /// Texts of the description, and what takes their place.
    pub edits: &'a [[&'a str; 2]],
}

/// Numbers in text.
fn list(numbers: &[f64], between: &str) -> String {
    let numbers = numbers.iter().map(ToString::to_string);
    Vec::from_iter(numbers).join(between)
}

impl Exchange<'_> {
    pub fn new(version: u32, kind: u32, p: f64, x: &[f64]) -> Exchange<'_> {
        let (fault, flags, defines) = (0, "", &[][..]);
        Exchange {
            version,
            kind,
            fault,
            p,
            x,
            flags,
            defines,
            edits: &[],
        }
    }

    /// Packs it as `NAME.fmu` in a folder of the test.
    pub fn pack(&self, test: &str, name: &str) -> String {
        let folder = scratch(test);
        fs::create_dir_all(&folder).unwrap();
        let n = self.x.len();
        let Self {
            kind, fault, p, x, ..
        } = self;
        let mut values = vec![
            format!("-DN={n}"),
            format!("-DKIND={kind}"),
            format!("-DFAULT={fault}"),
            format!("-DP={p}"),
        ];
        if *kind != ROD {
            values.push(format!("-DX={{{}}}", list(x, ",")));
        }
        let mut defines: Vec<&str> = values.iter().map(String::as_str).collect();
        defines.push("-lm");
        defines.extend(self.defines);
        if self.version == 3 {
            defines.push("-DFMI3");
        }
        let library = compiled(&folder, "exchange.so", &["exchange.c"], &defines);
        let file = folder.join(format!("{name}.fmu"));
        let (text, platform) = match self.version {
            2 => (self.description_2(), "linux64"),
            _ => (self.description_3(), "x86_64-linux"),
        };
        let mut text = text;
        for [old, new] in self.edits {
            assert!(text.contains(old), "{old}: {text}");
            text = text.replacen(old, new, 1);
        }
        pack(&file, &text, platform, &[&library]);
        file.display().to_string()
    }

    fn indicators(&self) -> usize {
        usize::from([BALL, BELT, CHATTER, STEPPED].contains(&self.kind))
    }

    fn interface(&self) -> String {
        let state = if self.version == 2 { "state" } else { "State" };
        format!(
            r#"<ModelExchange modelIdentifier="exchange" canGetAndSetFMU{state}="true" canSerializeFMU{state}="true" {}/>"#,
            self.flags
        )
    }

    fn description_2(&self) -> String {
        let Self {
            kind, fault, p, x, ..
        } = self;
        let n = x.len();
        let mut variables = format!(
            r#"<ScalarVariable name="u" valueReference="5000" causality="input"><Real start="0"/></ScalarVariable>
            <ScalarVariable name="p" valueReference="5001" causality="parameter" variability="fixed"><Real start="{p}"/></ScalarVariable>
            <ScalarVariable name="y" valueReference="6000" causality="output"><Real/></ScalarVariable>
            <ScalarVariable name="last" valueReference="6001" causality="output"><Real/></ScalarVariable>
            <ScalarVariable name="t" valueReference="6002" causality="output"><Real/></ScalarVariable>
            <ScalarVariable name="kind" valueReference="7000" causality="parameter" variability="fixed"><Integer start="{kind}"/></ScalarVariable>
            <ScalarVariable name="count" valueReference="7001" causality="output"><Integer/></ScalarVariable>
            <ScalarVariable name="n" valueReference="7002" causality="input"><Integer start="0"/></ScalarVariable>
            <ScalarVariable name="seen" valueReference="7003" causality="output"><Integer/></ScalarVariable>
            <ScalarVariable name="fault" valueReference="7004" causality="parameter" variability="fixed"><Integer start="{fault}"/></ScalarVariable>"#
        );
        let (first, mut unknowns) = (11, String::new());
        for (i, x) in x.iter().enumerate() {
            let (k, state) = (i + 1, first + i);
            let _ = write!(
                variables,
                r#"<ScalarVariable name="x[{k}]" valueReference="{i}" initial="exact"><Real start="{x}"/></ScalarVariable>"#
            );
            let near = (i.max(1) - 1..(i + 2).min(n)).map(|j| (first + j).to_string());
            let near = Vec::from_iter(near).join(" ");
            let _ = write!(
                unknowns,
                r#"<Unknown index="{}" dependencies="{near} 1"/>"#,
                state + n
            );
        }
        for i in 0..n {
            let (k, vr, state) = (i + 1, 2000 + i, first + i);
            let _ = write!(
                variables,
                r#"<ScalarVariable name="der(x[{k}])" valueReference="{vr}"><Real derivative="{state}"/></ScalarVariable>"#
            );
        }
        if *kind == FOLLOW {
            variables += r#"<ScalarVariable name="u_dot" valueReference="5003" causality="input"><Real start="0" derivative="1"/></ScalarVariable>
                <ScalarVariable name="y_mean" valueReference="6004"><Real/></ScalarVariable>"#;
        }
        format!(
            r#"<fmiModelDescription fmiVersion="2.0" modelName="exchange" guid="t" numberOfEventIndicators="{}">{}
            <ModelVariables>{variables}</ModelVariables><ModelStructure><Outputs><Unknown index="3" dependencies="1"/>
            <Unknown index="4" dependencies=""/><Unknown index="5" dependencies=""/><Unknown index="7" dependencies=""/>
            <Unknown index="9" dependencies="8"/></Outputs><Derivatives>{unknowns}</Derivatives></ModelStructure></fmiModelDescription>"#,
            self.indicators(),
            self.interface()
        )
    }

    /// The states are an array.
    fn description_3(&self) -> String {
        let Self {
            kind, fault, p, x, ..
        } = self;
        let (n, starts) = (x.len(), list(x, " "));
        let more = match *kind {
            FOLLOW => {
                r#"<Float64 name="u_dot" valueReference="5003" causality="input" start="0" derivative="5000"/><Float64 name="y_mean" valueReference="6004"/>"#
            }
            _ => "",
        };
        let indicator = match self.indicators() {
            0 => "",
            _ => r#"<EventIndicator valueReference="6003"/>"#,
        };
        format!(
            r#"<fmiModelDescription fmiVersion="3.0" modelName="exchange" instantiationToken="t">{}<ModelVariables>
            <Float64 name="u" valueReference="5000" causality="input" start="0"/>
            <Float64 name="p" valueReference="5001" causality="parameter" variability="fixed" start="{p}"/>
            <Float64 name="y" valueReference="6000" causality="output"/><Float64 name="last" valueReference="6001" causality="output"/>
            <Float64 name="t" valueReference="6002" causality="output"/><Float64 name="z" valueReference="6003"/>{more}
            <Int32 name="kind" valueReference="7000" causality="parameter" variability="fixed" start="{kind}"/>
            <Int32 name="count" valueReference="7001" causality="output"/><Int32 name="n" valueReference="7002" causality="input" start="0"/>
            <Int32 name="seen" valueReference="7003" causality="output"/>
            <Int32 name="fault" valueReference="7004" causality="parameter" variability="fixed" start="{fault}"/>
            <Float64 name="x" valueReference="0" initial="exact" start="{starts}"><Dimension start="{n}"/></Float64>
            <Float64 name="der(x)" valueReference="2000" derivative="0"><Dimension start="{n}"/></Float64></ModelVariables>
            <ModelStructure><Output valueReference="6000" dependencies="5000"/><Output valueReference="6001" dependencies=""/>
            <Output valueReference="6002" dependencies=""/><Output valueReference="7001" dependencies=""/>
            <Output valueReference="7003" dependencies="7002"/><ContinuousStateDerivative valueReference="2000"/>{indicator}</ModelStructure>
            </fmiModelDescription>"#,
            self.interface()
        )
    }
}

/// Columns of a run, by name, and what is printed.
pub(super) struct Done {
    pub columns: HashMap<String, Vec<f64>>,
    pub text: String,
}

impl Done {
    pub fn last(&self, name: &str) -> f64 {
        *self.columns[name].last().unwrap()
    }

    /// The number before a word of the verdict.
    pub fn number(&self, before: &str) -> u64 {
        let text = self.text.split(&format!(" {before}")).next().unwrap();
        text.rsplit(' ').next().unwrap().parse().unwrap()
    }
}

/// Runs with a CSV file of all outputs and the first state.
#[track_caller]
pub(super) fn run(test: &str, arguments: &[&str]) -> Done {
    let csv = scratch(test).join("out.csv").display().to_string();
    let usual = ["run", "--quiet", "--csv", &csv, "--signals", "*"];
    let (code, text, error) = cosim(&[&usual[..], arguments].concat());
    assert_eq!(code, 0, "{error}");
    let rows = fs::read_to_string(&csv).unwrap();
    let mut rows = rows.lines();
    // The comma in `x[1,2]` is none between columns.
    let mut depth = 0;
    let names = rows.next().unwrap().split(|c| {
        depth += i32::from(c == '[') - i32::from(c == ']');
        c == ',' && depth == 0
    });
    let named = |n: &str| (n.trim_matches('"').to_string(), Vec::new());
    let mut columns: Vec<(String, Vec<f64>)> = names.map(named).collect();
    for row in rows {
        for (cell, (_, column)) in row.split(',').zip(&mut columns) {
            column.push(cell.parse().unwrap());
        }
    }
    Done {
        columns: columns.into_iter().collect(),
        text,
    }
}

#[track_caller]
pub(super) fn refused(test: &str, arguments: &[&str], parts: &[&str]) {
    let csv = scratch(test).join("out.csv").display().to_string();
    let usual = ["run", "--quiet", "--csv", &csv];
    let (code, _, error) = cosim(&[&usual[..], arguments].concat());
    assert_eq!(code, 1, "{error}");
    assert_contains(&error, parts);
}
