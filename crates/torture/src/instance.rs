//! An instance with its log, and what an importer that follows the standard knows about it: the oracle's side of the state.

use cargo_fmu::fmi::functions::*;
use cargo_fmu::fmi::order::Mode;
use cargo_fmu::fmi::{Fmu, Log, Message};
use fmu_description::Access;
use std::ffi::{CString, c_int};
use std::ptr;

/// What the oracle remembers of an instance, and of each of its saved states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// State.
    pub mode: Mode,
    /// Time of the last communication point, s.
    pub time: f64,
    /// A stop time was given.
    pub has_stop: bool,
}

impl Known {
    /// Something was set: FMI 3.0 lets nothing be read in Step Mode before the next step.
    pub fn note_set(&mut self, fmu: &Fmu) {
        if self.mode == Mode::Stepping && fmu.functions.fmi3().is_some() {
            self.mode = Mode::SteppingAfterSet;
        }
    }
}

const NEW: Known = Known {
    mode: Mode::Instantiated,
    time: 0.0,
    has_stop: false,
};

/// Which messages the importer has asked for.
#[derive(Clone, Debug, Default)]
pub struct Logging {
    /// Categories that are switched on.
    pub named: Vec<String>,
}

impl Logging {
    /// fmi2SetDebugLogging: all or only the named categories on, all or the named ones off; fmi3SetDebugLogging `adds` to those that are on.
    pub fn set(&mut self, on: bool, named: Vec<String>, adds: bool) {
        let every = [
            "logEvents",
            "logStatusWarning",
            "logStatusDiscard",
            "logStatusError",
        ];
        let is_named = |c: &&str| named.iter().any(|n| n == c || n == "logAll");
        let wanted: Vec<&str> = match (on, named.is_empty()) {
            (true, true) => every.to_vec(),
            (true, false) => {
                let was_on = |c: &&str| adds && self.named.iter().any(|n| n == c);
                let stays = |c: &&str| is_named(c) || was_on(c);
                every.into_iter().filter(stays).collect()
            }
            (false, true) => Vec::new(),
            (false, false) => {
                let was_on = |c: &&str| self.named.iter().any(|n| n == c) && !is_named(c);
                every.into_iter().filter(was_on).collect()
            }
        };
        self.named = wanted.into_iter().map(str::to_owned).collect();
    }

    /// Whether a failure of this category must be reported.
    pub fn expects(&self, category: &str) -> bool {
        // Errors are never muted: that is what debug logging is not about (FMI 2.0.4, section 2.1.5).
        let is_error = category == "logStatusError";
        is_error || self.named.iter().any(|n| n == category)
    }
}

/// A live instance; freed when dropped.
pub struct Instance<'a> {
    /// Its FMU.
    pub fmu: &'a Fmu,
    /// `fmi2Component`.
    pub c: Pointer,
    /// instanceName.
    pub name: String,
    log: Box<Log>,
    _callbacks: Box<Callbacks>,
    /// State as the oracle knows it.
    pub known: Known,
    /// Saved states that have not been freed.
    pub saved: Vec<(Pointer, Known)>,
    /// What the logger must hear.
    pub logging: Logging,
}

impl<'a> Instance<'a> {
    /// Whether a failure of this category must be reported: FMI 3.0 (section 2.3.1) lets errors be muted too.
    pub fn expects(&self, category: &str) -> bool {
        match self.fmu.functions.fmi3() {
            None => self.logging.expects(category),
            Some(_) => self.logging.named.iter().any(|n| n == category),
        }
    }

    /// fmi2Instantiate as it should be done.
    pub fn new(fmu: &'a Fmu, name: &str) -> Result<Self, String> {
        let log = Box::new(Log::new(name));
        let callbacks = Box::new(log.callbacks());
        let (c_name, guid) = (text(name), text(&fmu.description.guid));
        let resources = match fmu.resources.is_empty() {
            true => ptr::null(),
            false => fmu.resources.as_ptr(),
        };
        // SAFETY: valid strings, and callbacks that outlive the instance.
        let c = unsafe {
            fmu.functions.instantiate(
                c_name.as_ptr(),
                1,
                guid.as_ptr(),
                resources,
                &*callbacks,
                0,
                0,
            )
        };
        if c.is_null() {
            return Err(format!("fmi2Instantiate gave NULL: {:?}", log.take()));
        }
        Ok(Self {
            fmu,
            c,
            name: name.to_owned(),
            log,
            _callbacks: callbacks,
            known: NEW,
            saved: Vec::new(),
            logging: Logging::default(), // loggingOn = false
        })
    }

    /// Messages since the last call of this function.
    pub fn messages(&self) -> Vec<Message> {
        self.log.take()
    }

    /// What the oracle must remember after fmi2Reset.
    pub fn forget(&mut self) {
        self.known = NEW;
    }

    /// A call that must succeed.
    pub fn must(&self, name: &str, status: c_int) -> Result<(), String> {
        if status == OK {
            return Ok(());
        }
        Err(format!(
            "{name} gave {status}, expected 0 (fmi2OK): {:?}",
            self.messages()
        ))
    }

    /// From Instantiated to the first communication point, with the start values.
    pub fn initialize(&mut self) -> Result<(), String> {
        let f = &self.fmu.functions;
        // SAFETY: a live instance.
        unsafe {
            self.must(
                "fmi2SetupExperiment",
                f.setup_experiment(self.c, 0, 0.0, 0.0, 0, 0.0),
            )?;
            self.must(
                "fmi2EnterInitializationMode",
                f.enter_initialization_mode(self.c, 0.0, 0, 0.0),
            )?;
            self.must(
                "fmi2ExitInitializationMode",
                f.exit_initialization_mode(self.c),
            )?;
            self.must("fmi3EnterStepMode", f.leave_events(self.c))?;
        }
        self.known = Known {
            mode: Mode::Stepping,
            ..NEW
        };
        Ok(())
    }

    /// fmi2DoStep at the present time, which must succeed.
    pub fn advance(&mut self, h: f64) -> Result<(), String> {
        let t = self.known.time;
        // SAFETY: a live instance.
        let status = unsafe { self.fmu.functions.do_step(self.c, t, h, 1) };
        self.must("fmi2DoStep", status)?;
        self.known.time = t + h;
        Ok(())
    }

    /// fmi2Reset, which must succeed.
    pub fn reset(&mut self) -> Result<(), String> {
        // SAFETY: a live instance.
        let status = unsafe { self.fmu.functions.reset(self.c) };
        self.forget();
        self.must("fmi2Reset", status)
    }

    /// All computed Real variables; the status, and the numbers if it is fmi2OK.
    pub fn outputs(&self) -> (c_int, Vec<f64>) {
        let variables = self.fmu.description.variables.iter();
        let vr: Vec<u32> = variables
            .filter(|v| v.is_computed() && v.access() == Access::Real)
            .map(|v| v.reference)
            .collect();
        let mut values = vec![0.0; self.fmu.functions.count(&vr)];
        // SAFETY: a live instance, room for all elements.
        let status = unsafe {
            self.fmu
                .functions
                .get_real(self.c, vr.as_ptr(), vr.len(), values.as_mut_ptr())
        };
        (status, values)
    }

    /// All of the instance that can be saved, as bytes.
    pub fn snapshot(&self) -> Result<Vec<u8>, String> {
        let f = &self.fmu.functions;
        let (mut state, mut size) = (ptr::null_mut(), 0);
        // SAFETY: a live instance, places for the results, and as many bytes as asked for.
        unsafe {
            self.must("fmi2GetFMUstate", f.get_fmu_state(self.c, &mut state))?;
            self.must(
                "fmi2SerializedFMUstateSize",
                f.serialized_fmu_state_size(self.c, state, &mut size),
            )?;
            let mut bytes = vec![0; size];
            self.must(
                "fmi2SerializeFMUstate",
                f.serialize_fmu_state(self.c, state, bytes.as_mut_ptr(), size),
            )?;
            self.must("fmi2FreeFMUstate", f.free_fmu_state(self.c, &mut state))?;
            Ok(bytes)
        }
    }

    /// Take over a state that was saved as bytes.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (f, mut state) = (&self.fmu.functions, ptr::null_mut());
        // SAFETY: a live instance, readable bytes of the length given, places for the results.
        unsafe {
            self.must(
                "fmi2DeSerializeFMUstate",
                f.deserialize_fmu_state(self.c, bytes.as_ptr(), bytes.len(), &mut state),
            )?;
            self.must("fmi2SetFMUstate", f.set_fmu_state(self.c, state))?;
            self.must("fmi2FreeFMUstate", f.free_fmu_state(self.c, &mut state))
        }
    }
}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        // SAFETY: a live instance, freed once.
        unsafe { self.fmu.functions.free_instance(self.c) }
    }
}

/// A C string.
pub fn text(s: &str) -> CString {
    CString::new(s).expect("names have no NUL")
}

/// What a freshly made instance does in its first steps of 1 ms, bit for bit.
pub fn first_steps(instance: &mut Instance) -> Result<Vec<u64>, String> {
    instance.initialize()?;
    let mut bits = Vec::new();
    for _ in 0..5 {
        instance.advance(1e-3)?;
        let (status, values) = instance.outputs();
        instance.must("fmi2GetReal", status)?;
        bits.extend(values.iter().map(|v| v.to_bits()));
    }
    Ok(bits)
}
