//! Demands against forward dynamics, against a hand calculation, and inverse against forward
//! kinematics.
#![allow(non_snake_case)]

use hdrm::{Hdrm, Input, Options, State};
use machine_file::Machine;
use motion_check::{
    AllowedRanges, DemandModel, Kinematics, Motion, Payload, Pose, Quantity, TipMotion,
};
use nalgebra::{UnitQuaternion, Vector3, Vector6};

/// Seeded numbers in [−1, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn array<const N: usize>(&mut self, scale: f64) -> [f64; N] {
        std::array::from_fn(|_| scale * self.next())
    }

    /// In the middle 80 % of each joint's range, away from the end stops.
    fn zeta(&mut self, machine: &Machine) -> [f64; 6] {
        let ranges = machine.limits.zeta();
        ranges.map(|[min, max]| 0.5 * (min + max) + 0.4 * (max - min) * self.next())
    }
}

/// Oracle: forward dynamics, which takes another path than inverse dynamics, of the machine with
/// that payload, its inertia written into the machine file.
#[test]
fn forward_dynamics_under_the_demanded_forces_gives_the_acceleration_back() {
    let machine = Machine::reference();
    let mut random = Random(0x5eed);
    for case in 0..200 {
        let payload = Payload {
            mass: 310.0 + 290.0 * random.next(),
            com: [0.37, -0.06, 0.11],
        };
        let motion = Motion {
            zeta: random.zeta(&machine),
            zeta_dot: random.array(0.4),
            zeta_ddot: random.array(0.8),
        };
        let capability = DemandModel::new(&machine, &payload).expect("valid");
        let demand = capability.demand(&motion);

        let mut file = machine.clone();
        let body = &mut file.bodies.PL;
        let share = payload.mass / body.mass;
        let I = &mut body.inertia_com;
        for entry in [
            &mut I.xx, &mut I.yy, &mut I.zz, &mut I.xy, &mut I.xz, &mut I.yz,
        ] {
            *entry *= share;
        }
        (body.mass, body.com) = (payload.mass, payload.com);
        // Torques beyond the wrist's limits would saturate.
        file.limits.tau_wrist_max = [1e6; 3];
        let plant = Hdrm::new(&file, &Options::from_machine(&file)).expect("valid");
        let input = Input {
            f: demand.f,
            tau_wrist: demand.tau_wrist,
            ..Input::default()
        };
        let (zeta, zeta_dot) = (motion.zeta, motion.zeta_dot);
        let state = State {
            zeta,
            zeta_dot,
            ..State::default()
        };
        let found = plant.forward_dynamics(&state, &input);
        for (k, found) in found.into_iter().enumerate() {
            let wanted = motion.zeta_ddot[k];
            // Joints 4 and 6 feel little inertia: forces of 70 kN rounded, over 8 kg·m².
            assert!(
                (found - wanted).abs() < 1e-9,
                "case {case}, joint {k}: {found} {wanted}"
            );
        }
    }
}

/// The force on the tip that a point mass there has from gravity and its own acceleration, given as
/// the wrench of the environment, demands the same as the mass itself.
#[test]
fn a_load_demands_what_its_weight_and_its_inertia_do() {
    let machine = Machine::reference();
    let payload = Payload::from_machine(&machine);
    let kinematics = Kinematics::new(&machine).expect("works");
    let zeta = machine.start.zeta;
    let pose = kinematics.pose(&zeta);
    let acceleration = Vector6::new(0.7, -0.4, 0.9, 0.0, 0.0, 0.0);
    let tip = TipMotion {
        pose,
        velocity: Vector6::zeros(),
        acceleration,
    };
    let motion = kinematics.motion(&tip, &zeta).expect("regular");
    let (mass, com) = (170.0, [0.2, -0.3, 0.1]);
    let loaded = DemandModel::with_load(&machine, &payload, mass, com).expect("valid");
    let bare = DemandModel::new(&machine, &payload).expect("valid");
    // No turning: the load accelerates as the tip does.
    let a: Vector3<f64> = acceleration.fixed_rows::<3>(0).into();
    let force = pose.orientation.inverse() * ((a + Vector3::y() * machine.gravity) * -mass);
    let moment = Vector3::from(com).cross(&force);
    let wrench = [force.x, force.y, force.z, moment.x, moment.y, moment.z];
    let state = State {
        zeta,
        ..State::default()
    };
    let plant = bare.plant();
    let (f, tau) = plant.inverse_dynamics(&state, &motion.zeta_ddot, &wrench);
    let found = loaded.demand(&motion);
    for k in 0..3 {
        assert!(
            (found.f[k] - f[k]).abs() < 1e-7,
            "{k}: {} {}",
            found.f[k],
            f[k]
        );
        assert!((found.tau_wrist[k] - tau[k]).abs() < 1e-8, "{k}");
    }
}

/// Statics by hand: the machine with weightless bodies besides the lift boom and the payload, boom
/// level, tilt boom level too. The moment about the lift joint is that of two weights; the lift
/// actuator has the lever arm of its triangle.
#[test]
fn the_lift_force_of_two_weights_is_their_moment_over_the_lever_arm() {
    let mut machine = Machine::reference();
    let light = 1e-9;
    for body in machine.bodies.in_order_mut() {
        body.mass = light;
        let I = &mut body.inertia_com;
        for entry in [
            &mut I.xx, &mut I.yy, &mut I.zz, &mut I.xy, &mut I.xz, &mut I.yz,
        ] {
            *entry *= light;
        }
    }
    machine.bodies.A2.mass = 290.0;
    machine.bodies.PL.mass = 1.0;
    let payload = Payload {
        mass: 240.0,
        com: [0.4, 0.0, 0.0],
    };
    let g = &machine.geometry;
    let zeta = [0.0; 6];
    let capability = DemandModel::new(&machine, &payload).expect("valid");
    let demand = capability.demand(&Motion::rest(zeta));

    // Weights: the boom's centre of mass in axes turned by −beta2, the payload 0.4 m beyond the
    // wrist's last joint.
    let [cx, cy, _] = machine.bodies.A2.com;
    let boom = cx * g.beta2.cos() + cy * g.beta2.sin();
    let load = 2.0 + 1.5 + 0.2 + 0.2 + 0.15 + 0.4;
    let moment = machine.gravity * (290.0 * boom + 240.0 * load);
    // Foot and rod pin from the lift joint; the lever arm is their cross product over the
    // actuator's length.
    let foot = Vector3::new(g.L2_2 * g.beta1.sin(), -g.L2_2 * g.beta1.cos(), 0.0);
    let pin = Vector3::new(g.L1_2 * g.beta2.cos(), -g.L1_2 * g.beta2.sin(), 0.0);
    let arm = foot.cross(&pin).z / (pin - foot).norm();
    let expected = moment / arm;
    assert!(
        (demand.f[1] / expected - 1.0).abs() < 1e-8,
        "{} {expected}",
        demand.f[1]
    );
    // At rest the gear's factor is the mean of η and 1/η; the screw turns the force into torque.
    let p = &machine.emla.lift;
    let k = 0.5 * (p.eta_gear + 1.0 / p.eta_gear);
    let torque = k * expected * p.rho / std::f64::consts::TAU / p.N_gear;
    let current = torque / (1.5 * f64::from(p.p) * p.lambda_m);
    assert!((demand.tau_e[1] / torque - 1.0).abs() < 1e-8);
    assert!((demand.i_q[1] / current - 1.0).abs() < 1e-8);
    assert!((demand.v[1] / (p.R_s * current) - 1.0).abs() < 1e-8);
    assert_eq!((demand.x_dot, demand.w_m), ([0.0; 3], [0.0; 3]));
}

/// Rates and accelerations of the joints against differences of the angles that the inverse finds
/// along a tip motion of constant acceleration. Over δ = 1e-3 s their errors are δ²/6 times the
/// third and δ²/12 times the fourth derivative, below 1e-5.
#[test]
fn joint_motion_is_the_derivative_of_the_inverse_kinematics() {
    let machine = Machine::reference();
    let kinematics = Kinematics::new(&machine).expect("works");
    let start = kinematics.pose(&machine.start.zeta);
    let velocity = Vector6::new(0.11, -0.07, 0.05, 0.2, -0.13, 0.31);
    let acceleration = Vector6::new(0.3, 0.2, -0.25, 0.0, 0.0, 0.0);
    let at = |t: f64| {
        let w: Vector3<f64> = velocity.fixed_rows::<3>(3).into();
        let v: Vector3<f64> = velocity.fixed_rows::<3>(0).into();
        let a: Vector3<f64> = acceleration.fixed_rows::<3>(0).into();
        let pose = Pose {
            position: start.position + v * t + a * (0.5 * t * t),
            orientation: UnitQuaternion::from_scaled_axis(w * t) * start.orientation,
        };
        Vector6::from(
            kinematics
                .inverse(&pose, &machine.start.zeta)
                .expect("reached"),
        )
    };
    let d = 1e-3;
    let tip = TipMotion {
        pose: start,
        velocity,
        acceleration,
    };
    let motion = kinematics
        .motion(&tip, &machine.start.zeta)
        .expect("regular");
    let rate = (at(d) - at(-d)) / (2.0 * d);
    let second = (at(d) - 2.0 * at(0.0) + at(-d)) / (d * d);
    for k in 0..6 {
        assert!((motion.zeta_dot[k] - rate[k]).abs() < 1e-5, "{k}");
        assert!(
            (motion.zeta_ddot[k] - second[k]).abs() < 2e-4,
            "{k}: {} {}",
            motion.zeta_ddot[k],
            second[k]
        );
    }
}

/// The inverse gives the angles back whose pose it is asked for, from a pose some way off, and says
/// how far a pose out of reach is.
#[test]
fn the_inverse_finds_the_angles_of_a_pose() {
    let machine = Machine::reference();
    let kinematics = Kinematics::new(&machine).expect("works");
    let mut random = Random(7);
    for case in 0..300 {
        let zeta = random.zeta(&machine);
        let near: [f64; 6] = std::array::from_fn(|k| zeta[k] + 0.05 * random.next());
        let found = kinematics
            .inverse(&kinematics.pose(&zeta), &near)
            .unwrap_or_else(|error| panic!("case {case}: {error:?}"));
        for k in 0..6 {
            assert!((found[k] - zeta[k]).abs() < 1e-8, "case {case}, joint {k}");
        }
    }
    let mut far = kinematics.pose(&machine.start.zeta);
    far.position = Vector3::new(7.1, 1.5, 0.0);
    let unreached = kinematics
        .inverse(&far, &machine.start.zeta)
        .expect_err("out of reach");
    // The stretched arm ends at 4.55 m.
    assert!((unreached.distance - 2.55).abs() < 0.2, "{unreached:?}");
}

/// What the table of limits takes from where, with numbers that tell all of them apart.
#[test]
fn limits_are_those_of_the_machine_file() {
    let mut machine = Machine::reference();
    machine.ratings.lift.force_max = 61e3;
    machine.ratings.tilt.rod_speed_max = 0.061;
    machine.ratings.slew.motor_speed_rpm = 2900.0;
    machine.emla.tilt.i_max = 77.0;
    let limits = AllowedRanges::from_machine(&machine);
    let capability = DemandModel::new(&machine, &Payload::from_machine(&machine)).expect("valid");
    let demand = capability.demand(&Motion::rest(machine.start.zeta));
    let margins = limits.margins(&demand);
    let range = |quantity| {
        let margin = margins.iter().find(|margin| margin.quantity == quantity);
        margin.expect("a limit of each").range
    };
    let largest = |quantity| range(quantity)[1];
    assert_eq!(largest(Quantity::Force(1)), 61e3);
    assert_eq!(largest(Quantity::RodSpeed(2)), 0.061);
    assert!((largest(Quantity::MotorSpeed(0)) - 303.687).abs() < 1e-3);
    assert_eq!(largest(Quantity::Current(2)), 77.0);
    assert_eq!(largest(Quantity::WristTorque(2)), 800.0);
    assert_eq!(range(Quantity::Stroke(1)), [0.0, 0.66]);
    // 650 V of DC link over √3, less than v_max.
    assert!((largest(Quantity::Voltage(0)) - 375.0).abs() < 0.3);
    assert_eq!(range(Quantity::Joint(2)), machine.limits.zeta()[2]);

    assert!(margins.iter().all(motion_check::Margin::holds));
    for margin in margins {
        assert_eq!(margin.value, demand.value(margin.quantity));
    }
}
