//! A component of FMI-LS-WASM in wasmtime, compiled once in a process, and its instances, for
//! `functions`. It reaches nothing of this machine but the FMU's resources, which it may read
//! through WASI, the clock and random numbers.

use std::ffi::{CStr, CString, c_int, c_void};
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::AtomicPtr;
use std::sync::atomic::Ordering::Relaxed;

use anyhow::{Context, Result, anyhow, ensure};
use fmi_import::Limits;
use fmi_import::standard::Logger;
use wasmtime::component::{
    Component, HasSelf, InstancePre, Linker, ResourceAny, ResourceTable, bindgen,
};
use wasmtime::{Config, Engine, Store, StoreLimits, StoreLimitsBuilder};
use wasmtime_wasi::{FsPerms, WasiCtx, WasiCtxBuilder, WasiCtxView, WasiView};

bindgen!({ path: "../../fmi/fmu-check/src/fmi3.wit", world: "fmu" });

pub use exports::fmi::fmi3::{co_simulation, model_exchange};
pub use fmi::fmi3::types::{DependencyKind, IntervalFraction, Status};
use fmi::fmi3::{callbacks, intermediate_update_callbacks};

/// Where the FMU's resources are for the component.
const RESOURCES: &str = "/resources/";

/// What the process runs.
static LOADED: OnceLock<Loaded> = OnceLock::new();

struct Loaded {
    component: InstancePre<State>,
    co_simulation: wasmtime::Result<co_simulation::GuestIndices>,
    model_exchange: wasmtime::Result<model_exchange::GuestIndices>,
    resources: std::path::PathBuf,
    limits: Limits,
}

/// Compiles the component in a file.
pub fn load(path: &Path, limits: Limits) -> Result<()> {
    let mut config = Config::new();
    config.wasm_function_references(true).wasm_gc(true);
    // The same bits on every machine.
    config.relaxed_simd_deterministic(true);
    let engine = Engine::new(&config)?;
    let component = Component::from_file(&engine, path)?;
    let mut linker = Linker::new(&engine);
    callbacks::add_to_linker::<_, HasSelf<_>>(&mut linker, |state| state)?;
    intermediate_update_callbacks::add_to_linker::<_, HasSelf<_>>(&mut linker, |state| state)?;
    wasmtime_wasi::p2::add_to_linker_sync(&mut linker)?;
    let component = linker.instantiate_pre(&component)?;
    let folder = path.ancestors().nth(3).context("it is in no FMU")?;
    let loaded = Loaded {
        co_simulation: co_simulation::GuestIndices::new(&component),
        model_exchange: model_exchange::GuestIndices::new(&component),
        component,
        resources: folder.join("resources"),
        limits,
    };
    if let (Err(one), Err(other)) = (&loaded.co_simulation, &loaded.model_exchange) {
        return Err(anyhow!("it is no FMU of FMI-LS-WASM: {one:#}; {other:#}"));
    }
    ensure!(LOADED.set(loaded).is_ok(), "a process has one FMU");
    Ok(())
}

/// What the component's imports use.
pub struct State {
    wasi: WasiCtx,
    table: ResourceTable,
    limits: StoreLimits,
    environment: AtomicPtr<c_void>,
    logger: Option<Logger>,
}

impl State {
    /// Logs a message of this status and category.
    pub fn log(&self, status: Status, category: &str, text: &str) {
        let texts = [category, text].map(|text| CString::new(text.replace('\0', " ")));
        if let (Some(logger), [Ok(category), Ok(text)]) = (self.logger, texts) {
            let environment = self.environment.load(Relaxed);
            // SAFETY: what the importer gave, and C strings.
            unsafe {
                logger(
                    environment,
                    status as c_int,
                    category.as_ptr(),
                    text.as_ptr(),
                )
            };
        }
    }
}

impl WasiView for State {
    fn ctx(&mut self) -> WasiCtxView<'_> {
        let Self { wasi, table, .. } = self;
        WasiCtxView { ctx: wasi, table }
    }
}

impl fmi::fmi3::types::Host for State {}

impl callbacks::Host for State {
    fn log_message(&mut self, _: String, status: Status, category: String, text: String) {
        self.log(status, &category, &text);
    }

    fn clock_update(&mut self) {}

    fn lock_preemption(&mut self) {}

    fn unlock_preemption(&mut self) {}
}

impl intermediate_update_callbacks::Host for State {
    fn intermediate_update(&mut self, _: f64, _: bool, _: bool, _: bool, _: bool) -> (bool, f64) {
        (false, 0.0)
    }
}

/// The interface of an instance.
pub enum Guest {
    CoSimulation(co_simulation::Guest),
    ModelExchange(model_exchange::Guest),
}

/// An instance, in a memory of its own.
pub struct Instance {
    pub store: Store<State>,
    pub guest: Guest,
    pub this: ResourceAny,
    /// What the last read of texts and of bytes gave.
    pub texts: Vec<CString>,
    pub bytes: Vec<Vec<u8>>,
}

/// The arguments with which either kind of instance is made.
pub struct Arguments<'a> {
    pub texts: [&'a CStr; 2],
    pub is_logging: bool,
    pub environment: *mut c_void,
    pub logger: Option<Logger>,
}

impl Instance {
    /// An instance for Co-Simulation, with eventModeUsed, earlyReturnAllowed and variables, or for
    /// Model Exchange; None if the FMU makes none, or after a message.
    pub fn new(arguments: Arguments, kind: Option<([bool; 2], &[u32])>) -> Option<Box<Self>> {
        let loaded = LOADED.get()?;
        let mut wasi = WasiCtxBuilder::new();
        wasi.inherit_stdout().inherit_stderr();
        // One without resources needs none.
        let _ = wasi.preopened_dir(&loaded.resources, RESOURCES, FsPerms::ReadOnly);
        let memory = loaded
            .limits
            .memory
            .map_or(usize::MAX, |most| most as usize);
        let limits = StoreLimitsBuilder::new().memory_size(memory);
        let state = State {
            wasi: wasi.build(),
            table: ResourceTable::new(),
            limits: limits.trap_on_grow_failure(true).build(),
            environment: AtomicPtr::new(arguments.environment),
            logger: arguments.logger,
        };
        let mut store = Store::new(loaded.component.engine(), state);
        store.limiter(|state| &mut state.limits);
        match Self::make(loaded, &mut store, &arguments, kind) {
            Ok(Some((guest, this))) => Some(Box::new(Self {
                store,
                guest,
                this,
                texts: Vec::new(),
                bytes: Vec::new(),
            })),
            Ok(None) => None,
            Err(error) => {
                let text = format!("{:#}", error.root_cause());
                store.data().log(Status::Fatal, "logStatusFatal", &text);
                None
            }
        }
    }

    fn make(
        loaded: &Loaded,
        store: &mut Store<State>,
        arguments: &Arguments,
        kind: Option<([bool; 2], &[u32])>,
    ) -> Result<Option<(Guest, ResourceAny)>> {
        let instance = loaded.component.instantiate(&mut *store)?;
        let [name, token] = arguments.texts.map(CStr::to_str);
        let (name, token, logging) = (name?, token?, arguments.is_logging);
        let lacks = |error: &wasmtime::Error| anyhow!("{error:#}");
        Ok(match kind {
            Some(([events, early], variables)) => {
                let indices = loaded.co_simulation.as_ref().map_err(lacks)?;
                let guest = indices.load(&mut *store, &instance)?;
                let this = guest
                    .co_simulation_instance()
                    .call_instantiate_co_simulation(
                        store, name, token, RESOURCES, false, logging, events, early, variables,
                    )?;
                this.map(|this| (Guest::CoSimulation(guest), this))
            }
            None => {
                let indices = loaded.model_exchange.as_ref().map_err(lacks)?;
                let guest = indices.load(&mut *store, &instance)?;
                let this = guest
                    .model_exchange_instance()
                    .call_instantiate_model_exchange(
                        store, name, token, RESOURCES, false, logging,
                    )?;
                this.map(|this| (Guest::ModelExchange(guest), this))
            }
        })
    }
}
