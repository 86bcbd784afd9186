//! Subcommand `machine`: what is done to machine files.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::{Args, Subcommand};
use cosim::cli::print;
use machine::Machine;
use studies::perturbation::{Bounds, draw};

use super::evaluation::create;

#[derive(Subcommand)]
pub enum MachineCommand {
    /// Write a machine whose masses, centres of mass, inertias and lengths are off by errors drawn by seed
    Perturb(PerturbArgs),
}

#[derive(Args)]
pub struct PerturbArgs {
    /// Seed of the errors; the same as that of `table --world real`
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Machine file to start from [default: the reference machine]
    #[arg(long, value_name = "FILE")]
    machine: Option<PathBuf>,
    /// Bound on the error of each body's mass, with its inertia, and of joint friction, as a part
    #[arg(long, default_value_t = Bounds::REAL.mass, value_name = "PART")]
    mass: f64,
    /// Bound on the error of each centre of mass along each axis, m
    #[arg(long, default_value_t = Bounds::REAL.com, value_name = "METRES")]
    com: f64,
    /// Bound on the error of each second moment of mass along each axis, as a part, besides that of the mass
    #[arg(long, default_value_t = Bounds::REAL.second_moment, value_name = "PART")]
    second_moment: f64,
    /// Bound on the error of each length, m
    #[arg(long, default_value_t = Bounds::REAL.length, value_name = "METRES")]
    length: f64,
    /// Bound on gravity's angle out of plumb about each horizontal axis, degrees
    #[arg(long, default_value_t = Bounds::REAL.plumb.to_degrees(), value_name = "DEGREES")]
    plumb: f64,
    /// Machine file to write
    #[arg(long, default_value = "machine.json", value_name = "FILE")]
    out: PathBuf,
}

/// Do it.
pub fn run(command: &MachineCommand) -> Result<()> {
    match command {
        MachineCommand::Perturb(args) => perturb(args),
    }
}

fn perturb(args: &PerturbArgs) -> Result<()> {
    let nominal = match &args.machine {
        None => Machine::reference(),
        Some(file) => {
            let name = || file.display().to_string();
            let text = std::fs::read_to_string(file).with_context(name)?;
            Machine::from_json(&text).with_context(name)?
        }
    };
    let bounds = Bounds {
        mass: args.mass,
        com: args.com,
        second_moment: args.second_moment,
        length: args.length,
        plumb: args.plumb.to_radians(),
    };
    let (machine, gravity) = draw(&nominal, args.seed, &bounds)?;
    let mut file = create(&args.out)?;
    serde_json::to_writer_pretty(&mut file, &machine)?;
    writeln!(file)?;
    file.flush()
        .with_context(|| args.out.display().to_string())?;
    let [x, y, z] = gravity;
    print(format_args!(
        "machine of seed {} written to {}; gravity, which is no part of the file: --set hdrm.gravity[1]={x} --set hdrm.gravity[2]={y} --set \
         hdrm.gravity[3]={z}\n",
        args.seed,
        args.out.display()
    ))
}
