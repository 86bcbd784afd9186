//! Parameters of the effects that the idealised actuator neglects, in groups that the FMU `Rig` and
//! the studies switch on and off, with their checks.

use model_rules::{ParamError, check_fields, require};
use serde::{Deserialize, Serialize};

/// The effects beyond the idealised actuator. A group acts only if its `on` is true.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Extras {
    /// Magnetic saturation of the quadrature axis.
    pub saturation: Saturation,
    /// Winding and magnets at temperature.
    pub temperature: Temperature,
    /// Harmonics of the magnets' flux.
    pub ripple: Ripple,
    /// Cogging torque.
    pub cogging: Cogging,
    /// Inverter that samples and holds.
    pub switching: Switching,
    /// Dry friction with presliding, gear drag.
    pub friction: Friction,
    /// Play between nut and rod.
    pub backlash: Backlash,
    /// Mounting, pins, torsion.
    pub compliance: Compliance,
    /// Damping in the parts where it arises.
    pub damping: Damping,
    /// Core and inverter losses.
    pub losses: Losses,
    /// Temperatures of winding and housing.
    pub heat: Heat,
}

/// Magnetic saturation: `λ_q = L_q i_q/(1 + a·|i_q|)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Saturation {
    /// Switch.
    pub on: bool,
    /// Share by which `λ_q/i_q` is less at `i_max` than at 0.
    pub share: f64,
}

/// Resistance and magnets at temperature.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Temperature {
    /// Switch.
    pub on: bool,
    /// Temperature at which the parameters hold, K.
    pub reference: f64,
    /// Rise of the winding's resistance, 1/K.
    pub copper: f64,
    /// Rise of the magnets' flux, 1/K (negative).
    pub magnet: f64,
}

/// Harmonics of the magnets' flux over the electrical angle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ripple {
    /// Switch.
    pub on: bool,
    /// Amplitude of the 6th, as a part of λ_m.
    pub sixth: f64,
    /// Amplitude of the 12th, as a part of λ_m.
    pub twelfth: f64,
}

/// Cogging torque `torque·sin(per_turn·θ_m)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cogging {
    /// Switch.
    pub on: bool,
    /// Amplitude, N·m.
    pub torque: f64,
    /// Periods per turn of the motor.
    pub per_turn: f64,
}

/// Inverter that samples at the switching frequency of the machine's section `inverter`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Switching {
    /// Switch; off: an inverter that applies the commanded dq voltages at once.
    pub on: bool,
    /// Whether the voltages are rotated ahead to compensate the rotor's motion until they act.
    pub advance: bool,
    /// Dead time between the two devices of a leg, s.
    pub dead_time: f64,
    /// Current over which the dead time's effect changes sign, A.
    pub i_0: f64,
    /// Error of the rotor's electrical angle in the drive, rad: it rotates the commanded voltages
    /// and the measured currents.
    pub offset: f64,
}

/// Friction of bearings, gear, screw, nut and seals. Switched on, it replaces the idealised gear
/// efficiency and the motor's smooth Coulomb friction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Friction {
    /// Switch.
    pub on: bool,
    /// Breakaway over Coulomb friction.
    pub breakaway: f64,
    /// Stribeck speed of the nut, m/s.
    pub v_stribeck: f64,
    /// Stiffness of the bristles at the nut, N/m.
    pub stiffness: f64,
    /// Damping of the bristles at rest, N·s/m.
    pub damping: f64,
    /// Coulomb friction of the preloaded screw and nut, N·m at the screw.
    pub screw_drag: f64,
    /// Rolling friction over the nut's force.
    pub screw_loss: f64,
    /// Coulomb friction of the rod's seals, N; acts on the nut.
    pub seal: f64,
    /// Coulomb friction of the gear without load, N·m at the motor.
    pub gear_drag: f64,
    /// Viscous drag of the gear, N·m·s/rad at the motor.
    pub gear_viscous: f64,
    /// Friction of the gear's mesh over the transmitted torque.
    pub gear_loss: f64,
    /// Windage, N·m·s²/rad² at the motor.
    pub windage: f64,
    /// Force over which the load-dependent friction sets in, N.
    pub f_smooth: f64,
    /// Dry friction out is 1 + a times, in 1 − a times what the other values say.
    pub asymmetry: f64,
}

/// Play between nut and rod.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Backlash {
    /// Switch.
    pub on: bool,
    /// Whole width, m.
    pub width: f64,
    /// Deflection over which the damping of the contact sets in, m.
    pub contact: f64,
}

/// Compliances in series with nut, screw and rod.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compliance {
    /// Switch.
    pub on: bool,
    /// Stiffness of mounting and pins, N/m.
    pub mount: f64,
    /// Torsional stiffness of gear and coupling at the screw, N·m/rad.
    pub torsion: f64,
}

/// Damping between nut and rod. Switched on, `C_b` is the damping of screw, nut and bearings alone,
/// and the mounting has its own damper; switched off, `C_b` is that of all together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Damping {
    /// Switch.
    pub on: bool,
    /// Damper in parallel with the compliance of mounting, pins and torsion, N·s/m.
    pub mount: f64,
}

/// Factors on the losses of the machine file's sections `core` and `inverter`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Losses {
    /// Switch.
    pub on: bool,
    /// Factor on the core losses.
    pub core: f64,
    /// Factor on the inverter losses.
    pub inverter: f64,
}

/// Winding and housing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Heat {
    /// Switch; off: temperatures are constant.
    pub on: bool,
    /// Heat capacity of the winding, J/K.
    pub C_w: f64,
    /// Thermal resistance from winding to housing, K/W.
    pub R_wh: f64,
    /// Heat capacity of the housing, J/K.
    pub C_h: f64,
    /// Thermal resistance from housing to the air around it, K/W.
    pub R_ha: f64,
}

impl Extras {
    /// All effects on except [`Damping`], with typical values for a servo motor of 11.6 kW with
    /// planetary gear and preloaded ball screw: 20 % saturation at the peak current; copper and
    /// NdFeB magnets (handbook values); 1 % flux harmonics; 24 cogging periods (8 poles, 12 slots);
    /// 2 µs dead time (IGBT modules); breakaway 1.3 times the Coulomb friction; 40 µm play of nut
    /// and pins; 60 N/µm for mounting and pins; 2 kJ/K for copper and teeth, 15 kJ/K for housing
    /// and gear.
    pub const AS_BUILT: Self = Self {
        saturation: Saturation {
            on: true,
            share: 0.2,
        },
        temperature: Temperature {
            on: true,
            reference: 293.15,
            copper: 0.003_93,
            magnet: -0.0011,
        },
        ripple: Ripple {
            on: true,
            sixth: 0.01,
            twelfth: 0.01,
        },
        cogging: Cogging {
            on: true,
            torque: 0.06,
            per_turn: 24.0,
        },
        switching: Switching {
            on: true,
            advance: true,
            dead_time: 2e-6,
            i_0: 0.5,
            offset: 0.0,
        },
        friction: Friction {
            on: true,
            breakaway: 1.3,
            v_stribeck: 5e-3,
            stiffness: 2e8,
            damping: 2e5,
            screw_drag: 0.5,
            screw_loss: 0.026,
            seal: 260.0,
            gear_drag: 0.14,
            gear_viscous: 0.0012,
            gear_loss: 0.05,
            windage: 4e-6,
            f_smooth: 900.0,
            asymmetry: 0.0,
        },
        backlash: Backlash {
            on: true,
            width: 40e-6,
            contact: 5e-6,
        },
        compliance: Compliance {
            on: true,
            mount: 6e7,
            torsion: 2e4,
        },
        damping: Damping {
            on: false,
            mount: 2e4,
        },
        losses: Losses {
            on: true,
            core: 1.15,
            inverter: 1.10,
        },
        heat: Heat {
            on: true,
            C_w: 2e3,
            R_wh: 0.06,
            C_h: 15e3,
            R_ha: 0.15,
        },
    };

    /// The same values with every switch off: the idealised actuator.
    #[must_use]
    pub const fn off(mut self) -> Self {
        self.saturation.on = false;
        self.temperature.on = false;
        self.ripple.on = false;
        self.cogging.on = false;
        self.switching.on = false;
        self.friction.on = false;
        self.backlash.on = false;
        self.compliance.on = false;
        self.damping.on = false;
        self.losses.on = false;
        self.heat.on = false;
        self
    }

    /// Takes the values of heat and temperature from a machine file.
    #[must_use]
    pub fn with_machine(
        self,
        heat: &machine_file::Heat,
        temperature: &machine_file::Temperature,
    ) -> Self {
        Self {
            heat: Heat {
                on: self.heat.on,
                C_w: heat.C_w,
                R_wh: heat.R_wh,
                C_h: heat.C_h,
                R_ha: heat.R_ha,
            },
            temperature: Temperature {
                on: self.temperature.on,
                reference: temperature.reference,
                copper: temperature.copper,
                magnet: temperature.magnet,
            },
            ..self
        }
    }

    /// Checks every value, also of groups that are off.
    pub(crate) fn check(&self, p: &machine_file::Emla) -> Result<(), ParamError> {
        check_fields! { self;
            Positive: temperature.reference, cogging.per_turn, switching.i_0, friction.v_stribeck,
                friction.stiffness, friction.f_smooth, backlash.contact, compliance.mount,
                compliance.torsion, heat.C_w, heat.R_wh, heat.C_h, heat.R_ha;
            NotNegative: ripple.sixth, ripple.twelfth, cogging.torque, switching.dead_time,
                friction.damping, friction.screw_drag, friction.screw_loss, friction.seal,
                friction.gear_drag, friction.gear_viscous, friction.gear_loss, friction.windage,
                damping.mount, backlash.width, losses.core, losses.inverter;
            Asymmetry: friction.asymmetry;
        }?;
        let share = self.saturation.share;
        require(
            "saturation.share",
            share,
            "in [0, 1)",
            (0.0..1.0).contains(&share),
        )?;
        let (breakaway, rule) = (self.friction.breakaway, "finite and ≥ 1");
        require("friction.breakaway", breakaway, rule, breakaway >= 1.0)?;
        let offset = self.switching.offset;
        require(
            "switching.offset",
            offset,
            "between -π/2 and π/2",
            offset.abs() <= std::f64::consts::FRAC_PI_2,
        )?;
        let t = &self.temperature;
        for (name, value) in [
            ("temperature.copper", t.copper),
            ("temperature.magnet", t.magnet),
        ] {
            require(name, value, "between -0.1 and 0.1", value.abs() <= 0.1)?;
        }
        let f_sw = p.inverter.map_or(0.0, |inverter| inverter.f_sw);
        let samples = !self.switching.on || f_sw >= 100.0;
        let rule = "at least 100 Hz while switching is on";
        require("inverter.f_sw", f_sw, rule, samples)
    }
}
