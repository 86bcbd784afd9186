//! Subcommand `testbed`: the one-axis experiment, in which the lift and the tilt actuator work
//! against load emulators that replay the forces of the machine.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use cosim::Verdict;
use cosim::cli::{output, print};
use cosim::io::csv::CsvFile;

use crate::analyses::testbed::{self, Axis, CHECK, Replay, UNKNOWN_LOAD};
use crate::print::output::{conditions, finish};
use crate::print::testbed::{rigs_text, text, unknown_load_text};
use crate::setup::run_setup::MachineArgs;

#[derive(Args)]
pub struct TestbedArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Testbed: a packed .ssp [default: Testbed.ssp beside the system]
    #[arg(long, value_name = "FILE")]
    testbed: Option<PathBuf>,
    /// Testbed of actuators as built: a packed .ssp [default: RigTestbed.ssp beside the system]
    #[arg(long, value_name = "FILE")]
    rig_testbed: Option<PathBuf>,
    /// Time constant of the loads, s
    #[arg(long, default_value_t = 0.02, value_name = "SECONDS")]
    lag: f64,
    /// Write reference and measurement of each axis (s, m, m/s, N) to TRAJECTORY_AXIS.csv in this
    /// directory
    #[arg(long, value_name = "DIR")]
    csv_dir: Option<PathBuf>,
    /// Also write the numbers to this JSON file
    #[arg(long, value_name = "FILE", value_parser = output())]
    json: Option<PathBuf>,
}

/// Runs the machine, then the testbeds, and prints their tables.
pub fn testbed(args: &TestbedArgs) -> Result<Verdict> {
    anyhow::ensure!(
        args.lag.is_finite() && args.lag >= 0.0,
        "--lag must be finite and not negative"
    );
    let machine = args.machine.setup().build()?;
    let mut verdict = machine.verdict.clone();
    let packed = |path: &Option<PathBuf>, name: &str| {
        let path = path.clone().unwrap_or_else(|| machine.sibling_path(name));
        args.machine.setup().packed(&path).system()
    };
    let (system, base) = (&machine.system, &machine.base);
    let bed = packed(&args.testbed, testbed::SYSTEM)?;
    let runs = testbed::record(system, base)?;
    for run in &runs {
        verdict.extend(run.verdict.clone().prefixed("the machine"));
    }
    let replay = Replay {
        machine: system,
        base,
        runs: &runs,
        lag: args.lag,
    };
    let axes = replay.on(&bed, &[CHECK])?;
    testbed::judge(&axes, &mut verdict);
    let lag = format!("load emulators with a lag of {} ms\n", 1e3 * args.lag);
    print(lag + &text(&axes))?;
    let unknown = replay.on(&bed, &UNKNOWN_LOAD)?;
    print(format!("\n{}", unknown_load_text(&unknown)))?;
    let bed = packed(&args.rig_testbed, testbed::RIG_SYSTEM)?;
    let rigs = replay.on_rigs(&bed, &UNKNOWN_LOAD)?;
    print(format!("\n{}", rigs_text(&rigs)))?;
    if let Some(dir) = &args.csv_dir {
        for axis in &axes {
            let name = format!("{}_{}.csv", axis.trajectory, axis.axis);
            write_course(axis, &dir.join(name))?;
        }
    }
    let mut found = conditions(system, base);
    found["lag_s"] = args.lag.into();
    found["testbed"] = serde_json::to_value(&axes)?;
    found["testbed_unknown_load"] = serde_json::to_value(&unknown)?;
    found["testbed_rigs"] = serde_json::to_value(&rigs)?;
    finish(found, verdict, args.json.as_deref(), args.machine.check())
}

fn write_course(axis: &Axis, path: &Path) -> Result<()> {
    let names = ["x desired", "x", "x_dot desired", "x_dot", "F desired", "F"];
    let mut file = CsvFile::create(path, &names.map(String::from))?;
    let course = &axis.course;
    for (k, t) in course.time.iter().enumerate() {
        let [x, v, f] =
            [&course.position, &course.velocity, &course.force].map(|c| [c[0][k], c[1][k]]);
        file.row(*t, &[x[0], x[1], v[0], v[1], f[0], f[1]])?;
    }
    file.finish()
}
