//! What the command lines of programs on this library share: which system, how it is stepped, which values it starts from; a progress
//! bar.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};

use crate::master::{Schedule, Stepping};
use crate::noise::Noise;
use crate::run::Experiment;
use crate::system::{Setting, System};

/// Which system is run.
#[derive(Args, Clone)]
pub struct SystemArgs {
    /// System: a packed .ssp, or a .ssd with --fmu-dir
    #[arg(long, value_name = "FILE")]
    pub system: Option<PathBuf>,
    /// Take the FMUs from this directory, by file name
    #[arg(long, value_name = "DIR")]
    pub fmu_dir: Option<PathBuf>,
    /// System structure to take from the packed system: `triangular_pd.ssd` [default: SystemStructure.ssd]
    #[arg(long, value_name = "NAME")]
    pub variant: Option<String>,
    /// Parameter set for the system, in the packed system (`resources/triangular.ssv`) or a file; repeatable, before all other options
    #[arg(long, value_name = "FILE")]
    pub parameters: Vec<PathBuf>,
}

impl SystemArgs {
    /// Load the system; without `--system` the one that `default` finds.
    pub fn load(&self, default: impl FnOnce() -> Result<PathBuf>) -> Result<System> {
        let path = self.system.clone().map_or_else(default, Ok)?;
        let mut system = System::load(&path, self.variant.as_deref(), self.fmu_dir.as_deref())?;
        for set in &self.parameters {
            system.apply_set(set)?;
        }
        Ok(system)
    }
}

/// How the system is stepped, and from which values.
#[derive(Args, Clone)]
pub struct RunArgs {
    /// Communication step H, s
    #[arg(long, default_value_t = 1e-3, value_name = "SECONDS")]
    pub step: f64,
    /// Stop time, s [default: that of the system's default experiment, or what the program knows better]
    #[arg(long, value_name = "SECONDS")]
    pub stop_time: Option<f64>,
    /// Order of stepping
    #[arg(long, value_enum, default_value_t)]
    pub schedule: Schedule,
    /// With --schedule jacobi: pass first time derivatives of continuous signals instead of holding them
    #[arg(long)]
    pub input_derivatives: bool,
    /// Start value of any variable, repeatable, applied last; an enumeration item may be given by name
    #[arg(long = "set", value_name = "COMPONENT.VARIABLE=VALUE")]
    pub settings: Vec<String>,
}

impl RunArgs {
    /// The experiment on `system` that these arguments describe.
    pub fn experiment(&self, system: &System) -> Result<Experiment> {
        let schedule = match (self.schedule, self.input_derivatives) {
            (Schedule::Jacobi, true) => Schedule::JacobiDerivatives,
            (_, true) => bail!("--input-derivatives needs --schedule jacobi"),
            (schedule, false) => schedule,
        };
        let settings = self.settings.iter().map(|text| {
            let setting = system.parse_setting(text);
            setting.with_context(|| format!("--set {text}"))
        });
        Ok(Experiment {
            stepping: Stepping {
                start: system.structure.start_time,
                step: self.step,
                schedule,
            },
            stop: self.stop_time,
            settings: settings.collect::<Result<Vec<Setting>>>()?,
            noise: Noise::default(),
        })
    }
}

impl ValueEnum for Schedule {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::GaussSeidel, Self::Jacobi]
    }

    fn to_possible_value(&self) -> Option<clap::builder::PossibleValue> {
        let (name, help) = match self {
            Self::GaussSeidel => (
                "gauss-seidel",
                "Components one after the other in the order of the system; later ones get the mean force of the step",
            ),
            Self::Jacobi => (
                "jacobi",
                "All components at once from the values at the communication point",
            ),
            Self::JacobiDerivatives => return None,
        };
        Some(clap::builder::PossibleValue::new(name).help(help))
    }
}

/// The file `name` in one of the places where the FMUs lie for a program: the folder that the environment variable `variable` names, the
/// program's own folder, `fmu/` in it or above it (the build folder).
pub fn find(name: &str, variable: &str) -> Result<PathBuf> {
    let mut folders = Vec::new();
    if let Some(folder) = std::env::var_os(variable) {
        folders.push(PathBuf::from(folder));
    } else if let Some(own) = std::env::current_exe()?.parent() {
        folders.push(own.to_path_buf());
        folders.extend(own.ancestors().take(4).map(|above| above.join("fmu")));
    }
    let files: Vec<PathBuf> = folders.iter().map(|folder| folder.join(name)).collect();
    let found = files.iter().find(|file| file.is_file()).cloned();
    found.with_context(|| {
        let places: Vec<_> = files.iter().map(|f| f.display().to_string()).collect();
        format!(
            "there is no {name}; name a system (--system) or a folder (environment variable {variable}); looked for: {}",
            places.join(", ")
        )
    })
}

/// A file to write to.
pub fn create(path: &Path) -> Result<BufWriter<File>> {
    let file = File::create(path);
    let file = file.with_context(|| format!("`{}` cannot be written", path.display()))?;
    Ok(BufWriter::with_capacity(1 << 16, file))
}

/// A progress bar over `length` steps or runs; an invisible one where it is to be `hidden`.
pub fn bar(length: u64, unit: &str, hidden: bool) -> ProgressBar {
    if hidden {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(length);
    let template = format!("{{bar:40}} {{pos}}/{{len}} {unit}, {{elapsed}} elapsed, {{eta}} left");
    if let Ok(style) = ProgressStyle::with_template(&template) {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// The exit code of a program that ends with `result`; an error is printed.
pub fn exit(result: Result<()>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
