//! Derivatives of outputs and rates with respect to time, state and inputs, from which the FMU
//! `Emla` answers FMI's calls for output derivatives and directional derivatives.

use crate::actuator::Emla;
use crate::conditions::Conditions;
use crate::dynamics::power_in;
use crate::efficiency::{Efficiency, Powers};
use crate::instant::Instant;
use crate::losses::{Losses, core_loss, inverter_loss};
use crate::output::Output;
use crate::state::{Balance, LossKinds, State};
use crate::{maps, motor};
use machine_file::{ActuatorInput as Input, BrakeState, Dq, Drive, link_current};

/// Derivatives of those members of [`Instant`] that the outputs need.
struct InstantTangent {
    v: Dq,
    v_dc: f64,
    R_s: f64,
    residual: f64,
    i: Dq,
    lambda: Dq,
    w_m: f64,
    tau_e: f64,
    x: f64,
    x_dot: f64,
    stretch: f64,
    stretch_dot: f64,
    F: f64,
    tau_load: f64,
    k: f64,
    w_m_dot: f64,
}

impl Emla {
    /// First time derivatives of the outputs. `u_dot` are those of the inputs, except the rod's
    /// position, whose derivative is always its velocity. Means and the network's residual are
    /// constant within a step.
    #[must_use]
    pub fn output_dot(&self, s: &State, u: &Input, u_dot: &Input) -> Output {
        let u_dot = Input {
            x: u.x_dot,
            ..*u_dot
        };
        let p = self.at_temperature(&s.thermal);
        let held = self.conditions(&p, s, u);
        self.output_tangent(s, u, &self.derivative_with(s, u, &held), &u_dot)
    }

    /// Derivative of the outputs along the direction `du` of the inputs, at fixed state.
    #[must_use]
    pub fn output_along(&self, s: &State, u: &Input, du: &Input) -> Output {
        self.output_tangent(s, u, &State::default(), du)
    }

    /// Derivative of [`Emla::derivative`] along the directions `ds` of the state and `du` of the
    /// inputs; the network's residual by finite differences.
    #[must_use]
    pub fn derivative_along(
        &self,
        s: &State,
        u: &Input,
        slip: f64,
        (ds, du): (&State, &Input),
    ) -> State {
        let p = &*self.at_temperature(&s.thermal);
        let held = &self.instant_conditions(p, s, u, slip);
        let now = self.instant(&s.point(), u, held);
        let by = self.residual_slopes(now.tau_e, now.w_m);
        let d = self.instant_tangent(s, u, (&now, held), ds, du, by);
        let dl = losses_tangent(&now, held, &d);
        let force = d.F - du.F_ext;
        let free = self.drive == Drive::Force;
        let (x, x_dot) = if free {
            (ds.x_dot, force / p.M_act)
        } else {
            (0.0, 0.0)
        };
        let w_e = f64::from(p.p) * d.w_m;
        let i = Dq {
            d: d.v.d - p.R_s * d.i.d - d.R_s * now.i.d + w_e * now.lambda.q + now.w_e * d.lambda.q,
            q: d.v.q - p.R_s * d.i.q - d.R_s * now.i.q - w_e * now.lambda.d - now.w_e * d.lambda.d,
        };
        let gates = if held.gates { 1.0 } else { 0.0 };
        let kinds = LossKinds {
            copper: dl.copper,
            inverter: dl.inverter,
        };
        let is_counted = self.electric.heat || !held.is_plain();
        let heated = State {
            thermal: ds.thermal,
            ..*s
        };
        let thermal = self.thermal_rates(&heated, du, dl.total(), &kinds);
        State {
            i_d: gates * i.d / p.L_d,
            i_q: gates * i.q / p.L_q,
            theta_m: ds.w_m,
            w_m: d.w_m_dot,
            x,
            x_dot,
            energy: Balance {
                supplied: power_in_tangent(&now, &d, &dl),
                delivered: self.power_out_tangent(&now, &d, u, du),
                lost: dl.total(),
            },
            kinds: if is_counted {
                kinds
            } else {
                LossKinds::default()
            },
            thermal,
            ..State::default()
        }
    }

    fn power_out_tangent(&self, now: &Instant, d: &InstantTangent, u: &Input, du: &Input) -> f64 {
        match self.drive {
            Drive::Motion => d.F * now.x_dot + now.F * d.x_dot,
            Drive::Force => du.F_ext * now.x_dot + u.F_ext * d.x_dot,
        }
    }

    /// Derivatives of `α·dF` by torque, 1/m, and motor speed, N·s/rad.
    fn residual_slopes(&self, tau_e: f64, w_m: f64) -> [f64; 2] {
        if self.alpha == 0.0 {
            return [0.0; 2];
        }
        // The network is smooth over some N·m and rad/s; half of the digits remain.
        const H: f64 = 1e-4;
        let dF = |tau, w| self.alpha * self.residual(tau, w).dF;
        [
            (dF(tau_e + H, w_m) - dF(tau_e - H, w_m)) / (2.0 * H),
            (dF(tau_e, w_m + H) - dF(tau_e, w_m - H)) / (2.0 * H),
        ]
    }

    /// Derivatives of the outputs along `ds` and `du`, with the residual held.
    #[must_use]
    pub fn output_tangent(&self, s: &State, u: &Input, ds: &State, du: &Input) -> Output {
        let p = &*self.at_temperature(&s.thermal);
        let held = self.conditions(p, s, u);
        let now = self.instant(&s.point(), u, &held);
        let losses = self.losses(&now, &held);
        let d = self.instant_tangent(s, u, (&now, &held), ds, du, [0.0; 2]);
        let dl = losses_tangent(&now, &held, &d);
        let (by_tau, by_w) = maps::quasi_static_slopes(p, now.tau_e, now.w_m);
        let F_phys = by_tau * d.tau_e + by_w * d.w_m;
        let P_in = power_in_tangent(&now, &d, &dl);
        let P_out = self.power_out_tangent(&now, &d, u, du);
        let electrical = (losses.electrical(), dl.electrical());
        let (force, speed) = (maps::quasi_static_force(p, now.tau_e, now.w_m), now.x_n_dot);
        let out = (
            force * speed,
            F_phys * speed + force * maps::travel_per_radian(p) * d.w_m,
        );
        let efficiency_phys = efficiency_tangent(&now, &d, electrical, out);
        let net = (s.residual.F_net * s.residual.x_dot_net, 0.0);
        let efficiency_net = efficiency_tangent(&now, &d, electrical, net);
        Output {
            F: d.F + s.lead * (now.K_b * d.stretch_dot + now.K_b_slope * d.x * now.stretch_dot),
            F_phys,
            F_hyb: F_phys,
            x_rod: d.x,
            x_rod_dot: d.x_dot,
            x_free: ds.x,
            x_free_dot: ds.x_dot,
            x_dot_hyb: self.blend(maps::travel_per_radian(p) * d.w_m, 0.0),
            i_d: d.i.d,
            i_q: d.i.q,
            theta_m: ds.theta_m,
            w_m: d.w_m,
            tau_e: d.tau_e,
            P_in,
            i_dc: current_tangent(power_in(&now, &losses), held.v_dc, P_in, d.v_dc),
            P_out,
            P_loss: dl.total(),
            P_copper: dl.copper,
            P_core: dl.core,
            P_inverter: dl.inverter,
            P_mech: dl.mechanical(),
            E_in: ds.energy.supplied,
            E_out: ds.energy.delivered,
            E_loss: ds.energy.lost,
            E_stored: self.stored_tangent(&now, &d),
            P_heat: self.heat_flow(&ds.thermal, du.T_ambient),
            E_inverter: ds.kinds.inverter,
            E_heat: ds.thermal.given,
            E_thermal: self.heat_rise(ds.thermal.T_winding, ds.thermal.T_housing),
            T_winding: ds.thermal.T_winding,
            T_housing: ds.thermal.T_housing,
            efficiency: self.blend(efficiency_phys, efficiency_net),
            efficiency_phys,
            efficiency_net,
            efficiency_interval: match self.bound {
                Some(_) => [efficiency_net; 2],
                None => [0.0; 2],
            },
            // Means and energies up to the last step are constant.
            ..Output::default()
        }
    }

    fn instant_tangent(
        &self,
        s: &State,
        u: &Input,
        (now, held): (&Instant, &Conditions),
        ds: &State,
        du: &Input,
        residual_by: [f64; 2],
    ) -> InstantTangent {
        let p = held.p;
        let (R_s, lambda_m) = self.temperature_tangent(&ds.thermal);
        let (x, x_dot) = match self.drive {
            Drive::Motion => (du.x, du.x_dot),
            Drive::Force => (ds.x, ds.x_dot),
        };
        let travel = maps::travel_per_radian(p);
        let (i, w_m) = (
            Dq {
                d: ds.i_d,
                q: ds.i_q,
            },
            ds.w_m,
        );
        let (stretch, stretch_dot) = (travel * ds.theta_m - x, travel * w_m - x_dot);
        let F_spring = p.C_b * stretch_dot + now.K_b * stretch + now.K_b_slope * x * now.stretch;
        let k = maps::gear_factor_slope(p, now.tau_load, s.w_m) * w_m;
        let lambda = Dq {
            d: p.L_d * i.d + lambda_m,
            q: p.L_q * i.q,
        };
        let tau_e = 1.5
            * f64::from(p.p)
            * (lambda.d * now.i.q + now.lambda.d * i.q - lambda.q * now.i.d - now.lambda.q * i.d);
        let residual = residual_by[0] * tau_e + residual_by[1] * w_m;
        let tau_load = maps::screw_load(p, F_spring - residual, w_m);
        let torque_left = tau_e
            - maps::motor_friction_slope(p, s.w_m) * w_m
            - (k * now.tau_load + now.k * tau_load) / p.N_gear;
        let inertia = k * p.J_s / (p.N_gear * p.N_gear);
        let v_dc = du.v_dc.unwrap_or(0.0);
        let d_largest = if held.largest < p.v_max {
            v_dc / 3.0_f64.sqrt()
        } else {
            0.0
        };
        let [v, dv] = [u.voltage(), du.voltage()];
        InstantTangent {
            v: if held.gates {
                motor::limited_tangent(held.largest, d_largest, v, dv)
            } else {
                Dq::default()
            },
            v_dc,
            R_s,
            residual,
            i,
            lambda,
            w_m,
            tau_e,
            x,
            x_dot,
            stretch,
            stretch_dot,
            F: F_spring - p.C_act * x_dot,
            tau_load,
            k,
            w_m_dot: match held.brake {
                BrakeState::Holds => 0.0,
                _ => (torque_left - now.w_m_dot * inertia) / maps::inertia(p, now.k),
            },
        }
    }

    fn stored_tangent(&self, now: &Instant, d: &InstantTangent) -> f64 {
        let p = &self.p;
        let rod = match self.drive {
            Drive::Motion => 0.0,
            Drive::Force => p.M_act * now.x_dot * d.x_dot,
        };
        1.5 * (p.L_d * now.i.d * d.i.d + p.L_q * now.i.q * d.i.q)
            + maps::inertia(p, 1.0) * now.w_m * d.w_m
            + now.K_b * now.stretch * d.stretch
            + 0.5 * now.K_b_slope * d.x * now.stretch * now.stretch
            + rod
    }
}

fn power_in_tangent(now: &Instant, d: &InstantTangent, dl: &Losses) -> f64 {
    1.5 * (d.v.dot(now.i) + now.v.dot(d.i)) + dl.core + dl.inverter
}

fn losses_tangent(now: &Instant, held: &Conditions, d: &InstantTangent) -> Losses {
    let p = held.p;
    let N = p.N_gear;
    let size = now.i.dot(now.i).sqrt();
    let size_dot = if size > 0.0 {
        now.i.dot(d.i) / size
    } else {
        0.0
    };
    let (_, by_size, by_v_dc) = inverter_loss(p, size, held.v_dc);
    let (core, core_slope) = core_loss(p, now.w_e);
    let gear_load = p.J_s * now.w_m_dot / N + now.tau_load;
    let gear_load_dot = p.J_s * d.w_m_dot / N + d.tau_load;
    let curvature = maps::stiffness_curvature(p, now.x);
    let (stretch, slope) = (now.stretch, now.K_b_slope);
    Losses {
        copper: 3.0 * p.R_s * now.i.dot(d.i) + 1.5 * d.R_s * now.i.dot(now.i),
        core: if held.gates {
            core_slope * f64::from(p.p) * d.w_m * now.lambda.dot(now.lambda)
                + 2.0 * core * now.lambda.dot(d.lambda)
        } else {
            0.0
        },
        inverter: by_size * size_dot + by_v_dc * d.v_dc,
        motor_friction: (maps::motor_friction_slope(p, now.w_m) * now.w_m + now.tau_friction)
            * d.w_m,
        gear: (d.k * gear_load * now.w_m
            + (now.k - 1.0) * (gear_load_dot * now.w_m + gear_load * d.w_m))
            / N,
        screw: 2.0 * p.C_s * now.w_m * d.w_m / (N * N),
        nut: 2.0 * p.C_b * now.stretch_dot * d.stretch_dot,
        rod: 2.0 * p.C_act * now.x_dot * d.x_dot,
        brake: held.brake.torque() * d.w_m,
        residual: -held.residual * maps::travel_per_radian(p) * d.w_m - d.residual * now.x_n_dot,
        stiffness: -0.5
            * stretch
            * (curvature * d.x * now.x_dot * stretch
                + slope * d.x_dot * stretch
                + 2.0 * slope * now.x_dot * d.stretch),
    }
}

/// Derivative of the efficiency. Pairs: value and derivative.
fn efficiency_tangent(
    now: &Instant,
    d: &InstantTangent,
    (electrical, electrical_dot): (f64, f64),
    (out, out_dot): (f64, f64),
) -> f64 {
    let powers = Powers {
        shaft: now.tau_e * now.w_m,
        electrical,
        out,
    };
    let dot = Powers {
        shaft: d.tau_e * now.w_m + now.tau_e * d.w_m,
        electrical: electrical_dot,
        out: out_dot,
    };
    Efficiency::new(powers, now.tau_e, now.w_m).map_or(0.0, |efficiency| efficiency.tangent(dot))
}

/// Derivative of [`link_current`] when power and voltage change by `dP` and `dv_dc`.
fn current_tangent(P: f64, v_dc: f64, dP: f64, dv_dc: f64) -> f64 {
    link_current(dP - link_current(P, v_dc) * dv_dc, v_dc)
}
