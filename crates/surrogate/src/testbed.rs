//! The virtual testbed: a simulation of an actuator that is richer than the model under training.
//!
//! NOT measurements. It stands in for the paper's test campaign, whose data are not public. It
//! shares the base machine's parameters (`machine::Emla`) and adds what the actuator model leaves
//! out: Stribeck and preload friction of the screw, friction of the nut that grows with the load,
//! gear losses that depend on speed besides a no-load drag, bearing and windage losses of the motor,
//! rod seals, larger core and inverter losses, cogging. The constants are chosen to be ordinary for a
//! planetary gear and a ball screw of this size; they belong to no particular product.
//!
//! The drive is a 1-DoF rig: motor, gear, screw and rod against a load force `F_ext`, positive
//! against extension. A speed controller with an inner current controller moves it.

use machine::Emla;

/// What the testbed knows beyond the base machine.
#[derive(Clone, Copy, Debug)]
pub struct Extra {
    /// Stribeck part of the motor's bearing and seal friction, N·m, fading over `w_stribeck`, rad/s.
    pub tau_stribeck: f64,
    /// Speed over which it fades, rad/s.
    pub w_stribeck: f64,
    /// Windage, N·m·s²/rad².
    pub windage: f64,
    /// Gear drag without load, N·m at the motor, and its rise with speed, N·m·s/rad.
    pub gear_drag: [f64; 2],
    /// Share of the transmitted torque lost in the gear at high speed.
    pub gear_loss: f64,
    /// Additional share at low speed (boundary lubrication), fading over `w_gear`, rad/s.
    pub gear_loss_slow: f64,
    /// Motor speed over which it fades, rad/s.
    pub w_gear: f64,
    /// Drag of the preloaded nut at the screw, N·m, and its Stribeck part.
    pub screw_drag: [f64; 2],
    /// Share of the nut's force lost in rolling friction, and its Stribeck part.
    pub screw_loss: [f64; 2],
    /// Rod speed over which the screw's Stribeck parts fade, m/s.
    pub v_stribeck: f64,
    /// Friction of the rod seals, N.
    pub seal: f64,
    /// Motor speed over which friction changes sign, rad/s.
    pub w_sign: f64,
    /// Force over which load-dependent friction sets in, N.
    pub f_smooth: f64,
    /// Cogging torque amplitude, N·m, and periods per revolution.
    pub cogging: [f64; 2],
    /// Factor on the base machine's core losses.
    pub core: f64,
    /// Factor on the base machine's inverter losses.
    pub inverter: f64,
}

/// The testbed's constants.
pub const EXTRA: Extra = Extra {
    tau_stribeck: 0.22,
    w_stribeck: 14.0,
    windage: 4.0e-6,
    gear_drag: [0.14, 0.0012],
    gear_loss: 0.050,
    gear_loss_slow: 0.012,
    w_gear: 40.0,
    screw_drag: [0.5, 0.3],
    screw_loss: [0.026, 0.008],
    v_stribeck: 0.008,
    seal: 260.0,
    w_sign: 0.5,
    f_smooth: 900.0,
    cogging: [0.06, 24.0],
    core: 1.15,
    inverter: 1.10,
};

/// What happens on the rig at one instant; SI, dq quantities peak-valued.
#[derive(Clone, Copy, Debug, Default)]
pub struct State {
    /// Currents, A.
    pub i: [f64; 2],
    /// Motor angle, rad.
    pub theta_m: f64,
    /// Motor speed, rad/s.
    pub w_m: f64,
    /// Rod position, m.
    pub x: f64,
    /// Rod speed, m/s.
    pub x_dot: f64,
    /// Nut position ahead of the rod's, m.
    pub stretch: f64,
}

impl State {
    fn plus(self, dt: f64, rate: &Self) -> Self {
        Self {
            i: [self.i[0] + dt * rate.i[0], self.i[1] + dt * rate.i[1]],
            theta_m: self.theta_m + dt * rate.theta_m,
            w_m: self.w_m + dt * rate.w_m,
            x: self.x + dt * rate.x,
            x_dot: self.x_dot + dt * rate.x_dot,
            stretch: self.stretch + dt * rate.stretch,
        }
    }
}

/// The rig: base machine and what it knows beyond.
#[derive(Clone, Debug)]
pub struct Testbed {
    p: Emla,
    extra: Extra,
}

impl Testbed {
    /// A rig around the base machine `p`.
    #[must_use]
    pub fn new(p: Emla) -> Self {
        Self { p, extra: EXTRA }
    }

    /// Base machine.
    #[must_use]
    pub fn base(&self) -> &Emla {
        &self.p
    }

    /// Air-gap torque of currents `i`, N·m.
    #[must_use]
    pub fn torque(&self, i: [f64; 2]) -> f64 {
        emla::maps::torque(&self.p, i[0], i[1])
    }

    /// Motor torque that all friction and the nut's force `f_nut`, N, take at speed `w`, rad/s.
    #[must_use]
    pub fn load_torque(&self, f_nut: f64, w: f64) -> f64 {
        let (p, e) = (&self.p, &self.extra);
        let lead = emla::maps::lead(p);
        let (n, v) = (p.N_gear, (lead * w / p.N_gear).abs());
        let direction = (w / e.w_sign).tanh();
        let slow = (-(w / e.w_stribeck).powi(2)).exp();
        let creep = (-(v / e.v_stribeck).powi(2)).exp();
        let bearing = p.C_m * w + direction * (p.tau_C + e.tau_stribeck * slow + e.windage * w * w);
        // |F| with a round corner: F²/√(F² + F_0²).
        let size = |f: f64, f_0: f64| f * f / f.hypot(f_0);
        let rolling = (e.screw_loss[0] + e.screw_loss[1] * creep) * lead * size(f_nut, e.f_smooth);
        let preload = e.screw_drag[0] + e.screw_drag[1] * creep;
        let screw = lead * f_nut + p.C_s * w / n + direction * (rolling + preload);
        let share = e.gear_loss + e.gear_loss_slow * (-w.abs() / e.w_gear).exp();
        let mesh = share * size(screw, lead * e.f_smooth) / n;
        let gear = direction * (mesh + e.gear_drag[0] + e.gear_drag[1] * w.abs());
        bearing + screw / n + gear
    }

    /// Losses outside torque and copper: core and inverter, W.
    #[must_use]
    pub fn electrical_losses(&self, i: [f64; 2], w_m: f64) -> f64 {
        let (p, e) = (&self.p, &self.extra);
        let size = i[0].hypot(i[1]);
        let flux = [p.L_d * i[0] + p.lambda_m, p.L_q * i[1]];
        let w_e = f64::from(p.p) * w_m.abs();
        let core = p.core.map_or(0.0, |c| {
            (c.k_h + c.k_e * w_e) * w_e * (flux[0] * flux[0] + flux[1] * flux[1])
        });
        let inverter = p.inverter.map_or(0.0, |c| {
            let per_ampere = std::f64::consts::FRAC_2_PI * (c.v_0 + c.f_sw * c.k_sw * c.v_dc);
            3.0 * size * (per_ampere + 0.5 * c.r_0 * size)
        });
        e.core * core + e.inverter * inverter
    }

    /// Inertia of motor, gear and screw at the motor, kg·m².
    #[must_use]
    pub fn inertia(&self) -> f64 {
        self.p.J_m + self.p.J_s / (self.p.N_gear * self.p.N_gear)
    }

    /// Force of nut on rod, N, and the rate of their distance, m/s.
    fn spring(&self, s: &State) -> (f64, f64) {
        let stretch_dot = emla::maps::travel_per_radian(&self.p) * s.w_m - s.x_dot;
        let k_b = emla::maps::stiffness(&self.p, s.x);
        (k_b * s.stretch + self.p.C_b * stretch_dot, stretch_dot)
    }

    fn rate(&self, s: &State, v: [f64; 2], f_ext: f64) -> State {
        let (p, e) = (&self.p, &self.extra);
        let w_e = f64::from(p.p) * s.w_m;
        let flux = [p.L_d * s.i[0] + p.lambda_m, p.L_q * s.i[1]];
        let (spring, stretch_dot) = self.spring(s);
        let cogging = e.cogging[0] * (e.cogging[1] * s.theta_m).sin();
        let drive = self.torque(s.i) + cogging - self.load_torque(spring, s.w_m);
        let seal = e.seal * (s.x_dot / (e.w_sign * emla::maps::travel_per_radian(p))).tanh();
        State {
            i: [
                (v[0] - p.R_s * s.i[0] + w_e * flux[1]) / p.L_d,
                (v[1] - p.R_s * s.i[1] - w_e * flux[0]) / p.L_q,
            ],
            theta_m: s.w_m,
            w_m: drive / self.inertia(),
            x: s.x_dot,
            x_dot: (spring - seal - p.C_act * s.x_dot - f_ext) / p.M_act,
            stretch: stretch_dot,
        }
    }

    /// One classical Runge–Kutta step of `dt` under held voltages and load.
    #[must_use]
    pub fn step(&self, s: &State, v: [f64; 2], f_ext: f64, dt: f64) -> State {
        let a = self.rate(s, v, f_ext);
        let b = self.rate(&s.plus(0.5 * dt, &a), v, f_ext);
        let c = self.rate(&s.plus(0.5 * dt, &b), v, f_ext);
        let d = self.rate(&s.plus(dt, &c), v, f_ext);
        s.plus(dt / 6.0, &a)
            .plus(dt / 3.0, &b)
            .plus(dt / 3.0, &c)
            .plus(dt / 6.0, &d)
    }

    /// Steady motion at rod speed `x_dot`, m/s, against `f_ext`, N, cogging aside.
    #[must_use]
    pub fn steady(&self, x_dot: f64, f_ext: f64) -> State {
        let travel = emla::maps::travel_per_radian(&self.p);
        let w_m = x_dot / travel;
        let seal = self.extra.seal * (w_m / self.extra.w_sign).tanh();
        let f_nut = f_ext + seal + self.p.C_act * x_dot;
        let x = 0.5 * self.p.L_s;
        let torque = self.load_torque(f_nut, w_m);
        State {
            i: [0.0, torque / (1.5 * f64::from(self.p.p) * self.p.lambda_m)],
            theta_m: 0.0,
            w_m,
            x,
            x_dot,
            stretch: f_nut / emla::maps::stiffness(&self.p, x),
        }
    }
}

/// Speed control of the rig: proportional–integral on the motor's speed, and on the currents.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    /// Integral part of the torque-producing current, A.
    i_q_integral: f64,
    /// Integral parts of the voltages, V.
    v_integral: [f64; 2],
}

/// Bandwidth of the current loop, rad/s.
const CURRENT_BANDWIDTH: f64 = 1500.0;
/// Bandwidth of the speed loop, rad/s, and of its integral part.
const SPEED_BANDWIDTH: [f64; 2] = [120.0, 30.0];

impl Drive {
    /// A drive already holding the steady state `s`.
    #[must_use]
    pub fn steady(s: &State, p: &Emla) -> Self {
        Self {
            i_q_integral: s.i[1],
            v_integral: [0.0, p.R_s * s.i[1]],
        }
    }

    /// Voltages for the commanded motor speed and acceleration, held for `dt`.
    pub fn command(
        &mut self,
        s: &State,
        p: &Emla,
        w_ref: f64,
        w_ref_dot: f64,
        dt: f64,
    ) -> [f64; 2] {
        let torque_per_ampere = 1.5 * f64::from(p.p) * p.lambda_m;
        let gain = SPEED_BANDWIDTH[0] * p.J_m / torque_per_ampere;
        let error = w_ref - s.w_m;
        self.i_q_integral += gain * SPEED_BANDWIDTH[1] * error * dt;
        let i_q = self.i_q_integral + gain * error + p.J_m * w_ref_dot / torque_per_ampere;
        let error = [-s.i[0], i_q - s.i[1]];
        let inductance = [p.L_d, p.L_q];
        let w_e = f64::from(p.p) * s.w_m;
        let decoupling = [-w_e * p.L_q * s.i[1], w_e * (p.L_d * s.i[0] + p.lambda_m)];
        std::array::from_fn(|k| {
            self.v_integral[k] += CURRENT_BANDWIDTH * p.R_s * error[k] * dt;
            self.v_integral[k] + CURRENT_BANDWIDTH * inductance[k] * error[k] + decoupling[k]
        })
    }
}
