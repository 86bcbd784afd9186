//! An FMU as the master wires it: its variables by element, and what that plans for its instances.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result, bail};
use fmi_description::{Archive, Description};
use fmi_import::Functions;
use fmi_import::batch::{Batch, Layout};
use fmi_import::fmi_instance::{Arguments, FmiInstance};
use fmi_import::{ClockPlan, is_triggered};
use fmi_import::{instantiate, output};

/// A loaded FMU, shared by all its instances.
pub struct Fmu {
    /// Name for messages: the file it came from.
    pub file: String,
    /// What the model description says; arrays of FMI 3.0 by element, which is how a system
    /// structure names them.
    pub description: Description,
    /// Where the unpacked resources are, as the version wants it: a URI or a path.
    pub resources: String,
    pub(crate) loaded: fmi_import::Fmu,
    layout: Layout,
    pub(crate) plan: Arc<ClockPlan>,
    instances: AtomicUsize,
    /// What is odd about the archive or its description, but does no harm.
    pub remarks: Vec<String>,
}

impl Fmu {
    /// Load an FMU from its bytes; `file` is its name for messages.
    pub fn load(file: &str, bytes: Vec<u8>) -> Result<Arc<Self>> {
        Self::open(file, bytes).with_context(|| format!("FMU `{file}` cannot be loaded"))
    }

    fn open(file: &str, bytes: Vec<u8>) -> Result<Arc<Self>> {
        let mut archive = Archive::open(bytes)?;
        let description = archive.description()?;
        let (loaded, remark) = fmi_import::Fmu::from_archive(file, &mut archive, description)?;
        let remarks = loaded.description.remarks.iter().cloned().chain(remark);
        let mut remarks: Vec<String> = remarks.map(|remark| remark.to_string()).collect();
        let description = loaded.description.clone().by_element();
        if description.capabilities.needs_execution_tool {
            remarks.push("it says that it needs its tool (needsExecutionTool)".into());
        }
        for v in description.variables.iter().filter(|v| is_triggered(v)) {
            let name = &v.name;
            remarks.push(format!(
                "its clock `{name}` is triggered from outside, which nothing does: it never ticks"
            ));
        }
        let layout = Layout::new(&description);
        Ok(Arc::new(Self {
            file: file.to_string(),
            resources: loaded.resources.to_string_lossy().into_owned(),
            loaded,
            plan: Arc::new(ClockPlan::new(&description, &layout)),
            layout,
            description,
            instances: AtomicUsize::new(0),
            remarks,
        }))
    }

    /// Where its unpacked resources are, as its version wants it: a URI or a path.
    pub fn resources(&self) -> &str {
        self.loaded.resources.to_str().unwrap_or_default()
    }

    /// Variables that are read or written together, by index; all must be of one type that is a
    /// number or a truth value.
    pub fn batch(&self, variables: Vec<usize>) -> Result<Batch> {
        let of = |k: &usize| &self.description.variables[*k];
        if let Some(v) = variables.iter().map(of).find(|v| !v.access().is_number()) {
            bail!("{} of FMU `{}` is not a number", v.name, self.file);
        }
        Ok(self.any_batch(variables))
    }

    /// The same of any type.
    pub(crate) fn any_batch(&self, variables: Vec<usize>) -> Batch {
        Batch::new(&self.description, &self.layout, variables)
    }

    /// An instance of these functions, which are those of the FMU or of a copy of its library; none
    /// where the FMU gives none. What it prints meanwhile is named as its own.
    pub(crate) fn make(
        &self,
        functions: &Arc<Functions>,
        arguments: &Arguments,
    ) -> Result<Option<Box<dyn FmiInstance>>> {
        let who = format!("{} (FMU `{}`)", arguments.name.to_string_lossy(), self.file);
        output::named(&who, || {
            instantiate(functions, &self.layout, &self.plan, arguments)
        })
    }

    /// Count one more instance, or refuse where the FMU allows only one per process.
    pub(crate) fn register(&self, name: &str) -> Result<()> {
        if self.instances.fetch_add(1, Ordering::SeqCst) > 0
            && self.description.capabilities.only_once
        {
            self.unregister();
            bail!(
                "{name}: FMU `{}` allows only one instance per process",
                self.file
            );
        }
        Ok(())
    }

    /// Count one instance less.
    pub(crate) fn unregister(&self) {
        self.instances.fetch_sub(1, Ordering::SeqCst);
    }
}
