//! Random calls of an instance for Model Exchange, in any order, against its call order: a call that
//! is refused changes nothing, one that is right is done.

use std::path::Path;

use anyhow::{Result, bail, ensure};
use cargo_fmu::fmi::instance::Manner;
use cargo_fmu::fmi::symbols::{DISCARD, ERROR, OK};
use cargo_fmu::fmi::{Fmu, Instance};
use fmu_description::Causality;

use crate::arguments::{place, room, seeds};
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
        let (name, allowed, is_valid, status, next) = call(&instance, &mut r, state);
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
    let manner = Manner {
        kind: 0,
        ..Manner::STRICT
    };
    Instance::with(fmu, "exchange", manner)
}

/// A call: its name, where it is allowed, whether its arguments are right, its status, and the state
/// it leads to.
type Call = (&'static str, &'static str, bool, i32, Option<char>);

fn call(instance: &Instance, r: &mut Random, state: char) -> Call {
    let (fmu, c) = (instance.fmu, instance.c);
    let (f, d) = (&fmu.functions, &fmu.description);
    let is_3 = f.fmi3().is_some();
    let states: usize = (d.derivatives.iter())
        .map(|u| d.variables[u.variable].size())
        .sum();
    let right = r.below(4) > 0;
    let n = |of: usize, r: &mut Random| {
        if right {
            of
        } else {
            r.of(&[0, of + 1, of.saturating_sub(1)])
        }
    };
    let is_null = !right && r.one_in(4);
    let (mut next, mut ends, mut told) = (0.0, false, [false; 2]);
    let reads = if is_3 { "NECT" } else { "ECT" };
    // SAFETY: a live instance; arrays of the lengths given, or NULL.
    unsafe {
        match r.below(13) {
            0 if state == 'I' => {
                let status = f
                    .setup_experiment(c, Default::default())
                    .max(f.enter_initialization_mode(c, Default::default()));
                ("fmi2EnterInitializationMode", "I", true, status, Some('N'))
            }
            1 => (
                "fmi2ExitInitializationMode",
                "N",
                true,
                f.exit_initialization_mode(c),
                Some('E'),
            ),
            2 if r.one_in(8) => ("fmi2Terminate", "EC", true, f.terminate(c), Some('T')),
            3 if r.one_in(8) => ("fmi2Reset", STATES, true, f.reset(c), Some('I')),
            4 => (
                "fmi2EnterEventMode",
                if is_3 { "C" } else { "EC" },
                true,
                f.enter_event_mode(c),
                Some('E'),
            ),
            5 | 6 => (
                "fmi2NewDiscreteStates",
                "E",
                true,
                f.handle_events(c, &mut next, &mut ends),
                Some('C'),
            ),
            7 => (
                "fmi2CompletedIntegratorStep",
                "C",
                true,
                f.completed_integrator_step(c, &mut told),
                None,
            ),
            8 => {
                let count = n(states, r);
                let x = seeds(r, count, right);
                let is_valid = x.len() == states && x.iter().all(|x| x.is_finite());
                (
                    "fmi2SetContinuousStates",
                    "C",
                    is_valid,
                    f.set_continuous_states(c, x.as_ptr(), x.len()),
                    None,
                )
            }
            9 => {
                let t = if right {
                    0.0
                } else {
                    r.of(&[f64::NAN, f64::INFINITY, -1.0])
                };
                ("fmi2SetTime", "EC", right, f.set_time(c, t), None)
            }
            10 => {
                let n = n(states, r);
                let mut x = vec![0.0; n];
                let to = room(&mut x, is_null);
                let is_valid = n == states && (!is_null || n == 0);
                match r.below(3) {
                    0 => (
                        "fmi2GetDerivatives",
                        reads,
                        is_valid,
                        f.get_derivatives(c, to, n),
                        None,
                    ),
                    1 => (
                        "fmi2GetContinuousStates",
                        "NECT",
                        is_valid,
                        f.get_continuous_states(c, to, n),
                        None,
                    ),
                    _ => (
                        "fmi2GetNominalsOfContinuousStates",
                        if is_3 { "NECT" } else { "IECT" },
                        is_valid,
                        f.get_nominals(c, to, n),
                        None,
                    ),
                }
            }
            11 => {
                let n = n(d.event_indicators, r);
                let mut z = vec![0.0; n];
                let to = room(&mut z, is_null);
                let is_valid = n == d.event_indicators && (!is_null || n == 0);
                (
                    "fmi2GetEventIndicators",
                    "NECT",
                    is_valid,
                    f.get_event_indicators(c, to, n),
                    None,
                )
            }
            _ => {
                let inputs = d
                    .variables
                    .iter()
                    .filter(|v| v.causality == Causality::Input && v.kind.name() == "Real");
                let Some(input) = inputs.min_by_key(|v| (v.reference + r.below(7) as u32) % 7)
                else {
                    return ("fmi2Reset", STATES, true, f.reset(c), Some('I'));
                };
                let mut value = seeds(r, input.size(), right);
                let to = place(&mut value[0], is_null);
                let status = f.set_real(c, &input.reference, 1, to);
                // Bounds, and inputs that are discrete, are looked at elsewhere.
                let is_refused = status != OK;
                let name = "fmi2SetReal";
                (
                    name,
                    if is_refused { "" } else { "INEC" },
                    !is_null,
                    status,
                    None,
                )
            }
        }
    }
}
