//! A smooth curve through the samples of a path, which `path` evaluates.

use crate::file::Sample;
use motion_check::{Pose, TipMotion};
use nalgebra::{Quaternion, SVector, UnitQuaternion, Vector3, Vector6};
use serde::{Deserialize, Serialize};

/// Position and quaternion w, x, y, z.
type Channels = SVector<f64, 7>;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Knot {
    t: f64,
    value: Channels,
    slope: Channels,
    second: Channels,
}

/// The cubic spline through the samples with rest at both ends, twice continuously differentiable.
/// In its first and last interval the polynomial is of fifth order, so that the acceleration at the
/// ends is zero too. Orientations are the spline of the quaternions' components, brought to length
/// 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Spline {
    knots: Vec<Knot>,
}

impl Spline {
    /// The curve through at least two samples, the first at time `begins`, s. Samples without
    /// orientation keep that of `start`.
    pub(crate) fn new(samples: &[Sample], start: &Pose, offset: Vector3<f64>, begins: f64) -> Self {
        let mut before = start.orientation.into_inner();
        let mut knots: Vec<Knot> = Vec::with_capacity(samples.len());
        for sample in samples {
            let q = sample
                .orientation
                .map_or(before, UnitQuaternion::into_inner);
            // q and −q are the same orientation: take the one nearer to the previous sample's.
            let q = if q.dot(&before) < 0.0 { -q } else { q };
            before = q;
            let p = sample.position + offset;
            knots.push(Knot {
                t: begins + (sample.t - samples[0].t),
                value: Channels::from([p.x, p.y, p.z, q.w, q.i, q.j, q.k]),
                slope: Channels::zeros(),
                second: Channels::zeros(),
            });
        }
        let mut spline = Self { knots };
        spline.solve();
        spline
    }

    /// Time of the last sample, s.
    pub(crate) fn end(&self) -> f64 {
        self.knots[self.knots.len() - 1].t
    }

    /// Times near which the acceleration or the speed is largest, s: four in each interval.
    pub(crate) fn extremes(&self) -> impl Iterator<Item = f64> {
        let of = |pair: &[Knot]| {
            let (from, over) = (pair[0].t, pair[1].t - pair[0].t);
            [0.0, 0.25, 0.5, 0.75].map(|part| from + part * over)
        };
        self.knots.windows(2).flat_map(of)
    }

    /// Index of the interval that `t` lies in, s.
    pub(crate) fn interval(&self, t: f64) -> usize {
        let next = self.knots.partition_point(|knot| knot.t <= t);
        next.clamp(1, self.knots.len() - 1) - 1
    }

    /// Slopes of the cubic spline, with zero at both ends: by elimination from `m_(i−1)/h_(i−1) + 2
    /// m_i (1/h_(i−1) + 1/h_i) + m_(i+1)/h_i = 3 (Δ_(i−1)/h_(i−1) + Δ_i/h_i)`, Δ the slopes of the
    /// chords.
    fn solve(&mut self) {
        let n = self.knots.len();
        let h = |k: &[Knot], i: usize| k[i + 1].t - k[i].t;
        let chord = |k: &[Knot], i: usize| (k[i + 1].value - k[i].value) / h(k, i);
        let mut upper = vec![0.0; n];
        for i in 1..n - 1 {
            let k = &self.knots;
            let (before, after) = (1.0 / h(k, i - 1), 1.0 / h(k, i));
            let right = (chord(k, i - 1) * before + chord(k, i) * after) * 3.0;
            let diagonal = 2.0 * (before + after) - before * upper[i - 1];
            let slope = (right - k[i - 1].slope * before) / diagonal;
            upper[i] = after / diagonal;
            self.knots[i].slope = slope;
        }
        for i in (1..n - 1).rev() {
            let next = self.knots[i + 1].slope;
            self.knots[i].slope -= next * upper[i];
        }
        for i in 1..n - 1 {
            let k = &self.knots;
            let second = (chord(k, i) * 3.0 - k[i].slope * 2.0 - k[i + 1].slope) * (2.0 / h(k, i));
            self.knots[i].second = second;
        }
    }

    /// Value, first and second derivative of all channels at `t`, s, limited to the samples' times.
    fn channels(&self, t: f64) -> [Channels; 3] {
        let i = self.interval(t);
        let (a, b) = (&self.knots[i], &self.knots[i + 1]);
        let h = b.t - a.t;
        let u = ((t - a.t) / h).clamp(0.0, 1.0);
        let way = b.value - a.value;
        let [v0, v1] = [a.slope * h, b.slope * h];
        let [a0, a1] = [a.second * (h * h), b.second * (h * h)];
        let c3 = way * 10.0 - v0 * 6.0 - v1 * 4.0 - a0 * 1.5 + a1 * 0.5;
        let c4 = way * -15.0 + v0 * 8.0 + v1 * 7.0 + a0 * 1.5 - a1;
        let c5 = way * 6.0 - v0 * 3.0 - v1 * 3.0 - a0 * 0.5 + a1 * 0.5;
        [
            a.value + (v0 + (a0 * 0.5 + (c3 + (c4 + c5 * u) * u) * u) * u) * u,
            (v0 + (a0 + (c3 * 3.0 + (c4 * 4.0 + c5 * (5.0 * u)) * u) * u) * u) / h,
            (a0 + (c3 * 6.0 + (c4 * 12.0 + c5 * (20.0 * u)) * u) * u) / (h * h),
        ]
    }

    /// Motion at `t`, s. With the interpolated quaternion u of any length
    /// ```text
    /// q = u/|u|,   ω = 2·vec(u̇ ū)/|u|²,   ω̇ = 2·vec(ü ū)/|u|² − 2 ω (u·u̇)/|u|²
    /// ```
    pub(crate) fn at(&self, t: f64) -> TipMotion {
        let [p, v, a] = self.channels(t);
        let q = |c: &Channels| Quaternion::new(c[3], c[4], c[5], c[6]);
        let (u, u_dot, u_ddot) = (q(&p), q(&v), q(&a));
        let square = u.norm_squared();
        let turn = |rate: Quaternion<f64>| (rate * u.conjugate()).imag() * (2.0 / square);
        let w = turn(u_dot);
        let w_dot = turn(u_ddot) - w * (2.0 * u.dot(&u_dot) / square);
        TipMotion {
            pose: Pose {
                position: Vector3::new(p[0], p[1], p[2]),
                orientation: UnitQuaternion::new_unchecked(u / square.sqrt()),
            },
            velocity: Vector6::new(v[0], v[1], v[2], w.x, w.y, w.z),
            acceleration: Vector6::new(a[0], a[1], a[2], w_dot.x, w_dot.y, w_dot.z),
        }
    }
}
