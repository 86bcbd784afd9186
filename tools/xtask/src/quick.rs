//! `cargo xtask quick`: format, clippy and the tests of one product, for a check between two edits.
//! `cargo xtask test` runs the rest.

use anyhow::Result;
use cargo_fmu::process::{execute, output};
use clap::Args;
use clap::builder::PossibleValuesParser;

use crate::phases::Phases;
use crate::test::{cargo, python};
use crate::workspace::Workspace;

/// A part of the repository that is developed by itself.
struct Product {
    name: &'static str,
    /// Prefixes of its files' paths.
    paths: &'static [&'static str],
    /// Its Python tests, `tests/test_*.py`, that take only seconds.
    outside: &'static str,
}

impl Product {
    const fn new(name: &'static str, paths: &'static [&str], outside: &'static str) -> Self {
        Self {
            name,
            paths,
            outside,
        }
    }
}

/// A file belongs to the first product that has a prefix of its path.
const PRODUCTS: [Product; 7] = [
    Product::new("fmi", &["fmi/"], "alone description"),
    Product::new("kit", &["kit/"], "c_types description fmi3 misuse"),
    Product::new("master", &["master/"], "alone bad_systems ssp"),
    Product::new(
        "machine",
        &["machine/", "parameters/"],
        "loads machines paths single",
    ),
    Product::new("studies", &["studies/"], "messages parameter_sets siblings"),
    Product::new("shells", &SHELLS, "description parameter_sets single ssp"),
    Product::new("tools", &[""], "circles documents handed_out measure"),
];
const SHELLS: [&str; 6] = [
    "actuator-table/",
    "examples/",
    "fmu-",
    "modelDescription/",
    "python/",
    "system/",
];

#[derive(Args)]
pub struct Options {
    /// Product to check, repeatable [default: those with files that differ from the main branch]
    #[arg(value_name = "PRODUCT", value_parser = PossibleValuesParser::new(PRODUCTS.map(|p| p.name)))]
    products: Vec<String>,
}

/// Checks the named products; without names, those that have changed.
pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let names = match options.products.is_empty() {
        true => changed(workspace)?,
        false => options.products.clone(),
    };
    let is_chosen = |product: &&Product| names.iter().any(|name| name == product.name);
    let products: Vec<&Product> = PRODUCTS.iter().filter(is_chosen).collect();
    println!(
        "{}",
        Vec::from_iter(products.iter().map(|p| p.name)).join(", ")
    );
    let phases = Phases::start();
    let result = check(workspace, &phases, &products);
    print!("\n{}", phases.table());
    result
}

fn check(workspace: &Workspace, phases: &Phases, products: &[&Product]) -> Result<()> {
    phases.run("format", || cargo(workspace, "fmt --all --check", &[]))?;
    let packages = packages(workspace, products);
    if !packages.is_empty() {
        let run = |name, command: &str, more: &str| {
            let arguments = format!("{command} --release --locked{packages}{more}");
            phases.run(name, || cargo(workspace, &arguments, &[]))
        };
        run("clippy", "clippy", " --all-targets -- -D warnings")?;
        run("tests", "test", "")?;
        run("programs", "build", " --bins")?;
    }
    phases.run("pytest", || pytest(workspace, products))
}

/// Arguments of cargo that name the packages of the products.
fn packages(workspace: &Workspace, products: &[&Product]) -> String {
    let mut arguments = String::new();
    for package in &workspace.cargo.packages {
        let folder = package.folder().strip_prefix(&workspace.root);
        let path = folder.unwrap_or(package.folder()).join("Cargo.toml");
        let name = product(&path.to_string_lossy().replace('\\', "/"));
        if products.iter().any(|product| product.name == name) {
            arguments += " --package ";
            arguments += &package.name;
        }
    }
    arguments
}

/// The product that a file of the repository belongs to.
fn product(path: &str) -> &'static str {
    let begins = |product: &&Product| product.paths.iter().any(|p| path.starts_with(p));
    let found = PRODUCTS.iter().find(begins);
    found.map_or("", |product| product.name)
}

/// Products with files that have changed since the branch left the main branch.
fn changed(workspace: &Workspace) -> Result<Vec<String>> {
    let git = |words: &[&str]| output(workspace.command("git").args(words));
    let main = [
        "refs/remotes/origin/HEAD",
        "refs/remotes/origin/main",
        "refs/heads/main",
    ];
    let main = git(&[&["for-each-ref", "--format=%(refname)"][..], &main].concat())?;
    let base = match main.lines().next() {
        Some(main) => git(&["merge-base", "HEAD", main])?,
        None => "HEAD".into(),
    };
    let differ = git(&["diff", "--name-only", base.trim()])?;
    let new = git(&["ls-files", "--others", "--exclude-standard"])?;
    let paths = differ.lines().chain(new.lines());
    Ok(paths.map(|path| product(path).to_string()).collect())
}

/// Runs the Python tests, on the FMUs that were packed last.
fn pytest(workspace: &Workspace, products: &[&Product]) -> Result<()> {
    let fmus = workspace.fmu_dir();
    let is_packed = fmus.join("Hdrm.fmu").is_file();
    let found = if is_packed { "with the" } else { "skipped: no" };
    let folder = fmus.display();
    println!("{found} FMUs in {folder}, which `cargo xtask pack --profile release` makes anew");
    if !is_packed {
        return Ok(());
    }
    let names = products
        .iter()
        .flat_map(|product| product.outside.split(' '));
    let mut command = workspace.command(python(workspace)?.program());
    command.args(["-m", "pytest", "-q", "-n", "2", "--dist", "loadfile"]);
    command.args(names.map(|name| format!("tests/test_{name}.py")));
    execute(command.env("FMU_DIR", fmus))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_file_has_a_product_and_each_test_a_file() {
        assert_eq!(product("kit/cargo-fmu/Cargo.toml"), "kit");
        assert_eq!(product("fmu-emla/src/lib.rs"), "shells");
        assert_eq!(product("fmi/fmu-check/Cargo.toml"), "fmi");
        assert_eq!(product("README.md"), "tools");
        let root = Workspace::find().unwrap().root;
        let tests = root.join("tests");
        for name in PRODUCTS.iter().flat_map(|p| p.outside.split(' ')) {
            assert!(tests.join(format!("test_{name}.py")).is_file(), "{name}");
        }
        let names = PRODUCTS.map(|product| product.name).join(", ");
        let workflow = std::fs::read_to_string(root.join(".github/workflows/quick.yml")).unwrap();
        assert!(workflow.contains(&format!("product: [{names}]")), "{names}");
    }
}
