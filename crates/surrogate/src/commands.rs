//! The command line.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context as _, Result};
use clap::{Args, Parser};
use indicatif::{ProgressBar, ProgressStyle};
use surrogate::campaign;
use surrogate::data;
use surrogate::testbed::Testbed;
use surrogate::training::{EPOCHS, Prepared, Progress};

/// Virtual testbed and Levenberg–Marquardt training of the actuator's surrogate network.
#[derive(Parser)]
#[command(version)]
pub enum Command {
    /// Simulate the test campaign (a simulation, not measurements) and write it as CSV.
    Testbed(TestbedArgs),
    /// Train the network on a CSV file; Ctrl-C keeps the state, --resume goes on.
    Train(TrainArgs),
}

/// Arguments of `testbed`.
#[derive(Args)]
pub struct TestbedArgs {
    /// Number of operating points.
    #[arg(long, default_value_t = 3000)]
    points: u32,
    /// Seed of operating points and sensor noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// CSV file to write.
    #[arg(long, default_value = "target/surrogate/testbed.csv")]
    out: PathBuf,
}

/// Arguments of `train`.
#[derive(Args)]
pub struct TrainArgs {
    /// CSV file with columns tau_e [N.m], w_m [rad/s], F_ext [N], x_dot [m/s].
    #[arg(long)]
    data: PathBuf,
    /// Seed of the split and of the first weights.
    #[arg(long, default_value_t = 1)]
    seed: u64,
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

impl Command {
    /// Do it.
    pub fn run(self) -> Result<()> {
        match self {
            Self::Testbed(args) => args.run(),
            Self::Train(args) => args.run(),
        }
    }
}

impl TestbedArgs {
    fn run(self) -> Result<()> {
        let testbed = Testbed::new(machine::Machine::reference().emla);
        let rows = campaign::campaign(&testbed, self.points, self.seed);
        let comment = format!(
            "virtual testbed: a simulation, not measurements; {} steady points, seed {}",
            self.points, self.seed
        );
        write(&self.out, &data::to_csv(&rows, &comment))?;
        println!(
            "{} simulated operating points in {}",
            rows.len(),
            self.out.display()
        );
        Ok(())
    }
}

impl TrainArgs {
    fn run(self) -> Result<()> {
        let prepared = Prepared::new(data::read_csv(&self.data)?, self.seed);
        let mut progress = if self.resume {
            Progress::resume(&self.checkpoint, &emla::WIDTHS, self.seed, &prepared)?
        } else {
            Progress::start(&emla::WIDTHS, self.seed, &prepared)
        };
        for path in [&self.out, &self.checkpoint] {
            make_folder(path)?;
        }
        progress.stop = None;
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
                println!("{}", progress.line(self.epochs));
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
        let text = serde_json::to_string_pretty(&network).context("cannot write JSON")?;
        write(&self.out, &text)?;
        report(&network.training, progress.seconds);
        println!("network in {}", self.out.display());
        Ok(())
    }
}

fn report(record: &emla::TrainingRecord, seconds: f64) {
    let emla::TrainingRecord {
        epochs,
        best_epoch,
        stop,
        mse,
        r_f,
        r_x_dot,
        ..
    } = record;
    println!("{epochs} epochs in {seconds:.0} s, stopped by: {stop}; best epoch {best_epoch}");
    println!("             training      validation    test          paper (train/val/test)");
    println!(
        "mse scaled   {:<13.3e} {:<13.3e} {:<13.3e} 0.00013 / 0.00476 / 0.00219",
        mse.training, mse.validation, mse.test
    );
    for (name, r) in [("R force     ", r_f), ("R rod speed ", r_x_dot)] {
        println!(
            "{name} {:<13.8} {:<13.8} {:<13.8} > 0.995",
            r.training, r.validation, r.test
        );
    }
}

fn make_folder(path: &std::path::Path) -> Result<()> {
    let Some(folder) = path.parent() else {
        return Ok(());
    };
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))
}

fn write(path: &std::path::Path, text: &str) -> Result<()> {
    make_folder(path)?;
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}
