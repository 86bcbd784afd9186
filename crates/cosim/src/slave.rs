//! One FMU instance: safe calls over the raw FMI 2.0 binding of the `fmi` crate. All `unsafe` of this crate is here.
//!
//! The crate's own `Instance` is not used, because it offers neither `fmi2SetRealInputDerivatives` nor `fmi2GetRealOutputDerivatives`
//! (and keeps the component private), and panics on a missing function, on slices of different length and on `fmi2Pending`.
#![allow(unsafe_code)]

use std::ffi::CString;
use std::ptr;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use crate::fmu::Fmu;
use crate::messages;
use anyhow::{Result, anyhow, bail};
use fmi::fmi2::{CallbackFunctions, binding};
use fmu_description::{Kind, Variable};

/// An FMU instance; terminated by the owner, freed when dropped.
pub struct Slave {
    fmu: Arc<Fmu>,
    name: String,
    component: binding::fmi2Component,
    /// FMI: must outlive the component.
    _callbacks: Box<CallbackFunctions>,
}

/// Where in the run a call was made, for its error text.
#[derive(Clone, Copy, Debug)]
pub enum At {
    /// Before the first step.
    Initialization,
    /// At a communication point, s.
    Time(f64),
}

impl std::fmt::Display for At {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Initialization => f.write_str("in initialization"),
            Self::Time(t) => write!(f, "at t = {t} s"),
        }
    }
}

impl Slave {
    /// Create the instance `name` of `fmu`. Errors it logs later become part of the error texts.
    pub fn new(fmu: &Arc<Fmu>, name: &str) -> Result<Self> {
        messages::collect();
        let c_string = |text: &str| {
            CString::new(text).map_err(|_| anyhow!("{name}: `{text}` has a NUL character"))
        };
        let (c_name, guid, resources) = (
            c_string(name)?,
            c_string(&fmu.description.guid)?,
            c_string(&fmu.resources)?,
        );
        fmu.register(name)?;
        let callbacks = Box::<CallbackFunctions>::default();
        // SAFETY: valid C strings; the callbacks have the layout of fmi2CallbackFunctions and outlive the component.
        let component = unsafe {
            fmu.api.fmi2Instantiate(
                c_name.as_ptr(),
                binding::fmi2Type_fmi2CoSimulation,
                guid.as_ptr(),
                resources.as_ptr(),
                ptr::from_ref(&*callbacks).cast(),
                0,
                1,
            )
        };
        if component.is_null() {
            fmu.instances.fetch_sub(1, Ordering::SeqCst);
            bail!(
                "{name}: FMU `{}` could not be instantiated{}",
                fmu.file,
                said(name)
            );
        }
        let slave = Self {
            fmu: fmu.clone(),
            name: name.to_string(),
            component,
            _callbacks: callbacks,
        };
        slave.log_only_trouble()?;
        Ok(slave)
    }

    /// Name of the instance.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The FMU it is an instance of.
    pub fn fmu(&self) -> &Arc<Fmu> {
        &self.fmu
    }

    /// Ask for warnings and errors only, where the FMU has the standard categories; other messages cost time.
    fn log_only_trouble(&self) -> Result<()> {
        const TROUBLE: [&str; 4] = [
            "logStatusWarning",
            "logStatusDiscard",
            "logStatusError",
            "logStatusFatal",
        ];
        let declared = &self.fmu.description.log_categories;
        let chosen: Vec<CString> = TROUBLE
            .iter()
            .filter(|c| declared.iter().any(|d| d == *c))
            .filter_map(|c| CString::new(*c).ok())
            .collect();
        if chosen.is_empty() {
            return Ok(());
        }
        let pointers: Vec<_> = chosen.iter().map(|c| c.as_ptr()).collect();
        // SAFETY: as many valid C strings as said.
        let status = unsafe {
            self.fmu
                .api
                .fmi2SetDebugLogging(self.component, 1, pointers.len(), pointers.as_ptr())
        };
        self.check(status, "fmi2SetDebugLogging", &[], At::Initialization)
    }

    /// Set a variable of any type from text: a number, `true`/`false`, an enumeration item's name or number, or a string.
    pub fn set_from_text(&self, variable: &str, text: &str) -> Result<()> {
        let v = self
            .fmu
            .description
            .variable(variable)
            .map_err(|e| anyhow!("{}: {e}", self.name))?;
        let api = &self.fmu.api;
        let vr = [v.reference];
        let unfit =
            |expected: &str| anyhow!("{}.{variable}: `{text}` is not {expected}", self.name);
        let (status, call) = match &v.kind {
            Kind::Real => {
                let value = text.parse::<f64>().map_err(|_| unfit("a number"))?;
                (
                    // SAFETY: one reference and one value of the type of the call.
                    unsafe { api.fmi2SetReal(self.component, vr.as_ptr(), 1, &value) },
                    "fmi2SetReal",
                )
            }
            Kind::Integer | Kind::Enumeration(_) => {
                let value = integer(&v.kind, text).map_err(|expected| unfit(&expected))?;
                (
                    // SAFETY: one reference and one value of the type of the call.
                    unsafe { api.fmi2SetInteger(self.component, vr.as_ptr(), 1, &value) },
                    "fmi2SetInteger",
                )
            }
            Kind::Boolean => {
                let value = match text {
                    "true" | "1" => 1,
                    "false" | "0" => 0,
                    _ => return Err(unfit("true or false")),
                };
                (
                    // SAFETY: one reference and one value of the type of the call.
                    unsafe { api.fmi2SetBoolean(self.component, vr.as_ptr(), 1, &value) },
                    "fmi2SetBoolean",
                )
            }
            Kind::String => {
                let value =
                    CString::new(text).map_err(|_| unfit("a string without NUL characters"))?;
                (
                    // SAFETY: one reference and one value of the type of the call.
                    unsafe { api.fmi2SetString(self.component, vr.as_ptr(), 1, &value.as_ptr()) },
                    "fmi2SetString",
                )
            }
            Kind::Binary | Kind::Clock => bail!("{}.{variable} cannot be set", self.name),
        };
        self.check(
            status,
            &format!("{call} to `{text}`"),
            &vr,
            At::Initialization,
        )
    }

    /// Value of a numeric variable; an integer, enumeration or boolean as a number.
    pub fn number(&self, variable: &Variable, at: At) -> Result<f64> {
        let vr = [variable.reference];
        let api = &self.fmu.api;
        let mut int = 0;
        let (status, call) = match variable.kind {
            Kind::Real => {
                let mut value = [0.0];
                self.get(&vr, &mut value, at)?;
                return Ok(value[0]);
            }
            Kind::Boolean => (
                // SAFETY: one reference and one value of the type of the call.
                unsafe { api.fmi2GetBoolean(self.component, vr.as_ptr(), 1, &mut int) },
                "fmi2GetBoolean",
            ),
            Kind::Integer | Kind::Enumeration(_) => (
                // SAFETY: one reference and one value of the type of the call.
                unsafe { api.fmi2GetInteger(self.component, vr.as_ptr(), 1, &mut int) },
                "fmi2GetInteger",
            ),
            Kind::String | Kind::Binary | Kind::Clock => {
                bail!("{}.{} is not a number", self.name, variable.name)
            }
        };
        self.check(status, call, &vr, at)?;
        Ok(int.into())
    }

    /// `fmi2SetupExperiment` and `fmi2EnterInitializationMode`.
    pub fn enter_initialization(&self, start: f64) -> Result<()> {
        // SAFETY: plain values. No stop time: a run may be continued.
        let status = unsafe {
            self.fmu
                .api
                .fmi2SetupExperiment(self.component, 0, 0.0, start, 0, 0.0)
        };
        self.check(status, "fmi2SetupExperiment", &[], At::Initialization)?;
        // SAFETY: the component is alive.
        let status = unsafe { self.fmu.api.fmi2EnterInitializationMode(self.component) };
        self.check(
            status,
            "fmi2EnterInitializationMode",
            &[],
            At::Initialization,
        )
    }

    /// `fmi2ExitInitializationMode`.
    pub fn exit_initialization(&self) -> Result<()> {
        // SAFETY: the component is alive.
        let status = unsafe { self.fmu.api.fmi2ExitInitializationMode(self.component) };
        self.check(
            status,
            "fmi2ExitInitializationMode",
            &[],
            At::Initialization,
        )
    }

    /// `fmi2GetReal`.
    pub fn get(&self, vr: &[u32], value: &mut [f64], at: At) -> Result<()> {
        debug_assert_eq!(vr.len(), value.len());
        let n = vr.len().min(value.len());
        // SAFETY: `n` readable references and room for `n` values.
        let status = unsafe {
            self.fmu
                .api
                .fmi2GetReal(self.component, vr.as_ptr(), n, value.as_mut_ptr())
        };
        self.check(status, "fmi2GetReal", vr, at)
    }

    /// `fmi2SetReal`.
    pub fn set(&self, vr: &[u32], value: &[f64], at: At) -> Result<()> {
        debug_assert_eq!(vr.len(), value.len());
        let n = vr.len().min(value.len());
        // SAFETY: `n` readable references and values.
        let status = unsafe {
            self.fmu
                .api
                .fmi2SetReal(self.component, vr.as_ptr(), n, value.as_ptr())
        };
        self.check(status, "fmi2SetReal", vr, at)
    }

    /// First time derivatives of outputs; `order` holds as many ones.
    pub fn get_derivatives(
        &self,
        vr: &[u32],
        order: &[i32],
        value: &mut [f64],
        at: At,
    ) -> Result<()> {
        debug_assert!(vr.len() == value.len() && vr.len() == order.len());
        let n = vr.len().min(value.len()).min(order.len());
        // SAFETY: `n` readable references and orders and room for `n` values.
        let status = unsafe {
            self.fmu.api.fmi2GetRealOutputDerivatives(
                self.component,
                vr.as_ptr(),
                n,
                order.as_ptr(),
                value.as_mut_ptr(),
            )
        };
        self.check(status, "fmi2GetRealOutputDerivatives", vr, at)
    }

    /// First time derivatives of inputs for the next step; `order` holds as many ones.
    pub fn set_derivatives(&self, vr: &[u32], order: &[i32], value: &[f64], at: At) -> Result<()> {
        debug_assert!(vr.len() == value.len() && vr.len() == order.len());
        let n = vr.len().min(value.len()).min(order.len());
        // SAFETY: `n` readable references, orders and values.
        let status = unsafe {
            self.fmu.api.fmi2SetRealInputDerivatives(
                self.component,
                vr.as_ptr(),
                n,
                order.as_ptr(),
                value.as_ptr(),
            )
        };
        self.check(status, "fmi2SetRealInputDerivatives", vr, at)
    }

    /// `fmi2DoStep` from `t` by `h`, both s.
    pub fn step(&self, t: f64, h: f64) -> Result<()> {
        // SAFETY: plain values.
        let status = unsafe { self.fmu.api.fmi2DoStep(self.component, t, h, 1) };
        self.check(status, "fmi2DoStep", &[], At::Time(t))
    }

    /// The instance's own time, s: the end of its last successful step.
    pub fn time(&self) -> Result<f64> {
        let mut time = f64::NAN;
        // SAFETY: room for one value.
        let status = unsafe {
            self.fmu.api.fmi2GetRealStatus(
                self.component,
                binding::fmi2StatusKind_fmi2LastSuccessfulTime,
                &mut time,
            )
        };
        self.check(status, "fmi2GetRealStatus", &[], At::Time(time))?;
        Ok(time)
    }

    /// `fmi2Terminate`.
    pub fn terminate(&self, at: At) -> Result<()> {
        // SAFETY: the component is alive.
        let status = unsafe { self.fmu.api.fmi2Terminate(self.component) };
        self.check(status, "fmi2Terminate", &[], at)
    }

    #[inline]
    fn check(&self, status: binding::fmi2Status, call: &str, vr: &[u32], at: At) -> Result<()> {
        match status {
            binding::fmi2Status_fmi2OK | binding::fmi2Status_fmi2Warning => Ok(()),
            _ => Err(self.error(status, call, vr, at)),
        }
    }

    #[cold]
    fn error(&self, status: binding::fmi2Status, call: &str, vr: &[u32], at: At) -> anyhow::Error {
        let result = match status {
            binding::fmi2Status_fmi2Discard => "fmi2Discard",
            binding::fmi2Status_fmi2Error => "fmi2Error",
            binding::fmi2Status_fmi2Fatal => "fmi2Fatal",
            binding::fmi2Status_fmi2Pending => "fmi2Pending (asynchronous steps are not supported)",
            _ => "an unknown status",
        };
        let kind_fits = |v: &Variable| match v.kind {
            Kind::Real => call.contains("Real"),
            Kind::Integer | Kind::Enumeration(_) => call.contains("Integer"),
            Kind::Boolean => call.contains("Boolean"),
            Kind::String => call.contains("String"),
            Kind::Binary | Kind::Clock => false,
        };
        let name = |r: &u32| {
            let found = self
                .fmu
                .description
                .variables
                .iter()
                .find(|v| v.reference == *r && kind_fits(v));
            found.map_or_else(|| format!("#{r}"), |v| v.name.clone())
        };
        let names = if vr.is_empty() {
            String::new()
        } else {
            format!(" of {}", vr.iter().map(name).collect::<Vec<_>>().join(", "))
        };
        anyhow!(
            "{} (FMU `{}`): {call}{names} {at} returned {result}{}",
            self.name,
            self.fmu.file,
            said(&self.name)
        )
    }
}

impl Drop for Slave {
    fn drop(&mut self) {
        // SAFETY: freed once; the library is still loaded, `fmu` holds it.
        unsafe { self.fmu.api.fmi2FreeInstance(self.component) };
        self.fmu.instances.fetch_sub(1, Ordering::SeqCst);
    }
}

/// The reasons that the instance has logged, else its warnings, as the end of an error text.
fn said(instance: &str) -> String {
    let mut messages = messages::take();
    messages.retain(|m| m.instance == instance);
    if messages.iter().any(|m| !m.is_warning) {
        messages.retain(|m| !m.is_warning);
    }
    let texts: Vec<_> = messages.into_iter().map(|m| m.text).collect();
    if texts.is_empty() {
        String::new()
    } else {
        format!(": {}", texts.join("; "))
    }
}

/// An integer, or an enumeration item by its name.
fn integer(kind: &Kind, text: &str) -> Result<i32, String> {
    if let Kind::Enumeration(items) = kind {
        if let Some(item) = items.iter().find(|item| item.name == text) {
            return i32::try_from(item.value).map_err(|_| format!("an item up to {}", i32::MAX));
        }
        let names: Vec<_> = items.iter().map(|item| item.name.as_str()).collect();
        return text
            .parse()
            .map_err(|_| format!("one of {}", names.join(", ")));
    }
    text.parse().map_err(|_| "a whole number".to_string())
}
