//! The comparison as tables for people and as comma-separated values.

use std::fmt::Write as _;

use anyhow::Result;

use super::bending::TARGET as BENDING_TARGET;
use super::{AHEAD, Cell, Spread, Summary, TARGETS, summaries};
use crate::table::TRAJECTORIES;

/// Columns: title, number where there is one, its scale to what is printed, digits.
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

/// The comparison of each trajectory: median (worst) over the cases, then the failures.
pub fn text(cells: &[Cell]) -> String {
    let mut text = String::new();
    for (trajectory, _) in TRAJECTORIES {
        let rows = summaries(cells, Some(trajectory));
        let width = rows.iter().map(|r| r.law.len()).max().unwrap_or(0).max(11);
        let mut line = format!("{trajectory:<width$}");
        for (title, of, ..) in COLUMNS {
            if rows.iter().any(|row| of(row).is_some()) {
                write!(line, "{title:>17}").expect("a String takes every text");
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
    if cells
        .iter()
        .any(|c| c.result.as_ref().is_ok_and(|t| t.bent.is_some()))
    {
        text += "; against the tip that the plant's joints say, less its mean; largest distance of the tip from there";
    }
    text += "\n";
    text + &failures(cells)
}

fn numbers(row: &Summary) -> String {
    let mut text = String::new();
    for (_, of, scale, digits) in COLUMNS {
        let Some(s) = of(row) else { continue };
        let number = |v: f64| match v.is_finite() {
            true => format!("{:.digits$}", scale * v),
            false => "failed".into(),
        };
        let cell = format!("{} ({})", number(s.median), number(s.worst));
        write!(text, "{cell:>17}").expect("a String takes every text");
    }
    text
}

fn failures(cells: &[Cell]) -> String {
    let failed = cells
        .iter()
        .filter_map(|c| Some((c, c.result.as_ref().err()?)));
    let line = |(c, error): (&Cell, &anyhow::Error)| {
        format!("{}, {}, {}: {error:#}\n", c.trajectory, c.law, c.case)
    };
    failed.map(line).collect()
}

/// The adaptive law `adaptive` over both trajectories beside the targets, and beside the best of the laws `rivals`.
pub fn verdict(cells: &[Cell], adaptive: &str, rivals: &[&str]) -> String {
    let rows = summaries(cells, None);
    let Some(own) = rows.iter().find(|r| r.law == adaptive) else {
        return String::new();
    };
    let met = |yes: bool| if yes { "met" } else { "NOT met" };
    let [median, worst] = TARGETS;
    let mut text = format!(
        "{adaptive}, known error over {} runs: median {:.3} mm (target {:.1}: {}), worst {:.3} mm (target {:.1}: {})\n",
        own.runs,
        1e3 * own.known.median,
        1e3 * median,
        met(own.known.median <= median),
        1e3 * own.known.worst,
        1e3 * worst,
        met(own.known.worst <= worst)
    );
    let rivals = rows.iter().filter(|r| rivals.contains(&r.law.as_str()));
    if let Some(best) = rivals.min_by(|a, b| a.known.median.total_cmp(&b.known.median)) {
        let ahead = best.known.median / own.known.median;
        text += &format!(
            "best rival with integral: {}, median {:.3} mm, worst {:.3} mm; {adaptive} is ahead by {ahead:.2} times in the median \
             (target {AHEAD}: {})\n",
            best.law,
            1e3 * best.known.median,
            1e3 * best.known.worst,
            met(ahead >= AHEAD)
        );
    }
    text
}

/// The worst of each law in the bending world beside the bound: the reference against the tip that the controller's own rigid kinematics tell.
pub fn bending_verdict(cells: &[Cell]) -> String {
    let line = |row: &Summary| {
        let met = if row.known_max.worst <= BENDING_TARGET {
            "met"
        } else {
            "NOT met"
        };
        format!(
            "{}: at most {:.3} mm from the rigid tip (bound {:.0} mm: {met})\n",
            row.law,
            1e3 * row.known_max.worst,
            1e3 * BENDING_TARGET
        )
    };
    summaries(cells, None).iter().map(line).collect()
}

/// One row a run.
pub fn write_csv(cells: &[Cell], out: &mut impl std::io::Write) -> Result<()> {
    let errors = ["known", "joints", "plant"]
        .map(|e| format!("{e} rmse [m],{e} max [m],{e} mean [m],{e} rmse less mean [m]"));
    writeln!(
        out,
        "trajectory,law,case,{},orientation rms [rad],orientation max [rad],tip speed max [m/s],rho [s]",
        errors.join(",")
    )?;
    for c in cells {
        write!(out, "{},{},{}", c.trajectory, c.law.trim(), c.case)?;
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
