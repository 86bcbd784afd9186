//! Interpolation in a `Curve` or `Map`: linear, or monotone cubic.

use serde::{Deserialize, Serialize};

/// The interpolation between the points of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Between {
    /// Straight lines.
    Linear,
    /// Cubics with a continuous slope that do not overshoot: monotone where the values are (F. N.
    /// Fritsch, R. E. Carlson, 1980, with the slopes of F. N. Fritsch, J. Butland, 1984).
    Monotone,
}

/// The value at `x` of a table with `value(i)` at `points[i]`, of which there are at least two.
/// `value` is called at most four times.
pub(super) fn interpolate(
    points: &[f64],
    value: impl Fn(usize) -> f64,
    x: f64,
    between: Between,
) -> f64 {
    let last = points.len() - 1;
    let x = x.clamp(points[0], points[last]);
    let k = points.partition_point(|point| *point <= x).clamp(1, last) - 1;
    let width = points[k + 1] - points[k];
    let (start, end) = (value(k), value(k + 1));
    let share = (x - points[k]) / width;
    if between == Between::Linear {
        return start + share * (end - start);
    }
    // Width and secant slope of this interval, of the one before and of the one after.
    let own = (width, (end - start) / width);
    let (w_before, w_after) = (
        (k > 0).then(|| points[k] - points[k - 1]),
        (k + 1 < last).then(|| points[k + 2] - points[k + 1]),
    );
    let before = w_before.map(|w| (w, (start - value(k - 1)) / w));
    let after = w_after.map(|w| (w, (value(k + 2) - end) / w));
    let slope = |next, other: Option<_>| match next {
        Some(next) => inner_slope(own, next),
        None => other.map_or(own.1, |other| end_slope(own, other)),
    };
    let (a, b) = (slope(before, after) * width, slope(after, before) * width);
    let rest = 1.0 - share;
    let change = end - start;
    start + share * share * (3.0 - 2.0 * share) * change + share * rest * (rest * a - share * b)
}

/// The slope between two intervals: the harmonic mean of their secant slopes, weighted by their
/// widths; 0 if the signs differ.
fn inner_slope((w_1, d_1): (f64, f64), (w_2, d_2): (f64, f64)) -> f64 {
    if d_1 * d_2 <= 0.0 {
        return 0.0;
    }
    let (a, b) = (2.0 * w_1 + w_2, w_1 + 2.0 * w_2);
    3.0 * (w_1 + w_2) / (b / d_1 + a / d_2)
}

/// The slope at an end: that of a parabola, kept monotone.
fn end_slope((w_1, d_1): (f64, f64), (w_2, d_2): (f64, f64)) -> f64 {
    let slope = ((2.0 * w_1 + w_2) * d_1 - w_1 * d_2) / (w_1 + w_2);
    if slope * d_1 <= 0.0 {
        0.0
    } else if d_1 * d_2 <= 0.0 && slope.abs() > 3.0 * d_1.abs() {
        3.0 * d_1
    } else {
        slope
    }
}
