//! Commands on the rig: its data, and what the models predict on profiles that they have not seen.

use std::io::{Write as _, stdout};
use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use emla::Surrogate;

use crate::files::{NetworkArg, write};
use crate::rig_plots;
use rig_data::campaign::{
    Trust, compliance, held_out_profiles, measure, rms, rows, training_profiles,
};
use rig_data::coupled_run::CoupledRun;
use rig_data::data;
use rig_data::prediction::{Errors, MODELS, Model, errors};
use rig_data::windows::{Truth, Window};

/// Number of the campaign's profiles, and the length of each, s.
const PROFILES: u32 = 120;
const SECONDS: f64 = 3.0;
/// Arguments of `data`.
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

    /// Run the campaign.
    pub(crate) fn run(self) -> Result<()> {
        let p = machine::Machine::reference().emla.lift;
        let profiles = training_profiles(self.profiles, self.seconds, self.seed);
        let campaign = measure(&p, &profiles, |profile| profile.seed)?;
        let repeated = &profiles[..profiles.len().min(4)];
        let again = measure(&p, repeated, |profile| !profile.seed)?;
        let rows = rows(&p, &campaign);
        let comment = format!(
            "rig: a simulation, not measurements; {} profiles of {} s at 1 kHz, means of 20 ms, seed {}",
            self.profiles, self.seconds, self.seed
        );
        write(&self.out, &data::to_csv_by_profile(&rows, &comment))?;
        let trust = Trust::of(&p, &campaign, &again);
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
            trust.floor,
            trust.repeatability
        )?;
        Ok(())
    }
}

/// Arguments of `compare`.
#[derive(Args)]
pub struct RigCompareArgs {
    #[command(flatten)]
    network: NetworkArg,
    /// Length of a held-out profile, s.
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// Seed of the held-out profiles.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for efficiency maps and time responses, as PNG and SVG; none without it.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Arguments of `loop`.
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
    /// Read and print.
    pub(crate) fn run(self) -> Result<()> {
        let p = machine::Machine::reference().emla.lift;
        let surrogate = self.network.read()?;
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
            writeln!(
                stdout(),
                "  {:<24}{}",
                format!("{name}, alpha = {alpha}"),
                e.cell()
            )?;
        }
        Ok(())
    }
}

impl RigCompareArgs {
    /// Predict and print.
    pub(crate) fn run(self) -> Result<()> {
        let p = machine::Machine::reference().emla.lift;
        let surrogate = self.network.read()?;
        let profiles = held_out_profiles(self.seconds, self.seed);
        let measured = measure(&p, &profiles, |profile| profile.seed)?;
        writeln!(
            stdout(),
            "root mean square errors on held-out profiles of the rig (a simulation): required current A / efficiency %"
        )?;
        writeln!(
            stdout(),
            "with the temperatures of winding and magnets known; in brackets taken for 20 °C"
        )?;
        write!(stdout(), "{:<10}{:>8}", "profile", "windows")?;
        for (name, alpha) in MODELS {
            write!(stdout(), "{:>38}", format!("{name}, alpha = {alpha}"))?;
        }
        writeln!(stdout())?;
        let models = MODELS.map(|(_, alpha)| Model::new(p, surrogate.clone(), alpha));
        for (profile, windows) in profiles.iter().zip(&measured) {
            line(profile.kind.name(), &models, &truths(windows))?;
        }
        let all: Vec<&Window> = measured.iter().flatten().collect();
        let [physics, hybrid, network] = line("all", &models, &truths(all.iter().copied()))?;
        for (name, other) in [("hybrid", hybrid), ("network", network)] {
            writeln!(
                stdout(),
                "{name} against physics: current {:.1} times better, efficiency {:.1} times",
                physics.current[0] / other.current[0],
                physics.efficiency[0] / other.efficiency[0]
            )?;
        }
        quality(&surrogate, &all)?;
        if let Some(folder) = &self.out {
            for file in rig_plots::all(&models, &surrogate, &measured[4], folder)? {
                writeln!(stdout(), "{}", file.display())?;
            }
        }
        Ok(())
    }
}

fn truths<'a>(windows: impl IntoIterator<Item = &'a Window>) -> Vec<Truth> {
    windows.into_iter().map(|w| w.truth).collect()
}

fn line(name: &str, models: &[Model; 3], windows: &[Truth]) -> Result<[Errors; 3]> {
    let errors = [0, 1, 2].map(|k: usize| errors(&models[k], windows));
    write!(stdout(), "{name:<10}{:>8}", windows.len())?;
    for e in &errors {
        write!(stdout(), "{:>38}", e.cell())?;
    }
    writeln!(stdout())?;
    Ok(errors)
}

/// The network itself on the rows of held-out profiles, as the sensors give them.
fn quality(surrogate: &Surrogate, windows: &[&Window]) -> Result<()> {
    let ranges = surrogate.file().ranges;
    let error = |w: &&Window| {
        let y = surrogate.evaluate(w.row.tau_e, w.row.w_m);
        [y.F - w.row.f_ext, y.x_dot - w.row.x_dot]
    };
    let [F, x_dot] = [0, 1].map(|k: usize| rms(windows.iter().map(|w| error(w)[k])));
    let scaled = [
        F / (ranges.f_ext.max - ranges.f_ext.min),
        x_dot / (ranges.x_dot.max - ranges.x_dot.min),
    ]
    .map(|e| 2.0 * e);
    writeln!(
        stdout(),
        "network on the sensors' rows: force {F:.0} N, rod speed {:.3} mm/s, mse scaled {:.2e} (paper's test 2.2e-3)",
        1e3 * x_dot,
        0.5 * (scaled[0] * scaled[0] + scaled[1] * scaled[1])
    )?;
    Ok(())
}
