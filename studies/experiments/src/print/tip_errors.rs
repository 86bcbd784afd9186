//! Tip errors of three controllers a row: the paper's table and those of other errors, as text, CSV
//! and JSON.

use std::fmt::Write as _;
use std::io;

use cosim::Verdict;
use serde_json::{Value, json};

use super::output::put_verdict;
use crate::analyses::inertia::{MODES, paper, scale_of};
use crate::analyses::robustness::{Study, judge};
use crate::measures::run::TipError;
use crate::runs::grid::{Cell, failures};

type TipCell = Cell<TipError>;

/// The paper's table for people, RMSE and maximum in mm, then the failures.
pub fn inertia_text(cells: &[TipCell]) -> String {
    let mut text = table(
        [
            format!("{:<11}{:>8}", "trajectory", "inertia"),
            format!("{:>16}", "paper, adaptive"),
        ],
        cells,
        |c| {
            let error = 100.0 * (scale_of(c) - 1.0);
            let paper = paper(c.trajectory, scale_of(c)).unwrap_or(f64::NAN);
            let name = format!("{:<11}{error:>7.0}%", c.trajectory);
            [name, format!("{:>16.1}", 1e3 * paper)]
        },
    );
    text += "tip RMSE and maximum in mm over the motion\n";
    text + &failures(cells, |c| {
        format!("{} {} at inertia x {}", c.trajectory, c.law, c.case)
    })
}

/// The cells of another study for people, with the target and the failures; a target that is not
/// met spoils `verdict`.
pub fn robustness_text(study: Study, cells: &[TipCell], verdict: &mut Verdict) -> String {
    let name = |trajectory: &str, case: &str| [format!("{trajectory:<11}  {case:<38}"), "".into()];
    let mut text = table(name("trajectory", &study.name()), cells, |c| {
        name(c.trajectory, &c.case)
    });
    text += &judge(study, cells, verdict);
    text + &failures(cells, |c| format!("{} {}, {}", c.trajectory, c.case, c.law))
}

/// A table with what stands before and behind the controllers in its first row, and in the row that
/// begins with a cell.
fn table(head: [String; 2], cells: &[TipCell], row: impl Fn(&TipCell) -> [String; 2]) -> String {
    let [mut text, end] = head;
    for mode in MODES {
        let _ = write!(text, "{:>20}", format!("{mode} (max)"));
    }
    text += &(end + "\n");
    for cells in cells.chunks(MODES.len()) {
        let [name, end] = row(&cells[0]);
        text += &name;
        for cell in cells {
            let cell = match &cell.result {
                Ok(TipError { motion, .. }) => {
                    format!("{:.3} ({:.3})", 1e3 * motion.rms(), 1e3 * motion.max)
                }
                Err(_) => "failed".into(),
            };
            let _ = write!(text, "{cell:>20}");
        }
        text += &(end + "\n");
    }
    text
}

/// The paper's table as comma-separated values.
pub fn write_inertia_csv(cells: &[TipCell], out: &mut impl io::Write) -> io::Result<()> {
    writeln!(
        out,
        "trajectory,inertia_scale,mode,rmse [m],max [m],rmse whole run [m],paper adaptive rmse [m]"
    )?;
    for c in cells {
        let values = c.result.as_ref().map_or([f64::NAN; 3], |tip| {
            [tip.motion.rms(), tip.motion.max, tip.whole.rms()]
        });
        writeln!(
            out,
            "{},{},{},{},{},{},{}",
            c.trajectory,
            c.case,
            c.law,
            values[0],
            values[1],
            values[2],
            paper(c.trajectory, scale_of(c)).unwrap_or(f64::NAN)
        )?;
    }
    Ok(())
}

/// The paper's table for programs.
pub fn inertia_json(cells: &[TipCell]) -> Value {
    let cell = |c: &TipCell| {
        let scale = scale_of(c);
        let value = json!({
            "trajectory": c.trajectory,
            "mode": c.law,
            "inertia_scale": scale,
            "paper_adaptive_rmse_m": paper(c.trajectory, scale),
        });
        with_result(value, c)
    };
    cells.iter().map(cell).collect()
}

/// The cells of another study for programs.
pub fn robustness_json(study: Study, cells: &[TipCell]) -> Value {
    let cell = |c: &TipCell| {
        let value = json!({
            "trajectory": c.trajectory,
            "mode": c.law,
            "case": c.case,
            "target_adaptive_rmse_m": study.target(),
        });
        with_result(value, c)
    };
    cells.iter().map(cell).collect()
}

fn with_result(mut value: Value, cell: &TipCell) -> Value {
    match &cell.result {
        Ok(tip) => {
            value["rmse_m"] = tip.motion.rms().into();
            value["max_m"] = tip.motion.max.into();
        }
        Err(error) => value["error"] = format!("{error:#}").into(),
    }
    put_verdict(&mut value, &cell.verdict);
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(law: &str, result: anyhow::Result<f64>) -> TipCell {
        let error = |distance| {
            let mut tip = TipError::new(0.0);
            tip.add(1.0, distance);
            tip
        };
        Cell {
            trajectory: "cubic",
            law: law.into(),
            case: "payload +40 %".into(),
            result: result.map(error),
            verdict: Verdict::default(),
        }
    }

    #[test]
    fn a_failed_cell_is_named_and_the_others_are_shown() {
        let cells = [
            cell("adaptive", Ok(0.6e-3)),
            cell("modular", Err(anyhow::anyhow!("emla_2: burnt"))),
            cell("pd", Ok(7.25e-3)),
        ];
        let text = robustness_text(Study::Payload, &cells, &mut Verdict::default());
        for part in [
            "0.600 (0.600)",
            "failed",
            "7.250 (7.250)",
            "cubic payload +40 %, modular: emla_2: burnt",
            "worst adaptive RMSE 0.600, target 0.5: NOT met",
        ] {
            assert!(text.contains(part), "`{part}` is missing in:\n{text}");
        }
    }
}
