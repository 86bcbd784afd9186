//! A profile driven on the rig: the actuator as built against a load, its drive, and its sensors.

use anyhow::{Context as _, Result};
use rig::{Drive, Extras, Input, Output, Rig};
use sensors::{ForceKind, Params, Sensors};

use crate::measurement::drive_control::{DriveControl, MotorReference, torque_per_ampere};
use crate::measurement::profile::{Desired, Profile, SAMPLE};

/// Switching period of the drive, s: it controls at each.
const DT: f64 = 125e-6;
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
pub fn rig(drive: Drive) -> Rig {
    let p = machine_file::Machine::reference().emla.lift;
    Rig::new(p, Extras::AS_BUILT, drive).expect("a valid machine")
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

/// Drive the profile; sensors with the seed `sensor_seed`.
pub fn run(profile: &Profile, sensor_seed: u64) -> Result<Vec<Instant>> {
    let rig = rig(Drive::Force);
    let sensors = sensors(sensor_seed);
    let desired = profile.desired();
    let travel = emla::maps::travel_per_radian(rig.params());
    let p = rig.params();
    let mut u = Input {
        v_dc: Some(p.link_voltage()),
        T_ambient: rig.extras().temperature.reference,
        x: 0.5 * (crate::measurement::profile::STROKE[0] + crate::measurement::profile::STROKE[1]),
        F_ext: desired[0].load,
        F_hold: desired[0].load,
        ..Input::default()
    };
    let mut s = rig
        .start(&u, [profile.T; 2])
        .context("the start of a profile")?;
    let held = torque_per_ampere(p) * s.i_q;
    let mut control = DriveControl::holding(p, held, [0.0, s.i_q]);
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
            let wanted = MotorReference {
                w: x_dot / travel,
                w_dot: slope / travel,
                tau: 0.0,
            };
            [u.v_d, u.v_q] = control.command(p, wanted, [s.i_d, s.i_q], s.w_m, DT);
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
