//! The program's command line, which `main` runs, and its commands `train` and `plots`.

use std::io::{Write as _, stdout};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context as _, Result};
use clap::{Args, Parser};
use emla::Surrogate;
use indicatif::{ProgressBar, ProgressStyle};

use super::files::{NetworkArg, make_folder, write_network};
use super::rig_commands::{CalibrateArgs, RigCompareArgs, RigDataArgs, RigLoopArgs};
use surrogate::measurement::data;
use surrogate::training::progress::{EPOCHS, Progress, TrainingData, test_rows};

use super::plots;

/// Data of the rig and Levenberg–Marquardt training of the actuator's surrogate network.
#[derive(Parser)]
#[command(version)]
pub enum Command {
    /// Run the campaign on the rig (a simulation, not measurements): transients, both directions,
    /// temperatures, sensors; write it as CSV.
    Data(RigDataArgs),
    /// Train the network on the rig's data or on a CSV file of your own; Ctrl-C keeps the state,
    /// --resume goes on.
    Train(TrainArgs),
    /// Draw predicted against true, residuals and learning curve.
    Plots(PlotsArgs),
    /// Judge physics, refitted physics, look-up map, network and hybrid, all of the same data, on
    /// profiles of the rig that are held out; draw their efficiency maps.
    Compare(RigCompareArgs),
    /// Calibrate the interval of a network's efficiency on profiles of the rig, and write it into
    /// the network's file.
    Calibrate(CalibrateArgs),
    /// Print tracking, required against true current, and what physics, hybrid and network predict,
    /// along a coupled run on rigs.
    Loop(RigLoopArgs),
}

/// Number of cells along torque and along speed over which the rig's rows are averaged; with more,
/// the network learns the noise.
const RIG_CELLS: u32 = 45;

#[derive(Args)]
pub struct TrainArgs {
    /// CSV file with columns tau_e [N.m], w_m [rad/s], F_ext [N], x_dot [m/s] [default: a campaign
    /// on the rig, which is run and kept beside the network as rig.csv]
    #[arg(long)]
    data: Option<PathBuf>,
    /// Seed of the split and of the first weights.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Gather rows into this many cells along torque and along speed, and train on their means; 0:
    /// train on the rows [default: 0, and 45 on the rig]
    #[arg(long)]
    cells: Option<u32>,
    /// Most epochs.
    #[arg(long, default_value_t = EPOCHS)]
    epochs: u32,
    /// Network file to write.
    #[arg(long, default_value = "target/surrogate/surrogate.json")]
    out: PathBuf,
    /// State of the run, written every tenth epoch and at the end or interruption.
    #[arg(long, default_value = "target/surrogate/checkpoint.json")]
    checkpoint: PathBuf,
    /// Go on from the checkpoint.
    #[arg(long)]
    resume: bool,
}

#[derive(Args)]
pub struct PlotsArgs {
    #[command(flatten)]
    network: NetworkArg,
    /// The CSV file the network was trained on; its test rows are shown.
    #[arg(long)]
    data: PathBuf,
    /// Folder for the pictures.
    #[arg(long, default_value = "target/surrogate")]
    out: PathBuf,
}

impl PlotsArgs {
    fn run(self) -> Result<()> {
        let surrogate = self.network.read_or(Surrogate::reference)?;
        let data = data::read_csv(&self.data)?;
        let record = surrogate.training();
        if record.data_sha256 != data.sha256 {
            writeln!(
                stdout(),
                "note: the network was trained on other data; all rows are new to it"
            )?;
        }
        let (inputs, targets) = test_rows(&data, record.seed);
        for file in plots::quality(&surrogate, &inputs, &targets, &self.out)? {
            writeln!(stdout(), "{}", file.display())?;
        }
        Ok(())
    }
}

impl Command {
    pub fn run(self) -> Result<()> {
        match self {
            Self::Data(args) => args.run(),
            Self::Train(args) => args.run(),
            Self::Plots(args) => args.run(),
            Self::Compare(args) => args.run(),
            Self::Calibrate(args) => args.run(),
            Self::Loop(args) => args.run(),
        }
    }
}

impl TrainArgs {
    /// Writes the rig's data into a file next to the network's; a resumed training uses the file
    /// that exists.
    fn campaign(&self) -> Result<PathBuf> {
        let file = self.out.with_file_name("rig.csv");
        if !(self.resume && file.is_file()) {
            RigDataArgs::for_training(self.seed, file.clone()).run()?;
        }
        Ok(file)
    }

    fn run(self) -> Result<()> {
        let (file, cells) = match &self.data {
            Some(file) => (file.clone(), 0),
            None => (self.campaign()?, RIG_CELLS),
        };
        let mut prepared = TrainingData::new(data::read_csv(&file)?, self.seed);
        let cells = self.cells.unwrap_or(cells);
        if cells > 0 {
            prepared = prepared.cell_means(cells);
        }
        let mut progress = if self.resume {
            Progress::resume(&self.checkpoint, &emla::WIDTHS, self.seed, &prepared)?
        } else {
            Progress::start(&emla::WIDTHS, self.seed, &prepared)
        };
        for path in [&self.out, &self.checkpoint] {
            make_folder(path)?;
        }
        let interrupted = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&interrupted);
        ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed))
            .context("cannot listen for Ctrl-C")?;
        let bar = ProgressBar::new(self.epochs.into());
        bar.set_style(ProgressStyle::with_template("{wide_bar} {msg}").expect("a valid template"));
        while progress.stop.is_none() && progress.epoch < self.epochs {
            if interrupted.load(Ordering::Relaxed) {
                break;
            }
            progress.epoch(&prepared, self.epochs);
            bar.set_position(progress.epoch.into());
            if bar.is_hidden() {
                writeln!(stdout(), "{}", progress.line(self.epochs))?;
            } else {
                bar.set_message(progress.line(self.epochs));
            }
            if progress.epoch % 10 == 0 {
                progress.save(&self.checkpoint)?;
            }
        }
        bar.finish_and_clear();
        progress.save(&self.checkpoint)?;
        let network = progress.network(&prepared);
        write_network(&self.out, &network)?;
        report(&network.training, progress.seconds)?;
        writeln!(stdout(), "network in {}", self.out.display())?;
        Ok(())
    }
}

fn report(record: &emla::TrainingRecord, seconds: f64) -> Result<()> {
    let (epochs, best_epoch, stop) = (record.epochs, record.best_epoch, &record.stop);
    let mut out = stdout();
    writeln!(
        out,
        "{epochs} epochs in {seconds:.0} s, stopped by: {stop}; best epoch {best_epoch}"
    )?;
    let head = "             training      validation    test          paper (train/val/test)";
    writeln!(out, "{head}")?;
    let mse = &record.mse;
    writeln!(
        out,
        "mse scaled   {:<13.3e} {:<13.3e} {:<13.3e} 0.00013 / 0.00476 / 0.00219",
        mse.training, mse.validation, mse.test
    )?;
    let correlations = [
        ("R force     ", &record.r_f),
        ("R rod speed ", &record.r_x_dot),
    ];
    for (name, r) in correlations {
        let [training, validation, test] = [r.training, r.validation, r.test];
        writeln!(
            out,
            "{name} {training:<13.8} {validation:<13.8} {test:<13.8} > 0.995"
        )?;
    }
    Ok(())
}
