//! The voltage law of one actuator ([eq:voltages_Control] to [eq:current_q_required]), which
//! `controller` evaluates and advances: dq voltages from the required force and rod motion with the
//! controller's nominal actuator parameters. dq quantities are peak-valued.

use crate::drive::reading::Reading;
use crate::settings::Settings;
use crate::tracking::RodMotion;
use emla::{Emla, maps};
use hdrm::saturate;

/// Required force and motion of one rod, the input of the voltage law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RodDemand {
    /// Required force on the load, N, limited.
    pub(crate) f_r: f64,
    pub(crate) motion: RodMotion,
    /// The required force before its limitation, N.
    pub(crate) f_unlimited: f64,
    /// The limit, N; None: only the current is limited.
    pub(crate) f_max: Option<f64>,
}

impl RodDemand {
    /// The force `f_unlimited`, N, limited to ±`f_max`.
    pub(crate) fn limited(f_max: Option<f64>, f_unlimited: f64, motion: RodMotion) -> Self {
        Self {
            f_r: f_max.map_or(f_unlimited, |f_max| saturate(f_unlimited, f_max)),
            motion,
            f_unlimited,
            f_max,
        }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct DriveState {
    /// Required direct-axis current, A.
    pub(crate) i_dr: f64,
    /// Required quadrature-axis current after the filter whose slope is d(i_qr)/dt, A.
    pub(crate) i_qr_filtered: f64,
    /// Integral parts of the voltages, V.
    pub(crate) v_d_integral: f64,
    pub(crate) v_q_integral: f64,
    /// State of the disturbance observer, N·m·s.
    observer: f64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Command {
    /// Direct-axis voltage, V.
    pub(crate) v_d: f64,
    /// Quadrature-axis voltage, V.
    pub(crate) v_q: f64,
    /// Required quadrature-axis current, A.
    pub(crate) i_qr: f64,
    /// Largest voltage of the drive, V.
    pub(crate) v_max: f64,
    /// Largest required current, A.
    pub(crate) i_max: f64,
    /// Feedback part of `v_d`, V.
    pub(crate) e_d: f64,
    /// Feedback part of `v_q`, V.
    pub(crate) e_q: f64,
    /// `F_hyb,r − F_hyb` by [eq:Error_Force_EMLA], N.
    pub(crate) force_error: f64,
    /// Sign of the force that is at its limit; 0: none.
    pub(crate) at_force_limit: f64,
    /// The network's residual force, `α·dF`, N.
    residual_force: f64,
}

impl Command {
    /// Amplitude of the voltage, V.
    pub(crate) fn voltage(&self) -> f64 {
        (self.v_d * self.v_d + self.v_q * self.v_q).sqrt()
    }
}

/// The voltage law with its parameters.
pub(crate) struct VoltageLaw<'a> {
    pub(crate) actuator: &'a Emla,
    pub(crate) settings: &'a Settings,
}

/// The network's residual force of each actuator at the present operating points, `α·dF`, N. The
/// hybrid actuator holds the same value over the next step, so it is cancelled, not fed back.
pub(crate) fn residual_forces(
    actuators: &[Emla; 3],
    settings: &Settings,
    now: [&Reading; 3],
) -> [f64; 3] {
    if settings.alpha == 0.0 {
        return [0.0; 3];
    }
    let point = |i: usize| {
        let Reading { i_d, i_q, w_m, .. } = *now[i];
        [maps::torque(actuators[i].params(), i_d, i_q), w_m]
    };
    let residuals = Emla::residuals(actuators, [0, 1, 2].map(point));
    residuals.map(|residual| settings.alpha * residual.dF)
}

impl VoltageLaw<'_> {
    fn p(&self) -> &machine_file::Emla {
        self.actuator.params()
    }

    /// Largest required current (peak), A, with the winding at `T_winding`, K.
    fn largest_current(&self, T_winding: f64) -> f64 {
        let derating = self.settings.derating.as_ref();
        derating.map_or(1.0, |d| d.share(T_winding)) * self.p().i_max
    }

    /// Largest voltage (peak) of the drive, V, with the DC-link voltage `v_dc`, V.
    fn largest_voltage(&self, v_dc: Option<f64>) -> f64 {
        let p = self.p();
        p.largest_voltage(v_dc.unwrap_or_else(|| p.link_voltage()))
    }

    /// Disturbance torque that the nominal actuator model does not explain, N·m, low-pass filtered
    /// at ω_d: deviations of gear losses, friction and torque constant.
    /// ```text
    /// d̂ = ω_d (z − J w_m),   z' = ω_d (J w_m + (τ_e − τ_load(F, w_m))/ω_d − z)
    /// ```
    /// Not in the paper (ω_d = 0 is its law). z depends on earlier measurements only, so the
    /// measured force has no direct feedthrough to the voltages.
    fn disturbance(&self, state: &DriveState, now: &Reading) -> f64 {
        let momentum = maps::inertia(self.p(), 1.0) * now.w_m;
        self.settings.gains.omega_d * (state.observer - momentum)
    }

    /// Required quadrature-axis current, A, saturated at the drive's (derated) limit.
    ///
    /// Source: [eq:current_q_required] solved for `i_qr`, with the reflected inertia corrected,
    /// friction at the required rates, and the required instead of the measured acceleration: the
    /// measured one closes an unfiltered loop around the current and is unstable. In `pd` mode
    /// there is no model but the lossless transmission.
    fn required_current(
        &self,
        state: &DriveState,
        demand: &RodDemand,
        now: &Reading,
        residual_force: f64,
    ) -> f64 {
        let p = self.p();
        let travel = maps::travel_per_radian(p);
        let tau_r = if self.settings.mode.law().knows_actuators() {
            let RodMotion { x_r_dot, x_r_ddot } = demand.motion;
            let (w_r, w_r_dot) = (x_r_dot / travel, x_r_ddot / travel);
            let F_r = demand.f_r - residual_force;
            maps::required_torque(p, F_r, w_r, w_r_dot) + self.disturbance(state, now)
        } else {
            demand.f_r * travel
        };
        let (lambda_d, lambda_q) = (p.L_d * now.i_d + p.lambda_m, p.L_q * now.i_q);
        let i_qr = (tau_r / (1.5 * f64::from(p.p)) + lambda_q * state.i_dr) / lambda_d;
        saturate(i_qr, self.largest_current(now.T_winding))
    }

    /// Limits the current `more`, A, which the velocity feedback adds to `i_qr`, so that both
    /// together stay within the currents for the largest rod forces at rest. Also returns the sign
    /// of the force that is at its limit, or 0. Friction and rotor inertia are not added to these
    /// currents: they help a load that drives the motor back, and friction that changes its sign
    /// with the measured speed would make the machine oscillate.
    fn within_force_limit(
        i_qr: f64,
        more: f64,
        demand: &RodDemand,
        current: impl Fn(&RodDemand) -> f64,
    ) -> (f64, f64) {
        let Some(f_max) = demand.f_max else {
            return (more, 0.0);
        };
        let at_rest = RodMotion::default();
        let [least, most] = [-f_max, f_max].map(|f| current(&RodDemand::limited(None, f, at_rest)));
        match i_qr + more {
            i_q if i_q > most => (most - i_qr, 1.0),
            i_q if i_q < least => (least - i_qr, -1.0),
            _ if demand.f_unlimited == demand.f_r => (more, 0.0),
            _ => (more, demand.f_unlimited.signum()),
        }
    }

    /// `di_dr/dt = −λ_i·i_d` ([eq:current_d_required] with `i_dd = 0`), A/s. 0 for a drive with its
    /// own current loop, which keeps i_d at 0: an offset of the measured i_d would make the
    /// integral grow without bound, and with it `λ_q i_dr`, a positive feedback of i_q.
    fn i_dr_dot(&self, now: &Reading) -> f64 {
        match self.settings.current_loop {
            true => 0.0,
            false => -self.settings.gains.lambda_i * now.i_d,
        }
    }

    /// The voltage law.
    /// ```text
    /// v_d = R_s i_d + L_d di_dr/dt − p w_m λ_q + e_d + ω_i ∫e_d dt
    /// v_q = R_s i_q + L_q di_qr/dt + p w_m λ_d + e_q + ω_i ∫e_q dt
    /// e_d = K_i (i_dr − i_d),   e_q = K_f (F_r − F) + K_v (ẋ_r − ẋ_n)
    /// ```
    /// The integrals are not in the paper (ω_i = 0 is its law): they compensate wrong motor
    /// parameters, above all the back-EMF of a wrong λ_m. They integrate the sum of both errors, so
    /// in steady state the velocity feedback keeps its force. The velocity feedback acts on the
    /// motor side, `ẋ_n = lead·w_m/N`: on the rod side, as printed, it is not collocated and
    /// unstable at these gains.
    ///
    /// A drive with its own current loop receives a current that includes the velocity feedback,
    /// `i_q,cmd = i_qr + K_v/K_i (ẋ_r − ẋ_n)`, with the ratio that the voltage law has between both
    /// errors: so the motor is as stiff against the force as under that law.
    ///
    /// `residual_force` is that of [`residual_forces`].
    pub(crate) fn command(
        &self,
        state: &DriveState,
        demand: &RodDemand,
        now: &Reading,
        residual_force: f64,
    ) -> Command {
        let (p, gains) = (self.p(), &self.settings.gains);
        let Reading { i_d, i_q, w_m, .. } = *now;
        let i_dr = state.i_dr;
        let velocity_error = demand.motion.x_r_dot - maps::travel_per_radian(p) * w_m;
        let current = |d: &RodDemand| self.required_current(state, d, now, residual_force);
        let mut i_qr = current(demand);
        // Feedback voltage per ampere of the required current, V/A.
        let ampere = match self.settings.current_loop {
            true => gains.K_i,
            false => gains.K_f * maps::beta_1(p, i_d),
        };
        // Without that feedback the damping cannot be expressed as a current and is not limited.
        let ratio = Some(gains.K_v / ampere).filter(|ratio| ratio.is_finite());
        let wanted = ratio.map_or(0.0, |ratio| ratio * velocity_error);
        let (given, at_force_limit) = Self::within_force_limit(i_qr, wanted, demand, current);
        let mut damping = gains.K_v * velocity_error;
        if self.settings.current_loop {
            i_qr = saturate(i_qr + given, self.largest_current(now.T_winding));
        } else if given != wanted && ampere > 0.0 {
            damping = ampere * given;
        }
        let di_qr = (i_qr - state.i_qr_filtered) / gains.di_qr_filter_time;
        let force_error = maps::beta_1(p, i_d) * (i_qr - i_q) - maps::beta_2(p, i_q) * (i_dr - i_d);
        let w_e = f64::from(p.p) * w_m;
        let e_d = gains.K_i * (i_dr - i_d);
        let e_q = gains.K_f * force_error + damping;
        Command {
            v_d: p.R_s * i_d + p.L_d * self.i_dr_dot(now) - w_e * p.L_q * i_q
                + e_d
                + state.v_d_integral,
            v_q: p.R_s * i_q
                + p.L_q * di_qr
                + w_e * (p.L_d * i_d + p.lambda_m)
                + e_q
                + state.v_q_integral,
            i_qr,
            v_max: self.largest_voltage(now.v_dc),
            i_max: self.largest_current(now.T_winding),
            e_d,
            e_q,
            force_error,
            at_force_limit,
            residual_force,
        }
    }

    /// Advances the law's state by `h` s with measurements and command held; the filters are exact
    /// for that. The integrals are frozen while the voltage exceeds the drive's (anti-windup).
    pub(crate) fn advance(&self, state: &mut DriveState, now: &Reading, command: &Command, h: f64) {
        let (p, gains) = (self.p(), &self.settings.gains);
        let reached = |rate: f64| -libm::expm1(-h * rate);
        state.i_dr += h * self.i_dr_dot(now);
        state.i_qr_filtered +=
            reached(1.0 / gains.di_qr_filter_time) * (command.i_qr - state.i_qr_filtered);
        if gains.omega_d > 0.0 {
            let F = now.F - command.residual_force;
            let unexplained =
                maps::torque(p, now.i_d, now.i_q) - maps::required_torque(p, F, now.w_m, 0.0);
            let momentum = maps::inertia(p, 1.0) * now.w_m;
            // `share / omega_d` is at most h; the torque over ω_d alone could overflow.
            let share = reached(gains.omega_d);
            state.observer +=
                share * (momentum - state.observer) + share / gains.omega_d * unexplained;
        }
        if command.voltage() < command.v_max && !self.settings.current_loop {
            state.v_d_integral += h * gains.omega_i * command.e_d;
            state.v_q_integral += h * gains.omega_i * command.e_q;
        }
    }
}

impl DriveState {
    /// The start state: no disturbance at motor speed `w_m`.
    pub(crate) fn undisturbed(p: &machine_file::Emla, w_m: f64) -> Self {
        Self {
            observer: maps::inertia(p, 1.0) * w_m,
            ..Self::default()
        }
    }

    /// Sets the filter to the steady state with the required current `i_qr`, A.
    pub(crate) fn settled(self, i_qr: f64) -> Self {
        Self {
            i_qr_filtered: i_qr,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Mode;
    use emla::{Drive, Surrogate};
    use machine_file::Machine;

    const H: f64 = 1e-3;

    fn settings(alpha: f64) -> Settings {
        let machine = Machine::reference();
        Settings {
            mode: Mode::Modular,
            alpha,
            ..Settings::from_gains(&machine.controller)
        }
    }

    fn actuator(alpha: f64) -> Emla {
        Emla::new(Machine::reference().emla.lift, Drive::Motion)
            .expect("valid")
            .with_surrogate(Surrogate::reference(), alpha)
    }

    /// Rod in steady motion under a force, with the currents that the actuator itself begins with.
    fn steady(actuator: &Emla) -> (RodDemand, Reading) {
        let start = emla::Input {
            x: 0.3,
            x_dot: 0.02,
            F_hold: 21e3,
            ..emla::Input::default()
        };
        let s = actuator.start(&start).expect("finite");
        let motion = RodMotion {
            x_r_dot: 0.02,
            x_r_ddot: 0.0,
        };
        let demand = RodDemand::limited(None, 21e3, motion);
        let measured = Reading {
            i_d: s.i_d,
            i_q: s.i_q,
            w_m: s.w_m,
            F: 21e3,
            ..Reading::default()
        };
        (demand, measured)
    }

    /// Where the actuator moves steadily as it should the law asks for the current that it has, and
    /// for the voltages that keep it: `v_d = −p w L_q i_q`, `v_q = R_s i_q + p w λ_m`. Tolerance:
    /// the actuator finds its start with the network by secants.
    #[test]
    fn a_steady_motion_is_kept() {
        for alpha in [0.0, 1.0] {
            let (actuator, settings) = (actuator(alpha), settings(alpha));
            let (demand, now) = steady(&actuator);
            let three = [(); 3].map(|()| actuator.clone());
            let [residual_force, ..] = residual_forces(&three, &settings, [&now; 3]);
            assert_eq!(residual_force != 0.0, alpha > 0.0);
            let law = VoltageLaw {
                actuator: &actuator,
                settings: &settings,
            };
            let p = actuator.params();
            let state = DriveState::undisturbed(p, now.w_m).settled(now.i_q);
            let command = law.command(&state, &demand, &now, residual_force);
            assert!((command.i_qr - now.i_q).abs() < 1e-9, "{command:?} {now:?}");
            let w_e = f64::from(p.p) * now.w_m;
            let [v_d, v_q] = [-w_e * p.L_q * now.i_q, p.R_s * now.i_q + w_e * p.lambda_m];
            // K_f multiplies what the current is off by.
            assert!((command.v_d - v_d).abs() < 1e-9, "{command:?} {v_d}");
            assert!((command.v_q - v_q).abs() < 1e-3, "{command:?} {v_q}");
        }
    }

    /// A torque that the model does not explain is found with the time constant 1/ω_d: `d (1 −
    /// e^(−ω_d t))`, and the current compensates it.
    #[test]
    fn an_unexplained_torque_is_observed() {
        let (actuator, settings) = (actuator(0.0), settings(0.0));
        let (demand, steady) = steady(&actuator);
        let law = VoltageLaw {
            actuator: &actuator,
            settings: &settings,
        };
        let p = actuator.params();
        let torque_constant = 1.5 * f64::from(p.p) * p.lambda_m;
        let now = Reading {
            i_q: steady.i_q + 0.7,
            ..steady
        };
        let d = 0.7 * torque_constant;
        let mut state = DriveState::undisturbed(p, now.w_m);
        for k in 0..50 {
            let command = law.command(&state, &demand, &now, 0.0);
            let t = f64::from(k) * H;
            let found = d * -libm::expm1(-settings.gains.omega_d * t);
            let more = command.i_qr - steady.i_q;
            assert!((more - found / torque_constant).abs() < 1e-9, "{k}: {more}");
            assert!((law.disturbance(&state, &now) - found).abs() < 1e-9);
            law.advance(&mut state, &now, &command, H);
        }
        assert!(settings.gains.omega_d * 0.05 > 0.5);
    }

    /// The states in closed form over one step of held values; at the voltage's limit the integrals
    /// rest, and the rest goes on.
    #[test]
    fn states_advance_by_their_equations() {
        let (actuator, settings) = (actuator(0.0), settings(0.0));
        let law = VoltageLaw {
            actuator: &actuator,
            settings: &settings,
        };
        let gains = &settings.gains;
        let now = Reading {
            i_d: 0.8,
            i_q: 11.0,
            w_m: 40.0,
            F: 21e3,
            ..Reading::default()
        };
        let begin = DriveState {
            i_dr: 0.3,
            i_qr_filtered: 9.0,
            v_d_integral: 0.25,
            v_q_integral: -0.5,
            observer: 0.0,
        };
        for (v_max, moves) in [(300.0, 1.0), (5.0, 0.0), (3.0, 0.0)] {
            let command = Command {
                v_d: 3.0,
                v_q: 4.0,
                i_qr: 12.0,
                v_max,
                e_d: 2.0,
                e_q: -1.5,
                ..Command::default()
            };
            assert_eq!(command.voltage(), 5.0);
            let mut state = begin;
            law.advance(&mut state, &now, &command, H);
            let share = 1.0 - (-H / gains.di_qr_filter_time).exp();
            let near = |a: f64, b: f64| (a - b).abs() < 1e-14 * b.abs().max(1.0);
            assert!(near(state.i_dr, 0.3 - H * gains.lambda_i * 0.8));
            assert!(near(state.i_qr_filtered, 9.0 + 3.0 * share));
            let integral = |e: f64| moves * H * gains.omega_i * e;
            assert!(near(state.v_d_integral, 0.25 + integral(2.0)));
            assert!(near(state.v_q_integral, -0.5 + integral(-1.5)));
        }
        // The slope of the required current is that of the filter.
        let command = law.command(&begin, &RodDemand::default(), &now, 0.0);
        let other = DriveState {
            i_qr_filtered: 8.0,
            ..begin
        };
        let more = law.command(&other, &RodDemand::default(), &now, 0.0);
        let slope = actuator.params().L_q / gains.di_qr_filter_time;
        assert!((more.v_q - command.v_q - slope).abs() < 1e-9);
        assert_eq!([command.i_max, command.v_max], [100.0, 375.0]);
    }

    /// For a drive with a current loop of its own the velocity feedback is part of the current, in
    /// the ratio of the voltage law's gains, within the drive's limit; the integrals rest, that of
    /// the measured i_d too.
    #[test]
    fn a_drive_with_a_current_loop_is_told_a_current() {
        let mut settings = settings(0.0);
        let actuator = actuator(0.0);
        let (mut demand, mut now) = steady(&actuator);
        now.i_d = 0.3;
        demand.motion.x_r_dot += 1e-3;
        let of = |settings: &Settings, demand: &RodDemand| {
            let law = VoltageLaw {
                actuator: &actuator,
                settings,
            };
            let state = DriveState::undisturbed(actuator.params(), now.w_m).settled(now.i_q);
            let command = law.command(&state, demand, &now, 0.0);
            let mut after = state;
            law.advance(&mut after, &now, &command, H);
            (command, [after.v_q_integral, after.i_dr])
        };
        settings.gains.omega_i = 100.0;
        let (voltage, integrals) = of(&settings, &demand);
        assert!(integrals.iter().all(|x| *x != 0.0), "{integrals:?}");
        settings.current_loop = true;
        let (current, integrals) = of(&settings, &demand);
        let share = 1e-3 * settings.gains.K_v / settings.gains.K_i;
        assert!((current.i_qr - voltage.i_qr - share).abs() < 1e-9);
        assert_eq!(integrals, [0.0; 2]);
        demand.motion.x_r_dot += 1.0;
        assert_eq!(of(&settings, &demand).0.i_qr, actuator.params().i_max);
    }

    /// With a limit of the force the current, velocity feedback included, is at most what that
    /// force takes at rest, in both directions and at any speed; within the limit nothing changes.
    #[test]
    fn a_drive_with_a_current_loop_keeps_the_limit_of_the_force() {
        let mut settings = settings(0.0);
        settings.current_loop = true;
        let actuator = actuator(0.0);
        let (start, steady) = steady(&actuator);
        let law = VoltageLaw {
            actuator: &actuator,
            settings: &settings,
        };
        let p = actuator.params();
        let demand = |f_max, asked, x_r_dot| {
            let motion = RodMotion {
                x_r_dot,
                x_r_ddot: 0.0,
            };
            RodDemand::limited(f_max, asked, motion)
        };
        let speed = start.motion.x_r_dot;
        for x_dot in [speed, -speed] {
            let now = Reading {
                w_m: x_dot / maps::travel_per_radian(p),
                ..steady
            };
            let state = DriveState::undisturbed(p, now.w_m).settled(now.i_q);
            let of = |demand| {
                let command = law.command(&state, &demand, &now, 0.0);
                (command.i_qr, command.at_force_limit)
            };
            // Currents that hold these forces, by the actuator's own map.
            let torque_constant = 1.5 * f64::from(p.p) * (p.lambda_m + p.L_d * now.i_d);
            let takes = |F| maps::required_torque(p, F, 0.0, 0.0) / torque_constant;
            for (asked, faster) in [(21e3, 1e-3), (-29e3, -2e-3)] {
                let free = of(demand(None, asked, x_dot + faster));
                assert_eq!(of(demand(Some(50e3), asked, x_dot + faster)), free);
            }
            for (asked, faster, force) in [(21e3, 1e-1, 30e3), (21e3, -1e-1, -30e3)] {
                let (i_q, sign) = of(demand(Some(30e3), asked, x_dot + faster));
                let error = (i_q - takes(force)).abs();
                assert!(error < 1e-9, "{i_q} A, {} A", takes(force));
                assert_eq!(sign, force.signum());
            }
            // Less, where friction is on the rod's side.
            let (i_q, sign) = of(demand(Some(30e3), 1e9, x_dot));
            let (held, _) = of(demand(None, 30e3, x_dot));
            let error = (i_q - held.min(takes(30e3))).abs();
            assert!(error < 1e-9 && sign == 1.0, "{i_q} A, {held} A");
        }
    }

    /// A feedback of the force that weighs next to nothing is no division by zero: where no
    /// velocity error damps, the voltage is that of no feedback at all.
    #[test]
    fn a_vanishing_feedback_keeps_the_voltage_finite_under_a_limit() {
        let actuator = actuator(0.0);
        let (start, steady) = steady(&actuator);
        let p = actuator.params();
        let of = |K_f| {
            let mut settings = settings(0.0);
            settings.gains.K_f = K_f;
            let law = VoltageLaw {
                actuator: &actuator,
                settings: &settings,
            };
            let motion = RodMotion {
                x_r_dot: maps::travel_per_radian(p) * steady.w_m,
                x_r_ddot: 0.0,
            };
            let demand = RodDemand::limited(Some(50e3), start.f_r, motion);
            let state = DriveState::undisturbed(p, steady.w_m);
            law.command(&state, &demand, &steady, 0.0).v_q
        };
        assert!(of(0.0).is_finite());
        assert_eq!(of(5e-324), of(0.0));
    }
}
