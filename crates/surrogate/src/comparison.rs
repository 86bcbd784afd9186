//! Physics, network and hybrid beside the virtual testbed's truth, on points and motions that the
//! training never saw. The truth is a simulation, too: that of the richer actuator.

use anyhow::{Context as _, Result};
use emla::{Drive, Emla, Input, Residual, State, Surrogate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::campaign::{LOAD_MAX, SPEED, motion_profile};
use crate::plots::{MAP_CELLS, Map, cell_centre};
use crate::testbed::Testbed;

/// Below this rod speed, m/s, both powers are small and their ratio says little.
const EFFICIENCY_SPEED: f64 = 0.01;
/// Logging interval of the motion profile and communication step, s.
const H: f64 = 1e-3;

/// Root mean squares of the errors of force, N, and of efficiency.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    /// Error of the force, N.
    pub force: f64,
    /// Error of the efficiency where it is defined.
    pub efficiency: f64,
}

/// Sum of squares on its way to a root mean square.
#[derive(Clone, Copy, Default)]
struct Rms {
    sum: f64,
    count: f64,
}

impl Rms {
    fn add(&mut self, error: f64) {
        self.sum += error * error;
        self.count += 1.0;
    }

    fn value(self) -> f64 {
        (self.sum / self.count).sqrt()
    }
}

/// Efficiency as the paper's Eq. (eq:dnn_prediction_efficiency) defines it in quadrants I and IV,
/// kept inside 0 … 1 (a load that does not even cover the electrical losses recovers nothing).
fn efficiency(shaft: f64, electrical: f64, out: f64) -> f64 {
    let ratio = if shaft > 0.0 {
        out / (shaft + electrical)
    } else {
        (-shaft - electrical) / -out
    };
    ratio.clamp(0.0, 1.0)
}

/// Blending factor 0 is the physics alone.
fn actuator(testbed: &Testbed, surrogate: &Surrogate, drive: Drive, alpha: f64) -> Result<Emla> {
    let emla = Emla::new(*testbed.base(), drive).context("the base machine")?;
    Ok(emla.with_surrogate(surrogate.clone(), alpha))
}

/// Errors of the quasi-static hybrid maps on `points` steady operating points drawn with `seed`,
/// uniform over load and speed, without sensor noise.
pub fn on_points(
    testbed: &Testbed,
    surrogate: &Surrogate,
    alpha: f64,
    points: u32,
    seed: u64,
) -> Result<Errors> {
    let p = testbed.base();
    let emla = actuator(testbed, surrogate, Drive::Motion, alpha)?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut force, mut ratio) = (Rms::default(), Rms::default());
    for _ in 0..points {
        let f_ext = rng.random_range(-LOAD_MAX..LOAD_MAX);
        let x_dot = rng.random_range(SPEED[0]..SPEED[1]);
        let truth = testbed.steady(x_dot, f_ext);
        let tau_e = testbed.torque(truth.i);
        let u = Input {
            x: truth.x,
            x_dot,
            F_hold: f_ext,
            ..Input::default()
        };
        let state = State {
            i_d: truth.i[0],
            i_q: truth.i[1],
            w_m: truth.w_m,
            residual: residual(surrogate, p, tau_e, truth.w_m),
            ..emla.start(&u).context("a steady point")?
        };
        let y = emla.output(&state, &u);
        force.add(y.F_hyb - f_ext);
        if y.efficiency_valid && f_ext > 0.0 && x_dot > EFFICIENCY_SPEED {
            let copper = 1.5 * p.R_s * truth.i[1] * truth.i[1];
            let electrical = copper + testbed.electrical_losses(truth.i, truth.w_m);
            ratio.add(y.efficiency - efficiency(tau_e * truth.w_m, electrical, f_ext * x_dot));
        }
    }
    Ok(Errors {
        force: force.value(),
        efficiency: ratio.value(),
    })
}

fn residual(surrogate: &Surrogate, p: &machine::Emla, tau_e: f64, w_m: f64) -> Residual {
    let net = surrogate.evaluate(tau_e, w_m);
    let physics = surrogate.guard(tau_e, w_m, |tau, w| {
        emla::maps::quasi_static_force(p, tau, w)
    });
    Residual {
        dF: net.F - physics,
        F_net: net.F,
        x_dot_net: net.x_dot,
        in_trained_range: net.in_trained_range,
    }
}

/// Errors of the dynamic hybrid actuator on the motion profile: it is given the testbed's voltages and
/// rod motion, and its delivered force and its efficiency (from that force) are set beside the testbed's.
pub fn on_profile(
    testbed: &Testbed,
    surrogate: &Surrogate,
    alpha: f64,
    seconds: f64,
) -> Result<Errors> {
    let p = testbed.base();
    let emla = actuator(testbed, surrogate, Drive::Motion, alpha)?;
    let profile = motion_profile(testbed, seconds);
    let input = |k: usize| {
        let now = &profile[k];
        Input {
            v_d: now.row.v_d,
            v_q: now.row.v_q,
            x: now.x,
            x_dot: now.row.x_dot,
            F_hold: now.row.f_ext,
            ..Input::default()
        }
    };
    let mut state = emla.start(&input(0)).context("the start of the profile")?;
    let (mut force, mut ratio) = (Rms::default(), Rms::default());
    for (k, now) in profile.iter().enumerate().take(profile.len() - 1) {
        let y = emla.output(&state, &input(k));
        force.add(y.F - now.row.f_ext);
        let row = &now.row;
        if y.efficiency_valid && row.tau_e > 0.0 && row.x_dot.abs() > EFFICIENCY_SPEED {
            let electrical = y.P_copper + y.P_core + y.P_inverter;
            let hybrid = efficiency(y.tau_e * y.w_m, electrical, y.P_out);
            let copper = 1.5 * p.R_s * (row.i_d * row.i_d + row.i_q * row.i_q);
            let electrical = copper + now.electrical_losses;
            let truth = efficiency(row.tau_e * row.w_m, electrical, row.f_ext * row.x_dot);
            ratio.add(hybrid - truth);
        }
        let u = input(k);
        let acceleration = (input(k + 1).x_dot - u.x_dot) / H;
        let moved = |s: f64| Input {
            x: u.x + s * (u.x_dot + 0.5 * s * acceleration),
            x_dot: u.x_dot + s * acceleration,
            ..u
        };
        state = emla
            .step(&state, moved, f64::from(k as u32) * H, H)
            .context("the profile")?;
    }
    Ok(Errors {
        force: force.value(),
        efficiency: ratio.value(),
    })
}

/// Efficiency over load and speed in quadrant I: physics, hybrid at `alpha`, virtual testbed.
pub fn efficiency_maps(testbed: &Testbed, surrogate: &Surrogate, alpha: f64) -> Result<[Map; 3]> {
    let physics = actuator(testbed, surrogate, Drive::Motion, 0.0)?;
    let hybrid = actuator(testbed, surrogate, Drive::Motion, alpha)?;
    let x = 0.5 * testbed.base().L_s;
    let of = |emla: &Emla, load: f64, x_dot: f64| -> Result<f64> {
        let u = Input {
            x,
            x_dot,
            F_hold: load,
            ..Input::default()
        };
        let state = emla.start(&u).context("a steady point")?;
        Ok(emla.output(&state, &u).efficiency)
    };
    let truth = |load: f64, x_dot: f64| -> Result<f64> {
        let s = testbed.steady(x_dot, load);
        let copper = 1.5 * testbed.base().R_s * s.i[1] * s.i[1];
        let electrical = copper + testbed.electrical_losses(s.i, s.w_m);
        Ok(efficiency(
            testbed.torque(s.i) * s.w_m,
            electrical,
            load * x_dot,
        ))
    };
    let map = |title: String, value: &dyn Fn(f64, f64) -> Result<f64>| -> Result<Map> {
        let row = |i| {
            (0..MAP_CELLS[1]).map(move |j| {
                let (f, v) = cell_centre(i, j);
                value(f, v)
            })
        };
        let cells = (0..MAP_CELLS[0])
            .map(|i| row(i).collect())
            .collect::<Result<_>>()?;
        Ok(Map { title, cells })
    };
    Ok([
        map("Efficiency: physics".into(), &|f, v| of(&physics, f, v))?,
        map(format!("Efficiency: hybrid, alpha = {alpha}"), &|f, v| {
            of(&hybrid, f, v)
        })?,
        map("Efficiency: virtual testbed".into(), &truth)?,
    ])
}
