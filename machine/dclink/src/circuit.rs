//! The circuit's equations at one instant: currents, powers, rates, and the guard functions of the
//! events that end its present mode. The integrators in `step` and `continuous` evaluate them.

use crate::link::DcLink;
use crate::pack::Line;
use crate::state::{Mode, Regime, State};

/// The integrated quantities: charge and voltages, and energies since the step began.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Point {
    /// State of charge.
    pub soc: f64,
    /// Voltages of the RC pairs, V.
    pub v: [f64; 2],
    /// Voltage of the capacitor, V.
    pub v_c: f64,
    /// Energy from the pack's source, J.
    pub battery: f64,
    /// Energy burnt in the brake resistor, J.
    pub brake: f64,
    /// Energy lost in all other resistances and in the limit, J.
    pub loss: f64,
    /// Of that, heat of the pack, J.
    pub heat: f64,
    /// Integral of the capacitor's voltage, V·s.
    pub flux: f64,
}

/// Currents and powers at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Flow {
    /// Current of the pack, A.
    pub i: f64,
    /// Open-circuit voltage, V.
    pub v_oc: f64,
    /// Power burnt in the brake resistor, W.
    pub P_brake: f64,
    /// Power that heats the pack, W.
    pub P_heat: f64,
    /// Power lost in all but the brake resistor, W.
    pub P_loss: f64,
}

impl Point {
    pub fn from_state(s: &State) -> Self {
        Self {
            soc: s.soc,
            v: s.v,
            v_c: s.v_c,
            ..Self::default()
        }
    }

    /// `self + Σ h_k·rates_k` for the quantities that the rates depend on; the energies stay.
    #[inline(always)]
    pub fn moved<const N: usize>(&self, terms: [(f64, &Self); N]) -> Self {
        let mut next = *self;
        for (h, rate) in terms {
            next.soc += h * rate.soc;
            next.v[0] += h * rate.v[0];
            next.v[1] += h * rate.v[1];
            next.v_c += h * rate.v_c;
        }
        next
    }

    /// `self + h·Σ weight_k·rates_k` for all quantities.
    #[inline(always)]
    pub fn advanced<const N: usize>(&self, h: f64, terms: [(f64, &Self); N]) -> Self {
        let mut next = self.moved(terms.map(|(weight, rate)| (h * weight, rate)));
        for (weight, rate) in terms {
            next.battery += h * weight * rate.battery;
            next.brake += h * weight * rate.brake;
            next.loss += h * weight * rate.loss;
            next.heat += h * weight * rate.heat;
            next.flux += h * weight * rate.flux;
        }
        next
    }
}

impl DcLink {
    /// Currents and powers.
    ///
    /// ```text
    /// i      = (v_oc − v_1 − v_2 − v_c)/(R_0 + R_line + R_precharge), or the limit
    /// P_heat = R_0 i² + v_1²/R_1 + v_2²/R_2
    /// P_loss = (v_oc − v_1 − v_2 − v_c) i + v_1²/R_1 + v_2²/R_2
    /// ```
    /// `P_loss` includes what the current limit drops besides the resistances.
    #[inline(always)]
    pub(crate) fn flow(&self, x: &Point, mode: Mode, line: &Line) -> Flow {
        let b = &self.pack;
        let v_oc = line.at(x.soc);
        let drop = v_oc - x.v[0] - x.v[1] - x.v_c;
        let i = match mode.regime {
            Regime::Free => drop * self.conductance[usize::from(mode.ready)],
            Regime::Discharging => b.limits(x.soc).0,
            Regime::Charging => -b.limits(x.soc).1,
        };
        let pairs = b.pair_losses(x.v);
        Flow {
            i,
            v_oc,
            P_brake: x.v_c * self.brake_current(x, mode),
            P_heat: self.p.battery.R_0 * i * i + pairs,
            P_loss: drop * i + pairs,
        }
    }

    fn brake_current(&self, x: &Point, mode: Mode) -> f64 {
        if mode.braking {
            x.v_c * self.inverse[1]
        } else {
            0.0
        }
    }

    /// Rates of all quantities, per second, while the drives draw `i_load`, A; `line` is the piece
    /// of the open-circuit voltage:
    /// ```text
    /// C dv_c/dt = i − i_load − v_c/R_brake,   d(soc)/dt = −i/Q,   τ_k dv_k/dt = R_k i − v_k
    /// ```
    #[inline(always)]
    pub(crate) fn rates(&self, x: &Point, mode: Mode, i_load: f64, line: &Line) -> Point {
        let (b, flow) = (&self.pack, self.flow(x, mode, line));
        Point {
            soc: b.soc_rate(flow.i),
            v: b.pair_rates(x.v, flow.i),
            v_c: if mode.empty {
                0.0
            } else {
                (flow.i - i_load - self.brake_current(x, mode)) * self.inverse[0]
            },
            battery: flow.v_oc * flow.i,
            brake: flow.P_brake,
            loss: flow.P_loss,
            heat: flow.P_heat,
            flux: x.v_c,
        }
    }

    /// Positive once the mode has ended: current limit reached or left, threshold of chopper or
    /// precharge passed, capacitor empty or no longer so. Continuous along a solution.
    pub(crate) fn guard(&self, x: &Point, mode: Mode, i_load: f64) -> f64 {
        let mut ended = f64::NEG_INFINITY;
        self.guards(x, mode, i_load, |_, value| ended = ended.max(value));
        ended
    }

    /// Calls `each` with number and value of every guard that this mode has: 0 current limits, 1
    /// chopper, 2 precharge, 3 capacitor.
    #[inline(always)]
    pub(crate) fn guards(
        &self,
        x: &Point,
        mode: Mode,
        i_load: f64,
        mut each: impl FnMut(usize, f64),
    ) {
        let b = &self.pack;
        let source = b.open_circuit(x.soc) - x.v[0] - x.v[1];
        let free = (source - x.v_c) * self.conductance[usize::from(mode.ready)];
        let (give, take) = b.limits(x.soc);
        let limits = match mode.regime {
            Regime::Free => (free - give).max(-take - free),
            Regime::Discharging => give - free,
            Regime::Charging => free + take,
        };
        each(0, limits);
        if self.p.brake.fitted {
            let chopper = if mode.braking {
                self.p.brake.v_off - x.v_c
            } else {
                x.v_c - self.p.brake.v_on
            };
            each(1, chopper);
        }
        if !mode.ready {
            each(2, x.v_c - self.p.precharge.share * source);
        }
        let capacitor = if mode.empty {
            self.flow(x, mode, &b.line(x.soc)).i - i_load
        } else {
            -x.v_c
        };
        each(3, capacitor);
    }

    /// The mode at this point after the mode `before`.
    pub(crate) fn mode(&self, x: &mut Point, before: Mode, i_load: f64) -> Mode {
        let (b, brake) = (&self.pack, &self.p.brake);
        let source = b.open_circuit(x.soc) - x.v[0] - x.v[1];
        let mut mode = before;
        mode.ready |= x.v_c >= self.p.precharge.share * source;
        mode.braking = brake.fitted
            && x.v_c
                > if mode.braking {
                    brake.v_off
                } else {
                    brake.v_on
                };
        let free = (source - x.v_c) * self.conductance[usize::from(mode.ready)];
        let (give, take) = b.limits(x.soc);
        mode.regime = match free {
            _ if free > give => Regime::Discharging,
            _ if free < -take => Regime::Charging,
            _ => Regime::Free,
        };
        if x.v_c <= 0.0 {
            x.v_c = 0.0;
            mode.empty = self.flow(x, mode, &b.line(x.soc)).i < i_load;
        } else {
            mode.empty = false;
        }
        mode
    }
}
