//! Time of one set + step + get through the C functions with a model that does next to nothing:
//! `cargo run --release -p fmi2-export --example overhead`.

use fmi2_export::ffi::{CallbackFunctions, Component, Status, Str};
use fmi2_export::{Info, InputPolynomial, Model, ModelError, Variable};
use serde::{Deserialize, Serialize};
use std::ffi::{CString, c_int};
use std::hint::black_box;
use std::ptr;
use std::time::Instant;

/// `x_dot = u` in four places.
#[derive(Clone, Serialize, Deserialize)]
struct Integrators {
    x: [f64; 4],
}

#[derive(Clone, Serialize, Deserialize)]
struct Nothing;

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Input {
    u: [f64; 4],
}

#[derive(Clone, Copy, Default)]
struct Output {
    x: [f64; 4],
}

type V = Variable<Integrators>;
const VARIABLES: &[V] = &[
    V::inputs("u", "rate", |u| &u.u, |u| &mut u.u)
        .min(-1e9)
        .max(1e9),
    V::outputs("x", "integral", |y| &y.x).depends_on(&[]),
];

impl Model for Integrators {
    type Parameters = Nothing;
    type Input = Input;
    type Output = Output;
    const INFO: Info = Info::new("Integrators", "next to nothing");

    fn variables() -> &'static [V] {
        VARIABLES
    }

    fn defaults() -> (Nothing, Input) {
        (Nothing, Input::default())
    }

    fn initialize(_p: &Nothing, _u: &Input, _t: f64) -> Result<Self, ModelError> {
        Ok(Self { x: [0.0; 4] })
    }

    fn output(&self, _p: &Nothing, _u: &Input) -> Result<Output, ModelError> {
        Ok(Output { x: self.x })
    }

    fn step(
        &mut self,
        _p: &Nothing,
        u: &InputPolynomial<Input>,
        _t: f64,
        h: f64,
    ) -> Result<(), ModelError> {
        for (x, u) in self.x.iter_mut().zip(u.value().u) {
            *x += h * u;
        }
        Ok(())
    }
}

fmi2_export::export_fmu!(Integrators);

unsafe extern "C" {
    fn fmi2Instantiate(
        name: Str,
        kind: c_int,
        guid: Str,
        resources: Str,
        functions: *const CallbackFunctions,
        visible: c_int,
        on: c_int,
    ) -> Component;
    fn fmi2FreeInstance(c: Component);
    fn fmi2EnterInitializationMode(c: Component) -> Status;
    fn fmi2ExitInitializationMode(c: Component) -> Status;
    fn fmi2SetReal(c: Component, vr: *const u32, n: usize, value: *const f64) -> Status;
    fn fmi2GetReal(c: Component, vr: *const u32, n: usize, value: *mut f64) -> Status;
    fn fmi2DoStep(c: Component, t: f64, h: f64, no_set_prior: c_int) -> Status;
}

fn main() {
    let xml = fmi2_export::model_description::<Integrators>().expect("a table without mistakes");
    let guid = xml
        .split('"')
        .find(|text| text.starts_with('{'))
        .expect("a GUID");
    let guid = CString::new(guid).expect("no NUL in a GUID");
    let functions = CallbackFunctions {
        logger: None,
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: ptr::null_mut(),
    };
    let (inputs, outputs, u, mut x) = (
        [0_u32, 1, 2, 3],
        [4_u32, 5, 6, 7],
        [1.0, 2.0, 3.0, 4.0],
        [0.0; 4],
    );
    let (steps, h) = (5_000_000, 1e-3);
    // SAFETY: one instance, made and freed here; arrays of the lengths given.
    unsafe {
        let c = fmi2Instantiate(
            c"one".as_ptr(),
            1,
            guid.as_ptr(),
            ptr::null(),
            &functions,
            0,
            0,
        );
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
        for _ in 0..3 {
            let start = Instant::now();
            for k in 0..steps {
                // All three have a look at the same memory, as an importer would; black_box keeps the calls apart.
                let status = [
                    fmi2SetReal(c, inputs.as_ptr(), 4, black_box(&u).as_ptr()),
                    fmi2DoStep(c, f64::from(k) * h, h, 1),
                    fmi2GetReal(c, outputs.as_ptr(), 4, black_box(&mut x).as_mut_ptr()),
                ];
                assert_eq!(status, [Status::Ok; 3]);
            }
            let each = start.elapsed().as_secs_f64() / f64::from(steps);
            println!("{:.1} ns per set of 4 + step + get of 4", 1e9 * each);
            reset(c);
        }
        fmi2FreeInstance(c);
    }
}

/// Back to the start time for the next round.
unsafe fn reset(c: Component) {
    unsafe extern "C" {
        fn fmi2Reset(c: Component) -> Status;
    }
    // SAFETY: a live instance.
    unsafe {
        assert_eq!(fmi2Reset(c), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
    }
}
