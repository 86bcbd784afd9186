//! The tables of `hdrm-fmu table` with three controllers a row, as text, CSV and JSON (also for the
//! report): tip errors under inertia errors (the paper's table) and in other robustness studies.

use std::fmt::Write as _;
use std::io;

use cosim::Verdict;
use serde_json::{Value, json};

use super::output::put_verdict;
use crate::analyses::inertia::{MODES, paper, scale_of};
use crate::analyses::robustness::{Study, judge};
use crate::measures::run::TipError;
use crate::runs::grid::{Cell, failure_lines};

type TipCell = Cell<TipError>;

/// The paper's table for people, RMSE and maximum in mm, then the failures.
pub fn inertia_text(cells: &[TipCell]) -> String {
    let head = ["trajectory  inertia", " paper, adaptive"].map(String::from);
    let mut text = table(head, cells, |c| {
        let error = 100.0 * (scale_of(c) - 1.0);
        let paper = paper(c.trajectory, scale_of(c)).unwrap_or(f64::NAN);
        let name = format!("{:<11}{error:>7.0}%", c.trajectory);
        [name, format!("{:>16.1}", 1e3 * paper)]
    });
    text += "tip RMSE and maximum in mm over the motion\n";
    let name = |c: &TipCell| format!("{} {} at inertia x {}", c.trajectory, c.law, c.case);
    text + &mark_legend(cells, name) + &failure_lines(cells, name)
}

/// The table of another study for people, with the target and the failures; a target that is not
/// met makes `verdict` bad.
pub fn robustness_text(study: Study, cells: &[TipCell], verdict: &mut Verdict) -> String {
    let name = |trajectory: &str, case: &str| [format!("{trajectory:<11}  {case:<38}"), "".into()];
    let mut text = table(name("trajectory", &study.name()), cells, |c| {
        name(c.trajectory, &c.case)
    });
    text += &judge(study, cells, verdict);
    let name = |c: &TipCell| format!("{} {}, {}", c.trajectory, c.case, c.law);
    text + &mark_legend(cells, name) + &failure_lines(cells, name)
}

/// A table whose columns are the controllers. `head` and `row` give the text before and after these
/// columns, in the header and in the row whose first cell is given. A `!` marks a cell whose run
/// broke a limit; it replaces the blank before the next column.
fn table(head: [String; 2], cells: &[TipCell], row: impl Fn(&TipCell) -> [String; 2]) -> String {
    let [mut text, end] = head;
    for mode in MODES {
        let _ = write!(text, "{:>20}", format!("{mode} (max)"));
    }
    text += &(end + "\n");
    for cells in cells.chunks(MODES.len()) {
        let [name, end] = row(&cells[0]);
        text += &name;
        let mut mark = "";
        for cell in cells {
            let (number, next) = match &cell.result {
                Ok(TipError { motion, .. }) => (
                    format!("{:.3} ({:.3})", 1e3 * motion.rms(), 1e3 * motion.max),
                    if cell.verdict.is_bad() { "!" } else { "" },
                ),
                Err(_) => ("failed".into(), ""),
            };
            let width = 20 - mark.len();
            let _ = write!(text, "{mark}{number:>width$}");
            mark = next;
        }
        let end = end.get(mark.len()..).unwrap_or_default();
        let _ = writeln!(text, "{mark}{end}");
    }
    text
}

/// What `!` means, and the limit that the worst marked run breaks; empty without marks.
fn mark_legend(cells: &[TipCell], name: impl Fn(&TipCell) -> String) -> String {
    let marked = cells.iter().filter(|c| c.verdict.is_bad());
    let marked = marked.filter_map(|c| Some((c, c.result.as_ref().ok()?.motion.rms())));
    let Some((worst, _)) = marked.max_by(|(_, a), (_, b)| a.total_cmp(b)) else {
        return String::new();
    };
    let broken = worst.verdict.findings().iter().find(|f| f.is_bad);
    let broken = broken.map_or("", |finding| &finding.text);
    format!(
        "! the run breaks a limit of the machine; the worst, {}: {broken}\n",
        name(worst)
    )
}

/// The paper's table as comma-separated values.
pub fn write_inertia_csv(cells: &[TipCell], out: &mut impl io::Write) -> io::Result<()> {
    writeln!(
        out,
        "trajectory,inertia_scale,mode,rmse [m],max [m],rmse whole run [m],paper adaptive rmse [m]"
    )?;
    for c in cells {
        let errors = |tip: &TipError| [tip.motion.rms(), tip.motion.max, tip.whole.rms()];
        let [rmse, max, whole] = c.result.as_ref().map_or([f64::NAN; 3], errors);
        let paper = paper(c.trajectory, scale_of(c)).unwrap_or(f64::NAN);
        let (trajectory, scale, law) = (c.trajectory, &c.case, &c.law);
        writeln!(
            out,
            "{trajectory},{scale},{law},{rmse},{max},{whole},{paper}"
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

    /// The mark takes the place of a blank, so the columns stay where they are.
    #[test]
    fn a_run_that_breaks_a_limit_is_marked() {
        let mut cells = [0.6e-3, 0.7e-3, 7.25e-3].map(|error| cell("pd", Ok(error)));
        let plain = robustness_text(Study::TipLoad, &cells, &mut Verdict::default());
        for (cell, force) in cells[1..].iter_mut().zip(["71 kN", "90 kN"]) {
            cell.verdict.object(format!("force: {force}"));
        }
        let text = robustness_text(Study::TipLoad, &cells, &mut Verdict::default());
        assert!(text.contains("0.600 (0.600)       0.700 (0.700)!      7.250 (7.250)!\n"));
        let (table, legend) = text
            .split_once("! the run breaks a limit")
            .expect("a legend");
        assert!(legend.ends_with("the worst, cubic payload +40 %, pd: force: 90 kN\n"));
        let unmarked = table.replace("!\n", "\n").replace('!', " ");
        assert_eq!(unmarked, plain);
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
