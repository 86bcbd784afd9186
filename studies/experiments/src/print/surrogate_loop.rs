//! The study of the surrogate in the loop (`hdrm-fmu table --study surrogate`) as a table.

use crate::analyses::surrogate_loop::SurrogateRow;

/// The table and a line that explains its columns.
pub fn text(rows: &[SurrogateRow]) -> String {
    let mut text = "load cells            controller    failed                   tip, mm (worst)              current, A        tip over physics\n"
        .to_owned();
    let cell = |[mean, low, high]: [f64; 3], factor: f64| {
        let [mean, low, high] = [mean, low, high].map(|value| factor * value);
        format!("{mean:.3} [{low:.3}, {high:.3}]")
    };
    for r in rows {
        let tip = format!("{} ({:.3})", cell(r.tip, 1e3), 1e3 * r.worst);
        let (current, ratio) = (cell(r.current, 1.0), cell(r.ratio, 1.0));
        let failed = format!("{} of {}", r.failed[0], r.failed[1]);
        text += &format!(
            "{:<22}{:<12}{failed:>8}{tip:>34}{current:>24}{ratio:>24}\n",
            r.sensors, r.model
        );
    }
    text + "load cells: and encoders at the rods; failed: stopped by the supervisor, or beyond the machine's limits; tip: RMSE of the known error over the motion; current: required less true, root mean square; over physics: on the same \
            machine and path; all: geometric mean over the machines and paths that failed with no controller of the same sensors, with its 95 % interval, bootstrap over machines\n"
}
