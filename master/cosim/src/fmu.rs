//! An FMU with its library loaded once, shared by all its instances.

#[cfg_attr(not(feature = "native"), path = "fmu/module.rs")]
mod library;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result, bail};
use fmi_description::{Archive, Description, Version};
#[cfg(feature = "native")]
use fmi_import::calls::Functions2;
use fmi_import::calls::Functions3;

use crate::slave::clocks::{Plan, is_triggered};
use crate::wiring::batch::{Batch, Layout};
use library::Library;

/// A loaded FMU. The library and the files that it needs live as long as any instance.
pub struct Fmu {
    /// Name for messages: the file it came from.
    pub file: String,
    /// What the model description says; arrays of FMI 3.0 by element, which is how a system
    /// structure names them.
    pub description: Description,
    /// Where the unpacked resources are, as the version wants it: a URI or a path.
    pub resources: String,
    pub(crate) api: Api,
    #[cfg(feature = "native")]
    unpacked: library::Unpacked,
    pub(crate) layout: Layout,
    pub(crate) plan: Arc<Plan>,
    pub(crate) instances: AtomicUsize,
    /// What is odd about the archive or its description, but does no harm.
    pub remarks: Vec<String>,
}

/// The functions of the library; those of modules are of FMI 3.0.
pub(crate) enum Api {
    #[cfg(feature = "native")]
    Fmi2(Arc<Functions2>),
    Fmi3(Arc<Functions3>),
}

impl Api {
    fn of(library: Library, version: Version) -> Self {
        match version {
            #[cfg(feature = "native")]
            Version::Fmi2 => Self::Fmi2(Arc::new(Functions2::of(library))),
            _ => Self::Fmi3(Arc::new(Functions3::of(library))),
        }
    }
}

impl Fmu {
    /// The functions of a copy of its library, for another thread: global variables are not shared.
    #[cfg(feature = "native")]
    pub(crate) fn copied(&self) -> Result<Api> {
        let copy = self.unpacked.copy();
        let copy = copy.with_context(|| format!("a copy of the library of FMU `{}`", self.file))?;
        Ok(Api::of(copy, self.description.fmi))
    }

    /// Load an FMU from its bytes; `file` is its name for messages.
    pub fn load(file: &str, bytes: Vec<u8>) -> Result<Arc<Self>> {
        Self::open(file, bytes).with_context(|| format!("FMU `{file}` cannot be loaded"))
    }

    fn open(file: &str, bytes: Vec<u8>) -> Result<Arc<Self>> {
        let mut archive = Archive::open(bytes)?;
        let description = archive.description()?;
        let (library, resources, remark) = Library::load(file, &mut archive, &description)?;
        let remarks = description.remarks.iter().cloned().chain(remark);
        let mut remarks: Vec<String> = remarks.map(|remark| remark.to_string()).collect();
        let description = description.by_element();
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
            resources,
            #[cfg(feature = "native")]
            unpacked: library.unpacked(),
            api: Api::of(library, description.fmi),
            plan: Arc::new(Plan::new(&description, &layout)),
            layout,
            description,
            instances: AtomicUsize::new(0),
            remarks,
        }))
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

    /// Count one more instance, or refuse where the FMU allows only one per process.
    pub(crate) fn register(&self, name: &str) -> Result<()> {
        if self.instances.fetch_add(1, Ordering::SeqCst) > 0
            && self.description.capabilities.only_once
        {
            self.instances.fetch_sub(1, Ordering::SeqCst);
            bail!(
                "{name}: FMU `{}` allows only one instance per process",
                self.file
            );
        }
        Ok(())
    }
}
