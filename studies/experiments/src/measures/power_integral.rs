//! Sums over recorded energies and powers, for the energy balances ([`super::energy`],
//! [`super::supply`]) and the sizing study.

/// Name of an actuator's output: work done on the load because an exchange set `x` elsewhere than
/// the velocity had taken the rod.
pub const SHIFT: &str = "energy.shift";

/// Last value minus the first; 0 for an empty column.
pub fn rise(column: &[f64]) -> f64 {
    column.last().unwrap_or(&0.0) - column.first().unwrap_or(&0.0)
}

/// Rise of `taken` over those steps in which `work` rises.
pub fn rise_while_working(taken: &[f64], work: &[f64]) -> f64 {
    let steps = taken.windows(2).zip(work.windows(2));
    let working = steps.filter(|(_, work)| work[1] > work[0]);
    working.map(|(taken, _)| taken[1] - taken[0]).sum()
}

/// Sums of the rises and of the falls, both positive, of an integrated power.
pub fn rises_and_falls(energy: &[f64]) -> (f64, f64) {
    let steps = energy.windows(2).map(|pair| pair[1] - pair[0]);
    steps.fold((0.0, 0.0), |(rises, falls), step| match step > 0.0 {
        true => (rises + step, falls),
        false => (rises, falls - step),
    })
}

/// Integral of a power by the trapezoidal rule.
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
