//! What model descriptions say of units, types, further names and bytes, by derives and by hand.

use fmu_export::prelude::*;
use fmu_export::{KNOWN_UNITS, check, model_description, model_description3};

const PRESSURE: TypeDefinition = TypeDefinition::new("Pressure", "Absolute pressure")
    .quantity("Pressure")
    .unit("Pa")
    .display_unit("mbar")
    .min(0.0)
    .nominal(1e5);
const RISE: TypeDefinition = TypeDefinition::new("Rise", "Difference of temperatures")
    .quantity("ThermodynamicTemperature")
    .unit("K")
    .display_unit("degC")
    .relative();

#[derive(Parameters)]
struct Valve {
    /// Conductance
    #[fmu(unit = "m3/(s.Pa)", display_unit = "l/(min.bar)", start = 1e-8)]
    conductance: f64,
    /// Diffusivity
    #[fmu(unit = "m2/s", start = 1e-5, alias("alpha", "a"))]
    diffusivity: f64,
}

#[derive(Parameters)]
struct Parameters {
    valve: [Valve; 2],
    /// Amount
    #[fmu(unit = "mol", start = 2.0, alias("moles"))]
    amount: f64,
}

#[derive(Input)]
struct Input {
    /// Supply
    #[fmu(type = PRESSURE, start = 2e5, alias("p_in"))]
    supply: f64,
    /// Gradients
    #[fmu(unit = "K/m", alias("slope"))]
    gradient: [f64; 2],
}

#[derive(Output)]
struct Output {
    /// Flow
    #[fmu(unit = "l/min", depends_on(supply))]
    flow: f64,
    /// Warmth
    #[fmu(type = RISE, unit = "K", max = 50.0, depends_on(supply))]
    rise: f64,
}

/// A tank with a valve
#[derive(State)]
#[fmu(parameters = Parameters, input = Input, output = Output, model_exchange)]
struct Tank {
    /// Pressure
    #[fmu(unit = "Pa", type = PRESSURE, start = 1e5, alias("p_tank"))]
    pressure: f64,
    /// Volume that has passed
    #[fmu(unit = "m3")]
    volume: [f64; 2],
}

impl Ode for Tank {
    fn derivative(&self, p: &Parameters, u: &Input, _t: f64, dx: &mut Self) {
        let flow = p.valve[0].conductance * (u.supply - self.pressure);
        (dx.pressure, dx.volume) = (flow * 1e8 * p.amount, [flow, u.gradient[0]]);
    }

    fn outputs(&self, p: &Parameters, u: &Input) -> Output {
        let flow = p.valve[0].conductance * (u.supply - self.pressure);
        Output {
            flow: 6e4 * flow,
            rise: 1e-6 * u.supply,
        }
    }
}

/// Oracle: the texts that FMI 2.0 (sections 2.2.2, 2.2.3, 2.2.7) and FMI 3.0 (2.4.3 to 2.4.7) ask
/// for; factors by hand: 1 l/(min·bar) is 1e-3/(60 · 1e5) m³/(s·Pa).
#[test]
fn units_types_and_aliases_are_described() {
    assert_eq!(check::<Tank>(), [""; 0]);
    let [two, three] =
        [model_description::<Tank>(), model_description3::<Tank>()].map(Result::unwrap);
    let both = [
        r#"<Unit name="m3/(s.Pa)">"#,
        r#"<BaseUnit kg="-1" m="4" s="1"/>"#,
        r#"<DisplayUnit name="l/(min.bar)" factor="6000000000.0"/>"#,
        r#"<BaseUnit m="3" s="-1" factor="1.6666666666666667e-5"/>"#,
        r#"<BaseUnit mol="1"/>"#,
        r#"<BaseUnit m="-1" K="1"/>"#,
        r#"<DisplayUnit name="mbar" factor="0.01"/>"#,
        r#"quantity="Pressure" unit="Pa" displayUnit="mbar" min="0.0" nominal="100000.0"/>"#,
        r#"quantity="ThermodynamicTemperature" unit="K" displayUnit="degC" relativeQuantity="true"/>"#,
        r#"declaredType="Pressure" unit="Pa" displayUnit="mbar" min="0.0" nominal="100000.0""#,
        r#"declaredType="Rise" unit="K" displayUnit="degC" max="50.0""#,
    ];
    for (xml, text) in [&two, &three]
        .into_iter()
        .flat_map(|xml| both.map(|text| (xml, text)))
    {
        assert!(xml.contains(text), "{text} {xml}");
    }
    for text in [
        r#"<SimpleType name="Pressure" description="Absolute pressure">"#,
        r#"<Real unit="Pa/s" derivative="#,
        r#"<Real unit="m3/s" derivative="#,
        r#"<ScalarVariable name="valve[2].alpha" valueReference="3" description="Diffusivity" causality="local" variability="fixed" initial="calculated">"#,
        r#"<ScalarVariable name="slope[2]" valueReference="7" description="Gradients" causality="local" variability="continuous" initial="calculated">"#,
    ] {
        assert!(two.contains(text), "{text} {two}");
    }
    let last = two.rfind("</ScalarVariable>").unwrap();
    assert!(two[..last].rfind("name=\"p_tank\"") > two[..last].rfind("name=\"der("));
    for text in [
        r#"<Float64Type name="Rise" description="Difference of temperatures" quantity"#,
        r#"<Alias name="valve[1].a" description="Diffusivity"/>"#,
        r#"<Alias name="slope" description="Gradients"/>"#,
        r#"<Alias name="p_tank" description="Pressure"/>"#,
    ] {
        assert!(three.contains(text), "{text} {three}");
    }
}

#[derive(Input)]
struct Bytes {
    /// A picture
    #[fmu(mime_type = "image/png", max_size = 4, start = &[1, 2, 3])]
    picture: Binary,
}

/// Bytes
#[derive(State)]
#[fmu(input = Bytes)]
struct Camera {
    /// Time
    #[fmu(unit = "s")]
    t: f64,
}

impl Ode for Camera {
    fn derivative(&self, _p: &(), _u: &Bytes, _t: f64, dx: &mut Self) {
        dx.t = 1.0;
    }
}

#[test]
fn bytes_say_what_and_how_many_they_are() {
    assert_eq!(check::<Camera>(), [""; 0]);
    let xml = model_description3::<Camera>().unwrap();
    let text = r#"mimeType="image/png" maxSize="4">"#;
    assert!(xml.contains(text), "{xml}");
    assert!(!xml.contains(" max="), "{xml}");
}

#[derive(Input)]
struct Long {
    /// Too many bytes
    #[fmu(max_size = 2, start = &[1, 2, 3])]
    bytes: Binary,
}

/// Bytes
#[derive(State)]
#[fmu(input = Long)]
struct Tape {
    /// Time
    #[fmu(unit = "s")]
    t: f64,
}

impl Ode for Tape {
    fn derivative(&self, _p: &(), _u: &Long, _t: f64, dx: &mut Self) {
        dx.t = 1.0;
    }
}

#[test]
fn too_many_bytes_are_refused() {
    let text = model_description3::<Tape>().unwrap_err();
    let expected = "variable `bytes`: start value 010203 must be at most 2 bytes long";
    assert_eq!(text, expected);
}

#[derive(Input)]
struct Level {
    /// Level that is wanted
    #[fmu(unit = "m")]
    level: f64,
}

/// A filter whose input is named like its state
#[derive(State)]
#[fmu(input = Level)]
struct Filter {
    /// Level
    #[fmu(unit = "m", alias("h"))]
    level: f64,
}

impl Ode for Filter {
    fn derivative(&self, _p: &(), u: &Level, _t: f64, dx: &mut Self) {
        dx.level = u.level - self.level;
    }
}

#[test]
fn an_input_named_like_a_state_is_told() {
    let text = model_description::<Filter>().unwrap_err();
    let expected = "variable `level`: is the name of a Real input and of a Real output; each variable has a name of its own";
    assert!(text.starts_with(expected), "{text}");
}

/// Every unit and symbol of the page is one, and every known unit and display unit is on it.
#[test]
fn the_page_lists_the_units() {
    let page = include_str!("../../../../docs/kit/units.md");
    let cell = |name: &str| page.contains(&format!("`{name}`"));
    for unit in KNOWN_UNITS {
        let shown = unit.display.iter().map(|shown| shown.name);
        for name in [unit.name].into_iter().chain(shown) {
            assert!(cell(name), "{name}");
        }
    }
    let rows = page.lines().filter(|line| line.starts_with("| "));
    for name in rows.flat_map(|row| row.split('`').skip(1).step_by(2)) {
        assert!(Unit::find(name).is_some(), "{name}");
    }
}
