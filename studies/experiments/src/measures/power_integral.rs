//! Powers integrated over time: what a run recorded of an energy, in parts.

/// Output of an actuator that tells what crossed its mechanical border between two steps, where it
/// has one: see `Balance::shift`.
pub const SHIFT: &str = "energy.shift";

/// Last value less the first; 0 without any.
pub fn rise(column: &[f64]) -> f64 {
    column.last().unwrap_or(&0.0) - column.first().unwrap_or(&0.0)
}

/// Rise of `taken` over the steps in which `work` rises.
pub fn rise_while_working(taken: &[f64], work: &[f64]) -> f64 {
    let steps = taken.windows(2).zip(work.windows(2));
    let working = steps.filter(|(_, work)| work[1] > work[0]);
    working.map(|(taken, _)| taken[1] - taken[0]).sum()
}

/// Sums of the rises and of the falls of an integrated power.
pub fn rises_and_falls(energy: &[f64]) -> (f64, f64) {
    let mut ways = (0.0, 0.0);
    for pair in energy.windows(2) {
        let rise = pair[1] - pair[0];
        if rise > 0.0 {
            ways.0 += rise;
        } else {
            ways.1 -= rise;
        }
    }
    ways
}

/// Trapezoidal rule.
pub fn integral(times: &[f64], power: &[f64]) -> f64 {
    let steps = times.windows(2).zip(power.windows(2));
    steps
        .map(|(t, p)| 0.5 * (t[1] - t[0]) * (p[0] + p[1]))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rises_and_falls_are_kept_apart() {
        assert_eq!(rises_and_falls(&[1.0, 4.0, 2.0, 2.0, 7.0]), (8.0, 2.0));
        assert_eq!(integral(&[0.0, 1.0, 3.0], &[2.0, 4.0, 6.0]), 13.0);
        assert_eq!(
            rise_while_working(&[0.0, 5.0, 4.0, 9.0], &[0.0, 1.0, 1.0, 2.0]),
            10.0
        );
    }
}
