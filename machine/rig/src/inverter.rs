//! Three-phase inverter for `step`, `dynamics`, `start` and `output`: voltage limit, sampling and
//! hold in stator coordinates, dead time, and the drive's own current loop.
//!
//! Source: S.-K. Sul, *Control of Electric Machine Drive Systems*, chapters on space-vector
//! modulation and on dead time.

use crate::{HeldVoltages, Input, Rig, State};
use machine_file::Dq;

impl Rig {
    /// The switching period, s, if the voltages are sampled and held.
    pub(crate) fn switching_period(&self) -> Option<f64> {
        let f_sw = self.p.inverter.map_or(0.0, |inverter| inverter.f_sw);
        self.extra.switching.on.then(|| 1.0 / f_sw)
    }

    /// The voltage of the inputs, limited, V.
    pub(crate) fn commanded_voltage(&self, u: &Input) -> Dq {
        self.limit_voltage(u.voltage(), u)
    }

    /// `v`, V, limited to `v_max` and to `v_dc/√3` of space-vector modulation, direction kept.
    pub(crate) fn limit_voltage(&self, v: Dq, u: &Input) -> Dq {
        v.limited(self.p.largest_voltage(self.link_voltage(u)))
    }

    /// Voltage for the next switching period of `T` s: that of the inputs, or of the current loop
    /// ```text
    /// e = (0, i_q,r) − i,   v = K_p e + ∫ K_i e dt
    /// ```
    /// with the measured currents. The integrals are frozen while the voltage is limited.
    pub(crate) fn requested_voltage(&self, s: &mut State, u: &Input, T: f64) -> Dq {
        let Some(gains) = self.current_loop else {
            return self.commanded_voltage(u);
        };
        let i_max = self.p.i_max;
        let i = self.measured_currents(s.current());
        let e = Dq {
            d: -i.d,
            q: u.i_q_required.max(-i_max).min(i_max) - i.q,
        };
        let [d, q] = s.regulator;
        let requested = gains.K_p * e + Dq { d, q };
        let given = self.limit_voltage(requested, u);
        if given == requested {
            s.regulator = [d + T * gains.K_i * e.d, q + T * gains.K_i * e.q];
        }
        given
    }

    /// Begins a switching period of `T` s at motor angle `theta_m` and speed `w_m`: the voltage
    /// computed in the last period acts now; `v` (dq) acts in the next one. As it is held over that
    /// period, its mean delay is 3/2·T.
    pub(crate) fn next_period(
        &self,
        hold: &HeldVoltages,
        v: Dq,
        theta_m: f64,
        w_m: f64,
        T: f64,
    ) -> HeldVoltages {
        let lead = if self.extra.switching.advance {
            1.5 * T * w_m
        } else {
            0.0
        };
        let angle = f64::from(self.p.p) * (theta_m + lead) + self.extra.switching.offset;
        let next = v.turned(libm::sincos(angle));
        HeldVoltages {
            acting: hold.next,
            next: [next.d, next.q],
            left: hold.left + T,
        }
    }

    /// Currents as the drive measures them, A: in the dq coordinates of its rotor angle, which has
    /// an error.
    pub(crate) fn measured_currents(&self, i: Dq) -> Dq {
        let s = &self.extra.switching;
        if !s.on || s.offset == 0.0 {
            return i;
        }
        let (sin, cos) = libm::sincos(s.offset);
        i.turned((-sin, cos))
    }

    /// Voltage at the motor in dq coordinates, V: the command itself, or the held voltage minus the
    /// loss by the dead time.
    #[inline(always)]
    pub(crate) fn voltage(&self, hold: &HeldVoltages, u: &Input, i: Dq, theta_m: f64) -> Dq {
        if !self.extra.switching.on {
            return self.commanded_voltage(u);
        }
        let (sin, cos) = libm::sincos(f64::from(self.p.p) * theta_m);
        let held = Dq {
            d: hold.acting[0],
            q: hold.acting[1],
        };
        let lost = self.dead_time_voltage(i.turned((sin, cos)), self.link_voltage(u));
        (held + (-1.0) * lost).turned((-sin, cos))
    }

    /// Voltage lost by the dead time, V, for the currents `i` in stator coordinates: in each phase
    /// `v_dc·t_d·f_sw` against the current's sign. The common-mode part drives no current.
    /// ```text
    /// i_a = i_α,   i_b, i_c = −i_α/2 ± √3/2·i_β,   v_α = (2 v_a − v_b − v_c)/3,   v_β = (v_b − v_c)/√3
    /// ```
    /// The sign is smoothed to i/√(i² + i_0²): near zero the current charges the devices'
    /// capacitances.
    fn dead_time_voltage(&self, i: Dq, v_dc: f64) -> Dq {
        let (s, root) = (&self.extra.switching, 3.0_f64.sqrt());
        let f_sw = self.p.inverter.map_or(0.0, |inverter| inverter.f_sw);
        let step = v_dc * s.dead_time * f_sw;
        let sign = |i: f64| i / (i * i + s.i_0 * s.i_0).sqrt();
        let a = sign(i.d);
        let b = sign(0.5 * (root * i.q - i.d));
        let c = sign(-0.5 * (root * i.q + i.d));
        (step / 3.0)
            * Dq {
                d: 2.0 * a - b - c,
                q: root * (b - c),
            }
    }

    /// Held voltages that give the voltage `v`, V, in steady motion from the start: in stator
    /// coordinates, dead time compensated.
    pub(crate) fn steady_hold(
        &self,
        v: Dq,
        i: Dq,
        u: &Input,
        theta_m: f64,
        w_m: f64,
    ) -> HeldVoltages {
        let Some(T) = self.switching_period() else {
            return HeldVoltages::default();
        };
        let at = |theta: f64| {
            let turn = libm::sincos(f64::from(self.p.p) * theta);
            let v = v.turned(turn) + self.dead_time_voltage(i.turned(turn), self.link_voltage(u));
            [v.d, v.q]
        };
        HeldVoltages {
            acting: at(theta_m - 0.5 * T * w_m),
            next: at(theta_m + 0.5 * T * w_m),
            left: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Drive, Extras};

    fn rig(change: impl Fn(&mut Extras)) -> Rig {
        let mut extra = Extras::AS_BUILT;
        change(&mut extra);
        Rig::new(
            machine_file::Machine::reference().emla.lift,
            extra,
            Drive::Motion,
        )
        .expect("valid")
    }

    fn input(v_d: f64, v_q: f64) -> Input {
        Input {
            v_d,
            v_q,
            v_dc: Some(650.0),
            ..Input::default()
        }
    }

    /// A command at angle 0 acts one period later, at the speed w with the rotor then turned by
    /// p·w·T; in the middle of that period, with the advance, it stands where it was commanded in
    /// rotor coordinates.
    #[test]
    fn a_command_acts_one_and_a_half_periods_late() {
        let rig = rig(|e| e.switching.dead_time = 0.0);
        let (T, w, u) = (125e-6, 200.0, input(-20.0, 90.0));
        let empty = HeldVoltages::default();
        let computed = rig.next_period(&empty, rig.commanded_voltage(&u), 0.0, w, T);
        assert_eq!(computed.acting, [0.0; 2]);
        let acts = rig.next_period(&computed, Dq::default(), w * T, w, T);
        let middle = rig.voltage(&acts, &u, Dq::default(), 1.5 * w * T);
        assert!((middle.d + 20.0).abs() < 1e-11 && (middle.q - 90.0).abs() < 1e-11);
        let begin = rig.voltage(&acts, &u, Dq::default(), w * T);
        let angle = 0.5 * 4.0 * w * T; // the rotor lags by half a period, so the voltage leads by it
        let (sin, cos) = angle.sin_cos();
        assert!((begin.d - (-20.0 * cos - 90.0 * sin)).abs() < 1e-11);
        assert!((begin.q - (-20.0 * sin + 90.0 * cos)).abs() < 1e-11);
    }

    /// Without the advance the voltage acts where the rotor was.
    #[test]
    fn without_advance_the_voltage_lags() {
        let rig = rig(|e| {
            e.switching.dead_time = 0.0;
            e.switching.advance = false;
        });
        let (T, w) = (125e-6, 200.0);
        let computed = rig.next_period(&HeldVoltages::default(), Dq { d: 0.0, q: 90.0 }, 0.0, w, T);
        assert!((computed.next[0]).abs() < 1e-12 && (computed.next[1] - 90.0).abs() < 1e-12);
    }

    /// By hand: current in phase a alone against b and c takes `v_dc·t_d·f_sw`·(2 + 1 + 1)/3 from
    /// the α axis: 650·2e-6·8000·4/3.
    #[test]
    fn dead_time_takes_its_share_against_the_current() {
        let rig = rig(|e| e.switching.i_0 = 1e-9);
        let lost = rig.dead_time_voltage(Dq { d: 10.0, q: 0.0 }, 650.0);
        assert!((lost.d - 650.0 * 0.016 * 4.0 / 3.0).abs() < 1e-6 && lost.q.abs() < 1e-6);
        let (i, mut least) = (12.0, f64::INFINITY);
        for k in 0..360 {
            let (sin, cos) = (f64::from(k).to_radians()).sin_cos();
            let i = Dq {
                d: i * cos,
                q: i * sin,
            };
            least = least.min(rig.dead_time_voltage(i, 650.0).dot(i) / i.dot(i).sqrt());
        }
        // Least where one phase carries nothing: 10.4·2/√3.
        assert!(
            (least - 10.4 * 2.0 / 3.0_f64.sqrt()).abs() < 1e-3,
            "{least}"
        );
    }

    /// |v| stays within v_dc/√3 = 375.3 V at 650 V, where v_max of 375 V counts, and at 400 V within 231 V; the direction is kept.
    #[test]
    fn the_dc_link_limits_the_voltage() {
        let rig = rig(|_| ());
        let size = |v: Dq| v.dot(v).sqrt();
        let v = rig.commanded_voltage(&input(-300.0, 400.0));
        assert!((size(v) - 375.0).abs() < 1e-9 && (v.d / v.q + 0.75).abs() < 1e-12);
        let low = Input {
            v_dc: Some(400.0),
            ..input(-300.0, 400.0)
        };
        assert!((size(rig.commanded_voltage(&low)) - 400.0 / 3.0_f64.sqrt()).abs() < 1e-9);
        assert_eq!(
            rig.commanded_voltage(&input(3.0, -4.0)),
            Dq { d: 3.0, q: -4.0 }
        );
    }
}
