//! Subcommand `table`: studies of robustness (the paper's first), of control laws and surrogate.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::{Args, ValueEnum};
use cosim::Verdict;
use cosim::cli::{output, print};
use serde_json::Value;

use crate::analyses::robustness::{self, Study};
use crate::analyses::surrogate_loop::{self, RigNetwork};
use crate::analyses::{comparison, inertia};
use crate::print::output::{
    conditions, print_counted, put_verdict, with_progress, write, write_json,
};
use crate::print::{comparison as compared, surrogate_loop as loop_print, tip_errors};
use crate::runs::grid::{self, Case, Cell, count_failed};
use crate::setup::laws;
use crate::setup::run_setup::{MachineArgs, RunSetup};
use crate::setup::start_values::{Law, MODES, SHIPPED, laws_of_modes};
use crate::worlds::{PARAMETERS, World, cases, value_name};

#[derive(Args)]
pub struct TableArgs {
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Plant and sensors that the controllers are compared on
    #[arg(long, value_enum, default_value_t = World::Ideal)]
    pub world: World,
    /// What is varied, repeatable [default: inertia; in the other worlds rivals]
    #[arg(long = "study", value_enum)]
    studies: Vec<StudyArg>,
    /// First seed: of the three of the noise study, or of the drawn machines [default: 1]
    #[arg(long)]
    seed: Option<u64>,
    /// Number of drawn machines [default: 20, or 5 that bend]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..))]
    seeds: Option<u64>,
    /// Law to compare, by its name in the table; repeatable [default: all of the study]
    #[arg(long = "law", value_name = "NAME")]
    pub laws: Vec<String>,
    /// Also write the cells of the inertia study, or the runs of a comparison of laws, to this CSV
    /// file
    #[arg(long, value_name = "FILE", value_parser = output())]
    pub csv: Option<PathBuf>,
    /// Also write all cells to this JSON file
    #[arg(long, value_name = "FILE", value_parser = output())]
    json: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub enum StudyArg {
    /// The paper's table: mass and inertia of all bodies
    Inertia,
    /// Motor and transmission parameters, each and together
    Motor,
    /// Payload alone
    Payload,
    /// Sensor noise
    Noise,
    /// Unknown wrench on the tip
    TipLoad,
    /// All of the above
    All,
    /// All controller modes: known error, error of the plant's tip, orientation, rho
    Rivals,
    /// Adaptation x disturbance observer x integral of the voltage law x integral of the tip error
    Ablation,
    /// The laws with integral but without adaptation, at several rates of the integral
    IntegralRate,
    /// In the real world: the changes of its parameter set, taken back one at a time
    Changes,
    /// In the real world: options that its parameter set leaves off, added one at a time
    Tried,
    /// In the real world: with and without force sensor, speeds known or estimated, other delays
    Sensors,
    /// In the real world: physics, hybrid and network under the shipped law and the paper's, on the
    /// nominal machine
    Surrogate,
}

/// The studies of robustness by their arguments.
const ROBUSTNESS: [(StudyArg, Study); 4] = [
    (StudyArg::Motor, Study::Motor),
    (StudyArg::Payload, Study::Payload),
    (StudyArg::Noise, Study::Noise),
    (StudyArg::TipLoad, Study::TipLoad),
];

impl StudyArg {
    /// Whether the study needs the real world.
    fn is_of_real_world(self) -> bool {
        use StudyArg::{Changes, Sensors, Surrogate, Tried};
        matches!(self, Changes | Tried | Sensors | Surrogate)
    }

    /// Whether the study compares control laws over the cases of a world.
    fn compares_laws(self) -> bool {
        use StudyArg::{Ablation, Changes, IntegralRate, Rivals, Sensors, Tried};
        matches!(
            self,
            Rivals | Ablation | IntegralRate | Changes | Tried | Sensors
        )
    }

    /// Whether the study exists in this world.
    fn fits(self, world: World) -> bool {
        match world {
            World::Ideal => !self.is_of_real_world(),
            World::Real => self.compares_laws() || self == Self::Surrogate,
            World::StrictRigid => self.compares_laws(),
            World::Bending | World::Strict => self.compares_laws() && !self.is_of_real_world(),
        }
    }
}

/// The studies of one call: setup and results so far.
struct Tables<'a> {
    args: &'a TableArgs,
    setup: RunSetup,
    /// For the JSON file.
    found: Value,
    failed: usize,
}

/// Prints the tables of all studies; fails if a cell failed, after the others have been printed.
pub fn table(args: &TableArgs) -> Result<Verdict> {
    let setup = args.machine.setup().world(args.world).build()?;
    let wanted = args.wanted()?;
    args.refuse_unused(&wanted)?;
    let mut tables = Tables {
        args,
        found: conditions(&setup.system, &setup.base),
        setup,
        failed: 0,
    };
    let comparisons = wanted.iter().filter(|study| study.compares_laws());
    let comparisons: Vec<_> = comparisons.collect();
    let wants = |study| wanted.contains(&study) || wanted.contains(&StudyArg::All);
    // The tables of tip errors mark the runs whose verdict is bad, so they need no hint.
    let has_unmarked = !comparisons.is_empty()
        || wanted.contains(&StudyArg::Surrogate)
        || tables.setup.verdict.is_bad();
    if !comparisons.is_empty() {
        let count = args.seeds.unwrap_or(args.world.default_seeds());
        let seeds = args.first_seed()..args.first_seed() + count;
        let cases = cases(args.world, &tables.setup.system, seeds, 1.0)?;
        for study in comparisons {
            tables.compare(*study, &cases.list)?;
        }
    }
    if wanted.contains(&StudyArg::Surrogate) {
        tables.surrogate()?;
    }
    if wants(StudyArg::Inertia) {
        tables.inertia()?;
    }
    for (argument, study) in ROBUSTNESS {
        if wants(argument) {
            tables.robustness(study)?;
        }
    }
    let (mut found, verdict) = (tables.found, tables.setup.verdict);
    put_verdict(&mut found, &verdict);
    write_json(args.json.as_deref(), &found)?;
    if has_unmarked || args.machine.check() {
        print_counted(&verdict, args.machine.check())?;
    }
    ensure!(tables.failed == 0, "{} cells failed", tables.failed);
    Ok(verdict)
}

impl TableArgs {
    /// The studies given by `--study`, else the default of the world.
    fn wanted(&self) -> Result<Vec<StudyArg>> {
        let wanted = match (&self.studies[..], self.world) {
            ([], World::Ideal) => vec![StudyArg::Inertia],
            ([], _) => vec![StudyArg::Rivals],
            (studies, _) => studies.to_vec(),
        };
        for study in &wanted {
            ensure!(
                study.fits(self.world),
                "--study {} does not exist in the {} world",
                value_name(*study),
                self.world.name()
            );
        }
        Ok(wanted)
    }

    fn first_seed(&self) -> u64 {
        self.seed.unwrap_or(1)
    }

    /// Refuses options that none of these studies reads, and one CSV file for several tables.
    fn refuse_unused(&self, studies: &[StudyArg]) -> Result<()> {
        use StudyArg::{All, Inertia, Noise, Surrogate};
        let has = |study: StudyArg| studies.contains(&study);
        let comparisons = studies.iter().filter(|study| study.compares_laws()).count();
        let draws = comparisons > 0 && self.world != World::Ideal;
        let tables = comparisons + usize::from(has(Inertia) || has(All));
        let seed = draws || has(Noise) || has(All);
        let seeds = draws || has(Surrogate);
        let of_seed = "the study noise, and comparisons of laws outside the ideal world";
        let of_seeds = "the study surrogate, and comparisons of laws outside the ideal world";
        let of_law = "comparisons of laws, such as the study rivals";
        let of_csv = "one table at a time, of the study inertia or of a comparison of laws";
        for (option, is_given, is_read, readers) in [
            ("--seed", self.seed.is_some(), seed, of_seed),
            ("--seeds", self.seeds.is_some(), seeds, of_seeds),
            ("--law", !self.laws.is_empty(), comparisons > 0, of_law),
            ("--csv", self.csv.is_some(), tables == 1, of_csv),
        ] {
            ensure!(!is_given || is_read, "{option} is for {readers}");
        }
        Ok(())
    }

    /// Those of `laws` that `--law` names, else all.
    fn chosen(&self, mut laws: Vec<Law>) -> Result<Vec<Law>> {
        if !self.laws.is_empty() {
            let names: Vec<&str> = laws.iter().map(|law| law.name.as_str()).collect();
            for wanted in &self.laws {
                ensure!(
                    names.contains(&wanted.as_str()),
                    "--law {wanted}: must be one of `{}`",
                    names.join("`, `")
                );
            }
            laws.retain(|law| self.laws.contains(&law.name));
        }
        Ok(laws)
    }
}

impl Tables<'_> {
    /// Compares the laws of `study` on the cases of the world.
    fn compare(&mut self, study: StudyArg, cases: &[Case]) -> Result<()> {
        let setup = &mut self.setup;
        let (system, base, verdict) = (&setup.system, &setup.base, &mut setup.verdict);
        let world = self.args.world;
        let network = (study == StudyArg::Tried).then(RigNetwork::new);
        let network = network.transpose()?;
        let laws = match (study, &network) {
            (StudyArg::Ablation, _) => laws::ablation(),
            (StudyArg::IntegralRate, _) => laws::integral_rates(),
            (StudyArg::Changes, _) => {
                laws::without_changes(system, PARAMETERS, self.args.machine.parameters()?, SHIPPED)?
            }
            (_, Some(network)) => laws::unused_options(SHIPPED, &network.path),
            (StudyArg::Sensors, _) => laws::sensor_variants(SHIPPED),
            _ => laws_of_modes(&MODES),
        };
        let laws = self.args.chosen(laws)?;
        let trajectories = world.trajectories();
        let count = laws.len() * cases.len() * trajectories.len();
        let cells = with_progress(count as u64, "runs", |done| {
            comparison::run(system, base, &laws, cases, trajectories, done)
        })?;
        print(compared::text(&cells))?;
        if world.bends() {
            print(comparison::judge_bending(&cells, verdict))?;
        } else if study == StudyArg::Rivals {
            let rivals = laws.iter().filter(|law| law.is_rival_with_integral());
            let rivals: Vec<_> = rivals.map(|law| law.name.as_str()).collect();
            for adaptive in ["adaptive", SHIPPED] {
                print(comparison::judge(&cells, adaptive, &rivals, verdict))?;
            }
        }
        verdict.extend(grid::verdict(&cells));
        write(self.args.csv.as_deref(), |file| {
            compared::write_csv(&cells, file)
        })?;
        // Outside the ideal world a law may fail on some machines; the table shows that.
        let (failed, all) = (count_failed(&cells), cells.len());
        let is_result = failed == 0 || world != World::Ideal && failed < all;
        ensure!(is_result, "{failed} of {all} runs failed");
        self.found[value_name(study)] = compared::json(world, &cells);
        Ok(())
    }

    /// The surrogate in the loop.
    fn surrogate(&mut self) -> Result<()> {
        let RunSetup { system, base, .. } = &self.setup;
        let network = RigNetwork::new()?;
        let count = self.args.seeds.unwrap_or(surrogate_loop::MACHINES);
        let drawn = surrogate_loop::machines(system, count)?;
        let machines = &drawn.list;
        let count = surrogate_loop::runs(machines.len()) as u64;
        let (runs, verdict) = with_progress(count, "runs", |done| {
            surrogate_loop::run(system, base, &network, machines, done)
        })?;
        let rows = surrogate_loop::rows(&runs);
        print(loop_print::text(&rows))?;
        self.setup.verdict.extend(verdict);
        self.found["surrogate"] = serde_json::json!({ "rows": rows, "runs": runs });
        Ok(())
    }

    /// The paper's table.
    fn inertia(&mut self) -> Result<()> {
        let RunSetup { system, base, .. } = &self.setup;
        let cells = with_progress(inertia::CELLS as u64, "runs", |done| {
            inertia::run(system, base, done)
        })?;
        print(tip_errors::inertia_text(&cells) + "\n")?;
        write(self.args.csv.as_deref(), |file| {
            tip_errors::write_inertia_csv(&cells, file)
        })?;
        self.found["inertia"] = tip_errors::inertia_json(&cells);
        self.count(&cells);
        Ok(())
    }

    /// Another robustness study.
    fn robustness(&mut self, study: Study) -> Result<()> {
        let RunSetup { system, base, .. } = &self.setup;
        let cases = study.cases(system, base, self.args.first_seed())?;
        let cells = with_progress(robustness::count(&cases), "runs", |done| {
            robustness::run(system, base, &cases, done)
        })?;
        let verdict = &mut self.setup.verdict;
        print(tip_errors::robustness_text(study, &cells, verdict) + "\n")?;
        self.found[study.name()] = tip_errors::robustness_json(study, &cells);
        self.count(&cells);
        Ok(())
    }

    fn count<T>(&mut self, cells: &[Cell<T>]) {
        self.failed += count_failed(cells);
        self.setup.verdict.extend(grid::verdict(cells));
    }
}
