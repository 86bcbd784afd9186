//! Models whose solver chooses its steps, called as an importer calls them.
#![allow(non_snake_case)]
#![allow(missing_docs, clippy::undocumented_unsafe_blocks)]

#[path = "../border/client.rs"]
#[allow(dead_code)] // an importer for several tests
mod client;
mod rod;
#[path = "../border/states.rs"]
mod states;

/// The model that the importer loads.
mod probe {
    pub use crate::rod::Rod as Probe;
}

use allocation_counter::measure;
use client::*;
use fmu_export::ffi::*;
use fmu_export::prelude::*;
use rod::{CELLS, Rod, evaluations, exact};

/// Its states: the first number is that of the input.
fn cells(fmu: &Fmu) -> [f64; CELLS] {
    fmu.get(std::array::from_fn(|i| i as u32 + 1))
}

fn error(fmu: &Fmu, t: f64) -> f64 {
    (cells(fmu).iter().zip(exact(t)))
        .map(|(x, exact)| (x - exact).abs())
        .fold(0.0, f64::max)
}

/// An instance at the start of its steps.
fn stepping(tolerance: Option<f64>) -> Fmu {
    let fmu = Fmu::instantiated();
    assert_eq!(setup(&fmu, tolerance), Status::Ok);
    assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
    fmu.start();
    fmu
}

fn setup(fmu: &Fmu, tolerance: Option<f64>) -> Status {
    let is_given = tolerance.is_some().into();
    unsafe { fmi2SetupExperiment(fmu.c, is_given, tolerance.unwrap_or(-1.0), 0.0, 0, 0.0) }
}

/// Errors of internal steps add up, and conduction damps them: below twice the tolerance (the
/// values are 2 ± 1, the nominal value 1). Without one it is that of the model, 1e-4. Each is met
/// by no more than the effort it needs.
#[test]
fn the_tolerance_is_the_importers() {
    let mut last = f64::INFINITY;
    let mut least = 0;
    for (tolerance, effective) in [(None, 1e-4), (Some(1e-6), 1e-6), (Some(1e-9), 1e-9)] {
        let fmu = stepping(tolerance);
        let before = evaluations();
        for k in 0..10 {
            assert_eq!(fmu.step(f64::from(k) * 0.01, 0.01), Status::Ok);
        }
        let (error, effort) = (error(&fmu, 0.1), evaluations() - before);
        assert!(
            error < 2.0 * effective && error < last,
            "{effective:e}: {error:e}"
        );
        assert!(effort > least, "{effective:e}: {effort}");
        (last, least) = (error, effort);
    }
}

#[test]
fn a_tolerance_that_is_none_is_refused_and_nothing_changes() {
    let fmu = Fmu::instantiated();
    let before = fmu.snapshot();
    for wrong in [0.0, -1e-6, 1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(setup(&fmu, Some(wrong)), Status::Error);
        let text = fmu.last().text;
        let expected =
            format!("fmi2SetupExperiment: tolerance = {wrong} must be above 0 and below 1");
        assert_eq!(text, expected);
        assert_eq!(fmu.snapshot(), before);
    }
    assert_eq!(setup(&fmu, Some(1e-3)), Status::Ok);
}

#[test]
fn the_description_has_the_models_tolerance() {
    let xml = fmu_export::model_description::<Rod>().unwrap();
    assert!(xml.contains(r#" tolerance="0.0001""#), "{xml}");
    assert_eq!(fmu_export::check::<Rod>(), [""; 0]);
}

/// Restored states go on to the same bits, in another instance too: the step to try first is saved.
#[test]
fn a_restored_state_goes_on_bit_for_bit() {
    let fmu = stepping(Some(1e-7));
    assert_eq!(fmu.step(0.0, 0.01), Status::Ok);
    let bytes = fmu.snapshot();
    let run = |fmu: &Fmu| {
        assert_eq!(fmu.step(0.01, 0.005), Status::Ok);
        assert_eq!(fmu.step(0.015, 0.02), Status::Ok);
        fmu.snapshot()
    };
    let first = run(&fmu);
    let other = stepping(None);
    let (status, state) = other.deserialize(&bytes);
    assert_eq!((status, other.restore(state)), (Status::Ok, Status::Ok));
    assert_eq!(run(&other), first);
}

/// The input jumps: the internal step of before is too long for what then comes.
#[test]
fn steps_that_were_too_long_are_told() {
    let fmu = stepping(Some(1e-8));
    assert_eq!(fmu.step(0.0, 0.2), Status::Ok);
    assert_eq!(fmu.set(&[0], &[1e3]), Status::Ok);
    let told = |fmu: &Fmu| {
        let all = fmu.messages();
        all.into_iter()
            .filter(|m| m.text.contains("rejected by the tolerance"))
            .map(|m| m.text)
            .collect::<Vec<_>>()
    };
    let before = told(&fmu).len();
    assert_eq!(fmu.step(0.2, 0.2), Status::Ok);
    let told = told(&fmu);
    assert_eq!(told.len(), before + 1, "{:?}", fmu.messages());
    let last = &told[before];
    assert!(last.starts_with("t = 0.2 s, h = 0.2 s: "), "{last}");
    let numbers: Vec<u64> = last
        .split(' ')
        .filter_map(|word| word.parse().ok())
        .collect();
    assert!(numbers.iter().all(|&n| n > 0), "{last}");
}

/// Where derivatives are refused nothing moves.
#[test]
fn a_step_that_fails_leaves_everything() {
    let fmu = stepping(None);
    assert_eq!(fmu.step(0.0, 0.01), Status::Ok);
    assert_eq!(fmu.set(&[0], &[1e308]), Status::Ok);
    let before = fmu.snapshot();
    assert_eq!(fmu.step(0.01, 1.0), Status::Discard);
    assert_eq!(fmu.snapshot(), before);
    assert_eq!(fmu.set(&[0], &[0.0]), Status::Ok);
    assert_eq!(fmu.step(0.01, 1.0), Status::Ok);
}

#[test]
fn a_step_does_not_allocate() {
    let fmu = Fmu::with(callbacks, c"file:///tmp/", false);
    assert_eq!(setup(&fmu, Some(1e-6)), Status::Ok);
    assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
    fmu.start();
    assert_eq!(fmu.step(0.0, 0.01), Status::Ok);
    let steps = || {
        for k in 1..20 {
            assert_eq!(fmu.set(&[0], &[f64::from(k % 3) * 50.0]), Status::Ok);
            assert_eq!(fmu.step(f64::from(k) * 0.01, 0.01), Status::Ok);
        }
    };
    assert_eq!(measure(steps).count_total, 0);
}

/// What `rate_depends_on` says is the pattern of the Jacobian: three evaluations in place of 20.
#[test]
fn the_jacobian_is_as_sparse_as_is_said() {
    let effort = |step: fn()| {
        let before = evaluations();
        step();
        evaluations() - before
    };
    let sparse =
        effort(|| rod::step(rod::Sparse::initialize(&(), &Default::default(), 0.0).unwrap()));
    let exact = effort(|| rod::step(Rod::initialize(&(), &Default::default(), 0.0).unwrap()));
    let full = effort(|| rod::step(rod::Full::initialize(&(), &Default::default(), 0.0).unwrap()));
    // 7 of the stages and 2 + 3 or 2 + 20 of each Jacobian, of which there is one a step.
    assert!(
        full * 12 > sparse * 27 && full * 12 < sparse * 30,
        "{sparse} {full}"
    );
    // None of a Jacobian that the model knows; differences of linear equations miss it by rounding.
    assert!(
        sparse * 9 > exact * 11 && sparse * 9 < exact * 13,
        "{sparse} {exact}"
    );
}

/// Oracle: the matrix of conduction, −400 (1, −2, 1) by rows, and what differences make of it.
#[test]
fn derivatives_are_those_that_the_model_gives() {
    let fmu = stepping(None);
    let rate = |k: u32| CELLS as u32 + k;
    let found = fmu.directional(&[rate(1), rate(2), rate(3), rate(4)], &[2], &[1.0]);
    assert_eq!(found, (Status::Ok, vec![400.0, -800.0, 400.0, 0.0]));
    let both = fmu.directional(&[rate(1), rate(2), 1], &[0, 1], &[0.5, 2.0]);
    assert_eq!(both, (Status::Ok, vec![0.5 - 800.0, 800.0, 2.0]));
}

#[test]
fn a_wrong_jacobian_is_named() {
    let wrong = |of, by, said, found| {
        format!(
            "the directional derivative of `{of}` by `{by}` is {said}, differences of the output give {found}"
        )
    };
    assert_eq!(
        fmu_export::check::<rod::Wrong>(),
        [
            wrong("der(T)", "T", "3.0000e0", "-3.0000e0"),
            wrong("der(T)", "heat", "5.0000e-1", "1.0000e0"),
            wrong("twice", "T", "0.0000e0", "2.0000e0"),
        ]
    );
}

/// A rate names what is no variable: the first step says so.
#[test]
fn a_rate_of_an_unknown_name_is_refused() {
    let mut rod = rod::Misnamed::initialize(&(), &Default::default(), 0.0).unwrap();
    let u = InputPolynomial::held(rod::Input::default());
    let error = Model::step(&mut rod, &(), &u, &(), 0.0, 0.1).unwrap_err();
    let text = "the rate of `T` depends on `t[i]`; it must be an input or state of the table";
    assert_eq!(error.to_string(), text);
}

/// Cells that say nothing of what their rates depend on
#[derive(State)]
#[fmu(parameters = Cells, solver = "stiff")]
struct Undeclared {
    /// Cells
    #[fmu(unit = "1", len = p.n)]
    x: Vec<f64>,
}

#[derive(Parameters)]
struct Cells {
    /// Number of cells
    #[fmu(start = 2, min = 1)]
    n: i32,
}

impl Ode for Undeclared {
    fn derivative(&self, _p: &Cells, _u: &(), _t: f64, _dx: &mut Self) {}

    fn valid(&self, _p: &Cells, _u: &(), _t: f64) -> Result<(), ModelError> {
        Err(ModelError::new("the equations were asked for"))
    }
}

/// A full Jacobian is made for as many states as the message says, and for no more.
#[test]
fn too_many_states_must_say_what_their_rates_depend_on() {
    for (n, text) in [
        (4096, "the equations were asked for"),
        (
            4097,
            "a solver for stiff models of 4097 states must know which states each derivative reads: say `rate_depends_on(…)` of each state, \
             or have at most 4096",
        ),
    ] {
        let (mut p, u) = Undeclared::defaults();
        p.n = n;
        let mut model = Undeclared::initialize(&p, &u, 0.0).unwrap();
        let error = Model::step(&mut model, &p, &InputPolynomial::held(u), &(), 0.0, 0.1);
        assert_eq!(error.unwrap_err().to_string(), text);
    }
}
