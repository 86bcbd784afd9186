//! A profile driven on the rig: the actuator as built against a load, its drive, and its sensors.

use anyhow::{Context as _, Result};
use rig::{Drive, Extras, Input, Output, Rig, State};
use sensors::{ForceKind, Params, Sensors};

use crate::profile::{Desired, Profile, SAMPLE};

/// Switching period of the drive, s: it controls at each.
const DT: f64 = 125e-6;
/// Bandwidths of speed and current control, rad/s, and of the speed's integral.
const W_SPEED: f64 = 150.0;
const W_INTEGRAL: f64 = 40.0;
const W_CURRENT: f64 = 1500.0;
/// Error of a temperature reading, K.
const THERMOMETER: f64 = 1.0;

/// One sample: what was asked for, what is, and what the sensors say.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// Desired values.
    pub desired: Desired,
    /// The rig itself; `F_mean` and the energies belong to the millisecond before.
    pub truth: Output,
    /// Commanded voltages, V.
    pub v: [f64; 2],
    /// The sensors' readings.
    pub measured: Reading,
}

/// Readings of the rig's sensors.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reading {
    /// Currents, A.
    pub i: [f64; 2],
    /// Motor angle, rad.
    pub theta_m: f64,
    /// Force on the load, N.
    pub F: f64,
    /// Rod position, m.
    pub x: f64,
    /// Temperatures of winding and housing, K.
    pub T: [f64; 2],
}

/// The rig of the reference machine as built.
///
/// # Errors
/// Never for the reference machine.
pub fn rig(drive: Drive) -> Result<Rig> {
    Rig::new(
        machine::Machine::reference().emla.lift,
        Extras::AS_BUILT,
        drive,
    )
    .context("the reference machine")
}

/// Sensors of a rig: those of the machine, and a rod encoder. Their fixed errors and noise come
/// from the seed.
pub fn sensors(seed: u64) -> Sensors {
    let mut p = Params {
        seed,
        ..Params::OFF
    };
    p.motor_encoder.on = true;
    p.rod_encoder.on = true;
    p.current.on = true;
    p.force.kind = ForceKind::Sensor;
    Sensors::new(p)
}

/// What the speed control of the rig's drive remembers: integrals of speed, N·m, and of the
/// currents, V.
#[derive(Clone, Copy, Debug, Default)]
struct Control {
    speed: f64,
    current: [f64; 2],
}

impl Control {
    /// Voltages for the speed `w`, rad/s, that changes at `w_dot`.
    /// ```text
    /// τ = J ẇ + K_w (w − w_m) + ∫,   i_q = τ/(3/2·p·λ_m),   v = K_c (i_r − i) + ∫ + back-EMF
    /// ```
    fn command(&mut self, rig: &Rig, s: &State, [w, w_dot]: [f64; 2]) -> [f64; 2] {
        let p = rig.params();
        let J = emla::maps::inertia(p, 1.0);
        let (per_ampere, pairs) = (1.5 * f64::from(p.p) * p.lambda_m, f64::from(p.p));
        let error = w - s.w_m;
        self.speed += DT * J * W_SPEED * W_INTEGRAL * error;
        let tau = J * (w_dot + W_SPEED * error) + self.speed;
        let required = [0.0, (tau / per_ampere).clamp(-p.i_max, p.i_max)];
        let (w_e, i) = (pairs * s.w_m, [s.i_d, s.i_q]);
        let emf = [-w_e * p.L_q * i[1], w_e * (p.L_d * i[0] + p.lambda_m)];
        std::array::from_fn(|k| {
            let off = required[k] - i[k];
            self.current[k] += DT * W_CURRENT * p.R_s * off;
            W_CURRENT * p.L_d * off + self.current[k] + emf[k]
        })
    }
}

/// Drive the profile; sensors with the seed `sensor_seed`.
///
/// # Errors
/// A step that the rig cannot make.
pub fn run(profile: &Profile, sensor_seed: u64) -> Result<Vec<Instant>> {
    let rig = rig(Drive::Force)?;
    let sensors = sensors(sensor_seed);
    let desired = profile.desired();
    let travel = emla::maps::travel_per_radian(rig.params());
    let v_dc = rig
        .params()
        .inverter
        .map_or(650.0, |inverter| inverter.v_dc);
    let mut u = Input {
        v_dc: Some(v_dc),
        T_ambient: rig.extras().temperature.reference,
        x: 0.5 * (crate::profile::STROKE[0] + crate::profile::STROKE[1]),
        F_ext: desired[0].load,
        F_hold: desired[0].load,
        ..Input::default()
    };
    let mut s = rig
        .start(&u, [profile.T; 2])
        .context("the start of a profile")?;
    let mut control = Control {
        speed: 1.5 * f64::from(rig.params().p) * rig.params().lambda_m * s.i_q,
        current: [0.0, rig.params().R_s * s.i_q],
    };
    let bias = thermometers(sensor_seed);
    let mut sampled = sensors.start(&sensed(&rig.output(&s, &u)));
    let mut instants = Vec::with_capacity(desired.len());
    for (k, now) in desired.iter().enumerate() {
        let next = desired.get(k + 1).unwrap_or(now);
        let slope = (next.x_dot - now.x_dot) / SAMPLE;
        let steps = (SAMPLE / DT).round() as u32;
        for j in 0..steps {
            let share = f64::from(j) / f64::from(steps);
            let x_dot = now.x_dot + share * SAMPLE * slope;
            let v = control.command(&rig, &s, [x_dot / travel, slope / travel]);
            [u.v_d, u.v_q] = v;
            u.F_ext = now.load + share * (next.load - now.load);
            let t = (k as f64 + share) * SAMPLE;
            s = rig.step(&s, &u, t, DT).context("a profile")?;
        }
        let truth = rig.output(&s, &u);
        let seen = sensed(&truth);
        let sample = sensors.measure(&sampled, &seen);
        let reading = *sensors.read(&sampled, &sample);
        sensors.advance(&mut sampled, &sample, SAMPLE);
        instants.push(Instant {
            desired: *next,
            truth,
            v: [u.v_d, u.v_q],
            measured: Reading {
                i: [reading.i_d[0], reading.i_q[0]],
                theta_m: reading.theta_m[0],
                F: reading.F[0],
                x: reading.x[0],
                T: [truth.T_winding + bias[0], truth.T_housing + bias[1]],
            },
        });
    }
    Ok(instants)
}

/// Errors of the two thermometers, K, fixed for a campaign's sensors.
fn thermometers(seed: u64) -> [f64; 2] {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    std::array::from_fn(|_| rng.random_range(-THERMOMETER..THERMOMETER))
}

/// What the sensors of the first axis look at.
fn sensed(y: &Output) -> sensors::Signals {
    let first = |value: f64| [value, 0.0, 0.0];
    sensors::Signals {
        theta_m: first(y.theta_m),
        w_m: first(y.w_m),
        i_d: first(y.i_d),
        i_q: first(y.i_q),
        F: first(y.F),
        x: first(y.x_rod),
        x_dot: first(y.x_rod_dot),
        ..sensors::Signals::default()
    }
}
