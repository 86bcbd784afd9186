//! The conditions under which the report was made, for the last section of its page.

use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

use cosim::Setting;
use cosim::master::Schedule;
use serde_json::{Value, json};

use super::request::Request;
use experiments::setup::machine_choice::MachineFile;

/// Time (s since 1970), computer, program, machine, step (s) and schedule, settings, and the
/// system's components with their FMUs.
pub fn conditions(request: &Request<'_>, machine: &MachineFile) -> Value {
    let system = request.system;
    let pairs = system.structure.components.iter().zip(&system.fmus);
    let setting = |s: &Setting| format!("{} = {}", system.name(s.port), s.value);
    let components = pairs.map(|(c, fmu)| {
        let d = &fmu.description;
        json!({
            "name": c.name,
            "source": c.source,
            "model": d.model,
            "version": d.version,
            "guid": d.guid,
            "tool": d.tool,
        })
    });
    let passed = SystemTime::now().duration_since(UNIX_EPOCH);
    json!({
        "made": passed.unwrap_or_default().as_secs(),
        "host": host().unwrap_or_else(|| "unknown".into()),
        "platform": format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        "processor": processor().unwrap_or_else(|| "unknown".into()),
        "cores": std::thread::available_parallelism().map_or(1, usize::from),
        "program": concat!("hdrm-fmu ", env!("CARGO_PKG_VERSION")),
        "system": system.path.display().to_string(),
        "machine_file": machine.name,
        // Another machine than the paper's by its name, else null.
        "own_machine": machine.own_name(),
        "machine_sha256": machine.sha256,
        "step": request.base.stepping.step,
        "schedule": match request.base.stepping.schedule {
            Schedule::GaussSeidel => "Gauss–Seidel",
            Schedule::Standard => "standard: get all, set all, step all",
            Schedule::Jacobi => "Jacobi, inputs held",
            Schedule::JacobiDerivatives => "Jacobi, with input derivatives",
        },
        "settings": request.base.settings.iter().map(setting).collect::<Vec<_>>(),
        "components": components.collect::<Vec<_>>(),
    })
}

/// Name of this computer by the program `hostname`.
fn host() -> Option<String> {
    let output = Command::new("hostname").output().ok()?;
    let name = String::from_utf8(output.stdout).ok()?;
    Some(name.trim().to_string()).filter(|name| !name.is_empty())
}

/// Name of the processor, on Linux.
fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|l| l.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_string())
}
