//! Efficiency at an operating point, from powers that `output` gives; derivative for `tangent`.

/// Efficiency of an operating point.
///
/// Source: `[paper]` Eq. (eq:dnn_prediction_efficiency), with P_mech counted once: `τ_e·w_m`
/// already feeds the mechanical losses, so only the electrical ones (copper, core, inverter) are
/// added; absolute values in quadrant IV.
/// ```text
/// τ_e > 0, w_m > 0 (I):   η = P_out/(τ_e w_m + P_el)
/// τ_e > 0, w_m < 0 (IV):  η = (|τ_e w_m| − P_el)/|P_out|
/// ```
/// `P_out` is the power of a quasi-static map, so changes of the stored energy do not affect η. It
/// is limited to [0, 1]: near standstill friction or copper losses exceed the power.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Efficiency {
    numerator: f64,
    denominator: f64,
    generating: bool,
}

/// The powers that make up an efficiency, W (or their derivatives).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Powers {
    /// Shaft power `τ_e·w_m`.
    pub shaft: f64,
    /// Electrical losses.
    pub electrical: f64,
    /// Output of the map.
    pub out: f64,
}

impl Powers {
    fn fraction(self, generating: bool) -> (f64, f64) {
        if generating {
            (-self.shaft - self.electrical, -self.out)
        } else {
            (self.out, self.shaft + self.electrical)
        }
    }
}

/// Whether the efficiency is defined: quadrants I and IV.
pub(crate) fn is_defined(tau_e: f64, w_m: f64) -> bool {
    tau_e > 0.0 && w_m != 0.0
}

impl Efficiency {
    /// The efficiency at torque `tau_e`, N·m, and motor speed `w_m`, rad/s; None where undefined.
    pub(crate) fn new(powers: Powers, tau_e: f64, w_m: f64) -> Option<Self> {
        let generating = w_m < 0.0;
        let (numerator, denominator) = powers.fraction(generating);
        is_defined(tau_e, w_m).then_some(Self {
            numerator,
            denominator,
            generating,
        })
    }

    pub(crate) fn value(self) -> f64 {
        if self.numerator <= 0.0 || self.denominator <= 0.0 {
            return 0.0;
        }
        (self.numerator / self.denominator).min(1.0)
    }

    /// Derivative for the derivatives `dot` of the powers; zero at the ends of [0, 1].
    pub(crate) fn tangent(self, dot: Powers) -> f64 {
        let value = self.value();
        if value <= 0.0 || value >= 1.0 {
            return 0.0;
        }
        let (numerator, denominator) = dot.fraction(self.generating);
        (numerator - value * denominator) / self.denominator
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_defined_in_quadrants_one_and_four() {
        assert!(is_defined(1e-300, 1e-300) && is_defined(1.0, -1.0));
        for (tau_e, w_m) in [
            (0.0, 1.0),
            (0.0, -1.0),
            (1.0, 0.0),
            (-1.0, 1.0),
            (-1.0, -1.0),
        ] {
            assert!(!is_defined(tau_e, w_m), "{tau_e}, {w_m}");
        }
    }

    /// Value and derivative with powers that give nothing, less than nothing, all and more than
    /// all.
    #[test]
    fn it_stays_between_nothing_and_all() {
        let of = |shaft: f64, electrical: f64, out: f64, w_m: f64| {
            let powers = Powers {
                shaft,
                electrical,
                out,
            };
            let dot = Powers {
                shaft: 2.0,
                electrical: 0.5,
                out: 3.0,
            };
            let efficiency = Efficiency::new(powers, 1.0, w_m).expect("a torque");
            (efficiency.value(), efficiency.tangent(dot))
        };
        // Motoring: out/(shaft + electrical); its derivative is (3 − η·2.5)/(shaft + electrical).
        assert_eq!(of(3.0, 1.0, 2.0, 1.0), (0.5, (3.0 - 0.5 * 2.5) / 4.0));
        // Generating: (−shaft − electrical)/(−out).
        assert_eq!(of(-3.0, 1.0, -4.0, -1.0), (0.5, (-2.5 + 0.5 * 3.0) / 4.0));
        assert_eq!(of(3.0, 1.0, 0.0, 1.0), (0.0, 0.0));
        assert_eq!(of(3.0, 1.0, -2.0, 1.0), (0.0, 0.0));
        assert_eq!(of(-1.0, 1.0, 2.0, 1.0), (0.0, 0.0));
        assert_eq!(of(3.0, 1.0, 4.0, 1.0), (1.0, 0.0));
        assert_eq!(of(3.0, 1.0, 5.0, 1.0), (1.0, 0.0));
    }
}
