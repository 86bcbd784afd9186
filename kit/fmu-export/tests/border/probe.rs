//! A model made to be tested: integrators with a known solution, one variable of every kind, and
//! faults on demand.

use fmu_export::{
    ALL_PARAMETERS, Enumeration, Evaluation, File, Info, InputPolynomial, Model, ModelError,
    StepEnd, Terminal, Variable,
};
use serde::{Deserialize, Serialize};
use std::cell::{Cell, RefCell};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// `x_dot = u + rate` for both elements of `x`.
#[derive(Clone, Serialize, Deserialize)]
pub struct Probe {
    x: [f64; 2],
    gain: f64,
    faulty: bool,
    #[serde(skip)]
    warning: Option<String>,
}

#[derive(Clone, Serialize, Deserialize)]
pub struct Parameters {
    gain: f64,
    rate: [f64; 2],
    law: i32,
    level: i32,
    enabled: bool,
    file: String,
}

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub struct Input {
    u: [f64; 2],
    held: f64,
    fault: i32,
    switch: bool,
}

#[derive(Clone, Copy, Default)]
pub struct Output {
    x: [f64; 2],
    y: f64,
    doubled: i32,
    on: bool,
    inner: f64,
}

/// What output and step share: here only the state and the inputs it was made of.
pub struct Now {
    x: [f64; 2],
    /// Without `switch`, which it does not read.
    u: Input,
}

thread_local! {
    /// Evaluations made in this thread.
    pub static EVALUATIONS: Cell<u32> = const { Cell::new(0) };
    /// Whether the model panics when an instance is made in this thread.
    pub static PANICS_WHEN_MADE: Cell<bool> = const { Cell::new(false) };
}

thread_local! {
    /// For fault 7: told when the step has begun, and asked whether it may go on.
    static WAIT: RefCell<Option<[Arc<AtomicBool>; 2]>> = const { RefCell::new(None) };
}

/// Lets the next step with fault 7 in this thread say when it has begun, and wait.
pub fn wait_in_step(entered: Arc<AtomicBool>, go_on: Arc<AtomicBool>) {
    WAIT.set(Some([entered, go_on]));
}

fn wait() {
    if let Some([entered, go_on]) = WAIT.take() {
        entered.store(true, Ordering::Release);
        while !go_on.load(Ordering::Acquire) {
            std::thread::yield_now();
        }
    }
}

impl Evaluation<Probe> for Now {
    fn new(model: &Probe, _p: &Parameters, u: &Input) -> Result<Self, ModelError> {
        EVALUATIONS.set(EVALUATIONS.get() + 1);
        Ok(Now { x: model.x, u: *u })
    }
}

impl Now {
    fn assert_belongs_to(&self, model: &Probe, u: &Input) {
        assert_eq!(self.x, model.x, "evaluation of another state");
        let of_inputs = |u: &Input| (u.u, u.held, u.fault);
        assert_eq!(of_inputs(&self.u), of_inputs(u), "of other inputs");
    }
}

const LAW: Enumeration = Enumeration::new(
    "Law",
    "an enumeration",
    &[("plain", "first & <plain>"), ("other", "the other")],
);

type V = Variable<Probe>;

/// Value references, counted by hand: the table must agree with them.
#[rustfmt::skip]
pub mod vr {
    pub const GAIN: u32 = 0; pub const RATE: [u32; 2] = [1, 2]; pub const LAW: u32 = 3; pub const LEVEL: u32 = 4;
    pub const ENABLED: u32 = 5; pub const FILE: u32 = 6; pub const U: [u32; 2] = [7, 8]; pub const HELD: u32 = 9;
    pub const FAULT: u32 = 10; pub const SWITCH: u32 = 11; pub const X: [u32; 2] = [12, 13]; pub const Y: u32 = 14;
    pub const DOUBLED: u32 = 15; pub const ON: u32 = 16; pub const INNER: u32 = 17; pub const COUNT: u32 = 18;
}

#[rustfmt::skip]
const VARIABLES: &[V] = &[
    V::parameter("gain", "factor of y", |p| &p.gain, |p| &mut p.gain).unit("1").min(0.0).max(10.0).tunable(),
    V::parameters("rate", "added to u", |p| &p.rate, |p| &mut p.rate).unit("m/s").display_unit("mm/s"),
    V::integer_parameter("law", "of the enumeration", |p| &p.law, |p| &mut p.law).enumeration(&LAW),
    V::integer_parameter("level", "a number", |p| &p.level, |p| &mut p.level).min(-3.0).max(7.0),
    V::boolean_parameter("enabled", "a flag", |p| &p.enabled, |p| &mut p.enabled),
    V::string_parameter("file", "sets everything", |p| &p.file, read_file),
    V::inputs("u", "what is integrated", |u| &u.u, |u| &mut u.u).unit("m/s").min(-1e6),
    V::input("held", "changes at communication points", |u| &u.held, |u| &mut u.held).discrete(),
    V::integer_input("fault", "1 panic, 2 error, 3 warning, 7 wait, 8 half, 9 end, 10 whole in step; 4 panic, 5 error, 6 NaN in output", |u| &u.fault, |u| &mut u.fault),
    V::boolean_input("switch", "a switch", |u| &u.switch, |u| &mut u.switch).not_in_evaluation(),
    V::outputs("x", "integral of u + rate", |y| &y.x).unit("m").nominal(2.5).depends_on(&[]).each_initially_depends_on(&[&["rate[i]"], &[ALL_PARAMETERS]]),
    V::output("y", "gain x[1] + u[2]", |y| &y.y).unit("m/s").depends_on(&["u[2]", "fault"]).initially_depends_on(&["gain", "u"]),
    V::integer_output("doubled", "twice the fault", |y| &y.doubled),
    V::boolean_output("on", "the switch", |y| &y.on).depends_on(&["switch"]),
    V::local("inner", "not for wiring", |y| &y.inner),
];

fn read_file(p: &mut Parameters, text: &str, resources: Option<&Path>) -> Result<(), String> {
    let level = text
        .parse()
        .map_err(|e| format!("{e}; it must be a number"))?;
    let folder = resources
        .map(|folder| folder.display().to_string())
        .unwrap_or_default();
    *p = Parameters {
        level,
        gain: 0.5,
        rate: [7.5, 8.5],
        file: format!("{text}@{folder}"),
        ..p.clone()
    };
    p.file = text.to_owned();
    p.law = if folder == "/tmp/a b" { 2 } else { 1 };
    Ok(())
}

impl Model for Probe {
    type Parameters = Parameters;
    type Input = Input;
    type Output = Output;
    type Evaluation = Now;

    const INFO: Info = Info::new("Probe", "a \"model\" to be tested & nothing else")
        .version("1.2.3")
        .author("nobody")
        .experiment(0.0, 2.0, 0.125)
        .documentation(&[File {
            path: "index.html",
            bytes: b"<p>probe</p>",
        }])
        .icon(b"png")
        .resources(&[File {
            path: "a/b.txt",
            bytes: b"text",
        }])
        .with_input_derivatives()
        .with_output_derivatives()
        .with_directional_derivatives()
        .with_early_return()
        .terminals(&[Terminal::new(
            "axle",
            "org.example.axle",
            "moves and is moved",
            &[("velocity", "u"), ("position", "x")],
        )]);

    fn variables() -> &'static [V] {
        VARIABLES
    }

    fn defaults() -> (Parameters, Input) {
        assert!(!PANICS_WHEN_MADE.get(), "asked to when made");
        let rate = [0.0, 0.25];
        let file = "4".to_owned();
        let p = Parameters {
            gain: 3.0,
            rate,
            law: 1,
            level: 4,
            enabled: true,
            file,
        };
        (
            p,
            Input {
                held: 1.5,
                ..Input::default()
            },
        )
    }

    fn initialize(p: &Parameters, _u: &Input, t: f64) -> Result<Self, ModelError> {
        if p.level == 6 {
            return Err(ModelError::new("level = 6 is for nobody"));
        }
        Ok(Probe {
            x: [t, p.rate[1]],
            gain: p.gain,
            faulty: false,
            warning: None,
        })
    }

    fn tune(&mut self, p: &Parameters) -> Result<(), ModelError> {
        if p.gain == 9.0 {
            return Err(ModelError::new("gain = 9 is for nobody"));
        }
        self.gain = p.gain;
        Ok(())
    }

    fn output(&self, _p: &Parameters, u: &Input, now: &Now) -> Result<Output, ModelError> {
        now.assert_belongs_to(self, u);
        let mut y = self.gain * self.x[0] + u.u[1];
        match u.fault {
            4 => panic!("asked to in output by {}", u.fault),
            5 => return Err(ModelError::new("no output for fault = 5")),
            6 => y = f64::NAN,
            _ => {}
        }
        Ok(Output {
            x: self.x,
            y,
            doubled: u.fault.wrapping_mul(2),
            on: u.switch,
            inner: self.x[0] + self.x[1],
        })
    }

    fn step(
        &mut self,
        p: &Parameters,
        u: &InputPolynomial<Input>,
        now: &Now,
        _t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        now.assert_belongs_to(self, u.value());
        let mut end = StepEnd::WHOLE;
        match u.value().fault {
            1 => {
                self.faulty = true; // half a step: what a panic may leave behind
                panic!("asked to in step");
            }
            2 => return Err(ModelError::new("no step for fault = 2")),
            3 => self.warning = Some("careful in step".to_owned()),
            7 => wait(),
            8 => end.reached = Some(0.5 * h),
            10 => end.reached = Some(h),
            9 => (end.terminate, end.event) = (true, true),
            _ => {}
        }
        assert!(!self.faulty, "a poisoned instance was stepped");
        let h = end.reached.unwrap_or(h);
        for i in 0..2 {
            // The exact integral of the polynomial, from the derivatives themselves.
            let d = |k| u.derivative(k).u[i];
            self.x[i] +=
                h * (d(0) + p.rate[i] + h * (d(1) / 2.0 + h * (d(2) / 6.0 + h * d(3) / 24.0)));
        }
        Ok(end)
    }

    fn output_derivative(
        &self,
        p: &Parameters,
        u: &Input,
        now: &Now,
        u_dot: &Input,
    ) -> Result<Output, ModelError> {
        now.assert_belongs_to(self, u);
        let x = [u.u[0] + p.rate[0], u.u[1] + p.rate[1]];
        Ok(Output {
            x,
            y: self.gain * x[0] + u_dot.u[1],
            ..Output::default()
        })
    }

    fn directional_derivative(
        &self,
        _p: &Parameters,
        u: &Input,
        now: &Now,
        du: &Input,
    ) -> Result<Output, ModelError> {
        now.assert_belongs_to(self, u);
        Ok(Output {
            y: du.u[1],
            ..Output::default()
        })
    }

    fn take_warning(&mut self) -> Option<String> {
        self.warning.take()
    }
}

fmu_export::export_fmu!(Probe);
