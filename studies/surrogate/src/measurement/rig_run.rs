//! Drives the rig along a profile: the actuator as built against a load, with its drive and its
//! sensors. For campaigns and judgement; the efficiency maps take the rig alone.

use anyhow::{Context as _, Result};
use rig::{Drive, Extras, Input, Output, Rig};
use sensors::{ForceKind, Params, Sensors};

use crate::measurement::drive_control::{DriveControl, MotorReference, torque_per_ampere};
use crate::measurement::profile::{Desired, MID_STROKE, Profile, SAMPLE};

/// Switching period of the drive, s, which is its sample time.
const DT: f64 = 125e-6;
/// Largest error of a thermometer, K.
const THERMOMETER_ERROR: f64 = 1.0;

/// One sample of a run: desired, true and measured values.
#[derive(Clone, Copy, Debug)]
pub struct RigSample {
    /// Desired values.
    pub desired: Desired,
    /// True values; `F_mean` and the energies are those of the millisecond before.
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

/// Sensors of a rig: those of the machine, and a rod encoder. The seed draws their fixed errors and
/// their noise.
fn sensors(seed: u64) -> Sensors {
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

/// Drives the rig along the profile; `sensor_seed` draws the sensors' errors.
pub fn run(profile: &Profile, sensor_seed: u64) -> Result<Vec<RigSample>> {
    let rig = rig(Drive::Force);
    let sensors = sensors(sensor_seed);
    let desired = profile.desired();
    let travel = emla::maps::travel_per_radian(rig.params());
    let p = rig.params();
    let mut u = Input {
        v_dc: Some(p.link_voltage()),
        T_ambient: rig.extras().temperature.reference,
        x: MID_STROKE,
        F_ext: desired[0].load,
        F_hold: desired[0].load,
        ..Input::default()
    };
    let mut s = rig
        .start(&u, [profile.T; 2])
        .context("the start of a profile")?;
    let holding_torque = torque_per_ampere(p) * s.i_q;
    let mut control = DriveControl::new(p, holding_torque, [0.0, s.i_q]);
    let bias = thermometer_errors(sensor_seed);
    let mut sensor_state = sensors.start(&sensor_signals(&rig.output(&s, &u)));
    let mut samples = Vec::with_capacity(desired.len());
    for (k, now) in desired.iter().enumerate() {
        let next = desired.get(k + 1).unwrap_or(now);
        let slope = (next.x_dot - now.x_dot) / SAMPLE;
        let steps = (SAMPLE / DT).round() as u32;
        for j in 0..steps {
            let share = f64::from(j) / f64::from(steps);
            let x_dot = now.x_dot + share * SAMPLE * slope;
            let reference = MotorReference {
                w: x_dot / travel,
                w_dot: slope / travel,
                tau: 0.0,
            };
            [u.v_d, u.v_q] = control.command(p, reference, [s.i_d, s.i_q], s.w_m, DT);
            u.F_ext = now.load + share * (next.load - now.load);
            let t = (k as f64 + share) * SAMPLE;
            s = rig.step(&s, &u, t, DT).context("a profile")?;
        }
        let truth = rig.output(&s, &u);
        let sample = sensors.measure(&sensor_state, &sensor_signals(&truth));
        let reading = *sensors.read(&sensor_state, &sample);
        sensors.advance(&mut sensor_state, &sample, SAMPLE);
        samples.push(RigSample {
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
    Ok(samples)
}

/// Constant errors of the two thermometers, K.
fn thermometer_errors(seed: u64) -> [f64; 2] {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    std::array::from_fn(|_| rng.random_range(-THERMOMETER_ERROR..THERMOMETER_ERROR))
}

/// The signals that the sensors of the first axis measure.
fn sensor_signals(y: &Output) -> sensors::Signals {
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
