//! The commands about the rig: `data`, `compare` and `calibrate` run it; `loop` judges a recorded
//! run with rigs. The command line and `train` call them.

use std::env::{self, consts::EXE_SUFFIX};
use std::io::{Write as _, stdout};
use std::path::PathBuf;
use std::process;

use anyhow::{Context as _, Result, ensure};
use clap::Args;
use emla::Surrogate;

use super::files::{NetworkArg, write, write_network};
use super::plots;
use surrogate::judgement::candidates::{CALIBRATION_SEED, Candidates, coverage};
use surrogate::judgement::conformal::{calibrate, points};
use surrogate::judgement::free_run::drive;
use surrogate::measurement::campaign::{
    PROFILES, RowErrors, SECONDS, compliance, held_out_profiles, measure, rms, rows,
    training_profiles,
};
use surrogate::measurement::coupled_run::CoupledRun;
use surrogate::measurement::data;
use surrogate::prediction::identification::Identification;
use surrogate::prediction::model::{MODELS, Model, errors};

#[derive(Args)]
pub struct RigDataArgs {
    /// Number of profiles.
    #[arg(long, default_value_t = PROFILES)]
    profiles: u32,
    /// Length of a profile, s.
    #[arg(long, default_value_t = SECONDS)]
    seconds: f64,
    /// Seed of profiles and sensors.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// CSV file to write.
    #[arg(long, default_value = "target/surrogate/rig.csv")]
    out: PathBuf,
}

impl RigDataArgs {
    /// The campaign that a network is trained on.
    pub(crate) fn for_training(seed: u64, out: PathBuf) -> Self {
        Self {
            profiles: PROFILES,
            seconds: SECONDS,
            seed,
            out,
        }
    }

    pub(crate) fn run(self) -> Result<()> {
        let p = machine_file::Machine::reference().emla.lift;
        let profiles = training_profiles(self.profiles, self.seconds, self.seed);
        let campaign = measure(&p, &profiles, |profile| profile.seed)?;
        let repeated = &profiles[..profiles.len().min(4)];
        let again = measure(&p, repeated, |profile| !profile.seed)?;
        let identification = Identification::new(&p, &campaign);
        let (rows, numbers) = rows(&identification.electrical, &campaign);
        let comment = format!(
            "rig: a simulation, not measurements; {} profiles of {} s at 1 kHz, means of 20 ms, seed {}",
            self.profiles, self.seconds, self.seed
        );
        write(&self.out, &data::to_csv(&rows, &numbers, &comment))?;
        let errors = RowErrors::new(&p, &campaign, &again);
        writeln!(
            stdout(),
            "{} rows of {} profiles in {}",
            rows.len(),
            profiles.len(),
            self.out.display()
        )?;
        writeln!(
            stdout(),
            "compliance between nut and rod {:.2e} m/N; force errors of a row, root mean square: {:.0} N by the sensors alone (noise floor), {:.0} N from run to run (repeatability)",
            compliance(&p, &campaign),
            errors.floor,
            errors.repeatability
        )?;
        Ok(())
    }
}

#[derive(Args)]
pub struct RigCompareArgs {
    #[command(flatten)]
    network: NetworkArg,
    /// Seed of the campaign that the network was trained on: physics and look-up map are fitted to
    /// it.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of held-out profiles.
    #[arg(long, default_value_t = 60)]
    profiles: u32,
    /// Length of a held-out profile, s.
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// Number of held-out profiles on which the interval of the efficiency is tried.
    #[arg(long, default_value_t = 600)]
    covered: u32,
    /// Also print the table of the loop, as `hdrm-fmu table --world real --study surrogate` on this
    /// many machines.
    #[arg(long)]
    machines: Option<u32>,
    /// Folder for efficiency maps and time responses, as PNG and SVG; none without it.
    #[arg(long)]
    out: Option<PathBuf>,
}

#[derive(Args)]
pub struct CalibrateArgs {
    #[command(flatten)]
    network: NetworkArg,
    /// Number of profiles on the rig, none of which a network was trained on.
    #[arg(long, default_value_t = 3000)]
    profiles: u32,
    /// Network file to write.
    #[arg(long, default_value = "target/surrogate/surrogate.json")]
    out: PathBuf,
}

impl CalibrateArgs {
    pub(crate) fn run(self) -> Result<()> {
        let p = machine_file::Machine::reference().emla.lift;
        let network = self.network.read_or(Surrogate::reference)?;
        let profiles = held_out_profiles(self.profiles, SECONDS, CALIBRATION_SEED);
        let driven = drive(&p, &profiles)?;
        let bound = calibrate(&points(p, &network, &driven)?);
        let mut file = network.file();
        file.efficiency_bound = Some(bound);
        write_network(&self.out, &file)?;
        writeln!(stdout(), "{bound:?}\nnetwork in {}", self.out.display())?;
        Ok(())
    }
}

#[derive(Args)]
pub struct RigLoopArgs {
    #[command(flatten)]
    network: NetworkArg,
    /// CSV file of `hdrm-fmu run` on a system with rigs, with --signals "*".
    #[arg(long)]
    run: PathBuf,
    /// Time from which on the run counts, s.
    #[arg(long, default_value_t = 4.0)]
    start: f64,
}

impl RigLoopArgs {
    pub(crate) fn run(self) -> Result<()> {
        let p = machine_file::Machine::reference().emla.lift;
        let surrogate = self.network.read_or(Surrogate::reference)?;
        let run = CoupledRun::read(&self.run)?;
        let windows = run.windows(&p, self.start);
        let tip = rms(run.tip_errors(self.start));
        let required = rms(run.current_errors(self.start));
        writeln!(
            stdout(),
            "{}: tip RMSE {:.4} mm; required less true current {required:.3} A rms; predicted from force and motion ({} windows of 20 ms):",
            self.run.display(),
            1e3 * tip,
            windows.len()
        )?;
        for (name, alpha) in MODELS {
            let e = errors(&Model::new(p, surrogate.clone(), alpha), &windows);
            let name = format!("{name}, alpha = {alpha}");
            writeln!(stdout(), "  {name:<24}{}", e.cell())?;
        }
        Ok(())
    }
}

impl RigCompareArgs {
    pub(crate) fn run(self) -> Result<()> {
        let p = machine_file::Machine::reference().emla.lift;
        let trained = || Surrogate::from_json(surrogate::RIG_NETWORK).expect("a valid network");
        let (shipped, network) = (Surrogate::reference(), self.network.read_or(trained)?);
        let candidates = Candidates::new(&p, &network, self.seed)?;
        writeln!(stdout(), "{}", candidates.identification.text(&p))?;
        let judged = candidates.judge(&p, self.profiles, self.seconds)?;
        writeln!(stdout(), "{judged}")?;
        let networks = [("network", &network), ("shipped network", &shipped)];
        write!(stdout(), "{}", coverage(&p, &networks, self.covered)?)?;
        if let Some(machines) = self.machines {
            run_loop_table(machines)?;
        }
        if let Some(folder) = &self.out {
            let work = held_out_profiles(5, self.seconds, self.seed);
            let work = measure(&p, &work[4..], |profile| profile.seed)?;
            let models = MODELS.map(|(_, alpha)| Model::new(p, network.clone(), alpha));
            for file in plots::comparison(&models, &network, &work[0], folder)? {
                writeln!(stdout(), "{}", file.display())?;
            }
        }
        Ok(())
    }
}

/// Prints the table of the loop by `hdrm-fmu`, which lies in the folder of this program.
fn run_loop_table(machines: u32) -> Result<()> {
    let own = env::current_exe().context("where this program lies")?;
    let program = own.with_file_name(format!("hdrm-fmu{EXE_SUFFIX}"));
    let arguments = format!("table --world real --study surrogate --seeds {machines}");
    let status = process::Command::new(&program)
        .args(arguments.split(' '))
        .status();
    let status = status.with_context(|| program.display().to_string())?;
    ensure!(status.success(), "{}: {status}", program.display());
    Ok(())
}
