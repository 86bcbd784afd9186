//! The surrogate in the loop as a table for people.

use crate::studies::surrogate_loop::SurrogateRow;

/// The rows as a table for people.
pub fn text(rows: &[SurrogateRow]) -> String {
    let mut text = format!(
        "{:<22}{:<12}{:>20}{:>16}{:>32}\n",
        "load cells", "controller", "tip, mm (worst)", "current, A", "tip over physics [95 %]"
    );
    for r in rows {
        let tip = format!("{:.3} ({:.3})", 1e3 * r.tip.median, 1e3 * r.tip.worst);
        let [ratio, low, high] = r.ratio;
        let ratio = format!("{ratio:.3} [{low:.3}, {high:.3}]");
        text += &format!(
            "{:<22}{:<12}{tip:>20}{:>16.3}{ratio:>32}\n",
            r.sensors, r.model, r.current.median
        );
    }
    text + "load cells: and encoders at the rods; tip: RMSE of the known error over the motion, median of machines and paths; current: required less true, root mean square; \
            over physics: geometric mean over the same machines and paths, bootstrap\n"
}
