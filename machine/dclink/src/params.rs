//! Parameters of pack, link, brake chopper and precharge, set by the FMU `DcLink`; their checks.

use model_rules::{ParamError, Range, check, check_fields, require};
use serde::{Deserialize, Serialize};

/// Number of points of the open-circuit voltage, at equal steps of the state of charge from 0 to 1.
pub const POINTS: usize = 21;

/// All parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Params {
    /// The pack.
    pub battery: Battery,
    /// Capacitor and wiring.
    pub link: Link,
    /// The brake chopper.
    pub brake: Brake,
    /// Precharge.
    pub precharge: Precharge,
    /// Voltage below which drives cannot work, V.
    pub v_min: f64,
    /// Voltage above which a warning is due, V.
    pub v_max: f64,
}

/// A battery pack: cells in series.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Battery {
    /// Cells in series.
    pub cells: i32,
    /// Capacity, A·h.
    pub capacity: f64,
    /// Open-circuit voltage of a cell at states of charge 0, 0.05, …, 1, V; linear in between.
    pub ocv: [f64; POINTS],
    /// Series resistance of the pack, Ω.
    pub R_0: f64,
    /// Resistances of the RC pairs, Ω; 0: the pair is left out.
    pub R: [f64; 2],
    /// Time constants of the RC pairs, s.
    pub tau: [f64; 2],
    /// Largest discharge current, A.
    pub discharge_limit: f64,
    /// Largest charge current, A.
    pub charge_limit: f64,
    /// State of charge below which the discharge limit falls linearly, to 0 at 0.
    pub soc_low: f64,
    /// State of charge above which the charge limit falls linearly, to 0 at 1.
    pub soc_high: f64,
    /// Heat capacity, J/K.
    pub heat_capacity: f64,
    /// Heat resistance to the surroundings, K/W.
    pub heat_resistance: f64,
    /// State of charge at the start.
    pub soc_start: f64,
    /// Temperature at the start, K.
    pub T_start: f64,
}

/// Capacitor and wiring.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// Capacitance, F.
    pub C: f64,
    /// Resistance between pack and capacitor, Ω.
    pub R: f64,
}

/// The brake chopper: a resistor that is switched across the link.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Brake {
    /// Whether there is one.
    pub fitted: bool,
    /// Resistance, Ω.
    pub R: f64,
    /// Voltage at which it is switched on, V.
    pub v_on: f64,
    /// Voltage at which it is switched off, V.
    pub v_off: f64,
}

/// How the capacitor is charged at the start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Precharge {
    /// Whether the capacitor is precharged; otherwise it starts at the pack's voltage.
    pub on: bool,
    /// The resistor, Ω.
    pub R: f64,
    /// Voltage of the capacitor at the start, V.
    pub v_start: f64,
    /// Share of the pack's voltage at which the resistor is bypassed.
    pub share: f64,
}

impl Params {
    /// A pack of 200 LFP cells (12.9 kWh), with link and chopper for three drives of 10 kW. Typical
    /// values, not those of a product.
    pub const REFERENCE: Self = Self {
        battery: Battery {
            cells: 200,
            capacity: 20.0,
            // Steep at both ends, flat between, as lithium iron phosphate is.
            ocv: [
                3.000, 3.100, 3.175, 3.205, 3.225, 3.240, 3.250, 3.257, 3.263, 3.268, 3.272, 3.276,
                3.280, 3.284, 3.288, 3.292, 3.296, 3.300, 3.306, 3.325, 3.400,
            ],
            R_0: 0.12,
            R: [0.08, 0.0],
            tau: [30.0, 600.0],
            discharge_limit: 60.0,
            charge_limit: 20.0,
            soc_low: 0.05,
            soc_high: 0.95,
            heat_capacity: 60e3,
            heat_resistance: 0.5,
            soc_start: 0.8,
            T_start: 293.15,
        },
        link: Link { C: 12e-3, R: 0.02 },
        brake: Brake {
            fitted: true,
            R: 20.0,
            v_on: 750.0,
            v_off: 730.0,
        },
        precharge: Precharge {
            on: false,
            R: 50.0,
            v_start: 0.0,
            share: 0.95,
        },
        v_min: 450.0,
        v_max: 850.0,
    };

    pub(crate) fn check(&self) -> Result<(), ParamError> {
        let Self {
            battery: b,
            link,
            brake,
            precharge,
            ..
        } = self;
        check_fields! { self;
            Positive: battery.capacity, battery.heat_capacity, battery.heat_resistance,
                battery.T_start, link.C, brake.R, brake.v_off;
            NotNegative: battery.R_0, battery.discharge_limit, battery.charge_limit, precharge.R,
                precharge.v_start, v_min;
            Share: battery.soc_low, battery.soc_high, battery.soc_start;
        }?;
        let positive = [
            ("battery.cells", f64::from(b.cells)),
            ("battery.tau_1", b.tau[0]),
            ("battery.tau_2", b.tau[1]),
        ];
        check(Range::Positive, positive)?;
        let not_negative = [("battery.R_1", b.R[0]), ("battery.R_2", b.R[1])];
        check(Range::NotNegative, not_negative)?;
        let rule = "finite, ≥ 0, and > 0 together with battery.R_0";
        let has_resistance = link.R >= 0.0 && link.R + b.R_0 > 0.0;
        require("link.R", link.R, rule, has_resistance)?;
        let (v_on, share) = (brake.v_on, precharge.share);
        require("brake.v_on", v_on, "above brake.v_off", v_on > brake.v_off)?;
        let rule = "above 0 and below 1";
        require("precharge.share", share, rule, share > 0.0 && share < 1.0)?;
        require("v_max", self.v_max, "above v_min", self.v_max > self.v_min)?;
        let rises = |pair: &[f64]| pair[0] > 0.0 && pair[1] >= pair[0] && pair[1].is_finite();
        match b.ocv.windows(2).find(|pair| !rises(pair)) {
            None => Ok(()),
            Some(pair) => {
                let rule = "positive and nowhere falling";
                require("battery.ocv", pair[1], rule, false)
            }
        }
    }
}
