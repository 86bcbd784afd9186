//! `cargo xtask demo`, for a first look: from a fresh checkout to the coupled machine. Builds the
//! FMUs and programs, prints the paper's table, and writes a report.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context as _, Result};
use cargo_fmu::pack::Platforms;
use cargo_fmu::process::execute;

use crate::pack::{self, PAPER};
use crate::phases::Phases;
use crate::workspace::Workspace;

/// Profile of FMUs and programs: one for both, so that shared crates are compiled once. The FMUs
/// compute the same as those of `cargo xtask pack`, which run faster but take minutes to link.
const PROFILE: &str = "release";
/// Packages of the programs, always built together, so that shared crates keep their features.
const PROGRAMS: [&str; 2] = ["experiments", "report"];

/// Runs the demo; CSV files, report and figures go to `demo/` of the target directory.
pub fn run(workspace: &Workspace) -> Result<()> {
    println!(
        "From nothing, on two cores: some two minutes to the paper's table, some two more to the \
         report. The machine's FMUs and the program that runs them are compiled first; a second \
         time all of this takes a minute."
    );
    let phases = Phases::start();
    let fmus = workspace.fmu_dir();
    let hdrm_fmu = phases.run("compile the FMUs of the paper and hdrm-fmu", || {
        pack::paper_with(workspace, &arguments("hdrm-fmu"), &fmus)?;
        program(workspace, "hdrm-fmu")
    })?;
    let system = fmus.join("Manipulator.ssp");
    let run = |arguments: &[&str]| {
        let mut command = workspace.command(&hdrm_fmu);
        command.args(arguments).arg("--system").arg(&system);
        command
    };
    phases.run("the paper's table: 30 runs", || {
        execute(&mut run(&["table"]))
    })?;
    let out = workspace.target.join("demo");
    fs::create_dir_all(&out).with_context(|| out.display().to_string())?;
    phases.run("signals of three runs as CSV", || {
        let mut compare = run(&["compare", "--trajectory", "cubic", "--interval", "0.01"]);
        execute(compare.arg("--csv-dir").arg(&out))
    })?;
    phases.run("compile the other FMUs and hdrm-fmu-report", || {
        let arguments = arguments("hdrm-fmu-report");
        pack::suite_with(workspace, &arguments, &Platforms::default(), &fmus)
    })?;
    let report = out.join("report.html");
    phases.run("the report: its runs, page and figures", || {
        let recorded = workspace.root.join("docs/studies/recorded");
        let mut command = run(&["report"]);
        command.arg("--out").arg(&report);
        command.arg("--figures").arg(out.join("figures"));
        for study in ["tournament", "margins"] {
            let file = recorded.join(study).with_extension("json");
            command.arg(format!("--{study}")).arg(file);
        }
        execute(&mut command)
    })?;
    print!("\n{}", phases.table());
    println!("open {} in a browser", report.display());
    println!("`cargo xtask web` makes the live machine, which runs in a browser");
    println!(
        "the FMUs in {} were built fast; `cargo xtask pack` makes them run faster",
        fmus.display()
    );
    Ok(())
}

/// Arguments of cargo that build a program together with the libraries of the FMUs.
fn arguments(program: &str) -> Vec<String> {
    let packages = PROGRAMS.iter().flat_map(|name| ["--package", *name]);
    let all = ["--profile", PROFILE].into_iter().chain(packages);
    all.chain(["--bin", program]).map(String::from).collect()
}

/// The file of a program that was built together with the FMUs of the paper.
fn program(workspace: &Workspace, name: &str) -> Result<PathBuf> {
    let packages = PAPER.iter().chain(&PROGRAMS);
    let packages = packages.flat_map(|name| ["--package", *name]);
    let targets: Vec<_> = packages.chain(["--bin", name]).collect();
    workspace.build_program(PROFILE, &targets, name)
}
