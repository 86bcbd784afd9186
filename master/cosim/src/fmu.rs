//! A loaded FMU with its variables by element: systems hold it, and instances are made of it.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result, bail, ensure};
use fmi_description::{Archive, Causality, Description, Interface};
use fmi_import::batch::{Batch, Layout};
use fmi_import::fmi_instance::{Arguments, FmiInstance};
use fmi_import::value::Value;
use fmi_import::{
    Binary, Choice, ClockPlan, ExchangePlan, Functions, Limits, as_component, instantiate,
    messages, output,
};

use crate::io::digest::sha256;

/// A loaded FMU, shared by all its instances.
#[derive(Clone)]
pub struct Fmu {
    /// Name for messages: the file it came from.
    pub file: String,
    /// The model description, with arrays of FMI 3.0 by element, as a system structure names them.
    pub description: Description,
    /// Size of all its files, bytes.
    pub(crate) unpacked_size: u64,
    pub(crate) loaded: Arc<fmi_import::Fmu>,
    layout: Layout,
    pub(crate) plan: Arc<ClockPlan>,
    /// How its instances are integrated, for Model Exchange.
    exchange: Option<Arc<ExchangePlan>>,
    instances: Arc<AtomicUsize>,
    /// The model description, if it has structural parameters.
    text: Option<Arc<str>>,
    /// What its instances are set to in Configuration Mode: structural parameters, by index.
    pub(crate) configuration: Vec<(usize, Value)>,
    /// The arrays that then have other sizes, as far as they can be set.
    pub(crate) resized: Vec<Batch>,
    /// Values of its structural parameters, by value reference.
    sizes: HashMap<u32, String>,
    /// How it was wanted.
    pub(crate) wanted: FmuWish,
    /// Each instance lives in a process of its own, with these limits.
    pub(crate) isolation: Option<Limits>,
    /// SHA-256 of the archive.
    pub(crate) sha256: String,
    /// Harmless oddities of the archive or its description.
    pub remarks: Vec<String>,
}

/// How a component uses its FMU.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FmuWish {
    /// The interface, if one is chosen.
    pub interface: Option<Interface>,
    /// Which of its binaries, and whether in processes of their own.
    pub binary: Binary,
    /// What each of these processes may need.
    pub limits: Limits,
}

impl Fmu {
    /// Loads an FMU from its bytes; `file` is its name for messages. If it has Co-Simulation, that is
    /// used, else Model Exchange or Scheduled Execution.
    pub fn load(file: &str, bytes: Vec<u8>) -> Result<Arc<Self>> {
        Self::load_as(file, bytes, FmuWish::default())
    }

    /// The same as it is wanted. An FMU whose binary is WebAssembly is always isolated.
    pub fn load_as(file: &str, bytes: Vec<u8>, wanted: FmuWish) -> Result<Arc<Self>> {
        Self::open(file, bytes, wanted).with_context(|| format!("FMU `{file}` cannot be loaded"))
    }

    fn open(file: &str, bytes: Vec<u8>, wanted: FmuWish) -> Result<Arc<Self>> {
        ensure!(
            !wanted.binary.is_isolated || cfg!(target_os = "linux"),
            "a process of its own (--isolate, or the annotation of the component) needs Linux"
        );
        use Interface::{CoSimulation, ModelExchange, ScheduledExecution};
        let usable = &[CoSimulation, ModelExchange, ScheduledExecution][..];
        let interfaces = wanted.interface.as_ref();
        let interfaces = interfaces.map_or(usable, std::slice::from_ref);
        let sha256 = sha256(&bytes);
        let mut archive = Archive::open(bytes)?;
        let description = archive.description_as(interfaces)?;
        let (loaded, remark) =
            fmi_import::Fmu::from_archive(file, &mut archive, description, wanted.binary)?;
        let is_isolated = wanted.binary.is_isolated || loaded.is_wasm();
        let while_loading = messages::reasons(&format!("FMU `{file}`"));
        let remarks = loaded.description.remarks.iter().cloned().chain(remark);
        let remarks = remarks.map(|remark| remark.to_string());
        let mut remarks: Vec<String> = remarks.chain(while_loading).collect();
        let description = as_component(&loaded.description);
        if description.capabilities.needs_execution_tool {
            remarks.push("it says that it needs its tool (needsExecutionTool)".into());
        }
        let layout = Layout::new(&description);
        let mut variables = description.variables.iter();
        let text = match variables.any(|v| v.causality == Causality::StructuralParameter) {
            true => Some(archive.description_text()?.into()),
            false => None,
        };
        Ok(Arc::new(Self {
            file: file.to_string(),
            unpacked_size: archive.unpacked_size(),
            loaded: Arc::new(loaded),
            text,
            configuration: Vec::new(),
            resized: Vec::new(),
            sizes: HashMap::new(),
            wanted,
            isolation: is_isolated.then_some(wanted.limits),
            plan: Arc::new(ClockPlan::new(&description, &layout)),
            exchange: exchange_plan(&description, &layout)?,
            layout,
            description,
            instances: Arc::default(),
            sha256,
            remarks,
        }))
    }

    /// Whether each of its instances lives in a process of its own.
    pub fn is_isolated(&self) -> bool {
        self.isolation.is_some()
    }

    /// Whether it has structural parameters, on which the sizes of arrays may depend.
    pub(crate) fn is_configurable(&self) -> bool {
        self.text.is_some()
    }

    /// Whether it is the name of a structural parameter.
    pub(crate) fn is_structural(&self, name: &str) -> bool {
        let found = self
            .description
            .index(name)
            .filter(|_| self.is_configurable());
        let v = found.map(|k| &self.description.variables[k]);
        v.is_some_and(|v| v.causality == Causality::StructuralParameter)
    }

    /// The same FMU with other values of structural parameters, by name, and with the arrays that
    /// it has then.
    pub(crate) fn configured(&self, values: &BTreeMap<String, Value>) -> Result<Arc<Self>> {
        let text = self.text.as_deref().unwrap_or_default();
        let value = |(name, value): (&String, &Value)| {
            Ok((
                self.description.variable(name)?.reference,
                value.to_string(),
            ))
        };
        let sizes: HashMap<u32, String> = values.iter().map(value).collect::<Result<_>>()?;
        let arrays = Description::parse_as(text, &[self.description.interface], &sizes)?;
        let description = as_component(&arrays);
        let layout = Layout::new(&description);
        let index =
            |(name, value): (&String, &Value)| Some((description.index(name)?, value.clone()));
        let before = self.loaded.description.variables.iter();
        let (mut resized, mut first) = (Vec::new(), 0);
        for (v, before) in arrays.variables.iter().zip(before) {
            let elements = first..first + v.size();
            first = elements.end;
            let is_given = v.causality == Causality::Parameter || v.is_input();
            if v.dimensions != before.dimensions && !elements.is_empty() && is_given {
                resized.push(Batch::new(&description, &layout, elements.collect()));
            }
        }
        Ok(Arc::new(Self {
            plan: Arc::new(ClockPlan::new(&description, &layout)),
            configuration: values.iter().filter_map(index).collect(),
            resized,
            sizes,
            exchange: exchange_plan(&description, &layout)?,
            layout,
            description,
            ..self.clone()
        }))
    }

    /// The same FMU, integrated by another method; None if it is for Co-Simulation.
    ///
    /// # Errors
    /// It cannot be integrated by that method.
    pub(crate) fn with_method(&self, choice: Choice) -> Result<Option<Arc<Self>>> {
        let can_be_stiff = self
            .exchange
            .as_ref()
            .is_none_or(|plan| plan.can_be_stiff());
        ensure!(
            choice != Choice::Stiff || can_be_stiff,
            "the Jacobian of its states is too large without dependencies in its description"
        );
        Ok(self.with_exchange(|plan| plan.choice = choice))
    }

    /// The same FMU with the means over a step of outputs, pairs of an output and of the variable
    /// that gets its mean; None if it is for Co-Simulation.
    pub(crate) fn with_means(&self, of: &[[usize; 2]]) -> Option<Arc<Self>> {
        self.with_exchange(|plan| plan.take_means(&self.description, &self.layout, of))
    }

    fn with_exchange(&self, change: impl FnOnce(&mut ExchangePlan)) -> Option<Arc<Self>> {
        let mut plan = ExchangePlan::clone(self.exchange.as_ref()?);
        change(&mut plan);
        let exchange = Some(Arc::new(plan));
        Some(Arc::new(Self {
            exchange,
            ..self.clone()
        }))
    }

    /// The method by which it is integrated, if one is chosen.
    pub(crate) fn method(&self) -> Option<Choice> {
        let choice = self.exchange.as_ref()?.choice;
        (choice != Choice::Automatic).then_some(choice)
    }

    /// Where its unpacked resources are: a URI or a path, depending on the version of FMI.
    pub fn resources(&self) -> &str {
        self.loaded.resources.to_str().unwrap_or_default()
    }

    /// A batch of variables that are read or written together, by index; all must be of one type,
    /// numeric or Boolean.
    pub fn batch(&self, variables: Vec<usize>) -> Result<Batch> {
        let mut all = variables.iter().map(|k| &self.description.variables[*k]);
        if let Some(v) = all.find(|v| !v.access().is_number()) {
            bail!("{} of FMU `{}` is not a number", v.name, self.file);
        }
        Ok(self.any_batch(variables))
    }

    /// The same with variables of any type.
    pub(crate) fn any_batch(&self, variables: Vec<usize>) -> Batch {
        Batch::new(&self.description, &self.layout, variables)
    }

    /// Makes an instance with these functions, of the FMU or of a copy of its library; None if the
    /// FMU returns none. Text that it prints meanwhile is marked as its own.
    pub(crate) fn make(
        &self,
        functions: &Arc<Functions>,
        arguments: &Arguments,
    ) -> Result<Option<Box<dyn FmiInstance>>> {
        let who = format!("{} (FMU `{}`)", arguments.name.to_string_lossy(), self.file);
        output::named(&who, || {
            let exchange = self.exchange.as_ref();
            instantiate(functions, &self.layout, &self.plan, exchange, arguments)
        })
    }

    /// Makes an instance in a process of its own, with these limits; None if the FMU returns none.
    pub(crate) fn make_isolated(
        &self,
        arguments: &Arguments,
        limits: Limits,
    ) -> Result<Option<Box<dyn FmiInstance>>> {
        #[cfg(all(feature = "native", target_os = "linux"))]
        {
            use fmi_import::isolated::IsolatedInstance;
            let sizes = (&self.sizes, self.description.variables.len());
            let fmu = (&*self.file, &*self.loaded);
            let exchange = self.exchange.as_deref();
            let made = IsolatedInstance::new(fmu, sizes, exchange, arguments, limits)?;
            return Ok(made.map(|instance| Box::new(instance) as Box<dyn FmiInstance>));
        }
        #[allow(unreachable_code)] // known above
        {
            let _ = (arguments, limits, &self.sizes);
            bail!("there are no processes here")
        }
    }

    /// Counts one more instance; an error if the FMU allows only one per process.
    pub(crate) fn register(&self, name: &str) -> Result<()> {
        if self.instances.fetch_add(1, Ordering::SeqCst) > 0
            && self.description.capabilities.only_once
            && self.isolation.is_none()
        {
            self.unregister();
            bail!(
                "{name}: FMU `{}` allows only one instance per process",
                self.file
            );
        }
        Ok(())
    }

    /// Counts one instance less.
    pub(crate) fn unregister(&self) {
        self.instances.fetch_sub(1, Ordering::SeqCst);
    }
}

/// How an FMU for Model Exchange is integrated.
fn exchange_plan(description: &Description, layout: &Layout) -> Result<Option<Arc<ExchangePlan>>> {
    let is_exchange = description.interface == Interface::ModelExchange;
    let plan = is_exchange.then(|| ExchangePlan::new(description, layout));
    Ok(plan.transpose()?.map(Arc::new))
}
