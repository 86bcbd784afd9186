//! `cargo xtask quick`: format, clippy and the tests of one product, for the minutes between two
//! edits. What it leaves out, `cargo xtask test` does.

use std::path::Path;

use anyhow::{Context, Result};
use cargo_fmu::process::{execute, output};
use clap::Args;
use clap::builder::PossibleValuesParser;

use crate::phases::Phases;
use crate::python::Python;
use crate::test::cargo;
use crate::workspace::Workspace;

/// Options of `cargo xtask quick`.
#[derive(Args)]
pub struct Options {
    /// Product to check, repeatable [default: those with files that differ from the main branch]
    #[arg(value_name = "PRODUCT", value_parser = PossibleValuesParser::new(PRODUCTS.map(|p| p.name)))]
    products: Vec<String>,
}

/// A part of the repository that is worked on by itself.
struct Product {
    name: &'static str,
    /// Its folders, or how the names of folders begin.
    folders: &'static [&'static str],
    /// Its tests from outside, `tests/test_*.py`, as far as they take seconds.
    tests: &'static str,
}

const PRODUCTS: [Product; 7] = [
    Product {
        name: "fmi",
        folders: &["fmi/"],
        tests: "alone cargo_fmu",
    },
    Product {
        name: "kit",
        folders: &["kit/"],
        tests: "c_types export_example sizes",
    },
    Product {
        name: "master",
        folders: &["master/"],
        tests: "bad_systems cosim_page page_engine step_control",
    },
    Product {
        name: "machine",
        folders: &["machine/", "parameters/"],
        tests: "loads machines paths",
    },
    Product {
        name: "studies",
        folders: &["studies/"],
        tests: "messages siblings verdicts",
    },
    Product {
        name: "shells",
        folders: &[
            "actuator-table/",
            "fmu-",
            "modelDescription/",
            "system/",
            "python/",
            "examples/",
        ],
        tests: "description parameter_sets single ssp",
    },
    Product {
        name: "tools",
        folders: &[""],
        tests: "circles documents handed_out measure",
    },
];

/// Tests from outside that take longer: `cargo xtask test` runs them.
#[cfg(test)]
const LONG: &str = "";

/// Check the products that are named, else those that have changed.
pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let mut chosen = options.products.clone();
    if chosen.is_empty() {
        chosen = changed(workspace)?;
    }
    let products: Vec<_> = PRODUCTS
        .iter()
        .filter(|p| chosen.iter().any(|name| name == p.name))
        .collect();
    let names: Vec<_> = products.iter().map(|p| p.name).collect();
    println!("products: {}", names.join(", "));
    let phases = Phases::default();
    let result = check(workspace, &phases, &products);
    print!("\n{}", phases.table());
    result?;
    println!("`cargo xtask test` checks everything");
    Ok(())
}

fn check(workspace: &Workspace, phases: &Phases, products: &[&Product]) -> Result<()> {
    phases.run("format", || cargo(workspace, "fmt --all --check", &[]))?;
    let packages = packages(workspace, products);
    if !packages.is_empty() {
        let with = |command: &str| {
            cargo(
                workspace,
                &format!("{command} --release --locked {packages}"),
                &[],
            )
        };
        phases.run("clippy", || {
            cargo(
                workspace,
                &format!("clippy --release --locked {packages} --all-targets -- -D warnings"),
                &[],
            )
        })?;
        phases.run("tests", || with("test"))?;
        phases.run("programs", || with("build --bins"))?;
    }
    phases.run("pytest", || pytest(workspace, products))
}

/// Arguments of cargo that name the packages.
fn packages(workspace: &Workspace, products: &[&Product]) -> String {
    let of = |folder: &Path| {
        let folder = folder.strip_prefix(&workspace.root).unwrap_or(folder);
        let file = folder.join("Cargo.toml");
        product(&file.to_string_lossy().replace('\\', "/"))
    };
    let packages = workspace.cargo.packages.iter();
    let chosen = packages.filter(|p| {
        products
            .iter()
            .any(|product| product.name == of(p.folder()))
    });
    let named: Vec<_> = chosen.map(|p| format!("--package {}", p.name)).collect();
    named.join(" ")
}

/// The product that a file of the repository belongs to: the first whose folder holds it.
fn product(file: &str) -> &'static str {
    let holds = |p: &&Product| p.folders.iter().any(|folder| file.starts_with(folder));
    let found = PRODUCTS.iter().find(holds);
    found.expect("the last one holds all").name
}

/// Products with files that differ from where the branch left the main branch.
fn changed(workspace: &Workspace) -> Result<Vec<String>> {
    let git = |arguments: &str| output(workspace.command("git").args(arguments.split(' ')));
    let main = "for-each-ref --format=%(refname) refs/remotes/origin/HEAD refs/remotes/origin/main refs/heads/main";
    let base = match git(main)?.lines().next() {
        Some(main) => git(&format!("merge-base HEAD {main}"))?,
        None => "HEAD".into(),
    };
    let differ = git(&format!("diff --name-only {}", base.trim()))?;
    let new = git("ls-files --others --exclude-standard")?;
    let files = differ.lines().chain(new.lines());
    Ok(files.map(|file| product(file).to_string()).collect())
}

/// The tests from outside, on the FMUs that are there.
fn pytest(workspace: &Workspace, products: &[&Product]) -> Result<()> {
    let fmus = workspace.fmu_dir();
    if !fmus.join("Hdrm.fmu").is_file() {
        println!(
            "skipped: there are no FMUs in {}; `cargo xtask pack --profile release` makes them",
            fmus.display()
        );
        return Ok(());
    }
    println!(
        "with the FMUs in {}, which `cargo xtask pack --profile release` makes anew",
        fmus.display()
    );
    let python = Python::provide(workspace)?;
    python
        .install_file(workspace, "tests", "tests/requirements.txt")
        .context("packages of the tests")?;
    let names = products.iter().flat_map(|product| product.tests.split(' '));
    let mut command = workspace.command(python.program());
    command.args(["-m", "pytest", "-q", "-n", "2", "--dist", "loadfile"]);
    execute(
        command
            .args(names.map(|name| format!("tests/test_{name}.py")))
            .env("FMU_DIR", fmus),
    )
}
