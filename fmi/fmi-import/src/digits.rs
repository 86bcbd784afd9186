//! Numbers as messages show them, for importer, master and studies. Files have all digits instead.
//!
//! ```
//! use fmi_import::digits::short;
//! assert_eq!(short(0.1 + 0.2), "0.3");
//! assert_eq!(short(1e-7), "1e-7");
//! ```

/// The number with the digits that a person needs: ten significant ones, and six decimals of a
/// large number, such as a time in s since 1970. What rounding has left behind is not shown.
#[must_use]
pub fn short(x: f64) -> String {
    let size = x.abs().log10().floor();
    let decimals = if size.is_finite() { size as i32 + 6 } else { 0 };
    let digits = usize::try_from(decimals.clamp(9, 16)).unwrap_or(9);
    let rounded = format!("{x:.digits$e}").parse().unwrap_or(x);
    match rounded.abs() {
        0.0 | 1e-5..1e15 => rounded.to_string(),
        _ => format!("{rounded:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_errors_are_not_shown() {
        for (number, shown) in [
            (0.1 + 0.2, "0.3"),
            (24249.0 * 0.001, "24.249"),
            (-1.0 / 3.0, "-0.3333333333"),
            (1_700_000_000.001, "1700000000.001"),
            (100.0, "100"),
            (2.5e-8, "2.5e-8"),
            (1e300, "1e300"),
            (0.0, "0"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(short(number), shown);
        }
    }
}
