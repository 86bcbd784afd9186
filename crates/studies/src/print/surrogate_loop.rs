//! The surrogate in the loop as a table for people.

use rig_data::prediction::Errors;

use crate::studies::surrogate_loop::SurrogateRun;

/// The runs as a table for people.
pub fn text(runs: &[SurrogateRun]) -> String {
    let mut text = format!(
        "{:<12}{:<9}{:<11}{:>9}{:>12}{:>22}{:>22}{:>22}\n",
        "trajectory",
        "law",
        "controller",
        "tip, mm",
        "current, A",
        "physics predicts",
        "hybrid",
        "network"
    );
    for r in runs {
        let cell = |e: &Errors| format!("{:.3} A, {:.2} %", e.current[0], 1e2 * e.efficiency[0]);
        let [physics, hybrid, network] = r.predicted.each_ref().map(cell);
        text += &format!(
            "{:<12}{:<9}{:<11}{:>9.3}{:>12.3}{physics:>22}{hybrid:>22}{network:>22}\n",
            r.trajectory,
            r.law,
            r.model,
            1e3 * r.tip,
            r.current
        );
    }
    text + "tip: RMSE of the known error over the motion; current: required less true, root mean square; predicted from true force and motion, temperatures known: \
            errors of current and efficiency, root mean square\n"
}
