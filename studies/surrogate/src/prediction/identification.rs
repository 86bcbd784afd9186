//! Fits the actuator's winding, magnets and friction to a campaign, and as a check the friction's
//! dependence on temperature, stroke and direction. For `data`, `compare` and `experiments`.

use emla::maps;
use machine_file::Emla;

use crate::measurement::profile::MID_STROKE;
use crate::measurement::windows::{Window, data_sheet};
use crate::prediction::least_squares::Fit;

/// Width of the current's range around 0 in which the voltage lost to the dead time changes its
/// sign, A.
const DEAD_TIME_CURRENT: f64 = 1.0;

/// The fitted parameters.
pub struct Identification {
    /// The machine's actuator with fitted magnets.
    pub electrical: Emla,
    /// The same with fitted friction.
    pub refitted: Emla,
    /// R_s, its rise with temperature, λ_m, its rise, and the voltage lost to the dead time.
    voltage: Fit<5>,
    /// τ_C, C_m, η.
    friction: Fit<3>,
    /// The same three, and friction by temperature, N/K, by position, N/m, and by direction, N.
    further: Fit<6>,
}

impl Identification {
    /// Fits the parameters to the windows of each profile of a campaign. The voltage equation in
    /// steady rotation:
    /// ```text
    /// v_q − ω_e L_d i_d − L_q di_q/dt = R (1 + α_Cu ΔT_w) i_q + λ (1 + α_m ΔT_h) ω_e + V_0 tanh(i_q/1 A)
    /// ```
    /// The force at constant speed, `F = F_qs(τ, ω)` with the torque by the fitted magnets, gives
    /// the motor's Coulomb and viscous friction and the gear's efficiency. The viscous friction of
    /// screw and rod cannot be told from the motor's; it stays nominal.
    pub fn new(p: &Emla, campaign: &[Vec<Window>]) -> Self {
        let sheet = data_sheet(p);
        let warm = |T: f64| T - sheet.reference;
        let pairs = f64::from(p.p);
        let first = [
            p.R_s,
            p.R_s * sheet.copper,
            p.lambda_m,
            p.lambda_m * sheet.magnet,
            0.0,
        ];
        let sizes = [p.R_s, p.R_s * 0.01, p.lambda_m, p.lambda_m * 0.01, 1.0];
        let voltage = Fit::new(first, sizes, campaign, |b, window| {
            let (row, w_e) = (&window.row, pairs * window.row.w_m);
            let v = row.v_q - w_e * p.L_d * row.i_d - p.L_q * window.i_q_dot;
            (b[0] + b[1] * warm(row.T_winding)) * row.i_q
                + (b[2] + b[3] * warm(row.T_housing)) * w_e
                + b[4] * (row.i_q / DEAD_TIME_CURRENT).tanh()
                - v
        });
        // The fitted resistance includes the inverter's drop, whose losses count separately.
        let [_, _, lambda_m, lambda_rise, _] = voltage.values;
        let electrical = Emla {
            lambda_m,
            temperature: Some(machine_file::Temperature {
                magnet: lambda_rise / lambda_m,
                ..sheet
            }),
            ..*p
        };
        let with = |tau_C, C_m, eta_gear| Emla {
            tau_C,
            C_m,
            eta_gear,
            ..electrical
        };
        let force = |b: &[f64], window: &Window| {
            let (torque, row) = (window.torque(&electrical), &window.row);
            maps::quasi_static_force(&with(b[0], b[1], b[2]), torque, row.w_m) - row.f_ext
        };
        let start = [p.tau_C, p.C_m, p.eta_gear];
        let friction = Fit::new(start, [1.0, 0.01, 0.1], campaign, |b, w| force(b, w));
        let [tau_C, C_m, eta] = friction.values;
        let sizes = [1.0, 0.01, 0.1, 10.0, 1e3, 100.0];
        let further = Fit::new([tau_C, C_m, eta, 0.0, 0.0, 0.0], sizes, campaign, |b, w| {
            let row = &w.row;
            let resistance = b[3] * warm(row.T_housing) + b[4] * (row.x - MID_STROKE);
            force(b, w) - row.w_m.signum() * resistance - b[5]
        });
        Self {
            electrical,
            refitted: with(tau_C, C_m, eta),
            voltage,
            friction,
            further,
        }
    }

    /// The table of all parameters with their intervals.
    pub fn text(&self, p: &Emla) -> String {
        let sheet = data_sheet(p);
        let of_voltage = self.voltage.values.into_iter().zip(self.voltage.half);
        let of_friction = self.friction.values.into_iter().zip(self.friction.half);
        let of_further = self.further.values.into_iter().zip(self.further.half);
        let fitted = of_voltage.chain(of_friction).chain(of_further.skip(3));
        let as_it_is = [
            ("R_s, ohm", p.R_s),
            ("rise of R_s, ohm/K", p.R_s * sheet.copper),
            ("lambda_m, Wb", p.lambda_m),
            ("rise of lambda_m, Wb/K", p.lambda_m * sheet.magnet),
            ("dead time, V", 0.0),
            ("tau_C, N.m", p.tau_C),
            ("C_m, N.m.s/rad", p.C_m),
            ("eta_gear", p.eta_gear),
            ("friction by temperature, N/K", 0.0),
            ("friction along the stroke, N/m", 0.0),
            ("force by direction, N", 0.0),
        ];
        let mut text =
            "parameter                           as it is      fitted   +- (95 %)\n".to_owned();
        for ((name, nominal), (value, half)) in as_it_is.into_iter().zip(fitted) {
            text += &format!("{name:<32}{nominal:>12.4e}{value:>12.4e}{half:>12.1e}\n");
        }
        let (voltage, friction, further) = (self.voltage.rms, self.friction.rms, self.further.rms);
        text + &format!(
            "residuals, root mean square: voltage {voltage:.2} V, force {friction:.0} N, {further:.0} N with temperature, stroke and direction\n"
        )
    }
}
