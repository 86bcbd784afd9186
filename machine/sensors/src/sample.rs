//! Takes one sample of all sensors and advances their state, for the FMU and the study `surrogate`.

use crate::current::Errors;
use crate::random::Source;
use crate::speed::Track;
use crate::{
    ACTUATORS, DELAY_MAX, JOINTS, Noise, Sensors, SpeedKind, W_M_MAX, X_DOT_MAX, ZETA_DOT_MAX,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Signals of the manipulator: the true values, or the readings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Signals {
    /// Joint angles, rad.
    pub zeta: [f64; JOINTS],
    /// Joint rates, rad/s; the true ones are used with ideal speeds only.
    pub zeta_dot: [f64; JOINTS],
    /// Motor angles, rad.
    pub theta_m: [f64; ACTUATORS],
    /// Motor speeds, rad/s; the true ones are used with ideal speeds only.
    pub w_m: [f64; ACTUATORS],
    /// Direct-axis currents, A.
    pub i_d: [f64; ACTUATORS],
    /// Quadrature-axis currents, A.
    pub i_q: [f64; ACTUATORS],
    /// Rod forces, N.
    pub F: [f64; ACTUATORS],
    /// Rod positions, m.
    pub x: [f64; ACTUATORS],
    /// Rod velocities, m/s; the true ones are used with ideal speeds only.
    pub x_dot: [f64; ACTUATORS],
}

/// States of filters, observers and hysteresis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Memory {
    joint: [Track; JOINTS],
    motor: [Track; ACTUATORS],
    rod: [Track; ACTUATORS],
    force: [f64; ACTUATORS],
    /// Outputs of the load cells' hysteresis, N.
    shown: [f64; ACTUATORS],
}

/// One sample: readings, and the new states of filters and observers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    output: Signals,
    memory: Memory,
}

/// Everything that changes from sample to sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    memory: Memory,
    /// Time from the last sample to the next one, s; `None` before the first step.
    period: Option<f64>,
    /// Noise of the next sample.
    noise: Noise,
    source: Source,
    /// Readings of the samples taken, the latest first.
    past: [Signals; 1 + DELAY_MAX as usize],
}

impl Sensors {
    /// The start state: all previous readings are those of these inputs, at rest.
    pub fn start(&self, u: &Signals) -> State {
        let mut source = Source::new(self.p.seed);
        let noise = self.noise(&mut source);
        let mut state = State {
            memory: Memory::default(),
            period: None,
            noise,
            source,
            past: [Signals::default(); 1 + DELAY_MAX as usize],
        };
        let first = self.measure(&state, u);
        state.memory = first.memory;
        state.past.fill(first.output);
        state
    }

    fn noise(&self, source: &mut Source) -> Noise {
        if self.p.is_noisy() {
            source.next()
        } else {
            Noise::default()
        }
    }

    /// The sample for these inputs.
    pub fn measure(&self, s: &State, u: &Signals) -> Sample {
        let mut now = Sample {
            output: Signals::default(),
            memory: s.memory,
        };
        self.joints(s, u, &mut now);
        (0..ACTUATORS).for_each(|k| self.actuator(s, u, k, &mut now));
        now
    }

    fn joints(&self, s: &State, u: &Signals, now: &mut Sample) {
        let p = &self.p;
        for k in 0..JOINTS {
            let zero = p.joint_zero.given[k] + p.joint_zero.bound * self.drawn.zero[k];
            let angle = if p.joint_zero.on {
                u.zeta[k] + zero
            } else {
                u.zeta[k]
            };
            let read = p.joint_encoder.read(angle, TAU, s.noise.joint[k]);
            let track = p.speed.follow(&s.memory.joint[k], read, s.period);
            now.memory.joint[k] = track;
            now.output.zeta[k] = read;
            now.output.zeta_dot[k] = self.speed(&track, u.zeta_dot[k], ZETA_DOT_MAX);
        }
    }

    fn actuator(&self, s: &State, u: &Signals, k: usize, now: &mut Sample) {
        let (p, drawn, noise) = (&self.p, &self.drawn, &s.noise);
        let (y, memory) = (&mut now.output, &mut now.memory);

        y.theta_m[k] = p.motor_encoder.read(u.theta_m[k], TAU, noise.motor[k]);
        memory.motor[k] = (p.speed.for_motors()).follow(&s.memory.motor[k], y.theta_m[k], s.period);
        y.w_m[k] = self.speed(&memory.motor[k], u.w_m[k], W_M_MAX);

        y.x[k] = p.rod_encoder.read(u.x[k], 1.0, noise.rod[k]);
        memory.rod[k] = p.speed.follow(&s.memory.rod[k], y.x[k], s.period);
        y.x_dot[k] = self.speed(&memory.rod[k], u.x_dot[k], X_DOT_MAX);

        let errors = Errors {
            gain: drawn.gain[k],
            offset: drawn.offset[k],
            noise: noise.current[k],
        };
        let currents = [u.i_d[k], u.i_q[k]];
        [y.i_d[k], y.i_q[k]] = p
            .current
            .read(currents, u.theta_m[k], y.theta_m[k], &errors);

        memory.force[k] = p.force.lag(s.memory.force[k], u.F[k], s.period);
        let is_first = s.period.is_none();
        memory.shown[k] = p
            .force
            .hysteresis(s.memory.shown[k], memory.force[k], is_first);
        let errors = [drawn.force_gain[k], drawn.bias[k]];
        y.F[k] = (p.force).read(memory.shown[k], errors, noise.force[k], y.i_q[k]);
    }

    /// The ideal speed, or the estimate within what the sensor can tell.
    fn speed(&self, track: &Track, ideal: f64, most: f64) -> f64 {
        match self.p.speed.kind {
            SpeedKind::Ideal => ideal,
            SpeedKind::Difference | SpeedKind::Observer => track.speed.clamp(-most, most),
        }
    }

    /// The readings at an instant whose sample is `now`: with a delay, those of an earlier sample.
    pub fn read<'a>(&self, s: &'a State, now: &'a Sample) -> &'a Signals {
        match self.p.delay {
            0 => &now.output,
            late => &s.past[late as usize - 1],
        }
    }

    /// The readings after a step, before new inputs are set: one sample older.
    pub fn held<'a>(&self, s: &'a State) -> &'a Signals {
        &s.past[self.p.delay as usize]
    }

    /// Stores the sample `now` and draws the noise of the next one, `h` s later.
    pub fn advance(&self, s: &mut State, now: &Sample, h: f64) {
        s.memory = now.memory;
        s.period = Some(h);
        s.past.rotate_right(1);
        s.past[0] = now.output;
        s.noise = self.noise(&mut s.source);
    }
}

impl Sample {
    /// Whether all readings and states are finite.
    pub fn is_finite(&self) -> bool {
        let Signals {
            zeta,
            zeta_dot,
            theta_m,
            w_m,
            i_d,
            i_q,
            F,
            x,
            x_dot,
        } = &self.output;
        let joints = zeta.iter().chain(zeta_dot);
        let motors = [theta_m, w_m, i_d, i_q, F, x, x_dot];
        let memory = &self.memory;
        let tracks = (memory.joint.iter())
            .chain(&memory.motor)
            .chain(&memory.rod);
        joints
            .chain(motors.into_iter().flatten())
            .chain(&memory.force)
            .all(|v| v.is_finite())
            && tracks.into_iter().all(|t| {
                [t.position, t.speed, t.acceleration]
                    .iter()
                    .all(|v| v.is_finite())
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Params;

    /// A position that jumps to its bound within a step of 1 ms, as a faulty encoder's does: 100 rad are
    /// 10⁵ rad/s, and 10 m are 10⁴ m/s.
    #[test]
    fn an_estimated_speed_stays_within_what_the_sensor_can_tell() {
        let mut p = Params::OFF;
        p.speed.kind = SpeedKind::Difference;
        p.speed.filter_time = 0.0;
        let sensors = Sensors::new(p);
        let still = Signals::default();
        let mut state = sensors.start(&still);
        let sample = sensors.measure(&state, &still);
        sensors.advance(&mut state, &sample, 1e-3);
        let jump = Signals {
            zeta: [100.0; JOINTS],
            theta_m: [-1e8; ACTUATORS],
            x: [10.0; ACTUATORS],
            ..still
        };
        let read = sensors.measure(&state, &jump).output;
        assert_eq!(read.zeta_dot, [ZETA_DOT_MAX; JOINTS]);
        assert_eq!(read.w_m, [-W_M_MAX; ACTUATORS]);
        assert_eq!(read.x_dot, [X_DOT_MAX; ACTUATORS]);
    }
}
