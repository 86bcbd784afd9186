//! Commands: virtual testbed, training, pictures and comparison of the network.

use std::io::{Write as _, stdout};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context as _, Result};
use clap::{Args, Parser};
use emla::Surrogate;
use indicatif::{ProgressBar, ProgressStyle};

use crate::rig_commands::{RigCompareArgs, RigDataArgs, RigLoopArgs};
use crate::testbed::Testbed;
use crate::training::{EPOCHS, Prepared, Progress};
use crate::{campaign, comparison, data, plots};

/// Virtual testbed and Levenberg–Marquardt training of the actuator's surrogate network.
#[derive(Parser)]
#[command(version)]
pub enum Command {
    /// Simulate the test campaign (a simulation, not measurements) and write it as CSV.
    Testbed(TestbedArgs),
    /// Train the network on a CSV file; Ctrl-C keeps the state, --resume goes on.
    Train(TrainArgs),
    /// Draw the efficiency map of physics, hybrid and virtual testbed over load and speed.
    Map(MapArgs),
    /// Draw predicted against true, residuals and learning curve.
    Plots(PlotsArgs),
    /// Print how much closer the hybrid comes to the virtual testbed's truth than the physics.
    Compare(CompareArgs),
    /// Run the campaign on the rig (a simulation, not measurements): transients, both directions, temperatures, sensors; write it as CSV.
    RigData(RigDataArgs),
    /// Print what physics, hybrid and network predict on profiles of the rig that are held out: current and efficiency.
    RigCompare(RigCompareArgs),
    /// Print tracking, required against true current, and what physics, hybrid and network predict, along a coupled run on rigs.
    RigLoop(RigLoopArgs),
}

/// Arguments of `testbed`.
#[derive(Args)]
pub struct TestbedArgs {
    /// Number of operating points.
    #[arg(long, default_value_t = 8000)]
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
    /// Gather rows into this many cells along torque and along speed, and train on their means; 0: train on the rows.
    #[arg(long, default_value_t = 0)]
    cells: u32,
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

/// The network that a picture or comparison is of.
#[derive(Args)]
pub(crate) struct NetworkArg {
    /// Network file; the shipped network without it.
    #[arg(long)]
    network: Option<PathBuf>,
}

impl NetworkArg {
    pub(crate) fn read(&self) -> Result<Surrogate> {
        let Some(path) = &self.network else {
            return Ok(Surrogate::reference());
        };
        let name = path.display();
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
        Surrogate::from_json(&text).with_context(|| name.to_string())
    }
}

/// Arguments of `map`.
#[derive(Args)]
pub struct MapArgs {
    #[command(flatten)]
    network: NetworkArg,
    /// Share of the network in the hybrid, 0 to 1.
    #[arg(long, default_value_t = 0.2)]
    alpha: f64,
    /// Folder for efficiency_map.png, .svg and .csv.
    #[arg(long, default_value = "target/surrogate")]
    out: PathBuf,
}

/// Arguments of `plots`.
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

/// Arguments of `compare`.
#[derive(Args)]
pub struct CompareArgs {
    #[command(flatten)]
    network: NetworkArg,
    /// Number of held-out operating points.
    #[arg(long, default_value_t = 2000)]
    points: u32,
    /// Their seed.
    #[arg(long, default_value_t = 20_260)]
    seed: u64,
    /// Length of the held-out motion profile, s.
    #[arg(long, default_value_t = 20.0)]
    seconds: f64,
}

impl MapArgs {
    fn run(self) -> Result<()> {
        let testbed = Testbed::new(machine::Machine::reference().emla);
        let surrogate = self.network.read()?;
        make_folder(&self.out.join("x"))?;
        let maps = comparison::efficiency_maps(&testbed, &surrogate, self.alpha)?;
        let mut csv = String::from("load [N],x_dot [m/s],physics [1],hybrid [1],testbed [1]\n");
        for i in 0..plots::MAP_CELLS[0] {
            for j in 0..plots::MAP_CELLS[1] {
                let (load, x_dot) = plots::cell_centre(i, j);
                let [a, b, c] = [0, 1, 2].map(|k: usize| maps[k].cells[i][j]);
                csv += &format!("{load},{x_dot},{a},{b},{c}\n");
            }
        }
        write(&self.out.join("efficiency_map.csv"), &csv)?;
        for file in plots::efficiency_maps(&maps, &self.out)? {
            writeln!(stdout(), "{}", file.display())?;
        }
        Ok(())
    }
}

impl PlotsArgs {
    fn run(self) -> Result<()> {
        let surrogate = self.network.read()?;
        let data = data::read_csv(&self.data)?;
        let record = surrogate.training();
        if record.data_sha256 != data.sha256 {
            writeln!(
                stdout(),
                "note: the network was trained on other data; all rows are new to it"
            )?;
        }
        make_folder(&self.out.join("x"))?;
        let (inputs, targets) = Prepared::new(data, record.seed).test_rows();
        for file in plots::quality(&surrogate, &inputs, &targets, &self.out)? {
            writeln!(stdout(), "{}", file.display())?;
        }
        Ok(())
    }
}

impl CompareArgs {
    fn run(self) -> Result<()> {
        let testbed = Testbed::new(machine::Machine::reference().emla);
        let surrogate = self.network.read()?;
        writeln!(
            stdout(),
            "RMS error against the virtual testbed (a simulation), and factor to the physics"
        )?;
        writeln!(
            stdout(),
            "        {} held-out operating points            {} s held-out motion profile",
            self.points,
            self.seconds
        )?;
        writeln!(
            stdout(),
            "alpha   force N          efficiency %       force N          efficiency %"
        )?;
        let errors = |alpha| -> Result<[f64; 4]> {
            let a = comparison::on_points(&testbed, &surrogate, alpha, self.points, self.seed)?;
            let b = comparison::on_profile(&testbed, &surrogate, alpha, self.seconds)?;
            Ok([a.force, 100.0 * a.efficiency, b.force, 100.0 * b.efficiency])
        };
        let physics = errors(0.0)?;
        for alpha in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let now = errors(alpha)?;
            let cell = |k: usize| format!("{:8.3} /{:5.1}", now[k], physics[k] / now[k]);
            writeln!(
                stdout(),
                "{alpha:<6}{}   {}   {}   {}",
                cell(0),
                cell(1),
                cell(2),
                cell(3)
            )?;
        }
        Ok(())
    }
}

impl Command {
    /// Do it.
    pub fn run(self) -> Result<()> {
        match self {
            Self::Testbed(args) => args.run(),
            Self::Train(args) => args.run(),
            Self::Map(args) => args.run(),
            Self::Plots(args) => args.run(),
            Self::Compare(args) => args.run(),
            Self::RigData(args) => args.run(),
            Self::RigCompare(args) => args.run(),
            Self::RigLoop(args) => args.run(),
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
        writeln!(
            stdout(),
            "{} simulated operating points in {}",
            rows.len(),
            self.out.display()
        )?;
        Ok(())
    }
}

impl TrainArgs {
    /// Train.
    pub fn run(self) -> Result<()> {
        let mut prepared = Prepared::new(data::read_csv(&self.data)?, self.seed);
        if self.cells > 0 {
            prepared = prepared.gathered(self.cells);
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
        let text = serde_json::to_string_pretty(&network).context("cannot write JSON")?;
        write(&self.out, &text)?;
        report(&network.training, progress.seconds)?;
        writeln!(stdout(), "network in {}", self.out.display())?;
        Ok(())
    }
}

fn report(record: &emla::TrainingRecord, seconds: f64) -> Result<()> {
    let emla::TrainingRecord {
        epochs,
        best_epoch,
        stop,
        mse,
        r_f,
        r_x_dot,
        ..
    } = record;
    writeln!(
        stdout(),
        "{epochs} epochs in {seconds:.0} s, stopped by: {stop}; best epoch {best_epoch}"
    )?;
    writeln!(
        stdout(),
        "             training      validation    test          paper (train/val/test)"
    )?;
    writeln!(
        stdout(),
        "mse scaled   {:<13.3e} {:<13.3e} {:<13.3e} 0.00013 / 0.00476 / 0.00219",
        mse.training,
        mse.validation,
        mse.test
    )?;
    for (name, r) in [("R force     ", r_f), ("R rod speed ", r_x_dot)] {
        writeln!(
            stdout(),
            "{name} {:<13.8} {:<13.8} {:<13.8} > 0.995",
            r.training,
            r.validation,
            r.test
        )?;
    }
    Ok(())
}

fn make_folder(path: &std::path::Path) -> Result<()> {
    let Some(folder) = path.parent() else {
        return Ok(());
    };
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))
}

pub(crate) fn write(path: &std::path::Path, text: &str) -> Result<()> {
    make_folder(path)?;
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}
