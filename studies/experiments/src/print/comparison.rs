//! The comparison of control laws in a world (`hdrm-fmu table --world …`) as tables, CSV and JSON.

use std::fmt::Write as _;
use std::io;

use cosim::io::cells::cell;
use serde_json::{Value, json};

use super::output::put_verdict;
use crate::analyses::comparison::{Summary, TrackingCell, summaries};
use crate::runs::grid::{ALL_TRAJECTORIES, Spread, failure_lines};
use crate::worlds::World;

/// A column: title, value if the law has one, factor to the printed unit, digits.
type Column = (&'static str, fn(&Summary) -> Option<Spread>, f64, usize);
const COLUMNS: [Column; 9] = [
    ("known, mm", |s| Some(s.known), 1e3, 3),
    ("its max, mm", |s| Some(s.known_max), 1e3, 3),
    ("joints, mm", |s| Some(s.joints), 1e3, 3),
    ("plant, mm", |s| Some(s.plant), 1e3, 3),
    ("less mean, mm", |s| Some(s.plant_varying), 1e3, 3),
    ("angle, mrad", |s| Some(s.orientation), 1e3, 2),
    ("rho, ms", |s| Some(s.rho), 1e3, 2),
    ("rigid varies, mm", |s| s.rigid_varying, 1e3, 3),
    ("sag max, mm", |s| s.sag, 1e3, 2),
];

/// A table for each trajectory, median (worst) over the cases, then the failures.
pub fn text(cells: &[TrackingCell]) -> String {
    let mut text = String::new();
    for trajectory in ALL_TRAJECTORIES {
        if !cells.iter().any(|c| c.trajectory == trajectory) {
            continue;
        }
        let rows = summaries(cells, Some(trajectory));
        let width = rows.iter().map(|r| r.law.len()).max().unwrap_or(0).max(11);
        let mut line = format!("{trajectory:<width$}");
        for (title, value, ..) in COLUMNS {
            if rows.iter().any(|row| value(row).is_some()) {
                let _ = write!(line, "{title:>17}");
            }
        }
        text += &(line + "\n");
        for row in &rows {
            text += &format!("{:<width$}{}\n", row.law, numbers(row));
        }
        text += "\n";
    }
    text += "median (worst) over the cases: RMSE of the tip's position error over the motion, its known part against the controller's \
             kinematics with its encoders' zeros, at the true joint angles, of the plant's tip, the same without its mean; RMS of the \
             orientation's error; rho = largest known error / largest speed";
    let bends = |c: &TrackingCell| c.result.as_ref().is_ok_and(|t| t.sag.is_some());
    if cells.iter().any(bends) {
        text += "; against the tip that the plant's joints say, less its mean; largest distance of the tip from there";
    }
    text += "\n";
    text + &failure_lines(cells, |c| {
        format!("{}, {}, {}", c.trajectory, c.law, c.case)
    })
}

fn numbers(row: &Summary) -> String {
    let mut text = String::new();
    for (_, value, scale, digits) in COLUMNS {
        let Some(s) = value(row) else { continue };
        let number = |v: f64| match v.is_finite() {
            true => format!("{:.digits$}", scale * v),
            false => "failed".into(),
        };
        let cell = format!("{} ({})", number(s.median), number(s.worst));
        let _ = write!(text, "{cell:>17}");
    }
    text
}

/// One row for each run.
pub fn write_csv(cells: &[TrackingCell], out: &mut impl io::Write) -> io::Result<()> {
    let errors = ["known", "joints", "plant"]
        .map(|e| format!("{e} rmse [m],{e} max [m],{e} mean [m],{e} rmse less mean [m]"));
    writeln!(
        out,
        "trajectory,law,case,{},orientation rms [rad],orientation max [rad],tip speed max [m/s],rho [s]",
        errors.join(",")
    )?;
    for c in cells {
        write!(out, "{},{},{}", c.trajectory, cell(&c.law), cell(&c.case))?;
        match &c.result {
            Ok(t) => {
                for e in [t.known, t.joints, t.plant] {
                    write!(out, ",{},{},{},{}", e.rmse, e.max, e.mean, e.varying)?;
                }
                let [rms, max] = t.orientation;
                writeln!(out, ",{rms},{max},{},{}", t.speed, t.rho())?;
            }
            Err(_) => writeln!(out, "{}", ",NaN".repeat(16))?,
        }
    }
    Ok(())
}

/// The summary of each law, and all runs, for programs.
pub fn json(world: World, cells: &[TrackingCell]) -> Value {
    let run = |cell: &TrackingCell| {
        let mut value = json!({"law": cell.law, "case": cell.case, "trajectory": cell.trajectory});
        match &cell.result {
            Ok(tracking) => value["tracking"] = json!(tracking),
            Err(error) => value["error"] = format!("{error:#}").into(),
        }
        put_verdict(&mut value, &cell.verdict);
        value
    };
    json!({
        "world": world,
        "laws": summaries(cells, None),
        "runs": cells.iter().map(run).collect::<Vec<_>>(),
    })
}
