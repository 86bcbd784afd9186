//! From a fresh checkout to the coupled machine: builds what runs it, prints the paper's table,
//! then writes a report.

use std::fs;

use anyhow::{Context as _, Result};
use cargo_fmu::pack::Platforms;
use cargo_fmu::process::execute;

use crate::pack;
use crate::phases::Phases;
use crate::workspace::Workspace;

/// Profile of FMUs and programs: one for both, so that what they share is compiled once. The FMUs
/// compute the same as those of `cargo xtask pack`, which take minutes longest to link and run
/// faster.
const PROFILE: &str = "release";
/// Packages that are built beside the FMUs, always together, so that their dependencies have the
/// same features.
const PACKAGES: [&str; 4] = ["--package", "studies", "--package", "report"];

/// Do it all, with CSV files, report and figures in `demo/` of the target directory.
pub fn run(workspace: &Workspace) -> Result<()> {
    println!(
        "From nothing, on two cores: some three minutes to the paper's table, some two more to the report. What is compiled now is the \
         machine's FMUs and the program that runs them; a second time all of this takes seconds."
    );
    let phases = Phases::default();
    let fmus = workspace.fmu_dir();
    let hdrm_fmu = phases.run("compile and pack FMUs, compile hdrm-fmu", || {
        let program = ["--bin", "hdrm-fmu"];
        let mut arguments = vec!["--profile", PROFILE];
        arguments.extend(PACKAGES.iter().chain(&program));
        let arguments: Vec<_> = arguments.into_iter().map(String::from).collect();
        pack::suite_with(workspace, &arguments, &Platforms::default(), &fmus)?;
        build(workspace, "hdrm-fmu")
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
    phases.run("compile hdrm-fmu-report", || {
        build(workspace, "hdrm-fmu-report")
    })?;
    let report = out.join("report.html");
    phases.run("the report: its runs, page and figures", || {
        let mut command = run(&["report", "--out"]);
        execute(
            command
                .arg(&report)
                .arg("--figures")
                .arg(out.join("figures")),
        )
    })?;
    print!("\n{}", phases.table());
    println!("open {} in a browser", report.display());
    println!(
        "the FMUs in {} were built fast; `cargo xtask pack` makes them run faster",
        fmus.display()
    );
    Ok(())
}

/// Build a program of [`PACKAGES`] from the same crates as the FMUs.
fn build(workspace: &Workspace, program: &str) -> Result<std::path::PathBuf> {
    let suite = workspace.suite();
    let shells = suite.iter().flat_map(|source| ["--package", source.name()]);
    let targets: Vec<_> = shells.chain(PACKAGES).chain(["--bin", program]).collect();
    let mut built = workspace.build(PROFILE, &targets)?;
    built
        .remove(program)
        .with_context(|| format!("there is no program `{program}`"))
}
