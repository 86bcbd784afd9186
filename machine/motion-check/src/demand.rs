//! Inverse dynamics of the machine, for path check and studies: the rod forces, strokes and speeds,
//! wrist torques, motor torques, currents and voltages that a joint motion requires.

use crate::quantity::Quantity;
use emla::maps;
use hdrm::{DOF, Hdrm, HdrmError, Load, Options, State};
use machine_file::{Emla, Machine};
use serde::{Deserialize, Serialize};

/// A payload held rigidly at the end-effector.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Payload {
    /// Mass, kg; the inertia of the machine file's payload is scaled with it.
    pub mass: f64,
    /// Centre of mass in D4's axes, m.
    pub com: [f64; 3],
}

impl Payload {
    /// The payload of the machine file.
    pub fn from_machine(machine: &Machine) -> Self {
        let body = &machine.bodies.PL;
        Self {
            mass: body.mass,
            com: body.com,
        }
    }
}

/// Joint motion at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Angles, rad.
    pub zeta: [f64; DOF],
    /// Rates, rad/s.
    pub zeta_dot: [f64; DOF],
    /// Accelerations, rad/s².
    pub zeta_ddot: [f64; DOF],
}

impl Motion {
    /// Rest in the pose `zeta`, rad.
    pub fn rest(zeta: [f64; DOF]) -> Self {
        Self {
            zeta,
            zeta_dot: [0.0; DOF],
            zeta_ddot: [0.0; DOF],
        }
    }
}

/// What a motion requires at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// Joint angles, rad.
    pub zeta: [f64; DOF],
    /// Strokes of slew, lift and tilt, m.
    pub x: [f64; 3],
    /// Rod speeds, m/s.
    pub x_dot: [f64; 3],
    /// Actuator forces on the manipulator, N, positive when extending.
    pub f: [f64; 3],
    /// Wrist torques, N·m.
    pub tau_wrist: [f64; 3],
    /// Motor speeds, rad/s.
    pub w_m: [f64; 3],
    /// Motor torques, N·m.
    pub tau_e: [f64; 3],
    /// Quadrature-axis currents (peak), A, at no direct-axis current.
    pub i_q: [f64; 3],
    /// Lengths of the voltage vectors (peak), V.
    pub v: [f64; 3],
}

impl Demand {
    /// Value of a quantity, SI unit.
    pub fn value(&self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Joint(k) => self.zeta[k],
            Quantity::Stroke(k) => self.x[k],
            Quantity::RodSpeed(k) => self.x_dot[k],
            Quantity::Force(k) => self.f[k],
            Quantity::WristTorque(k) => self.tau_wrist[k],
            Quantity::MotorSpeed(k) => self.w_m[k],
            Quantity::Current(k) => self.i_q[k],
            Quantity::Voltage(k) => self.v[k],
        }
    }
}

/// Inverse dynamics of a machine with a payload.
#[derive(Clone, Debug)]
pub struct DemandModel {
    plant: Hdrm,
    /// Slew, lift, tilt.
    actuators: [Emla; 3],
}

impl DemandModel {
    /// The nominal machine with `payload`; mass 0: none.
    pub fn new(machine: &Machine, payload: &Payload) -> Result<Self, HdrmError> {
        Self::with_load(machine, payload, 0.0, [0.0; 3])
    }

    /// As [`DemandModel::new`], with a load besides the payload: a point mass `mass`, kg, at `com`,
    /// m, from the tip T4 in T4's axes.
    pub fn with_load(
        machine: &Machine,
        payload: &Payload,
        mass: f64,
        com: [f64; 3],
    ) -> Result<Self, HdrmError> {
        let load = Load {
            payload_mass: payload.mass,
            payload_com: payload.com,
            mass,
            com,
        };
        let options = Options {
            load,
            ..Options::from_machine(machine)
        };
        Ok(Self {
            plant: Hdrm::new(machine, &options)?,
            actuators: machine.emla.in_order().map(|p| *p),
        })
    }

    /// The manipulator without its drives.
    pub fn plant(&self) -> &Hdrm {
        &self.plant
    }

    /// What `motion` requires, without end stops and contact.
    ///
    /// The motors follow the rods rigidly: `w_m = ẋ/travel`, `ẇ_m = ẍ/travel` with `ẍ = x'·ζ̈ +
    /// x''·ζ̇²`.
    pub fn demand(&self, motion: &Motion) -> Demand {
        let (zeta, zeta_dot, zeta_ddot) = (motion.zeta, motion.zeta_dot, motion.zeta_ddot);
        let state = State {
            zeta,
            zeta_dot,
            ..State::default()
        };
        let (f, tau_wrist) = self.plant.inverse_dynamics(&state, &zeta_ddot, &[0.0; DOF]);
        let strokes = self.plant.tree().configuration(&zeta).strokes;
        let x_dot: [f64; 3] = std::array::from_fn(|i| strokes[i].prime * zeta_dot[i]);
        let motors: [[f64; 4]; 3] = std::array::from_fn(|i| {
            let w = zeta_dot[i];
            let x_ddot = strokes[i].prime * zeta_ddot[i] + strokes[i].second * w * w;
            motor_demand(&self.actuators[i], f[i], x_dot[i], x_ddot)
        });
        Demand {
            zeta,
            x: strokes.map(|stroke| stroke.x),
            x_dot,
            f,
            tau_wrist,
            w_m: motors.map(|[w_m, ..]| w_m),
            tau_e: motors.map(|[_, tau_e, ..]| tau_e),
            i_q: motors.map(|[_, _, i_q, _]| i_q),
            v: motors.map(|[.., v]| v),
        }
    }
}

/// Speed, torque, current and voltage of a motor whose actuator exerts the force `F`, N, at the rod
/// speed `x_dot`, m/s, and acceleration `x_ddot`, m/s²; with `i_d = 0` and slowly changing currents
/// ```text
/// i_q = τ_e/(3/2·p·λ_m),   v_d = −p w_m L_q i_q,   v_q = R_s i_q + p w_m λ_m
/// ```
fn motor_demand(p: &Emla, F: f64, x_dot: f64, x_ddot: f64) -> [f64; 4] {
    let travel = maps::travel_per_radian(p);
    let w_m = x_dot / travel;
    let tau_e = maps::required_torque(p, F, w_m, x_ddot / travel);
    let pairs = f64::from(p.p);
    let i_q = tau_e / (1.5 * pairs * p.lambda_m);
    let v_d = -pairs * w_m * p.L_q * i_q;
    let v_q = p.R_s * i_q + pairs * w_m * p.lambda_m;
    [w_m, tau_e, i_q, libm::hypot(v_d, v_q)]
}
