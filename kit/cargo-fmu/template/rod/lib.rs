//! FMU `Rod`: conduction of heat in a rod of cells, a stiff model, to be replaced by one of your own.
//!
//! The smaller the cells, the faster heat passes between two of them: rates differ by n², so a solver
//! with steps of its own takes the steps that the temperatures need, not those of the fastest rate.

use fmu_export::prelude::*;

#[derive(Parameters)]
struct Parameters {
    /// Number of cells
    #[fmu(structural, start = 50, min = 2, max = 100_000)]
    n: i32,
    /// Length
    #[fmu(unit = "m", start = 0.5, min = 1e-3)]
    length: f64,
    /// Cross section
    #[fmu(unit = "m2", start = 1e-4, min = 1e-9)]
    area: f64,
    /// Heat conductivity
    #[fmu(unit = "W/(m.K)", start = 400.0, min = 1e-3)]
    conductivity: f64,
    /// Heat capacity of the whole rod
    #[fmu(unit = "J/K", start = 170.0, min = 1e-3)]
    capacity: f64,
    /// Temperature at the start
    #[fmu(unit = "K", display_unit = "degC", start = 293.15, min = 1.0)]
    T_start: f64,
}

#[derive(Input)]
struct Input {
    /// Temperatures that its ends are held at
    #[fmu(unit = "K", display_unit = "degC", start = 293.15, min = 1.0)]
    T_end: [f64; 2],
}

#[derive(Output)]
struct Output {
    /// Heat that flows in at each end
    #[fmu(unit = "W", depends_on(T_end[i]), initially_depends_on(T_end[i], parameters))]
    Q: [f64; 2],
}

/// Conduction of heat in a rod whose ends are held at two temperatures
#[derive(State)]
#[fmu(parameters = Parameters, input = Input, output = Output, model_exchange, solver = "stiff", experiment(0.0, 600.0, 10.0))]
struct Rod {
    /// Temperatures in the middles of the cells
    #[fmu(unit = "K", display_unit = "degC", len = p.n, start = p.T_start, nominal = 300.0,
        rate_depends_on(T[i - 1], T[i], T[i + 1], T_end))]
    T: Vec<f64>,
}

impl Ode for Rod {
    fn derivative(&self, p: &Parameters, u: &Input, _t: f64, dx: &mut Self) {
        // Between two middles; an end is half as far from the middle of its cell.
        let (n, T) = (self.T.len(), &self.T);
        let (conductance, capacity) = (p.conductivity * p.area * n as f64 / p.length, p.capacity / n as f64);
        let [left, right] = self.outputs(p, u).Q;
        for i in 0..n {
            let from_left = if i > 0 { conductance * (T[i - 1] - T[i]) } else { left };
            let from_right = if i + 1 < n { conductance * (T[i + 1] - T[i]) } else { right };
            dx.T[i] = (from_left + from_right) / capacity;
        }
    }

    fn outputs(&self, p: &Parameters, u: &Input) -> Output {
        let n = self.T.len();
        let conductance = 2.0 * p.conductivity * p.area * n as f64 / p.length;
        Output { Q: [conductance * (u.T_end[0] - self.T[0]), conductance * (u.T_end[1] - self.T[n - 1])] }
    }
}

export_fmu!(Rod);

#[cfg(test)]
mod tests {
    use super::*;

    /// Names, units and dependencies of the variables against what the model does.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<Rod>(), [""; 0]);
    }

    /// Oracle: less than the straight line between its ends are the waves sin(π k (i + ½)/n), which
    /// decay at 4 n² sin²(π k/(2 n)) times conductance over capacity of the whole rod. The errors of
    /// internal steps add up, and conduction damps them: less than ten times the tolerance, 1e-6 of
    /// 300 K.
    #[test]
    fn a_rod_that_is_heated_follows_its_closed_form() {
        let (p, mut u) = Rod::defaults();
        u.T_end = [393.15, 293.15];
        let mut rod = Rod::initialize(&p, &u, 0.0).unwrap();
        Model::step(&mut rod, &p, &InputPolynomial::held(u), &(), 0.0, 100.0).unwrap();
        let cells = rod.T.len();
        let (n, rate) = (cells as f64, p.conductivity * p.area / p.length / p.capacity);
        let line = |i: usize| 100.0 * (1.0 - (i as f64 + 0.5) / n);
        let wave = |k: usize, i: usize| (std::f64::consts::PI * k as f64 * (i as f64 + 0.5) / n).sin();
        for i in 0..cells {
            let waves = (1..=cells).map(|k| {
                let part = (0..cells).map(|j| wave(k, j) * line(j)).sum::<f64>() / if k < cells { n / 2.0 } else { n };
                let decay = 4.0 * n * n * (std::f64::consts::FRAC_PI_2 * k as f64 / n).sin().powi(2) * rate;
                part * wave(k, i) * (-100.0 * decay).exp()
            });
            let exact = 293.15 + line(i) - waves.sum::<f64>();
            assert!((rod.T[i] - exact).abs() < 10.0 * 1e-6 * 300.0, "{i}: {} {exact}", rod.T[i]);
        }
    }
}
