//! Subcommand `table` as far as it compares control laws in a world.

use std::io::Write as _;

use crate::laws::{self, Law};
use crate::surrogate_loop::{self, RigNetwork};
use crate::worlds::{self, Case, Cell, World};
use anyhow::{Context, Result, ensure};
use cosim::cli::{bar, print};
use cosim::run::Experiment;
use cosim::system::System;
use serde_json::{Value, json};

use super::evaluation::{StudyArg, TableArgs, create};

/// Law that the studies of the real world start from.
const SHIPPED: &str = "adaptive_integral";

/// Compare the laws of `study` in the world that the arguments name; the cells as JSON.
pub fn compare(
    args: &TableArgs,
    system: &System,
    base: &Experiment,
    cases: &[Case],
    study: StudyArg,
) -> Result<Value> {
    let network = RigNetwork::new()?;
    let mut laws = laws_of(study, system, &network, args.machine.parameters()?)?;
    if !args.laws.is_empty() {
        let names: Vec<&str> = laws.iter().map(|law| law.name.trim()).collect();
        for wanted in &args.laws {
            let listed = names.join("`, `");
            ensure!(
                names.contains(&wanted.as_str()),
                "--law {wanted}: must be one of `{listed}`"
            );
        }
        laws.retain(|law| args.laws.iter().any(|wanted| wanted == law.name.trim()));
    }
    let runs = laws.len() * cases.len() * 2;
    let bar = bar(runs as u64, "runs", false);
    let cells = worlds::run(system, base, &laws, cases, || bar.inc(1))?;
    bar.finish_and_clear();
    print(worlds::text(&cells))?;
    if args.world == World::Bending {
        print(worlds::bending_verdict(&cells))?;
    } else if study == StudyArg::Rivals {
        let rivals: Vec<_> = laws.iter().filter(|l| l.is_rival_with_integral()).collect();
        let rivals: Vec<_> = rivals.iter().map(|l| l.name.as_str()).collect();
        for adaptive in ["adaptive", SHIPPED] {
            print(worlds::verdict(&cells, adaptive, &rivals))?;
        }
    }
    if let Some(path) = &args.csv {
        let mut file = create(path)?;
        worlds::write_csv(&cells, &mut file)
            .and_then(|()| Ok(file.flush()?))
            .with_context(|| path.display().to_string())?;
    }
    let failed = cells.iter().filter(|c| c.result.is_err()).count();
    // Outside the ideal world a law may fail on some machine; that is a result, and printed as one.
    let allowed = if args.world == World::Ideal {
        0
    } else {
        cells.len() - 1
    };
    ensure!(failed <= allowed, "{failed} of {} runs failed", cells.len());
    Ok(json!({
        "world": args.world,
        "laws": worlds::summaries(&cells, None),
        "runs": cells.iter().map(cell_json).collect::<Vec<_>>(),
    }))
}

/// The surrogate in the loop; the runs as JSON.
pub fn in_the_loop(system: &System, base: &Experiment) -> Result<Value> {
    let network = RigNetwork::new()?;
    let bar = bar(surrogate_loop::RUNS as u64, "runs", false);
    let runs = surrogate_loop::run(system, base, &network, || bar.inc(1))?;
    bar.finish_and_clear();
    print(surrogate_loop::text(&runs))?;
    Ok(json!(runs))
}

/// `parameters` is the parameter set of the real world.
fn laws_of(
    study: StudyArg,
    system: &System,
    network: &RigNetwork,
    parameters: &str,
) -> Result<Vec<Law>> {
    Ok(match study {
        StudyArg::Ablation => laws::ablation(),
        StudyArg::IntegralRate => laws::rates(),
        StudyArg::Changes => laws::changes(system, worlds::PARAMETERS, parameters, SHIPPED)?,
        StudyArg::Tried => laws::tried(SHIPPED, &network.path),
        StudyArg::Sensors => laws::sensors(SHIPPED),
        _ => laws::rivals(),
    })
}

fn cell_json(cell: &Cell) -> Value {
    let mut value = json!({"law": cell.law, "case": cell.case, "trajectory": cell.trajectory});
    match &cell.result {
        Ok(tracking) => value["tracking"] = json!(tracking),
        Err(error) => value["error"] = format!("{error:#}").into(),
    }
    value
}
