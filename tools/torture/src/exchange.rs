//! Random calls of an instance for Model Exchange, in any order, against its call order: a call that
//! is refused changes nothing, one that is right is done.

use std::path::Path;

use anyhow::{Result, bail, ensure};
use fmi_description::Variable;
use fmi_import::instance::InstanceOptions;
use fmi_import::raw::{Array, ContinuousValues, InstanceKind, RawInstance, Update};
use fmi_import::status::{DISCARD, ERROR, OK};
use fmi_import::{Fmu, Instance};

use crate::arguments::seeds;
use crate::random::Random;

/// States of an instance, as letters: instantiated, initialization, event, continuous-time,
/// terminated.
const STATES: &str = "INECT";

/// So many calls of each FMU that offers Model Exchange.
pub fn run(path: &Path, calls: usize, seed: u64) -> Result<()> {
    let fmu = Fmu::open(path)?;
    if !fmu.description.model_exchange {
        println!("{}: no Model Exchange", path.display());
        return Ok(());
    }
    let (mut r, mut refused, mut done) = (Random::new(seed), 0, 0);
    let mut instance = new(&fmu)?;
    let mut state = 'I';
    for k in 0..calls {
        let before = instance.bytes()?;
        let Call {
            name,
            allowed,
            is_valid,
            status,
            next,
        } = call(&instance, &mut r, state);
        let said = || format!("call {k}: {name} in {state} gave {status}");
        let is_right = is_valid && allowed.contains(state);
        match status {
            OK => {
                ensure!(is_right, "{}, it must be refused", said());
                done += 1;
                state = next.unwrap_or(state);
            }
            DISCARD | ERROR => {
                ensure!(
                    status == DISCARD || !is_right,
                    "{}: {:?}",
                    said(),
                    instance.messages()
                );
                ensure!(
                    instance.bytes()? == before,
                    "{}, and the instance is another one",
                    said()
                );
                refused += 1;
            }
            _ => bail!("{}, no status of a call", said()),
        }
        if state == 'T' && r.one_in(8) {
            (instance, state) = (new(&fmu)?, 'I');
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

/// A call that was made.
struct Call {
    name: &'static str,
    /// The states that it is allowed in.
    allowed: &'static str,
    /// Its arguments are right.
    is_valid: bool,
    status: i32,
    /// The state that it leads to.
    next: Option<char>,
}

impl Call {
    fn new(name: &'static str, allowed: &'static str, is_valid: bool, status: i32) -> Self {
        let next = None;
        Self {
            name,
            allowed,
            is_valid,
            status,
            next,
        }
    }

    /// One without arguments that leads to another state.
    fn to(next: char, name: &'static str, allowed: &'static str, status: i32) -> Self {
        Self {
            next: Some(next),
            ..Self::new(name, allowed, true, status)
        }
    }
}

fn call(instance: &Instance, r: &mut Random, state: char) -> Call {
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
    let reads = if is_3 { "NECT" } else { "ECT" };
    match r.below(13) {
        0 if state == 'I' => {
            let begun = f.setup_experiment(Default::default());
            let status = begun.max(f.enter_initialization_mode(Default::default()));
            Call::to('N', "fmi2EnterInitializationMode", "I", status)
        }
        1 => {
            let status = f.exit_initialization_mode();
            Call::to('E', "fmi2ExitInitializationMode", "N", status)
        }
        2 if r.one_in(8) => Call::to('T', "fmi2Terminate", "EC", f.terminate()),
        3 if r.one_in(8) => Call::to('I', "fmi2Reset", STATES, f.reset()),
        4 => {
            let allowed = if is_3 { "C" } else { "EC" };
            Call::to('E', "fmi2EnterEventMode", allowed, f.enter_event_mode())
        }
        5 | 6 => {
            let status = f.handle_events(&mut Update::default());
            Call::to('C', "fmi2NewDiscreteStates", "E", status)
        }
        7 => {
            let status = f.completed_integrator_step(&mut [false; 2]);
            Call::new("fmi2CompletedIntegratorStep", "C", true, status)
        }
        8 => {
            let count = n(states, r);
            let x = seeds(r, count, right);
            let is_valid = x.len() == states && x.iter().all(|x| x.is_finite());
            let status = f.set_continuous_states(Array::Elements(&x));
            Call::new("fmi2SetContinuousStates", "C", is_valid, status)
        }
        9 => {
            let t = match right {
                true => 0.0,
                false => r.of(&[f64::NAN, f64::INFINITY, -1.0]),
            };
            Call::new("fmi2SetTime", "EC", right, f.set_time(t))
        }
        which @ (10 | 11) => {
            let nominals = if is_3 { "NECT" } else { "IECT" };
            let (which, allowed, of) = match (which, r.below(3)) {
                (11, _) => (ContinuousValues::Indicators, "NECT", d.event_indicators),
                (_, 0) => (ContinuousValues::Derivatives, reads, states),
                (_, 1) => (ContinuousValues::States, "NECT", states),
                _ => (ContinuousValues::Nominals, nominals, states),
            };
            let n = n(of, r);
            let mut x = vec![0.0; n];
            let is_valid = n == of && (!is_null || n == 0);
            let room = (!is_null).then_some(&mut x[..]);
            let status = f.get_continuous(which, room, n);
            Call::new(which.function(), allowed, is_valid, status)
        }
        _ => {
            let is_input = |v: &&Variable| v.is_input() && v.kind.name() == "Real";
            let inputs = d.variables.iter().filter(is_input);
            let Some(input) = inputs.min_by_key(|v| (v.reference + r.below(7) as u32) % 7) else {
                return Call::to('I', "fmi2Reset", STATES, f.reset());
            };
            let value = seeds(r, input.size(), right);
            let values = Array::or_null(&value, is_null);
            let status = f.set_reals(Array::Elements(&[input.reference]), values);
            // Bounds, and inputs that are discrete, are looked at elsewhere.
            let allowed = if status == OK { "INEC" } else { "" };
            Call::new("fmi2SetReal", allowed, !is_null, status)
        }
    }
}
