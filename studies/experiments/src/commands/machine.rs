//! Subcommand `machine`: checks machine files, scales and perturbs machines, gives their gains, and
//! writes them for tools of robotics.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use clap::{Args, Subcommand};
use cosim::cli::{output, print};
use machine_file::{extension_of, preset};
use motion_check::gain_rule::{self, Actuators, RuledGain};

use super::pictures::{DrawArgs, SceneArgs};
use crate::analyses::machine_check::{self, Checked, at_start};
use crate::machines::gains::parameter_set;
use crate::machines::robot::{Robot, mjcf, urdf};
use crate::machines::scaling::booms;
use crate::print::output::{write, write_json};
use crate::setup::machine_choice::read;
use crate::setup::packed_machine::pack;
use crate::worlds::perturbation::{Bounds, draw};

#[derive(Subcommand)]
pub enum MachineCommand {
    /// Write a machine whose masses, centres of mass, inertias and lengths are off by errors drawn
    /// by seed
    Perturb(PerturbArgs),
    /// List everything that is wrong with a machine file, with its place in the file, and try it in
    /// closed loop; the exit code is 1 if there is anything
    Check {
        /// Machine file, or name of a shipped machine
        #[arg(value_name = "FILE|NAME")]
        machine: String,
        /// Only what the file says: no trials in closed loop
        #[arg(long)]
        no_trials: bool,
    },
    /// Print the JSON Schema of machine files, for editors
    Schema,
    /// Write a machine with longer or shorter booms, as a file that extends the original
    Scale(ScaleArgs),
    /// Print the gains that the rule gives for a machine, with the reasons, or write them as a
    /// parameter set
    Gains {
        /// Machine file, or name of a shipped machine
        #[arg(value_name = "FILE|NAME")]
        machine: String,
        /// World that the gains are for: ideal (Manipulator.ssp) or real (Real.ssp)
        #[arg(long, default_value = "real", value_parser = ["ideal", "real"])]
        world: String,
        /// Parameter set to write, for `--parameters`
        #[arg(long, value_name = "FILE", value_parser = output())]
        output: Option<PathBuf>,
    },
    /// Write a machine for tools of robotics: MJCF with both closed loops, or URDF as a tree with the
    /// loops cut
    Export(ExportArgs),
    /// Pack FMUs and systems of a machine for tools that know no machine file: in FMI 2.0 and 3.0,
    /// with its start values, gains by the rule, and names of their own
    Pack {
        /// Machine file, or name of a shipped machine
        #[arg(value_name = "FILE|NAME")]
        machine: String,
        /// Folder for NAME_MACHINE.fmu and NAME_MACHINE.ssp, those of FMI 3.0 in fmi3/
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
    /// Draw a machine: side view with named points and dimensions, workspace, largest payload over
    /// reach and height
    Draw(DrawArgs),
    /// Write a machine's bodies and loops as JSON, for a page that animates it
    Scene(SceneArgs),
}

#[derive(Args)]
pub struct ExportArgs {
    /// Machine file, or name of a shipped machine
    #[arg(value_name = "FILE|NAME")]
    machine: String,
    #[command(flatten)]
    file: ExportFile,
}

#[derive(Args)]
#[group(required = true, multiple = false)]
pub struct ExportFile {
    /// MJCF file to write, for MuJoCo
    #[arg(long, value_name = "FILE", value_parser = output())]
    mjcf: Option<PathBuf>,
    /// URDF file to write, for ROS 2 and Pinocchio; its head says what a tree loses
    #[arg(long, value_name = "FILE", value_parser = output())]
    urdf: Option<PathBuf>,
}

#[derive(Args)]
pub struct ScaleArgs {
    /// Factor on all lengths of the booms; masses follow its cube, inertias its fifth power,
    /// strokes, screws and trajectories the factor
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    booms: f64,
    /// Machine file, or name of a shipped machine, to start from
    #[arg(long, value_name = "FILE|NAME", default_value = "reference")]
    machine: String,
    /// Machine file to write
    #[arg(long, value_name = "FILE", value_parser = output())]
    output: PathBuf,
}

#[derive(Args)]
pub struct PerturbArgs {
    /// Seed of the errors; draws the same machine as that seed in `table --world real`
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Machine file, or name of a shipped machine, to start from
    #[arg(long, value_name = "FILE|NAME", default_value = "reference")]
    machine: String,
    /// Bound on the relative error of each body's mass, with its inertia, and of joint friction
    #[arg(long, default_value_t = Bounds::REAL.mass, value_name = "PART")]
    mass: f64,
    /// Bound on the error of each centre of mass along each axis, m
    #[arg(long, default_value_t = Bounds::REAL.com, value_name = "METRES")]
    com: f64,
    /// Bound on the relative error of each second moment of mass per axis, besides that of the mass
    #[arg(long, default_value_t = Bounds::REAL.second_moment, value_name = "PART")]
    second_moment: f64,
    /// Bound on the error of each length, m
    #[arg(long, default_value_t = Bounds::REAL.length, value_name = "METRES")]
    length: f64,
    /// Bound on gravity's angle from the vertical about each horizontal axis, degrees
    #[arg(long, default_value_t = Bounds::REAL.plumb.to_degrees(), value_name = "DEGREES")]
    plumb: f64,
    /// Machine file to write
    #[arg(long, default_value = "machine.json", value_name = "FILE", value_parser = output())]
    out: PathBuf,
}

/// Runs a subcommand of `machine`.
pub fn run(command: &MachineCommand) -> Result<()> {
    match command {
        MachineCommand::Perturb(args) => perturb(args),
        MachineCommand::Check { machine, no_trials } => check(machine, !no_trials),
        MachineCommand::Schema => print(machine_file::SCHEMA_JSON),
        MachineCommand::Scale(args) => scale(args),
        MachineCommand::Gains {
            machine,
            world,
            output,
        } => gains(machine, world == "ideal", output.as_deref()),
        MachineCommand::Export(args) => export(args),
        MachineCommand::Pack { machine, out } => {
            let packed = pack(machine, out)?;
            let line = |file: &PathBuf| format!("packed {}\n", file.display());
            print(packed.iter().map(line).collect::<String>())
        }
        MachineCommand::Draw(_) | MachineCommand::Scene(_) => {
            unreachable!("done by another program")
        }
    }
}

fn check(name: &str, with_trials: bool) -> Result<()> {
    let Checked { found, notes, .. } = machine_check::check(name, with_trials, None)?;
    print_notes(&notes)?;
    if found.is_empty() {
        let tried = if with_trials {
            ", tried in closed loop"
        } else {
            ""
        };
        return print(format_args!(
            "{name}: a machine with which all FMUs run{tried}\n"
        ));
    }
    print(found.join("\n") + "\n")?;
    let is_missing = |line: &String| line.ends_with(" is missing") && !line.contains('.');
    let hint = if found.iter().any(is_missing) {
        "; a file that says only what differs from another machine needs \"extends\": \"reference\""
    } else {
        ""
    };
    bail!("{name}: {} found{hint}", found.len())
}

fn gains(machine: &str, is_ideal: bool, output: Option<&Path>) -> Result<()> {
    let actuators = match is_ideal {
        true => Actuators::Known,
        false => Actuators::AsBuilt,
    };
    let gains = gain_rule::gains_for(&read(machine)?, actuators, &[])?;
    if let Some(output) = output {
        let name = output.file_stem().unwrap_or_default().to_string_lossy();
        let set = parameter_set(&name, machine, &gains, is_ideal)?;
        return write(Some(output), |file| file.write_all(set.as_bytes()));
    }
    let line = |g: &RuledGain| format!("{:<20}{:>8} {:<8}{}\n", g.name, g.value, g.unit, g.why);
    print(gains.iter().map(line).collect::<String>())
}

fn export(args: &ExportArgs) -> Result<()> {
    let machine = read(&args.machine)?;
    let name = Path::new(&args.machine).file_stem().unwrap_or_default();
    let robot = Robot::new(name.to_string_lossy().into_owned(), &machine);
    let robot = robot.with_context(|| args.machine.clone())?;
    if let Some(file) = &args.file.mjcf {
        let text = mjcf(&robot)?;
        write(Some(file), |to| to.write_all(text.as_bytes()))?;
    }
    if let Some(file) = &args.file.urdf {
        let text = urdf(&robot)?;
        write(Some(file), |to| to.write_all(text.as_bytes()))?;
    }
    Ok(())
}

fn scale(args: &ScaleArgs) -> Result<()> {
    let s = args.booms;
    ensure!(
        s.is_finite() && s > 0.0,
        "--booms {s} must be finite and > 0"
    );
    let nominal = read(&args.machine)?;
    let scaled = booms(&nominal, s);
    scaled.check().context("the machine of that size")?;
    let [found, _] = at_start(&scaled);
    let extended = extended_name(&args.machine, &args.output)?;
    let file = extension_of(&extended, &nominal, &scaled);
    write_json(Some(&args.output), &file)?;
    let name = args.output.display();
    print(format_args!(
        "{name}: `{extended}` with booms {s} times as large\n"
    ))?;
    print_notes(&found)
}

fn print_notes(notes: &[String]) -> Result<()> {
    notes
        .iter()
        .try_for_each(|note| print(format_args!("note: {note}\n")))
}

/// How a file at `output` refers to the machine `name`: a shipped machine by its name, a file in
/// the same folder by its file name, any other file by its path.
fn extended_name(name: &str, output: &Path) -> Result<String> {
    if preset(name).is_some() {
        return Ok(name.to_owned());
    }
    let file = std::path::absolute(name)?;
    let folder = std::path::absolute(output)?;
    ensure!(
        file != folder,
        "--output must not be the file that is extended"
    );
    if file.parent() == folder.parent() {
        let own = file.file_name().unwrap_or_default();
        return Ok(own.to_string_lossy().into_owned());
    }
    Ok(file.display().to_string())
}

fn perturb(args: &PerturbArgs) -> Result<()> {
    let nominal = read(&args.machine)?;
    let bounds = Bounds {
        mass: args.mass,
        com: args.com,
        second_moment: args.second_moment,
        length: args.length,
        plumb: args.plumb.to_radians(),
    };
    let (machine, gravity) = draw(&nominal, args.seed, &bounds)?;
    write_json(Some(&args.out), &machine)?;
    let [x, y, z] = gravity;
    print(format_args!(
        "machine of seed {} written to {}; gravity, which is no part of the file: --set hdrm.gravity[1]={x} --set hdrm.gravity[2]={y} --set \
         hdrm.gravity[3]={z}\n",
        args.seed,
        args.out.display()
    ))
}
