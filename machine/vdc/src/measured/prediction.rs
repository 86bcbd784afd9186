//! Predicts measurements one communication step ahead, so that `controller` can compensate delays.

use crate::drive::Reading;
use crate::error::ControllerError;
use crate::nominal::Nominal;
use crate::reference::turn_orientation;
use crate::signals::Input;
use emla::{Emla, maps};
use hdrm::DOF;
use serde::{Deserialize, Serialize};

/// Planned voltages and accelerations of one communication step.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Plan {
    /// Voltages of the drives, V.
    pub(crate) v_d: [f64; 3],
    pub(crate) v_q: [f64; 3],
    /// Required joint accelerations, rad/s², which the machine is assumed to follow.
    pub(crate) zeta_ddot: [f64; DOF],
    /// Required rod accelerations, m/s².
    pub(crate) x_ddot: [f64; 3],
    /// Strokes, m, and their derivatives by the joint angles, m/rad; None for single rods.
    pub(crate) strokes: Option<[[f64; 2]; 3]>,
}

/// The measurements and the external reference after a step of `h` s in which `planned` acts, with
/// the nominal actuators and the network's weight `alpha`.
///
/// Joints and rods are assumed to follow the required accelerations: differentiating the measured
/// rates would double their noise. Currents, motor speeds and forces are computed with the nominal
/// actuator under the planned voltages; it starts from the measured force, so `F` must be
/// connected. `lead` is the time, s, over which that force is already predicted
/// ([`Emla::with_delay`]).
pub(crate) fn predict(
    nominal: &Nominal,
    alpha: f64,
    input: &Input,
    planned: &Plan,
    lead: f64,
    t: f64,
    h: f64,
) -> Result<Input, ControllerError> {
    let mut next = *input;
    let moved = |x: f64, v: f64, a: f64| (x + h * (v + 0.5 * h * a), v + h * a);
    for j in 0..DOF {
        (next.zeta[j], next.zeta_dot[j]) =
            moved(input.zeta[j], input.zeta_dot[j], planned.zeta_ddot[j]);
    }
    for i in 0..3 {
        let drive = nominal.actuator(i, alpha);
        let (x, x_dot) = match planned.strokes {
            Some(strokes) => (strokes[i][0], strokes[i][1] * input.zeta_dot[i]),
            None => (input.x[i], input.x_dot[i]),
        };
        let rod = Rod {
            x,
            x_dot,
            x_ddot: planned.x_ddot[i],
        };
        let acting = |s: f64| emla::Input {
            v_dc: input.v_dc,
            ..rod.at(s, planned.v_d[i], planned.v_q[i])
        };
        let start = rod.drive_state(&drive, &Reading::from_input(input, i), lead);
        let end = drive.step(&start, acting, t, h)?;
        let y = drive.output(&end, &acting(h));
        (next.i_d[i], next.i_q[i]) = (end.i_d, end.i_q);
        (next.w_m[i], next.F[i]) = (end.w_m, y.F);
        (next.x[i], next.x_dot[i]) = moved(input.x[i], x_dot, rod.x_ddot);
        (
            next.reference_rod_position[i],
            next.reference_rod_velocity[i],
        ) = moved(
            input.reference_rod_position[i],
            input.reference_rod_velocity[i],
            input.reference_rod_acceleration[i],
        );
        (next.reference_position[i], next.reference_velocity[i]) = moved(
            input.reference_position[i],
            input.reference_velocity[i],
            input.reference_acceleration[i],
        );
    }
    next.reference_orientation = turn_orientation(input, h);
    Ok(next)
}

/// Motion of a rod at the beginning of a step, at constant acceleration: m, m/s, m/s².
#[derive(Clone, Copy)]
struct Rod {
    x: f64,
    x_dot: f64,
    x_ddot: f64,
}

impl Rod {
    fn at(&self, s: f64, v_d: f64, v_q: f64) -> emla::Input {
        emla::Input {
            v_d,
            v_q,
            x: self.x + s * (self.x_dot + 0.5 * s * self.x_ddot),
            x_dot: self.x_dot + s * self.x_ddot,
            ..emla::Input::default()
        }
    }

    /// The actuator's state for this rod motion and the force `now.F`, predicted by `lead`, s.
    fn drive_state(&self, drive: &Emla, now: &Reading, lead: f64) -> emla::State {
        let p = drive.params();
        let travel = maps::travel_per_radian(p);
        let stretch_dot = travel * now.w_m - self.x_dot;
        let K_b = maps::stiffness(p, self.x);
        let F = now.F - lead * K_b * stretch_dot;
        let stretch = (F + p.C_act * self.x_dot - p.C_b * stretch_dot) / K_b;
        emla::State {
            i_d: now.i_d,
            i_q: now.i_q,
            w_m: now.w_m,
            theta_m: (self.x + stretch) / travel,
            residual: drive.residual(maps::torque(p, now.i_d, now.i_q), now.w_m),
            ..emla::State::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use emla::{Drive, Surrogate};
    use machine_file::Machine;

    const H: f64 = 1e-3;

    /// What is predicted is what the actuators themselves do, with the network's share and with a
    /// link that does not give the planned voltages. Tolerance: the nut's place is found from the
    /// force through a stiffness of 1e8 N/m, ε·0.3 m of it.
    #[test]
    fn the_prediction_is_what_the_actuators_do() {
        let machine = Machine::reference();
        let network = Surrogate::reference();
        for (alpha, v_dc) in [(0.0, None), (1.0, None), (0.4, Some(20.0))] {
            let rod = Rod {
                x: 0.3,
                x_dot: 0.02,
                x_ddot: 0.5,
            };
            let (v_d, v_q) = (-4.0, 31.0);
            let planned = Plan {
                v_d: [v_d; 3],
                v_q: [v_q; 3],
                x_ddot: [rod.x_ddot; 3],
                zeta_ddot: [2.0, -1.0, 3.0, 0.5, -0.5, 4.0],
                ..Plan::default()
            };
            let mut input = Input {
                v_dc,
                x: [rod.x; 3],
                x_dot: [rod.x_dot; 3],
                zeta: [0.1, 0.2, -0.3, 0.4, 0.5, 0.6],
                zeta_dot: [0.3, -0.2, 0.1, 0.5, -0.4, 0.2],
                reference_position: [1.0, 2.0, 3.0],
                reference_velocity: [0.5, -0.25, 0.125],
                reference_acceleration: [4.0, 8.0, -2.0],
                reference_orientation: [0.8, 0.0, 0.6, 0.0],
                reference_angular_velocity: [0.0, 30.0, 0.0],
                reference_rod_position: [0.1, 0.2, 0.3],
                reference_rod_velocity: [0.25, 0.5, -0.5],
                reference_rod_acceleration: [2.0, -4.0, 8.0],
                ..Input::default()
            };
            let acting = |s: f64| emla::Input {
                v_dc,
                ..rod.at(s, v_d, v_q)
            };
            let actuators = machine.emla.in_order().map(|p| {
                Emla::new(*p, Drive::Motion)
                    .expect("valid")
                    .with_surrogate(network.clone(), alpha)
            });
            let starts = [0, 1, 2].map(|i| {
                let start = emla::Input {
                    F_hold: 21e3,
                    ..acting(0.0)
                };
                emla::State {
                    w_m: 30.0,
                    i_d: 0.3,
                    ..actuators[i].start(&start).expect("finite")
                }
            });
            // The held residual belongs to the point at which the step begins.
            let starts = [0, 1, 2].map(|i| {
                let (s, p) = (starts[i], actuators[i].params());
                let tau_e = maps::torque(p, s.i_d, s.i_q);
                emla::State {
                    residual: actuators[i].residual(tau_e, s.w_m),
                    ..s
                }
            });
            for i in 0..3 {
                let y = actuators[i].output(&starts[i], &acting(0.0));
                (input.i_d[i], input.i_q[i], input.w_m[i]) = (y.i_d, y.i_q, y.w_m);
                input.F[i] = y.F;
            }
            let nominal = Nominal::new(&machine, &network).expect("works");
            let next = predict(&nominal, alpha, &input, &planned, 0.0, 0.0, H).expect("finite");
            for i in 0..3 {
                let end = actuators[i]
                    .step(&starts[i], acting, 0.0, H)
                    .expect("finite");
                let y = actuators[i].output(&end, &acting(H));
                assert!((next.F[i] - y.F).abs() < 1e-6, "{} {}", next.F[i], y.F);
                assert!((next.w_m[i] - y.w_m).abs() < 1e-9, "{}", next.w_m[i]);
                assert!((next.i_q[i] - y.i_q).abs() < 1e-9, "{}", next.i_q[i]);
                assert!((next.i_d[i] - y.i_d).abs() < 1e-9, "{}", next.i_d[i]);
                assert!((y.i_q - input.i_q[i]).abs() > 1e-3, "it changes: {}", y.i_q);
                let Rod { x, x_dot, .. } = rod;
                assert_eq!(next.x_dot[i], x_dot + H * rod.x_ddot);
                assert_eq!(next.x[i], x + H * (x_dot + 0.5 * H * rod.x_ddot));
            }
            // All else moves with its rate and a constant acceleration.
            let moves = |[x, v, a, x_next, v_next]: [f64; 5]| {
                let (x_end, v_end) = (x + H * v + 0.5 * H * H * a, v + H * a);
                (x_next - x_end).abs() < 1e-15 && (v_next - v_end).abs() < 1e-15
            };
            for j in 0..DOF {
                let (zeta, rate) = (input.zeta[j], input.zeta_dot[j]);
                let end = [next.zeta[j], next.zeta_dot[j]];
                assert!(moves([zeta, rate, planned.zeta_ddot[j], end[0], end[1]]));
            }
            for k in 0..3 {
                assert!(moves([
                    input.reference_position[k],
                    input.reference_velocity[k],
                    input.reference_acceleration[k],
                    next.reference_position[k],
                    next.reference_velocity[k],
                ]));
                assert!(moves([
                    input.reference_rod_position[k],
                    input.reference_rod_velocity[k],
                    input.reference_rod_acceleration[k],
                    next.reference_rod_position[k],
                    next.reference_rod_velocity[k],
                ]));
            }
            // A turn about y by 2·atan(0.6/0.8), and 0.03 rad more about the same axis.
            let half = 0.6_f64.atan2(0.8) + 0.015;
            let [w, x, y, z] = next.reference_orientation;
            assert!((w - half.cos()).abs() < 1e-15 && (y - half.sin()).abs() < 1e-15);
            assert_eq!([x, z], [0.0; 2]);
        }
    }
}
