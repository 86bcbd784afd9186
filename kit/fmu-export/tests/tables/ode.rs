//! Models of differential equations: accuracy, start values, nested states, steps that cannot be
//! done.

use fmu_export::prelude::*;
use fmu_export::{Continuous, check, model_description};

#[derive(Parameters)]
struct Parameters {
    /// Rate of growth
    #[fmu(unit = "1/s", start = -0.75)]
    rate: f64,
    /// Starts of the chain
    #[fmu(unit = "m", start = [0.5, -0.25])]
    chain_start: [f64; 2],
}

#[derive(Input)]
struct Input {
    /// What is integrated
    #[fmu(unit = "m/s", start = 1.25)]
    v: f64,
}

#[derive(State)]
struct Chain {
    /// Position
    #[fmu(unit = "m")]
    x: [f64; 2],
    /// Not shown, not integrated
    #[fmu(skip)]
    hidden: f64,
    #[fmu(skip)]
    history: Vec<f64>,
    #[fmu(skip)]
    window: [f64; 40],
    #[fmu(skip)]
    last: Option<(i32, String)>,
}

/// Growth, and a chain that follows an input
#[derive(State)]
#[fmu(parameters = Parameters, input = Input, max_step = 0.25)]
struct Growth {
    /// Size
    #[fmu(unit = "1", start = 2.0 * p.rate.abs() + u.v)]
    size: f64,
    #[fmu(start = Chain { x: p.chain_start, hidden: 1.5, history: vec![u.v], ..Chain::default() })]
    chain: Chain,
    /// As the chain starts
    #[fmu(unit = "m", start = p.chain_start, local)]
    copy: [f64; 2],
    /// As the chain starts
    #[fmu(unit = "m", start = p.chain_start)]
    shown: [f64; 2],
}

impl Ode for Growth {
    fn derivative(&self, p: &Parameters, u: &Input, t: f64, dx: &mut Self) {
        *dx = Self {
            size: p.rate * self.size,
            chain: Chain {
                x: [u.v, 3.0 * t * t],
                hidden: -self.chain.hidden,
                history: vec![3.0; 3],
                ..Chain::default()
            },
            ..Self::default()
        };
    }
}

fn started() -> (Growth, Parameters, Input) {
    let (p, u) = Growth::defaults();
    let x = Growth::initialize(&p, &u, 0.0).unwrap();
    (x, p, u)
}

#[test]
fn the_table_agrees_with_the_model() {
    assert_eq!(check::<Growth>(), [""; 0]);
    let xml = model_description::<Growth>().unwrap();
    for name in ["size", "chain.x[1]", "chain.x[2]", "copy[2]"] {
        assert!(xml.contains(&format!("name=\"{name}\"")), "{name}");
    }
    assert!(!xml.contains("hidden"));
    // Variables 1 rate, 2 and 3 chain_start, 4 v, 5 size, 6 and 7 chain, 8 and 9 copy, 10 and 11
    // shown: of their start values.
    for unknown in [
        r#"<Unknown index="5" dependencies="1 4"/>"#,
        r#"<Unknown index="10" dependencies="2"/>"#,
        r#"<Unknown index="11" dependencies="3"/>"#,
        r#"<Unknown index="5" dependencies=""/>"#,
    ] {
        assert!(xml.contains(unknown), "{unknown} {xml}");
    }
    assert!(
        !xml.contains("<Unknown index=\"8\""),
        "a local variable is no unknown"
    );
}

#[test]
fn start_values_follow_parameters_and_inputs() {
    let (x, ..) = started();
    assert_eq!(
        (x.size, x.chain.x, x.chain.hidden),
        (2.75, [0.5, -0.25], 1.5)
    );
    assert_eq!((x.copy, x.shown), ([0.5, -0.25], [0.5, -0.25]));
}

/// What is skipped is of any type: a step leaves it alone, saved states have it.
#[test]
fn skipped_fields_are_saved_and_not_integrated() {
    let (mut x, p, u) = started();
    x.chain.window[39] = 7.0;
    x.chain.last = Some((-3, "kept".to_owned()));
    Model::step(&mut x, &p, &InputPolynomial::held(u), &(), 0.0, 0.5).unwrap();
    let bytes = postcard::to_stdvec(&x).unwrap();
    let read: Growth = postcard::from_bytes(&bytes).unwrap();
    for x in [&x, &read] {
        let chain = &x.chain;
        assert_eq!((chain.hidden, &chain.history[..]), (1.5, &[1.25][..]));
        assert_eq!((chain.window[39], chain.window[0]), (7.0, 0.0));
        assert_eq!(chain.last, Some((-3, "kept".to_owned())));
    }
    assert_eq!(read.size.to_bits(), x.size.to_bits());
}

/// Oracle: size e^(rate t). The method of order 4 misses e^−z, z = −rate h, by z⁵/120 a step, e^z
/// z⁵/120 of it, and n times as much in n steps. The next term is z/6 of it.
#[test]
fn the_error_is_that_of_order_4() {
    for n in [4_i32, 8, 16] {
        let (mut x, p, u) = started();
        let h = 1.0 / f64::from(n);
        for k in 0..n {
            Model::step(
                &mut x,
                &p,
                &InputPolynomial::held(u),
                &(),
                f64::from(k) * h,
                h,
            )
            .unwrap();
        }
        let error = (x.size / 2.75 / (-0.75_f64).exp() - 1.0).abs();
        let z = 0.75 * h;
        let bound = f64::from(n) * z.exp() * z.powi(5) / 120.0;
        let least = bound * (1.0 - z / 4.0);
        assert!(least < error && error < bound, "{n}: {error:e} {bound:e}");
    }
}

/// A step longer than `max_step` is divided; a polynomial of order 3 in time is integrated exactly,
/// be it in the equations or an input.
#[test]
fn inputs_follow_their_derivatives_and_steps_are_divided() {
    let (mut x, p, u) = started();
    let course = InputPolynomial::with_derivatives(u, &[Input { v: 2.0 }, Input { v: -6.0 }]);
    Model::step(&mut x, &p, &course, &(), 1.0, 1.0).unwrap();
    // ∫ 1.25 + 2 s − 3 s² ds = 1.25, ∫ 3 t² dt from 1 to 2 = 7.
    assert!((x.chain.x[0] - 1.75).abs() < 1e-14, "{:?}", x.chain.x);
    assert!((x.chain.x[1] - 6.75).abs() < 1e-14, "{:?}", x.chain.x);
    let z = 0.75 * 0.25_f64;
    let bound = 4.0 * z.exp() * z.powi(5) / 120.0;
    let error = (x.size / 2.75 / (-0.75_f64).exp() - 1.0).abs();
    assert!(error < bound, "not in four steps: {error:e} {bound:e}");
}

#[test]
fn a_step_that_cannot_be_done_leaves_the_state() {
    let (mut x, mut p, u) = started();
    p.rate = 1e300;
    let held = InputPolynomial::held(u);
    let error = Model::step(&mut x, &p, &held, &(), 0.0, 0.5).unwrap_err();
    let text = error.to_string();
    assert!(
        text.starts_with("`size` became ")
            && text.ends_with(" at the end of the step; it must be finite"),
        "{text}"
    );
    p.rate = 1.0;
    let error = Model::step(&mut x, &p, &held, &(), 0.0, 300_000.0).unwrap_err();
    assert_eq!(
        error.to_string(),
        "1200000 internal steps of at most 0.25 s would be needed; there must be at most 1000000"
    );
    assert_eq!((x.size, x.chain.x), (2.75, [0.5, -0.25]));
    p.rate = f64::NAN;
    let error = Growth::initialize(&p, &u, 0.0).err().unwrap();
    assert_eq!(
        error.to_string(),
        "`size` became NaN at the start; it must be finite"
    );
}

#[derive(Input)]
struct Valve {
    /// Opens at 7
    #[fmu(unit = "1", min = 0.0, max = 10.0)]
    opening: f64,
    /// Noticed in the one case
    #[fmu(unit = "1/s")]
    flow: f64,
}

/// A model for its solver alone, with a wrong dependency in a mode that small moves never reach
#[derive(State)]
#[fmu(input = Valve, solver = "stiff")]
struct Tank {
    /// Level
    #[fmu(unit = "1", rate_depends_on(level, opening))]
    level: f64,
    /// Follows the other
    #[fmu(unit = "1", rate_depends_on(level, second))]
    second: f64,
    /// Was open
    #[fmu(discrete)]
    opened: bool,
}

impl Ode for Tank {
    fn derivative(&self, _p: &(), u: &Valve, _t: f64, dx: &mut Self) {
        dx.level = 0.1 - self.level + if u.opening > 7.0 { u.opening } else { 0.0 };
        let more = if self.opened { u.flow } else { 0.0 };
        dx.second = self.level - self.second + more;
    }

    fn event(&mut self, _p: &(), u: &Valve, _t: f64) -> Event {
        self.opened |= u.opening > 7.0;
        Event::NONE
    }
}

#[test]
fn wrong_dependencies_of_a_solver_in_modes_far_away_are_found() {
    assert_eq!(
        check::<Tank>(),
        ["`der(second)` depends on `flow`, which it does not declare"]
    );
}

#[derive(Parameters)]
struct Switch {
    /// Level at which it closes
    #[fmu(unit = "1", start = 0.25, tunable)]
    close: f64,
    /// Level at which it opens
    #[fmu(unit = "1", start = 0.75, tunable)]
    open: f64,
}

/// Of a field of its own, without a dependency on serde
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(crate = "fmu_export::serde")]
struct Memory {
    tuned: Vec<f64>,
}

/// Grows to its end
#[derive(State)]
#[fmu(parameters = Switch, solver = "adaptive")]
struct Growing {
    /// Level
    #[fmu(unit = "1", initially_depends_on(close))]
    level: f64,
    #[fmu(skip)]
    memory: Memory,
    #[fmu(skip)]
    log: Log,
}

impl Ode for Growing {
    fn begin(&mut self, p: &Switch, _u: &(), t: f64) -> Result<(), ModelError> {
        if p.close >= p.open {
            let text = format!("`close` = {} must be below `open` = {}", p.close, p.open);
            return Err(ModelError::new(text));
        }
        self.level = p.close + t;
        Ok(())
    }

    fn derivative(&self, _p: &Switch, _u: &(), _t: f64, dx: &mut Self) {
        dx.level = 1.0;
    }

    fn valid(&self, _p: &Switch, _u: &(), t: f64) -> Result<(), ModelError> {
        match self.level < 2.0 {
            true => Ok(()),
            false => Err(ModelError::new(format!("t = {t} s: it is full"))),
        }
    }

    fn tuned(&mut self, p: &Switch) -> Result<(), ModelError> {
        self.memory.tuned.push(p.open);
        self.log
            .warning("", format_args!("{} times", self.memory.tuned.len()));
        match p.open < 5.0 {
            true => Ok(()),
            false => Err(ModelError::new("too far")),
        }
    }

    fn completed(&mut self, p: &Switch, _u: &(), t: f64) -> Result<bool, ModelError> {
        self.memory.tuned.push(t);
        Ok(t > p.close)
    }

    fn messages(&mut self) -> Option<&mut Log> {
        Some(&mut self.log)
    }
}

#[test]
fn an_ode_compares_parameters_fails_by_name_and_reacts_to_tuning_and_steps() {
    assert_eq!(check::<Growing>(), [""; 0]);
    let (mut p, u) = Growing::defaults();
    p.close = 1.0;
    let error = Growing::initialize(&p, &u, 0.0).err().unwrap();
    assert_eq!(error.to_string(), "`close` = 1 must be below `open` = 0.75");
    p.close = 0.25;
    let mut x = Growing::initialize(&p, &u, 0.5).unwrap();
    assert_eq!(x.level, 0.75);
    let held = InputPolynomial::held(u);
    Model::step(&mut x, &p, &held, &(), 0.5, 1.0).unwrap();
    assert!((x.level - 1.75).abs() < 1e-12);
    let error = Model::step(&mut x, &p, &held, &(), 1.5, 1.0).err().unwrap();
    assert!(error.to_string().ends_with("it is full"), "{error}");
    assert!((x.level - 1.75).abs() < 1e-12);
    x.tune(&p).unwrap();
    p.open = 7.0;
    assert_eq!(x.tune(&p).unwrap_err().to_string(), "too far");
    assert_eq!(x.memory.tuned, [0.75]);
    let events = [0.125, 0.5].map(|t| x.completed_step(&p, &(), t).unwrap());
    assert_eq!(
        (events, &x.memory.tuned[1..]),
        ([false, true], &[0.125, 0.5][..])
    );
    assert!(Model::log(&mut x).is_some());
}

/// A position of a switch
#[derive(Clone, Copy, Enumeration)]
enum Position {
    /// Open
    Open,
    /// Closed
    Closed,
}

#[derive(Parameters)]
struct Sizes {
    /// Number of switches
    #[fmu(structural, start = 3, min = 1, max = 9)]
    n: i32,
}

/// Switches, as many as a parameter says
#[derive(State)]
#[fmu(parameters = Sizes)]
struct Switches {
    /// Where they are
    #[fmu(discrete, len = p.n, start = Position::Closed)]
    position: Vec<Choice<Position>>,
    /// How often each was switched
    #[fmu(discrete, len = p.n, start = 7 + i as i32)]
    count: Vec<i32>,
    /// Whether they are locked
    #[fmu(discrete, len = p.n, start = i == 1)]
    locked: Vec<bool>,
    /// What is written on them
    #[fmu(discrete, len = p.n)]
    label: Vec<String>,
}

impl Ode for Switches {
    fn derivative(&self, _p: &Sizes, _u: &(), _t: f64, _dx: &mut Self) {}
}

#[test]
fn discrete_vectors_are_of_any_type() {
    assert_eq!(check::<Switches>(), [""; 0]);
    let (p, u) = Switches::defaults();
    let x = Switches::initialize(&p, &u, 0.0).unwrap();
    assert_eq!(
        (&x.count[..], &x.locked[..]),
        (&[7, 8, 9][..], &[false, true, false][..])
    );
    assert!(
        x.position
            .iter()
            .all(|one| matches!(**one, Position::Closed))
    );
    assert_eq!((x.position.len(), x.label), (3, vec![String::new(); 3]));
}
