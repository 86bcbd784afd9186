//! Options for components in processes of their own, which all programs that run systems share.

use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use clap::Args;
use fmi_import::Limits;

use crate::structure::FmuUse;

/// Hosts an isolated component, if this process was started for that: the first call of each program
/// that runs systems. Returns the exit code when all is done.
pub fn serve_if_asked() -> Option<ExitCode> {
    #[cfg(target_os = "linux")]
    let served = fmi_import::isolated::serve_if_asked();
    #[cfg(not(target_os = "linux"))]
    let served = None;
    served
}

/// Which components live in processes of their own, and what these may need.
#[derive(Args, Clone, Debug, Default)]
pub struct IsolationArgs {
    /// Component that lives in a process of its own, so that what crashes, exits or hangs there ends
    /// the run with its rows kept; `all`, or a pattern with `*`; repeatable. On Linux
    #[arg(long, value_name = "COMPONENT")]
    pub isolate: Vec<String>,
    /// Longest time of a call in such a process, s [default: none]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub call_timeout: Option<f64>,
    /// Most memory of such a process: `500MB`, `2GiB` [default: none]
    #[arg(long, value_name = "SIZE")]
    pub memory_limit: Option<String>,
    /// What runs of FMUs that have a library and WebAssembly: library, or wasm, in processes of their
    /// own [default: library]
    #[arg(long, value_name = "BINARY")]
    pub prefer: Option<String>,
}

impl IsolationArgs {
    /// How components use their FMUs, with these interfaces.
    ///
    /// # Errors
    /// A limit is none, or there is no such binary.
    pub fn fmu_use(self, interfaces: Vec<String>) -> Result<FmuUse> {
        let prefers_wasm = self.prefers_wasm();
        let prefer = self.prefer.as_deref().unwrap_or("library");
        ensure!(
            prefers_wasm || prefer == "library",
            "--prefer {prefer}: it must be library or wasm"
        );
        Ok(FmuUse {
            interfaces,
            limits: self.limits()?,
            isolated: self.isolate,
            prefers_wasm,
        })
    }

    /// Whether WebAssembly runs where there is also a library.
    pub fn prefers_wasm(&self) -> bool {
        self.prefer.as_deref() == Some("wasm")
    }

    /// The limits of each process.
    fn limits(&self) -> Result<Limits> {
        let time = |seconds: f64| {
            let time = Duration::try_from_secs_f64(seconds).ok();
            let time = time.filter(|time| !time.is_zero());
            time.with_context(|| {
                format!("--call-timeout {seconds}: it must be a time greater than 0 s")
            })
        };
        let memory = |text: &String| {
            bytes(text).with_context(|| {
                format!("--memory-limit {text}: it must be a size such as 500MB, 2GB or 1.5GiB")
            })
        };
        Ok(Limits {
            time: self.call_timeout.map(time).transpose()?,
            memory: self.memory_limit.as_ref().map(memory).transpose()?,
        })
    }
}

/// A size with its unit, in bytes.
fn bytes(text: &str) -> Option<u64> {
    let units = [
        ("kB", 1e3),
        ("MB", 1e6),
        ("GB", 1e9),
        ("KiB", 1024.0),
        ("MiB", 1_048_576.0),
        ("GiB", 1_073_741_824.0),
    ];
    let (number, factor) = units.iter().find_map(|(unit, factor)| {
        let number = text.strip_suffix(unit)?;
        Some((number, *factor))
    })?;
    let number: f64 = number.trim().parse().ok()?;
    (number.is_finite() && number > 0.0).then_some((number * factor) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units() {
        let sizes = ["500MB", "1.5 GiB", "64KiB"].map(bytes);
        assert_eq!(
            sizes,
            [Some(500_000_000), Some(1_610_612_736), Some(65_536)]
        );
        for wrong in ["500", "MB", "-1MB", "0GB", "nanMB", "5TB"] {
            assert_eq!(bytes(wrong), None, "{wrong}");
        }
    }
}
