//! Calls of a [`RawInstance`] that need more than a row of `calls.rs`, for every user of `raw`:
//! those that pass texts and bytes, and sequences of several calls.

use std::ffi::{CStr, CString, c_int};
use std::ptr;

use super::{Array, Experiment, RawInstance, Update, c_text, result_pointer};
use crate::functions::VersionFunctions::{Fmi2, Fmi3};
use crate::standard::Text;
use crate::status::{ABSENT, NO_BYTES, OK, WARNING};
use crate::text;
use crate::value::Value;

/// `fmi2EventInfo`.
#[repr(C)]
#[derive(Default)]
struct EventInfo {
    /// Update needed again, simulation ends, nominals changed, states changed, next event known.
    flags: [c_int; 5],
    next: f64,
}

/// Which of the functions `fmi2Get…Status` is called.
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs)] // named in the standard
pub enum Inquiry {
    Status,
    Real,
    Integer,
    Boolean,
    String,
}

/// Workspace for calls that pass bytes.
#[derive(Default)]
pub struct BinaryRoom {
    sizes: Vec<usize>,
    at: Vec<*const u8>,
    /// What was read last.
    pub values: Vec<Value>,
}

impl RawInstance {
    /// fmi2SetupExperiment. In FMI 3.0 fmi3EnterInitializationMode passes the experiment, and
    /// nothing is called here.
    pub fn setup_experiment(&self, experiment: Experiment) -> c_int {
        match self.functions.is_fmi3() {
            true => OK,
            false => self.begin(experiment),
        }
    }

    /// Switches logging of these categories on or off; of all if none is named.
    pub fn set_debug_logging(&self, on: bool, categories: Array<Option<&CStr>>) -> c_int {
        let texts: Vec<Text>;
        let list = match categories {
            Array::Elements(categories) => {
                texts = categories.iter().map(|c| c_text(*c)).collect();
                texts.as_ptr()
            }
            Array::Null(_) => ptr::null(),
        };
        let n = categories.len();
        let _call = self.call();
        // SAFETY: NULL, or as many elements as said, each NULL or a C string.
        unsafe {
            match &self.version {
                Fmi2(f) => (f.fmi2SetDebugLogging)(self.c, on.into(), n, list),
                Fmi3(f) => (f.fmi3SetDebugLogging)(self.c, on, n, list),
            }
        }
    }

    /// Gets `n` texts of String variables; None if one of the pointers leads to no text.
    pub fn get_strings(&self, vr: &[u32], n: usize) -> (c_int, Option<Vec<CString>>) {
        assert!(n >= vr.len());
        let mut texts = vec![ptr::null(); n];
        let (c, m, vr, to) = (self.c, vr.len(), vr.as_ptr(), texts.as_mut_ptr());
        let _call = self.call();
        // SAFETY: a live instance or NULL, room for `n` texts.
        let status = unsafe {
            match &self.version {
                Fmi2(f) => (f.fmi2GetString)(c, vr, m, to),
                Fmi3(f) => (f.fmi3GetString)(c, vr, m, to, n),
            }
        };
        if status > WARNING {
            return (status, Some(vec![CString::default(); n]));
        }
        // SAFETY: the library returns NULL or C strings that are valid until the next call.
        let owned = texts.into_iter().map(|text| unsafe { text::read(text) });
        (status, owned.collect())
    }

    /// Sets String variables; None passes NULL.
    pub fn set_strings(&self, vr: &[u32], values: &[Option<&CStr>]) -> c_int {
        assert!(values.len() >= vr.len());
        let texts: Vec<Text> = values.iter().map(|text| c_text(*text)).collect();
        let (c, m, n, vr, from) = (self.c, vr.len(), texts.len(), vr.as_ptr(), texts.as_ptr());
        let _call = self.call();
        // SAFETY: a live instance or NULL, NULL or C strings.
        unsafe {
            match &self.version {
                Fmi2(f) => (f.fmi2SetString)(c, vr, m, from),
                Fmi3(f) => (f.fmi3SetString)(c, vr, m, from, n),
            }
        }
    }

    /// Gets `n` values of Binary variables; [`NO_BYTES`] if the FMU has no such bytes. FMI 3.0 only.
    pub fn get_binaries(&self, vr: &[u32], n: usize) -> (c_int, Vec<Vec<u8>>) {
        let mut room = BinaryRoom::default();
        let status = self.get_binaries_into(vr, n, &mut room);
        let values = room.values.into_iter().map(|value| match value {
            Value::Bytes(bytes) => bytes,
            _ => Vec::new(),
        });
        (status, values.collect())
    }

    /// The same into a workspace, whose buffers grow to the largest values.
    pub fn get_binaries_into(&self, vr: &[u32], n: usize, room: &mut BinaryRoom) -> c_int {
        let Fmi3(f) = &self.version else {
            return ABSENT;
        };
        let BinaryRoom { sizes, at, values } = room;
        sizes.clear();
        sizes.resize(n, 0);
        at.clear();
        at.resize(n, ptr::null());
        values.resize(values.len().max(n), Value::Bytes(Vec::new()));
        let (sizes_at, values_at) = (sizes.as_mut_ptr(), at.as_mut_ptr());
        let _call = self.call();
        // SAFETY: a live instance or NULL, room for all elements.
        let status =
            unsafe { (f.fmi3GetBinary)(self.c, vr.as_ptr(), vr.len(), sizes_at, values_at, n) };
        for (value, (at, size)) in values.iter_mut().zip(at.iter().zip(sizes.iter())) {
            let Value::Bytes(bytes) = value else { continue };
            let size = if at.is_null() || status > WARNING {
                0
            } else {
                *size
            };
            // SAFETY: as many bytes as the FMU says, until the next call.
            if !unsafe { text::read_bytes(*at, size, bytes) } {
                return NO_BYTES;
            }
        }
        status
    }

    /// Sets Binary variables. FMI 3.0 only.
    pub fn set_binaries(&self, vr: &[u32], values: &[&[u8]]) -> c_int {
        self.set_binaries_from(vr, values.iter().copied(), &mut BinaryRoom::default())
    }

    /// The same with a workspace.
    pub fn set_binaries_from<'a>(
        &self,
        vr: &[u32],
        values: impl Iterator<Item = &'a [u8]>,
        room: &mut BinaryRoom,
    ) -> c_int {
        let Fmi3(f) = &self.version else {
            return ABSENT;
        };
        room.at.clear();
        room.sizes.clear();
        for value in values {
            room.at.push(value.as_ptr());
            room.sizes.push(value.len());
        }
        let (n, sizes, at) = (room.at.len(), room.sizes.as_ptr(), room.at.as_ptr());
        let _call = self.call();
        // SAFETY: a live instance or NULL, arrays of the lengths given.
        unsafe { (f.fmi3SetBinary)(self.c, vr.as_ptr(), vr.len(), sizes, at, n) }
    }

    /// Updates discrete states once, in Event Mode.
    pub fn update_discrete_states(&self, update: &mut Update) -> c_int {
        let (c, mut info, mut flags) = (self.c, EventInfo::default(), [false; 5]);
        let _call = self.call();
        // SAFETY: a live instance or NULL; places for the results.
        let status = unsafe {
            match &self.version {
                Fmi2(f) => {
                    let status = (f.fmi2NewDiscreteStates)(c, ptr::from_mut(&mut info).cast());
                    flags = info.flags.map(|flag| flag != 0);
                    status
                }
                Fmi3(f) => {
                    let [again, ends, nominals, values, known] = flags.each_mut();
                    let next = &mut info.next;
                    (f.fmi3UpdateDiscreteStates)(c, again, ends, nominals, values, known, next)
                }
            }
        };
        let [again, terminates, _, _, is_known] = flags;
        *update = Update {
            again,
            terminates,
            next: if is_known { info.next } else { f64::INFINITY },
        };
        status
    }

    /// In Event Mode of Model Exchange: updates discrete states until no further update is needed,
    /// at most a thousand times, then enters Continuous-Time Mode.
    pub fn handle_events(&self, update: &mut Update) -> c_int {
        for _ in 0..1000 {
            let status = self.update_discrete_states(update);
            if status > WARNING {
                return status;
            }
            if !update.again {
                break;
            }
        }
        self.enter_continuous_time_mode()
    }

    /// From Event Mode to Step Mode; does nothing for FMUs without Event Mode.
    pub fn leave_events(&self) -> c_int {
        if !self.functions.has_event_mode() {
            return OK;
        }
        let mut update = Update::default();
        match self.update_discrete_states(&mut update) {
            OK | WARNING => self.enter_step_mode(),
            status => status,
        }
    }

    /// From Step Mode to Event Mode; does nothing for FMUs without Event Mode.
    pub fn enter_events(&self) -> c_int {
        match self.functions.has_event_mode() {
            true => self.enter_event_mode(),
            false => OK,
        }
    }

    /// Asks for the status `kind` (`fmi2StatusKind`); returns the name of the function and its
    /// status.
    pub fn inquire(&self, by: Inquiry, kind: c_int, is_null: bool) -> (&'static str, c_int) {
        let Fmi2(f) = &self.version else {
            return ("fmi2GetStatus", ABSENT);
        };
        let (mut integer, mut number, mut string) = (-1, f64::NAN, ptr::null());
        let _call = self.call();
        macro_rules! ask {
            ($function:ident, $place:expr) => {
                (
                    stringify!($function),
                    (f.$function)(self.c, kind, result_pointer((!is_null).then_some($place))),
                )
            };
        }
        // SAFETY: a live instance or NULL; places for one result or NULL.
        unsafe {
            match by {
                Inquiry::Status => ask!(fmi2GetStatus, &mut integer),
                Inquiry::Real => ask!(fmi2GetRealStatus, &mut number),
                Inquiry::Integer => ask!(fmi2GetIntegerStatus, &mut integer),
                Inquiry::Boolean => ask!(fmi2GetBooleanStatus, &mut integer),
                Inquiry::String => ask!(fmi2GetStringStatus, &mut string),
            }
        }
    }

    /// Gets `n` dependencies of a variable: which of its elements depends on which variable. FMI
    /// 3.0 only.
    pub fn get_dependencies(&self, vr: u32, n: usize) -> (c_int, Vec<usize>, Vec<u32>) {
        let Fmi3(f) = &self.version else {
            return (ABSENT, Vec::new(), Vec::new());
        };
        let (mut of, mut on, mut of_on, mut kinds) =
            (vec![0; n], vec![0; n], vec![0; n], vec![0; n]);
        let [to, of_to] =
            [&mut of, &mut of_on].map(|elements: &mut Vec<usize>| elements.as_mut_ptr());
        let _call = self.call();
        // SAFETY: a live instance or NULL; room for `n` of each.
        let status = unsafe {
            (f.fmi3GetVariableDependencies)(
                self.c,
                vr,
                to,
                on.as_mut_ptr(),
                of_to,
                kinds.as_mut_ptr(),
                n,
            )
        };
        (status, of, on)
    }
}
