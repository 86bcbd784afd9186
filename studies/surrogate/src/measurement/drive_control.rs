//! The control of a rig's drive: a cascade of the motor's speed and the currents. Used by the rig's
//! profiles and by the load emulator of the testbed.
//! ```text
//! τ = τ_load + J (ẇ + K_w (w − w_m)) + ∫,   i_q = τ/(3/2·p·λ_m),   v = K_c (i_r − i) + ∫ + back-EMF
//! ```

use emla::maps;
use machine_file::Emla;

// Bandwidths, rad/s: K_w of the speed control, its integral, and K_c/R_s of the current control.
const W_SPEED: f64 = 150.0;
const W_INTEGRAL: f64 = 40.0;
const W_CURRENT: f64 = 1500.0;

/// State of the control: the integrals of speed, N·m, and of the currents, V.
#[derive(Clone, Copy, Debug, Default)]
pub struct DriveControl {
    speed: f64,
    current: [f64; 2],
}

/// Reference of the motor's motion.
#[derive(Clone, Copy, Debug)]
pub struct MotorReference {
    /// Speed, rad/s.
    pub w: f64,
    /// Acceleration, rad/s².
    pub w_dot: f64,
    /// Feedforward torque of the load, N·m.
    pub tau: f64,
}

impl DriveControl {
    /// A drive that starts with the torque `tau`, N·m, in addition to the feedforward, and with the
    /// currents `i`, A.
    pub fn new(p: &Emla, tau: f64, i: [f64; 2]) -> Self {
        Self {
            speed: tau,
            current: i.map(|i| p.R_s * i),
        }
    }

    /// Voltages for the next `h` s, V, at the currents `i`, A, and the motor speed `w_m`, rad/s.
    pub fn command(
        &mut self,
        p: &Emla,
        reference: MotorReference,
        i: [f64; 2],
        w_m: f64,
        h: f64,
    ) -> [f64; 2] {
        let (J, error) = (maps::inertia(p, 1.0), reference.w - w_m);
        self.speed += h * J * W_SPEED * W_INTEGRAL * error;
        let tau = reference.tau + J * (reference.w_dot + W_SPEED * error) + self.speed;
        let i_q = (tau / torque_per_ampere(p)).clamp(-p.i_max, p.i_max);
        let w_e = f64::from(p.p) * w_m;
        let emf = [-w_e * p.L_q * i[1], w_e * (p.L_d * i[0] + p.lambda_m)];
        let required = [0.0, i_q];
        std::array::from_fn(|k| {
            let error = required[k] - i[k];
            self.current[k] += h * W_CURRENT * p.R_s * error;
            W_CURRENT * p.L_d * error + self.current[k] + emf[k]
        })
    }
}

/// Torque per ampere of the quadrature current, with no current in the direct axis, N·m/A.
pub fn torque_per_ampere(p: &Emla) -> f64 {
    1.5 * f64::from(p.p) * p.lambda_m
}
