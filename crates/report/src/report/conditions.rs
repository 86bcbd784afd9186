//! Under which conditions the report was made.

use cosim::master::Schedule;
use cosim::system::Setting;
use serde::Serialize;

use super::Request;
use studies::machine_file::MachineFile;

#[derive(Serialize)]
pub struct Conditions {
    /// UTC.
    date: String,
    host: String,
    platform: String,
    processor: String,
    cores: usize,
    program: &'static str,
    system: String,
    machine_file: String,
    machine_sha256: String,
    /// Communication step, s.
    step: f64,
    schedule: &'static str,
    settings: Vec<String>,
    components: Vec<Component>,
}

/// A component of the system and its FMU.
#[derive(Serialize)]
struct Component {
    name: String,
    source: String,
    model: String,
    version: String,
    guid: String,
    tool: String,
}

impl Conditions {
    pub fn of(request: &Request<'_>, machine: &MachineFile) -> Self {
        let system = request.system;
        let pairs = system.structure.components.iter().zip(&system.fmus);
        let setting = |s: &Setting| format!("{} = {}", system.name(s.port), s.value);
        Self {
            date: format!("{:.0}", jiff::Timestamp::now()),
            host: gethostname::gethostname().to_string_lossy().into_owned(),
            platform: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            processor: processor().unwrap_or_else(|| "unknown".into()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            program: concat!("hdrm-fmu ", env!("CARGO_PKG_VERSION")),
            system: system.path.display().to_string(),
            machine_file: machine.name.clone(),
            machine_sha256: machine.sha256.clone(),
            step: request.base.stepping.step,
            schedule: match request.base.stepping.schedule {
                Schedule::GaussSeidel => "Gauss–Seidel",
                Schedule::Standard => "standard: get all, set all, step all",
                Schedule::Jacobi => "Jacobi, inputs held",
                Schedule::JacobiDerivatives => "Jacobi, with input derivatives",
            },
            settings: request.base.settings.iter().map(setting).collect(),
            components: pairs
                .map(|(c, fmu)| Component {
                    name: c.name.clone(),
                    source: c.source.clone(),
                    model: fmu.description.model.clone(),
                    version: fmu.description.version.clone(),
                    guid: fmu.description.guid.clone(),
                    tool: fmu.description.tool.clone(),
                })
                .collect(),
        }
    }
}

/// Name of the processor, where Linux tells it.
fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|l| l.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_string())
}
