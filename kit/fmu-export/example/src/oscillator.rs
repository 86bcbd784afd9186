//! The model alone, which `lib` makes an FMU: a mass that moves in a plane, held by a spring and a
//! damper along each axis. Nothing in this file refers to FMI.
//!
//! ```text
//! m a_i = F_i − d v_i − k x_i (1 + (x_i/x_h)²)      i = 1, 2
//! ```
//! `x_h` is infinite for the linear spring. SI units; axes are fixed in space and do not influence
//! each other.

use serde::{Deserialize, Serialize};

/// Longest internal step, s.
const H_MAX: f64 = 1e-3;

/// Parameters; all positive, except that `d` may be zero.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Parameters {
    /// Mass m, kg.
    pub m: f64,
    /// Damping d, N·s/m.
    pub d: f64,
    /// Stiffness k, N/m.
    pub k: f64,
    /// Deflection x_h at which a hardening spring has twice the linear force, m.
    pub x_h: f64,
    /// 1: linear, 2: hardening.
    pub spring: i32,
    /// Position at the start, m.
    pub x_start: [f64; 2],
    /// File the parameters came from; empty for the built-in ones.
    pub file: String,
}

/// Position, m, and velocity, m/s, for each axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Position, m.
    pub x: [f64; 2],
    /// Velocity, m/s.
    pub v: [f64; 2],
}

impl Parameters {
    /// Force of the spring, N, and its derivative, N/m, at deflection `x`, m.
    pub fn spring_force(&self, x: f64) -> (f64, f64) {
        let hardening = if self.spring == 2 {
            (x / self.x_h).powi(2)
        } else {
            0.0
        };
        (
            self.k * x * (1.0 + hardening),
            self.k * (1.0 + 3.0 * hardening),
        )
    }

    /// Acceleration of one axis, m/s².
    pub fn acceleration(&self, x: f64, v: f64, force: f64) -> f64 {
        (force - self.d * v - self.spring_force(x).0) / self.m
    }

    /// Kinetic and potential energy, J.
    pub fn energy(&self, s: &State) -> f64 {
        let axis = |(x, v): (f64, f64)| {
            let hardening = if self.spring == 2 {
                0.5 * (x / self.x_h).powi(2)
            } else {
                0.0
            };
            0.5 * self.m * v * v + 0.5 * self.k * x * x * (1.0 + hardening)
        };
        s.x.into_iter().zip(s.v).map(axis).sum()
    }
}

/// The state after `h` s under the force `force(s)`, N, `s` seconds into the step. Runge–Kutta of
/// order 4.
pub fn advance(p: &Parameters, start: State, h: f64, force: impl Fn(f64) -> [f64; 2]) -> State {
    let n = (h / H_MAX).ceil(); // substeps divide h, so it ends where it should
    let dt = h / n;
    let mut s = start;
    for k in 0..n as u32 {
        let t = f64::from(k) * dt;
        let (f0, f1, f2) = (force(t), force(t + 0.5 * dt), force(t + dt));
        for i in 0..2 {
            let rate = |x: f64, v: f64, f: [f64; 2]| (v, p.acceleration(x, v, f[i]));
            let (x, v) = (s.x[i], s.v[i]);
            let a = rate(x, v, f0);
            let b = rate(x + 0.5 * dt * a.0, v + 0.5 * dt * a.1, f1);
            let c = rate(x + 0.5 * dt * b.0, v + 0.5 * dt * b.1, f1);
            let d = rate(x + dt * c.0, v + dt * c.1, f2);
            s.x[i] = x + dt / 6.0 * (a.0 + 2.0 * (b.0 + c.0) + d.0);
            s.v[i] = v + dt / 6.0 * (a.1 + 2.0 * (b.1 + c.1) + d.1);
        }
    }
    s
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters(spring: i32) -> Parameters {
        let x_start = [0.3, -0.2];
        Parameters {
            m: 2.3,
            d: 0.0,
            k: 41.0,
            x_h: 0.35,
            spring,
            x_start,
            file: String::new(),
        }
    }

    /// Oracle: x = x0 cos ωt + F/k (1 − cos ωt). RK4 misses e^{iz}, z = ω dt, by z⁵/120 a step: N
    /// z⁵/120 = ωT z⁴/120 of the amplitude, 4.22·4·(4.22e-3)⁴/120 = 4.5e-11; times amplitude 0.4
    /// and a little for rounding.
    #[test]
    fn the_linear_spring_swings_as_a_cosine() {
        let p = parameters(1);
        let start = State {
            x: p.x_start,
            v: [0.0; 2],
        };
        let s = advance(&p, start, 4.0, |_| [7.0, 0.0]);
        let (w, c) = ((p.k / p.m).sqrt(), ((p.k / p.m).sqrt() * 4.0).cos());
        let exact = [0.3 * c + 7.0 / p.k * (1.0 - c), -0.2 * c];
        let tolerance = w * 4.0 * (w * H_MAX).powi(4) / 120.0 * 0.5;
        for (x, exact) in s.x.into_iter().zip(exact) {
            assert!(
                (x - exact).abs() < tolerance,
                "{x} {exact}: {:e} > {tolerance:e}",
                x - exact
            );
        }
    }

    /// Oracle: energy. RK4 loses z⁶/72 of it a step (z at the stiffest deflection): 4000 ·
    /// (9.1e-3)⁶/72 < 4e-11.
    #[test]
    fn the_hardening_spring_keeps_its_energy() {
        let p = parameters(2);
        let start = State {
            x: p.x_start,
            v: [0.4, 1.9],
        };
        let s = advance(&p, start, 4.0, |_| [0.0; 2]);
        let drift = (p.energy(&s) - p.energy(&start)).abs() / p.energy(&start);
        assert!(drift < 4e-11, "{drift:e}");
        assert!(s != start);
    }
}
