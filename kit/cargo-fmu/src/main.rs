//! `cargo fmu`: makes crates, packs and checks FMUs of Rust models, and makes web pages of FMUs.
#![forbid(unsafe_code)]

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result};
use cargo_fmu::process::end;
use cargo_fmu::workspace::{Source, Workspace};
use cargo_fmu::{new, pack, verify, wasm, web};
use clap::{Args, Parser, Subcommand};

/// Cargo hands its subcommands their own name first.
#[derive(Parser)]
#[command(name = "cargo", bin_name = "cargo")]
enum Cargo {
    Fmu(Fmu),
}

/// FMUs from Rust models that use fmu-export
#[derive(Args)]
#[command(version)]
struct Fmu {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Make a new crate with a small model, its tests, and the other files of its FMU
    New {
        /// Folder of the crate; its last part is the name
        path: PathBuf,
        /// Folder of the crate fmu-export [default: that of the source that this program was built
        /// from]
        #[arg(long, value_name = "PATH")]
        fmu_export: Option<PathBuf>,
        /// A model to begin with, instead of a first-order lag
        #[arg(long, value_name = "NAME")]
        example: Option<new::Name>,
    },
    /// Build libraries and pack them, with documentation, resources and licences, into FMUs
    Pack {
        /// Package to pack, repeatable [default: the one of this folder, else all that make an FMU]
        #[arg(short, long = "package", value_name = "PACKAGE")]
        packages: Vec<String>,
        /// Example with crate type cdylib to pack, repeatable
        #[arg(long = "example", value_name = "EXAMPLE")]
        examples: Vec<String>,
        /// Platform to pack for, repeatable: linux64, win64, darwin64 or (FMI 3.0) aarch64-linux
        /// and aarch64-darwin, each for any machine of its kind, and wasm, which adds WebAssembly
        /// to the archives of FMI 3.0 [default: this machine, built the fast way]
        #[arg(long = "target", value_name = "PLATFORM")]
        targets: Vec<String>,
        /// Folder for the packed files [default: fmu/ in the target directory]
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// Cargo profile; fmu-release optimises the whole program at once, release builds faster
        #[arg(long, value_name = "PROFILE", default_value = pack::FMU_PROFILE)]
        profile: String,
        /// Value of a structural parameter, repeatable: a constant in FMI 2.0, the start value in
        /// FMI 3.0
        #[arg(long = "size", value_name = "NAME=VALUE")]
        sizes: Vec<String>,
    },
    /// Add WebAssembly of packages to archives of FMI 3.0 in the same order
    #[command(hide = true)]
    AddWasm {
        #[arg(short, long = "package")]
        packages: Vec<String>,
        #[arg(long, default_value = pack::FMU_PROFILE)]
        profile: String,
        fmus: Vec<PathBuf>,
    },
    /// Check FMUs, whoever made them: archive, description, libraries, and what they do when they
    /// are run
    Check(fmu_check::Arguments),
    /// Run the default experiment of an FMU and compare it with the results that it carries
    /// (FMI-LS-REF), or write such results
    Verify(verify::Arguments),
    /// Make one HTML file that runs an FMU or a packed system in any browser, from a folder
    Web {
        /// FMU or SSP with WebAssembly
        #[arg(value_name = "FILE")]
        model: PathBuf,
        /// The page
        #[arg(long, value_name = "FILE.html")]
        out: PathBuf,
        /// The master as a WebAssembly module [default: built from the source that this program
        /// was built from]
        #[arg(long, value_name = "FILE.wasm")]
        engine: Option<PathBuf>,
        /// Cargo profile with which it is built
        #[arg(long, value_name = "PROFILE", default_value = pack::FMU_PROFILE, conflicts_with = "engine")]
        profile: String,
        /// Another page than that of any model
        #[arg(long, hide = true)]
        page: Option<PathBuf>,
        #[arg(long, hide = true)]
        data: Vec<String>,
    },
}

fn main() -> ExitCode {
    let Cargo::Fmu(Fmu { command }) = Cargo::parse();
    end(run(command))
}

fn run(command: Command) -> Result<ExitCode> {
    match command {
        Command::New {
            path,
            fmu_export,
            example,
        } => {
            new::new(&path, fmu_export.as_deref(), example)?;
        }
        Command::Pack {
            packages,
            examples,
            targets,
            out,
            profile,
            sizes,
        } => {
            let platforms = pack::Platforms::named(&targets)?;
            let folder = std::env::current_dir().context("the current folder")?;
            let mut workspace = Workspace::containing(&folder)?;
            workspace.sizes = sizes;
            let mut sources = Source::chosen(packages, examples);
            if sources.is_empty() {
                sources = workspace.fmus(&folder);
            }
            let out = out.unwrap_or_else(|| workspace.target.join("fmu"));
            let profile = pack::profile(&profile);
            let packed = pack::fmus(&workspace, &sources, &profile, &platforms, &out)?;
            if platforms.wasm {
                wasm::add(&workspace, &sources, &profile, &pack::fmi3_files(&packed)?)?;
            }
        }
        Command::AddWasm {
            packages,
            profile,
            fmus,
        } => {
            let workspace = Workspace::containing(&std::env::current_dir()?)?;
            let sources = Source::chosen(packages, Vec::new());
            wasm::add(&workspace, &sources, &pack::profile(&profile), &fmus)?;
        }
        Command::Verify(arguments) => return arguments.run(),
        Command::Check(arguments) => return arguments.run(&["fmu", "check"]),
        Command::Web {
            model,
            out,
            engine,
            profile,
            page,
            data,
        } => {
            let page = web::Page {
                html: page.as_deref(),
                engine: engine.as_deref(),
                profile: &profile,
                data: &data,
            };
            let size = page.write(&model, &out)?;
            println!(
                "made {} ({} kB): open it in a browser",
                out.display(),
                size / 1000
            );
        }
    }
    Ok(ExitCode::SUCCESS)
}
