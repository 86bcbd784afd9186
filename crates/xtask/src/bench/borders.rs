//! What a call costs through FMI 3.0 beside FMI 2.0, in instructions: one library, both borders.

use std::path::Path;

use anyhow::{Result, ensure};
use cargo_fmu::library::{self, Version};
use cargo_fmu::workspace::Source;

use super::callgrind::{per_call, valgrind};
use super::inputs::{compiled, library_in};
use crate::workspace::Workspace;

/// Most instructions of set + step + get through FMI 3.0, in those through FMI 2.0.
const MOST: f64 = 1.1;

/// Count on an example and on the packed manipulator, print, and fail where FMI 3.0 costs too much.
pub fn check(workspace: &Workspace, hdrm: &Path) -> Result<()> {
    let driver = compiled(workspace, "borders.c", &["-ldl"])?;
    let count = |library: &Path, version: Version, call: &[&str]| {
        let token = library::description(&library::files_of(library, version)?)?.guid;
        let number = match version {
            Version::Fmi2 => "2",
            Version::Fmi3 => "3",
        };
        per_call([1000, 2000], |n| {
            let mut command = valgrind(workspace);
            command.arg(&driver).arg(number).arg(library).arg(&token);
            command.args(call).arg(n.to_string());
            command
        })
    };
    let both = |library: &Path, call: &[&str]| -> Result<[u64; 2]> {
        Ok([
            count(library, Version::Fmi2, call)?,
            count(library, Version::Fmi3, call)?,
        ])
    };
    let integrators = Source::Example("integrators".to_string());
    let integrators = workspace.build_fmus(&[integrators])?.remove(0);
    let [two, three] = both(&integrators, &["step", "0", "4", "4"])?;
    println!("set of 4 + step + get of 4: {two} through FMI 2.0, {three} through FMI 3.0");
    ensure!(
        three as f64 <= MOST * two as f64,
        "through FMI 3.0 it must be at most {MOST} times as much"
    );
    let hdrm = library_in(workspace, hdrm)?;
    let description = library::description(&library::files(&hdrm)?)?;
    let zeta = description.variable("zeta[1]")?.reference.to_string();
    let [six, array] = both(&hdrm, &["get", &zeta, "6"])?;
    println!("get of 6: {six} by six references of FMI 2.0, {array} by one of FMI 3.0");
    ensure!(array < six, "one reference must cost less than six");
    Ok(())
}
