//! `torture exchange`: random calls of an instance for Model Exchange, in any order. A call that
//! the standard does not allow must be refused and change nothing; a right one must succeed.

use std::path::Path;

use anyhow::{Result, bail, ensure};
use fmi_description::Variable;
use fmi_import::instance::InstanceOptions;
use fmi_import::raw::{Array, ContinuousValues, InstanceKind, RawInstance, Update};
use fmi_import::status::{DISCARD, ERROR, OK};
use fmi_import::{Fmu, Instance};

use crate::arguments::seeds;
use crate::random::Random;

/// State of an instance for Model Exchange.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Instantiated,
    Initialization,
    Event,
    ContinuousTime,
    Terminated,
}
use State::{ContinuousTime, Event, Initialization, Instantiated, Terminated};

/// States in which an instance has values.
const INITIALIZED: &[State] = &[Initialization, Event, ContinuousTime, Terminated];
/// States in which FMI 2.0 has nominal values.
const WITH_NOMINALS: &[State] = &[Instantiated, Event, ContinuousTime, Terminated];
const ALL: &[State] = &[
    Instantiated,
    Initialization,
    Event,
    ContinuousTime,
    Terminated,
];

/// Makes `calls` random calls of an FMU, if it offers Model Exchange.
pub fn run(path: &Path, calls: usize, seed: u64) -> Result<()> {
    let fmu = Fmu::open(path)?;
    if !fmu.description.model_exchange {
        println!("{}: no Model Exchange", path.display());
        return Ok(());
    }
    let (mut r, mut refused, mut done) = (Random::new(seed), 0, 0);
    let mut instance = new(&fmu)?;
    let mut state = Instantiated;
    for k in 0..calls {
        let before = instance.bytes()?;
        let (name, allowed, is_valid, status) = call(&instance, &mut r, state);
        let made = || format!("call {k}: {name} in state {state:?} gave {status}");
        let is_right = is_valid && allowed.contains(&state);
        match status {
            OK => {
                ensure!(is_right, "{}, it must be refused", made());
                done += 1;
                state = next_state(name, state);
            }
            DISCARD | ERROR => {
                ensure!(
                    status == DISCARD || !is_right,
                    "{}: {:?}",
                    made(),
                    instance.messages()
                );
                ensure!(
                    instance.bytes()? == before,
                    "{}, but the instance's state changed",
                    made()
                );
                refused += 1;
            }
            _ => bail!("{}, no status of a call", made()),
        }
        if state == Terminated && r.one_in(8) {
            (instance, state) = (new(&fmu)?, Instantiated);
        }
    }
    println!(
        "{}: {calls} calls, {done} done, {refused} refused, 0 complaints",
        path.display()
    );
    Ok(())
}

fn new(fmu: &Fmu) -> Result<Instance<'_>> {
    let options = InstanceOptions {
        kind: InstanceKind::ModelExchange,
        ..InstanceOptions::STRICT
    };
    Instance::with_options(fmu, "exchange", options)
}

/// The state after a call that was done.
fn next_state(name: &str, state: State) -> State {
    match name {
        "fmi2Reset" => Instantiated,
        "fmi2EnterInitializationMode" => Initialization,
        "fmi2ExitInitializationMode" | "fmi2EnterEventMode" => Event,
        "fmi2NewDiscreteStates" => ContinuousTime,
        "fmi2Terminate" => Terminated,
        _ => state,
    }
}

/// Makes a random call. Returns its name, the states in which it is allowed, whether its arguments
/// are valid, and its status.
fn call(
    instance: &Instance,
    r: &mut Random,
    state: State,
) -> (&'static str, &'static [State], bool, i32) {
    let (d, f): (_, &RawInstance) = (&instance.fmu.description, instance);
    let is_3 = f.functions().is_fmi3();
    let derivatives = d.derivatives.iter().map(|u| d.variables[u.variable].size());
    let states: usize = derivatives.sum();
    let right = r.below(4) > 0;
    let n = |of: usize, r: &mut Random| match right {
        true => of,
        false => r.of(&[0, of + 1, of.saturating_sub(1)]),
    };
    let is_null = !right && r.one_in(4);
    let readable = if is_3 { INITIALIZED } else { &INITIALIZED[1..] };
    match r.below(13) {
        0 if state == Instantiated => {
            let begun = f.setup_experiment(Default::default());
            let status = begun.max(f.enter_initialization_mode(Default::default()));
            let name = "fmi2EnterInitializationMode";
            (name, &[Instantiated], true, status)
        }
        1 => {
            let name = "fmi2ExitInitializationMode";
            (name, &[Initialization], true, f.exit_initialization_mode())
        }
        2 if r.one_in(8) => {
            let status = f.terminate();
            ("fmi2Terminate", &[Event, ContinuousTime], true, status)
        }
        3 if r.one_in(8) => ("fmi2Reset", ALL, true, f.reset()),
        4 => {
            let running: &[State] = &[ContinuousTime, Event];
            let allowed = if is_3 { &running[..1] } else { running };
            ("fmi2EnterEventMode", allowed, true, f.enter_event_mode())
        }
        5 | 6 => {
            let status = f.handle_events(&mut Update::default());
            ("fmi2NewDiscreteStates", &[Event], true, status)
        }
        7 => {
            let status = f.completed_integrator_step(&mut [false; 2]);
            let name = "fmi2CompletedIntegratorStep";
            (name, &[ContinuousTime], true, status)
        }
        8 => {
            let count = n(states, r);
            let x = seeds(r, count, right);
            let is_valid = x.len() == states && x.iter().all(|x| x.is_finite());
            let status = f.set_continuous_states(Array::Elements(&x));
            let name = "fmi2SetContinuousStates";
            (name, &[ContinuousTime], is_valid, status)
        }
        9 => {
            let t = match right {
                true => 0.0,
                false => r.of(&[f64::NAN, f64::INFINITY, -1.0]),
            };
            let status = f.set_time(t);
            ("fmi2SetTime", &[Event, ContinuousTime], right, status)
        }
        which @ (10 | 11) => {
            let nominals = if is_3 { INITIALIZED } else { WITH_NOMINALS };
            let (which, allowed, of) = match (which, r.below(3)) {
                (11, _) => (
                    ContinuousValues::Indicators,
                    INITIALIZED,
                    d.event_indicators,
                ),
                (_, 0) => (ContinuousValues::Derivatives, readable, states),
                (_, 1) => (ContinuousValues::States, INITIALIZED, states),
                _ => (ContinuousValues::Nominals, nominals, states),
            };
            let n = n(of, r);
            let mut x = vec![0.0; n];
            let is_valid = n == of && (!is_null || n == 0);
            let to = (!is_null).then_some(&mut x[..]);
            let status = f.get_continuous(which, to, n);
            (which.function(), allowed, is_valid, status)
        }
        _ => {
            let is_input = |v: &&Variable| v.is_input() && v.kind.name() == "Real";
            let inputs = d.variables.iter().filter(is_input);
            let Some(input) = inputs.min_by_key(|v| (v.reference + r.below(7) as u32) % 7) else {
                return ("fmi2Reset", ALL, true, f.reset());
            };
            let value = seeds(r, input.size(), right);
            let values = Array::or_null(&value, is_null);
            let status = f.set_reals(Array::Elements(&[input.reference]), values);
            // Refusals by bounds, or of discrete inputs, are checked elsewhere.
            let allowed = if status == OK { &ALL[..4] } else { &[] };
            ("fmi2SetReal", allowed, !is_null, status)
        }
    }
}
