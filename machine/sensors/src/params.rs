//! Parameters of the sensors, set by the FMU `Sensors` and the study `surrogate`.

use serde::{Deserialize, Serialize};

/// Number of joints.
pub const JOINTS: usize = 6;
/// Number of actuators.
pub const ACTUATORS: usize = 3;
/// Largest delay of a reading, communication steps.
pub const DELAY_MAX: u32 = 4;
/// Largest estimated speeds of joints, rad/s, motors, rad/s, and rods, m/s: those that ideal ones may
/// have. An estimate jumps beyond them where a position does.
pub const ZETA_DOT_MAX: f64 = 1e4;
/// See [`ZETA_DOT_MAX`].
pub const W_M_MAX: f64 = 1e6;
/// See [`ZETA_DOT_MAX`].
pub const X_DOT_MAX: f64 = 100.0;

/// All parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Params {
    /// Seed of noise and constant errors.
    pub seed: u64,
    /// Delay from measurement to reading, communication steps.
    pub delay: u32,
    /// Encoders of the motors; counts per turn.
    pub motor_encoder: Encoder,
    /// Encoders of the joints; counts per turn.
    pub joint_encoder: Encoder,
    /// Encoders of the rods; counts per metre.
    pub rod_encoder: Encoder,
    /// Zero errors of the joints' encoders.
    pub joint_zero: JointZero,
    /// Source of the speeds.
    pub speed: Speed,
    /// Current sensors.
    pub current: Current,
    /// Force sensors.
    pub force: Force,
}

/// An encoder.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Encoder {
    /// Whether it quantises; otherwise the position passes unchanged.
    pub on: bool,
    /// Counts per turn are 2^bits, of a rod counts per metre.
    pub bits: i32,
    /// Standard deviation of the noise before rounding, counts.
    pub noise: f64,
}

/// Zero errors of the joints' encoders.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointZero {
    /// Whether there are zero errors.
    pub on: bool,
    /// They are drawn uniformly from −bound to bound, rad.
    pub bound: f64,
    /// Constant errors, added to the drawn ones, rad.
    pub given: [f64; JOINTS],
}

/// Source of the speeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Speed {
    /// The method.
    pub kind: SpeedKind,
    /// Time constant of the filter after the difference, s; 0: none.
    pub filter_time: f64,
    /// Bandwidth of the tracking observer, rad/s.
    pub bandwidth: f64,
    /// Bandwidth at the motors, whose loop is faster, rad/s; 0: `bandwidth`.
    pub bandwidth_motor: f64,
}

impl Speed {
    /// The same with the bandwidth of the motors.
    pub(crate) fn for_motors(self) -> Self {
        match self.bandwidth_motor {
            0.0 => self,
            bandwidth => Self { bandwidth, ..self },
        }
    }
}

/// Method by which speeds are obtained.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SpeedKind {
    /// The true speeds pass.
    Ideal,
    /// Difference of two position readings over the step, and a first-order filter.
    Difference,
    /// Tracking observer of third order on the position readings.
    Observer,
}

/// Current sensors, in two phases of each motor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Current {
    /// Whether they have errors; otherwise the currents pass unchanged.
    pub on: bool,
    /// Relative gain errors are drawn uniformly from −gain to gain.
    pub gain: f64,
    /// Offsets are drawn uniformly from −offset to offset, A.
    pub offset: f64,
    /// Standard deviation of the noise, A.
    pub noise: f64,
    /// Bits of the converter over its whole range.
    pub bits: i32,
    /// The converter goes from −range to range, A, and saturates there.
    pub range: f64,
    /// Pole pairs of the motors.
    pub pole_pairs: i32,
}

/// Force sensors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Force {
    /// Source of the force.
    pub kind: ForceKind,
    /// Biases are drawn uniformly from −bias to bias, N.
    pub bias: f64,
    /// Relative gain errors are drawn uniformly from −gain to gain.
    pub gain: f64,
    /// Width of the loop between rising and falling force, N.
    pub hysteresis: f64,
    /// Standard deviation of the noise, N.
    pub noise: f64,
    /// Bandwidth of the first-order lag, Hz.
    pub bandwidth: f64,
    /// Force per measured quadrature current where the sensor is absent, N/A.
    pub per_current: f64,
}

/// Source of a rod force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ForceKind {
    /// The true force passes.
    Ideal,
    /// A sensor with bias, noise and bandwidth.
    Sensor,
    /// No sensor: the reading is the quadrature current times `per_current`, the force without
    /// acceleration and friction.
    Absent,
}

impl Params {
    /// Every effect off, but with typical values, so that a switch is enough to turn it on.
    ///
    /// Encoders of 17 bits (motor, one count of noise) and 19 bits (joint), as servo drives and
    /// absolute rotary encoders have; zero of a joint calibrated to 0.02°; closed-loop current
    /// transducers with 0.3 % of gain, 0.1 A of offset and 0.05 A of noise before a 12-bit
    /// converter over ±150 A; load cell of 70 kN with 0.5 % of bias, 0.1 % of noise and 1 kHz
    /// bandwidth.
    pub const OFF: Self = Self {
        seed: 0,
        delay: 0,
        motor_encoder: Encoder {
            on: false,
            bits: 17,
            noise: 1.0,
        },
        joint_encoder: Encoder {
            on: false,
            bits: 19,
            noise: 0.0,
        },
        rod_encoder: Encoder {
            on: false,
            bits: 20,
            noise: 0.0,
        },
        joint_zero: JointZero {
            on: false,
            bound: 0.02 * std::f64::consts::PI / 180.0,
            given: [0.0; JOINTS],
        },
        speed: Speed {
            kind: SpeedKind::Ideal,
            filter_time: 0.005,
            bandwidth: 300.0,
            bandwidth_motor: 0.0,
        },
        current: Current {
            on: false,
            gain: 0.003,
            offset: 0.1,
            noise: 0.05,
            bits: 12,
            range: 150.0,
            pole_pairs: 4,
        },
        force: Force {
            kind: ForceKind::Ideal,
            bias: 350.0,
            gain: 0.0,
            hysteresis: 0.0,
            noise: 70.0,
            bandwidth: 1000.0,
            per_current: PER_CURRENT,
        },
    };

    pub(crate) fn is_noisy(&self) -> bool {
        let counts = |e: &Encoder| e.on && e.noise > 0.0;
        counts(&self.motor_encoder)
            || counts(&self.joint_encoder)
            || counts(&self.rod_encoder)
            || self.current.on
            || self.force.kind == ForceKind::Sensor
    }
}

/// Force per quadrature current of the reference actuator without losses, N/A: `3/2·p·λ_m·2πN/ρ`
/// with p = 4, λ_m = 0.19 Wb, N = 6, ρ = 0.016 m.
const PER_CURRENT: f64 = 1.5 * 4.0 * 0.19 * std::f64::consts::TAU * 6.0 / 0.016;
