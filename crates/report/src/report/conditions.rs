//! Under which conditions the report was made.

use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

use cosim::Setting;
use cosim::master::Schedule;
use serde_json::{Value, json};

use super::request::Request;
use studies::machine_file::MachineFile;

/// Date (UTC), computer, program, machine, step (s) and schedule, settings, and the components of
/// the system with their FMUs.
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
    json!({
        "date": date(since_epoch()),
        "host": host().unwrap_or_else(|| "unknown".into()),
        "platform": format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        "processor": processor().unwrap_or_else(|| "unknown".into()),
        "cores": std::thread::available_parallelism().map_or(1, usize::from),
        "program": concat!("hdrm-fmu ", env!("CARGO_PKG_VERSION")),
        "system": system.path.display().to_string(),
        "machine_file": machine.name,
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

/// Name of this machine, as the program `hostname` says it.
fn host() -> Option<String> {
    let said = Command::new("hostname").output().ok()?;
    let name = String::from_utf8(said.stdout).ok()?;
    Some(name.trim().to_string()).filter(|name| !name.is_empty())
}

/// Seconds since the beginning of 1970.
fn since_epoch() -> u64 {
    let passed = SystemTime::now().duration_since(UNIX_EPOCH);
    passed.map_or(0, |passed| passed.as_secs())
}

/// Date and time of a second since the beginning of 1970, by ISO 8601. Years are counted from
/// March, so that the day that some years have is their last; 400 of them have 146 097 days.
fn date(seconds: u64) -> String {
    let (days, time) = (seconds / 86_400, seconds % 86_400);
    let days = days + 719_468; // since March 1, 0000
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153; // 0 is March; five months from March or August on have 153 days
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 {
        (month + 3, 0)
    } else {
        (month - 9, 1)
    };
    let year = 400 * era + year + next;
    let (hour, minute, second) = (time / 3600, time / 60 % 60, time % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

/// Name of the processor, where Linux tells it.
fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|l| l.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_string())
}

#[cfg(test)]
mod tests {
    use super::date;

    /// Oracle: `date --utc --date @SECONDS +%FT%TZ` of GNU.
    #[test]
    fn seconds_are_dates() {
        for (seconds, expected) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_868_800, "2000-03-01T00:00:00Z"),
            (1_709_210_096, "2024-02-29T12:34:56Z"),
            (1_735_689_599, "2024-12-31T23:59:59Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(date(seconds), expected);
        }
    }
}
