//! A batch of random calls on instances of one FMU, for `batches`, each judged by the oracle.

use std::ffi::c_int;

use anyhow::{Context, Result, bail, ensure};
use fmi_description::Access;
use fmi_import::standard::{Mode, is_allowed};
use fmi_import::status::{DISCARD, OK};

use crate::oracle::{Call, judge};
use crate::session::{INSTANCES, Session};
use crate::subject::first_steps;

/// Calls between two checks that an instance, once reset, works as a new one.
const CALLS_BETWEEN_RESETS: usize = 2000;

fn digest(hash: &mut u64, bytes: &[u8]) {
    for byte in bytes {
        *hash = (*hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    }
}

/// What is compared before and after a refused call.
#[derive(PartialEq, Debug)]
enum Observation {
    Nothing,
    Outputs(c_int, Vec<u64>),
    Bytes(Vec<u8>),
}

impl Session<'_> {
    /// Makes `n` calls.
    pub fn run(&mut self, n: usize) -> Result<()> {
        for k in 0..n {
            let i = self.random.below(INSTANCES);
            let place = || format!("call {k} on instance {i}");
            self.turn(i).with_context(place)?;
            if k % CALLS_BETWEEN_RESETS == CALLS_BETWEEN_RESETS - 1 {
                let reset = self.check_reset(i);
                reset.with_context(|| format!("reset after {}", place()))?;
            }
        }
        (0..INSTANCES).try_for_each(|i| self.check_reset(i))
    }

    /// Makes one call with all checks.
    fn turn(&mut self, i: usize) -> Result<()> {
        let before = match self.random.below(16) {
            0..8 => Observation::Nothing,
            8..15 => self.outputs(i)?,
            _ => Observation::Bytes(self.instances[i].bytes()?),
        };
        self.instances[i].messages();
        if let Observation::Outputs(_, bits) = &before {
            bits.iter()
                .for_each(|b| digest(&mut self.digest, &b.to_le_bytes()));
        }
        let call = self.call(i)?;
        digest(&mut self.digest, call.name.as_bytes());
        digest(&mut self.digest, &call.status.to_le_bytes());
        judge(&self.instances[i], &call)?;
        let column = match call.status {
            OK => 0,
            DISCARD => 1,
            _ => 2,
        };
        self.counts.entry(call.name).or_default()[column] += 1;
        if call.status == OK {
            return Ok(());
        }
        let after = match before {
            Observation::Nothing => return Ok(()),
            Observation::Outputs(..) => self.outputs(i)?,
            Observation::Bytes(_) => Observation::Bytes(self.instances[i].bytes()?),
        };
        self.compared += 1;
        let Call { name, status, .. } = call;
        ensure!(
            before == after,
            "{name} gave {status} and changed the instance: {before:?} -> {after:?}"
        );
        Ok(())
    }

    /// Reads outputs and time, which must be finite, and readable at a communication point.
    fn outputs(&self, i: usize) -> Result<Observation> {
        let instance = &self.instances[i];
        instance.messages();
        let (status, mut values) = instance.outputs();
        let mode = instance.known.mode;
        if status == OK && values.iter().any(|v| !v.is_finite()) {
            bail!("an output is not finite: {values:?}");
        }
        if status != OK && is_allowed(self.fmu.functions.name("fmi2GetReal"), mode) {
            // A model may refuse inconsistent inputs, such as a quaternion of length 0, but its
            // outputs must stay finite.
            let messages = instance.messages();
            if messages.iter().any(|m| m.format.contains(" became ")) {
                bail!("outputs are no numbers: {messages:?}");
            }
        }
        if status == OK && mode != Mode::Initialization {
            let mut time = f64::NAN;
            let got = instance.last_time(&mut time);
            instance.must("fmi2GetRealStatus", got)?;
            if time != instance.known.time {
                bail!("time is {time}, expected {}", instance.known.time);
            }
            values.push(time);
        }
        if status != OK {
            values.clear();
        }
        let bits = values.iter().map(|v| v.to_bits()).collect();
        Ok(Observation::Outputs(status, bits))
    }

    /// Checks that a reset instance does what a new one does, bit for bit.
    fn check_reset(&mut self, i: usize) -> Result<()> {
        let instance = &mut self.instances[i];
        instance.reset()?;
        ensure!(
            first_steps(instance)? == self.new_bits,
            "a reset instance does not do what a new one does"
        );
        instance.reset()
    }

    /// Makes a random call.
    fn call(&mut self, i: usize) -> Result<Call> {
        if self.random.one_in(64) {
            return self.without_instance(i);
        }
        match self.random.below(64) {
            0..3 => self.setup_experiment(i),
            3..6 => self.simple(i, "fmi2EnterInitializationMode"),
            6..9 => self.simple(i, "fmi2ExitInitializationMode"),
            9 if self.random.one_in(4) => self.simple(i, "fmi2Terminate"),
            10 if self.random.one_in(4) => self.simple(i, "fmi2Reset"),
            // In FMI 3.0 a call of Event Mode.
            11 => self.simple(i, "fmi2CancelStep"),
            49..53 if self.fmu.functions.is_fmi3() => self.event_call(i),
            53 if self.fmu.functions.is_fmi3() => self.absent(i),
            54 if self.fmu.functions.is_fmi3() => self.get_other(i),
            55..57 if self.fmu.functions.is_fmi3() => self.set_other(i),
            12 => self.set_debug_logging(i),
            13..15 => self.status(i),
            15 if self.random.one_in(2) => Ok(self.instantiate(i)),
            16..22 => self.set(i, Access::Real),
            22..24 => self.set_other(i),
            24 => self.set_string(i),
            25..30 => self.get(i, Access::Real),
            30..32 => self.get_other(i),
            32 => self.get(i, Access::String),
            33..35 if self.fmu.functions.is_fmi3() => self.adjoint(i),
            33..35 => self.set_input_derivatives(i),
            35..37 => self.get_output_derivatives(i),
            37..39 => self.get_directional_derivative(i),
            39..41 => self.get_state(i),
            41..43 => self.set_state(i),
            43..45 => self.free_state(i),
            45..47 => self.serialize(i),
            47..49 => self.deserialize(i),
            _ => self.do_step(i),
        }
    }
}
