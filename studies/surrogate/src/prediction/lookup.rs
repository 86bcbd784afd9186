//! A look-up map fitted to rows, for `surrogate compare`: friction force over torque and speed.

/// Number of nodes along torque and along speed. Each has the same number of rows on average, so
/// that slow speeds, where friction changes most, have as many as fast ones.
const NODES: usize = 14;

/// `F = τ/travel − lost(τ, w)` for w > 0, where the lost force is bilinear between cell means; the
/// other direction is the mirror image.
#[derive(Clone, Debug)]
pub struct LookUp {
    travel: f64,
    tau: [f64; NODES],
    w: [f64; NODES],
    lost: [[f64; NODES]; NODES],
}

impl LookUp {
    /// Fits the map to rows `[tau, w, F]`, at least as many as nodes; `travel` is the nut's travel
    /// per radian of the motor, m.
    pub fn new(travel: f64, rows: &[[f64; 3]]) -> Self {
        let rows: Vec<[f64; 3]> = rows
            .iter()
            .map(|r| if r[1] < 0.0 { r.map(|x| -x) } else { *r })
            .collect();
        let edges = |column: usize| -> Vec<f64> {
            let mut values: Vec<f64> = rows.iter().map(|r| r[column]).collect();
            values.sort_unstable_by(f64::total_cmp);
            let last = values.len() - 1;
            (0..=NODES).map(|k| values[last * k / NODES]).collect()
        };
        let [tau_edges, w_edges] = [edges(0), edges(1)];
        let cell = |edges: &[f64], x: f64| edges[1..NODES].partition_point(|&edge| edge <= x);
        let mut sums = [[[0.0; 2]; NODES]; NODES];
        let mut places = [[[0.0; 2]; NODES]; 2];
        for &[tau, w, F] in &rows {
            let (i, j) = (cell(&tau_edges, tau), cell(&w_edges, w));
            let add = |sum: &mut [f64; 2], x: f64| *sum = [sum[0] + x, sum[1] + 1.0];
            add(&mut sums[i][j], tau / travel - F);
            add(&mut places[0][i], tau);
            add(&mut places[1][j], w);
        }
        let nodes = |k: usize| places[k].map(|[sum, count]| sum / count);
        Self {
            travel,
            tau: nodes(0),
            w: nodes(1),
            lost: cell_means(sums),
        }
    }

    /// Force at constant speed, N.
    pub fn force(&self, tau: f64, w: f64) -> f64 {
        // Below the slowest node the lost force falls to 0, as both directions meet at rest.
        let sign = if w < 0.0 { -1.0 } else { 1.0 };
        let (i, a) = place(&self.tau, sign * tau);
        let (j, b) = place(&self.w, sign * w);
        let between = |row: &[f64; NODES]| row[j] + b * (row[j + 1] - row[j]);
        let (low, high) = (between(&self.lost[i]), between(&self.lost[i + 1]));
        let rest = (w.abs() / self.w[0]).min(1.0);
        tau / self.travel - rest * sign * (low + a * (high - low))
    }
}

/// The interval of `nodes` that holds `x`, and the place in it, 0 … 1; beyond the ends the end.
fn place(nodes: &[f64; NODES], x: f64) -> (usize, f64) {
    let k = nodes[1..NODES - 1].partition_point(|&node| node <= x);
    let share = (x - nodes[k]) / (nodes[k + 1] - nodes[k]);
    (k, share.clamp(0.0, 1.0))
}

/// Means of the cells; a cell without rows gets the mean of its neighbours, repeatedly.
fn cell_means(sums: [[[f64; 2]; NODES]; NODES]) -> [[f64; NODES]; NODES] {
    let mut means = sums.map(|row| row.map(|[sum, count]| (count > 0.0).then(|| sum / count)));
    while means.iter().flatten().any(Option::is_none) {
        let known = means;
        for i in 0..NODES {
            for j in 0..NODES {
                let near = |k: usize| k.saturating_sub(1)..(k + 2).min(NODES);
                let around = near(i).flat_map(|a| near(j).map(move |b| (a, b)));
                let values: Vec<f64> = around.filter_map(|(a, b)| known[a][b]).collect();
                if known[i][j].is_none() && !values.is_empty() {
                    means[i][j] = Some(values.iter().sum::<f64>() / values.len() as f64);
                }
            }
        }
    }
    means.map(|row| row.map(|mean| mean.expect("filled above")))
}
