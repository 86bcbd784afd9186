//! Variables of the FMU `Controller`, for `fmu_export`: names, units, bounds and dependencies.
//!
//! Each row names the field of `vdc` or `machine_file` that it reads or sets.

use super::enumerations::{CAUSE, LEVEL, MODE, RATE_COMMAND, SUPERVISOR, TRAJECTORY};
use super::files::{read_machine, read_path, read_surrogate};
use super::model::ControllerFmu;
use fmu_export::{ALL_PARAMETERS, DisplayUnit, File, Info, Terminal, Unit, Variable, joined, row};
use hdrm::Body;
use vdc::DELAY_MAX;

pub(crate) const INFO: Info = Info::new(
    "Controller",
    "Adaptive modular controller of an all-electric heavy-duty manipulator: virtual decomposition control with natural \
     adaptation, and a voltage law for each actuator",
)
.named_after(actuator_table::own_name)
.version(env!("CARGO_PKG_VERSION"))
.license("MIT OR Apache-2.0")
.experiment(0.0, 24.25, 1e-3)
.documentation(&[File { path: "index.html", bytes: include_bytes!("../documentation/index.html") }])
.icon(include_bytes!("../model.png"))
.terminals(&[
    Terminal::new("measurements", "io.github.hdrm-fmu.measurements", "what the controller knows of the plant", &[
        ("zeta", "zeta"), ("zeta_dot", "zeta_dot"), ("i_d", "i_d"), ("i_q", "i_q"), ("w_m", "w_m"), ("x", "x"), ("x_dot", "x_dot"), ("F", "F"),
    ]).bus(),
    Terminal::new("voltages", "io.github.hdrm-fmu.voltages", "voltages of slew, lift and tilt actuator", &[("v_d", "v_d"), ("v_q", "v_q")]),
    Terminal::new("wrist", "io.github.hdrm-fmu.torques", "torques of the wrist", &[("tau", "tau_wrist")]),
])
.resources(actuator_table::RESOURCES)
.units(&[
    Unit::new("V/N").m(1).s(-1).A(-1).display(&[DisplayUnit::new("V/kN", 1e3)]),
    Unit::new("N/A").kg(1).m(1).s(-2).A(-1),
    Unit::new("A/N").kg(-1).m(-1).s(2).A(1),
    Unit::new("m/N").kg(-1).s(2),
]);

type V = Variable<ControllerFmu>;

/// Dependencies of the required twists: joint motion, and reference without acceleration.
const TWISTS: &[&str] = &[
    "zeta",
    "zeta_dot",
    "reference.position",
    "reference.velocity",
    "reference.orientation",
    "reference.angular_velocity",
];
/// Dependencies of the required wrenches: joint motion, reference, and motion of the base.
const MOTION: &[&str] = joined!(
    TWISTS,
    &[
        "reference.acceleration",
        "base.tilt",
        "base.acceleration",
        "base.angular_velocity",
        "base.angular_acceleration",
    ],
);
/// The same with the rod's own reference and measurements.
const MOTION_AND_ROD: &[&str] = joined!(
    MOTION,
    &[
        "x[i]",
        "x_dot[i]",
        "reference.rod_position[i]",
        "reference.rod_velocity[i]",
        "reference.rod_acceleration[i]",
        "reference.rod_force[i]",
    ],
);
/// Dependencies of a drive's commands.
const DRIVE: &[&str] = joined!(
    MOTION_AND_ROD,
    &["i_d[i]", "i_q[i]", "w_m[i]", "T_winding[i]"]
);
/// Dependencies of the required rod velocities.
const RATES_AND_ROD: &[&str] = &[
    "zeta",
    "reference.position",
    "reference.velocity",
    "reference.orientation",
    "reference.angular_velocity",
    "x[i]",
    "reference.rod_position[i]",
    "reference.rod_velocity[i]",
];

/// An output that changes at communication points; initially it also depends on all parameters.
const fn at_points(row: V) -> V {
    row.initially_also_on(&[ALL_PARAMETERS]).discrete()
}

/// An output without direct feedthrough that initially depends on the start pose.
const fn of_start(row: V) -> V {
    row.depends_on(&[])
        .initially_depends_on(&["zeta", ALL_PARAMETERS])
        .discrete()
}

/// An output that depends on no input, also initially.
const fn of_supervisor(row: V) -> V {
    row.depends_on(&[])
        .initially_depends_on(&["supervisor", "level"])
}

/// The same, but for the state of the supply.
const fn with_supply(row: V) -> V {
    row.depends_on(&["supply.ready"])
        .initially_depends_on(&["supply.ready", "supervisor", "level"])
}

/// A gain in `machine.controller`.
const fn gain(row: V) -> V {
    row.tunable().range(0.0..=GAIN_MAX)
}

const ANGLE_MAX: f64 = 100.0;
const RATE_MAX: f64 = 1e4;
const CURRENT_MAX: f64 = 1e5;
const FORCE_MAX: f64 = 1e8;
/// Largest gain, far beyond use, so that no product with an input overflows.
const GAIN_MAX: f64 = 1e9;

#[rustfmt::skip]
pub(crate) const VARIABLES: &[V] = &[
    // Measurements
    row!(V, inputs zeta in u, "joint angles: slew, lift, tilt, wrist")
        .unit("rad").display_unit("deg").range(-ANGLE_MAX..=ANGLE_MAX),
    row!(V, inputs zeta_dot in u, "joint rates")
        .unit("rad/s").display_unit("deg/s").range(-RATE_MAX..=RATE_MAX),
    row!(V, inputs i_d in u, "direct-axis currents of slew, lift and tilt actuator (peak)")
        .unit("A").range(-CURRENT_MAX..=CURRENT_MAX),
    row!(V, inputs i_q in u, "quadrature-axis currents (peak)")
        .unit("A").range(-CURRENT_MAX..=CURRENT_MAX),
    row!(V, inputs w_m in u, "motor speeds")
        .unit("rad/s").display_unit("rpm").range(-1e6..=1e6),
    row!(V, inputs x in u, "rod positions, read if level = actuator")
        .unit("m").display_unit("mm").range(-10.0..=10.0),
    row!(V, inputs x_dot in u, "rod velocities; read by the virtual power flows and if level = actuator")
        .unit("m/s").display_unit("mm/s").range(-1e3..=1e3),
    row!(V, inputs F in u, "actuator forces, positive when pushing; read by the virtual power flows and, in a step, by the disturbance observer")
        .unit("N").display_unit("kN").range(-FORCE_MAX..=FORCE_MAX).not_in_evaluation(),
    row!(V, counted_input v_dc, "voltage of the DC link: its voltage limit is min(v_max, v_dc/sqrt(3)); until it is set, the nominal machine's counts")
        .unit("V").range(0.0..=1e5).nominal(500.0),
    row!(V, inputs T_winding in u, "temperatures of the windings, read while derating is on")
        .unit("K").display_unit("degC").range(1.0..=1e4).nominal(300.0),
    // External reference
    row!(V, inputs reference.position = u.reference_position, "desired tip position in the world, read if trajectory = external")
        .unit("m").range(-100.0..=100.0),
    row!(V, inputs reference.velocity = u.reference_velocity, "desired tip velocity in the world, read if trajectory = external")
        .unit("m/s").range(-100.0..=100.0),
    row!(V, inputs reference.acceleration = u.reference_acceleration, "desired tip acceleration in the world, read if trajectory = external")
        .unit("m/s2").range(-1e4..=1e4),
    row!(V, inputs reference.orientation = u.reference_orientation, "desired tip orientation, quaternion w, x, y, z of length 1, read if trajectory = external")
        .unit("1").range(-1.001..=1.001),
    row!(V, inputs reference.angular_velocity = u.reference_angular_velocity, "desired angular velocity of the tip in the world, read if trajectory = external")
        .unit("rad/s").display_unit("deg/s").range(-RATE_MAX..=RATE_MAX),

    row!(V, inputs reference.rod_position = u.reference_rod_position, "desired rod positions, read if level = actuator")
        .unit("m").display_unit("mm").range(-10.0..=10.0),
    row!(V, inputs reference.rod_velocity = u.reference_rod_velocity, "desired rod velocities, read if level = actuator")
        .unit("m/s").display_unit("mm/s").range(-1e3..=1e3),
    row!(V, inputs reference.rod_acceleration = u.reference_rod_acceleration, "desired rod accelerations, read if level = actuator")
        .unit("m/s2").range(-1e4..=1e4),
    row!(V, inputs reference.rod_force = u.reference_rod_force, "desired forces on the load, read if level = actuator")
        .unit("N").display_unit("kN").range(-FORCE_MAX..=FORCE_MAX),

    row!(V, inputs base.tilt = u.base_tilt, "what the controller is told of the base's tilt against the ground: roll about x, then pitch about its own z")
        .unit("rad").display_unit("deg").range(-3.2..=3.2).nominal(0.1),
    row!(V, inputs base.acceleration = u.base_acceleration, "what it is told of the base's acceleration, in the axes of the machine's world")
        .unit("m/s2").range(-1e3..=1e3).nominal(1.0),
    row!(V, inputs base.angular_velocity = u.base_angular_velocity, "what it is told of the base's angular velocity, in the same axes")
        .unit("rad/s").display_unit("deg/s").range(-100.0..=100.0).nominal(0.1),
    row!(V, inputs base.angular_acceleration = u.base_angular_acceleration, "what it is told of the rate of that")
        .unit("rad/s2").display_unit("deg/s2").range(-1e4..=1e4).nominal(0.1),

    row!(V, inputs rate.joint = u.rate_joint, "commanded joint rates, read in a step if trajectory = rates and rate.command = joint")
        .unit("rad/s").display_unit("deg/s").range(-RATE_MAX..=RATE_MAX).not_in_evaluation(),
    row!(V, inputs rate.tip = u.rate_tip, "commanded velocity (1 to 3) and angular velocity (4 to 6) of the tip in the world, read in a step if trajectory = rates and rate.command = tip")
        .each_unit(&["m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s"]).range(-RATE_MAX..=RATE_MAX).not_in_evaluation(),

    // Commands
    at_points(row!(V, outputs v_d, "direct-axis voltages (peak)")
        .unit("V").depends_on(&["i_d[i]", "i_q[i]", "w_m[i]"])),
    at_points(row!(V, outputs v_q, "quadrature-axis voltages (peak)")
        .unit("V").depends_on(DRIVE)),
    at_points(row!(V, outputs tau_wrist, "wrist torques, held to their limits")
        .unit("N.m").depends_on(MOTION)),
    at_points(row!(V, outputs f_required, "required actuator forces")
        .unit("N").display_unit("kN").depends_on(MOTION_AND_ROD)),
    at_points(row!(V, outputs x_dot_required, "required rod velocities")
        .unit("m/s").display_unit("mm/s").depends_on(RATES_AND_ROD)),
    at_points(row!(V, outputs i_q_required, "required quadrature-axis currents (peak)")
        .unit("A").depends_on(DRIVE)),
    of_start(row!(V, output motion_end, "time at which the reference has come to its end; the start time if trajectory = external")
        .unit("s")),
    row!(V, outputs desired.position = desired_position, "desired tip position in the world")
        .unit("m").depends_on(&["reference.position"]).initially_depends_on(&["zeta", "reference.position", ALL_PARAMETERS]).discrete(),
    at_points(row!(V, outputs tip_error, "desired minus actual tip position in the world")
        .unit("m").display_unit("mm").depends_on(&["zeta", "reference.position"])),
    at_points(row!(V, output tip_error_norm, "length of the tip error")
        .unit("m").display_unit("mm").depends_on(&["zeta", "reference.position"])),
    row!(V, outputs desired.orientation = desired_orientation, "desired tip orientation in the world, quaternion w, x, y, z")
        .unit("1").depends_on(&["reference.orientation"]).initially_depends_on(&["zeta", "reference.orientation", ALL_PARAMETERS]).discrete(),
    at_points(row!(V, output orientation_error_norm, "angle between desired and actual tip orientation")
        .unit("rad").display_unit("deg").depends_on(&["zeta", "reference.orientation"])),

    of_start(row!(V, output load.mass, "mass that the path has the end-effector carry beside its payload")
        .unit("kg")),
    of_start(row!(V, outputs load.com, "place of that load from the tip T4, in T4's axes")
        .unit("m")),

    // Adaptation
    at_points(row!(V, output mass_hat.T1 = mass_hat[Body::T1 as usize], "estimated mass of body T1").unit("kg").depends_on(&[])),
    at_points(row!(V, output mass_hat.A2 = mass_hat[Body::A2 as usize], "estimated mass of body A2").unit("kg").depends_on(&[])),
    at_points(row!(V, output mass_hat.C2 = mass_hat[Body::C2 as usize], "estimated mass of body C2").unit("kg").depends_on(&[])),
    at_points(row!(V, output mass_hat.D2 = mass_hat[Body::D2 as usize], "estimated mass of body D2").unit("kg").depends_on(&[])),
    at_points(row!(V, output mass_hat.A3 = mass_hat[Body::A3 as usize], "estimated mass of body A3").unit("kg").depends_on(&[])),
    at_points(row!(V, output mass_hat.C3 = mass_hat[Body::C3 as usize], "estimated mass of body C3").unit("kg").depends_on(&[])),
    at_points(row!(V, output mass_hat.D3 = mass_hat[Body::D3 as usize], "estimated mass of body D3").unit("kg").depends_on(&[])),
    at_points(row!(V, output mass_hat.RK = mass_hat[Body::RK as usize], "estimated mass of body RK").unit("kg").depends_on(&[])),
    at_points(row!(V, output mass_hat.CP = mass_hat[Body::CP as usize], "estimated mass of body CP").unit("kg").depends_on(&[])),
    at_points(row!(V, output mass_hat.A4 = mass_hat[Body::A4 as usize], "estimated mass of body A4").unit("kg").depends_on(&[])),
    at_points(row!(V, output mass_hat.C4 = mass_hat[Body::C4 as usize], "estimated mass of body C4").unit("kg").depends_on(&[])),
    at_points(row!(V, output mass_hat.D4 = mass_hat[Body::D4 as usize], "estimated mass of body D4").unit("kg").depends_on(&[])),
    at_points(row!(V, output mass_hat.PL = mass_hat[Body::PL as usize], "estimated mass of body PL").unit("kg").depends_on(&[])),

    // Stability in numbers
    at_points(row!(V, output lyapunov.nu_velocity = nu_velocity, "sum of 1/2 s'Ms over the bodies, s = V_r - V, with the plant's inertias")
        .unit("J").depends_on(joined!(TWISTS, &["base.angular_velocity"]))),
    at_points(row!(V, output lyapunov.nu_adaptation = nu_adaptation, "sum of gamma D_F(L||L_hat) over the bodies")
        .unit("J").depends_on(&[])),
    at_points(row!(V, outputs lyapunov.nu_actuator = nu_actuator, "accompanying function of each actuator")
        .unit("J").depends_on(DRIVE)),
    at_points(row!(V, output lyapunov.dissipation = dissipation, "sum of s'K_A s over the bodies")
        .unit("W").depends_on(joined!(TWISTS, &["base.angular_velocity"]))),
    at_points(row!(V, outputs lyapunov.vpf = vpf, "virtual power flow (x_dot_r - x_dot)(f_r - F) at each rod")
        .unit("W").depends_on(joined!(MOTION_AND_ROD, &["F[i]"]))),

    at_points(row!(V, outputs lyapunov.force_error = force_error, "required minus actual force of each actuator by its currents")
        .unit("N").display_unit("kN").depends_on(DRIVE)),
    at_points(row!(V, outputs lyapunov.dissipation_actuator = dissipation_actuator, "dissipation of each actuator in the bound on its accompanying function")
        .unit("W").depends_on(DRIVE)),

    at_points(row!(V, output stability.beta_1 = conditions.beta_1, "beta_1 at i_d = 0").unit("N/A").depends_on(&[])),
    at_points(row!(V, output stability.beta_2 = conditions.beta_2, "beta_2 at i_q = i_max").unit("N/A").depends_on(&[])),
    at_points(row!(V, output stability.printed_margin = conditions.printed_margin, "first stability condition as printed, left over right side at i_max: it holds from 1 on")
        .unit("1").depends_on(&[])),
    at_points(row!(V, output stability.epsilon_max = conditions.epsilon_max, "largest weight of Young's inequality for which the first condition holds at i_max")
        .unit("A/N").depends_on(&[])),
    at_points(row!(V, output stability.K_1 = conditions.K_1, "K_1 of the accompanying function, by the third condition")
        .unit("m/N").depends_on(&[])),
    at_points(row!(V, output stability.K_2 = conditions.K_2, "K_2 of the accompanying function: twice the least that the second condition allows with half the largest weight")
        .unit("H").depends_on(&[])),

    // Parameters
    row!(V, integer_parameter level, "what the controller follows")
        .items(&LEVEL),
    row!(V, integer_parameter mode, "how much of the controller is at work")
        .items(&MODE).tunable(),
    row!(V, integer_parameter trajectory, "desired motion of the tip")
        .items(&TRAJECTORY),
    row!(V, integer_parameter rate.command = rate_command, "what commanded rates are of, if trajectory = rates")
        .items(&RATE_COMMAND).tunable(),
    row!(V, parameters rate.joint_max = rates.joint, "largest joint rates, under commands of the tip too; the reference takes 98 % of them, the rest is for the feedback")
        .unit("rad/s").display_unit("deg/s").range(1e-6..=100.0),
    row!(V, parameters rate.joint_acceleration_max = rates.joint_acceleration, "largest accelerations of the joints' reference, under commands of the tip too")
        .unit("rad/s2").display_unit("deg/s2").range(1e-6..=1e4),
    row!(V, parameters rate.tip_max = rates.tip, "largest commanded velocity and angular velocity of the tip")
        .each_unit(&["m/s", "rad/s"]).range(1e-6..=100.0),
    row!(V, parameters rate.tip_acceleration_max = rates.tip_acceleration, "largest acceleration and angular acceleration under commands of the tip")
        .each_unit(&["m/s2", "rad/s2"]).range(1e-6..=1e4),
    row!(V, parameter rate.smoothing = rates.smoothing, "time constant with which rates follow commands")
        .unit("s").display_unit("ms").range(1e-3..=10.0),
    row!(V, boolean_parameter load.told = load_known, "whether the nominal machine takes over the loads that the path picks up and sets down")
        .tunable(),
    V::string_parameter("machine_file", "machine JSON, or name of a shipped machine, to use for the nominal parameters and gains instead of the reference machine",
        |p| &p.machine_file, read_machine)
        .packed_file(actuator_table::REFERENCE),
    V::string_parameter("surrogate_file", "network JSON of the hybrid actuators to use instead of the embedded network",
        |p| &p.surrogate_file, read_surrogate),
    V::string_parameter("path_file", "path to follow if trajectory = path: JSON or CSV file of waypoints or samples, or iso9283-cube, iso9283-rectangle",
        |p| &p.path_file, read_path),
    row!(V, boolean_parameter path_check, "whether a path that the nominal machine cannot do is refused before the start"),
    row!(V, parameter alpha, "blending factor of the hybrid actuators that the voltage law reckons with; 0: it knows the physics only")
        .unit("1").tunable().range(0.0..=1.0),
    row!(V, parameter settle_time in machine.controller, "time for which the start pose is held before the trajectory begins")
        .unit("s").range(0.0..=1e6),
    row!(V, parameter sample_time, "time between two samples: outputs change at its multiples after the start only; 0: every communication point is a sample")
        .unit("s").display_unit("ms").range(0.0..=10.0),
    row!(V, boolean_parameter derating, "whether the largest current falls with the winding's temperature"),
    row!(V, parameter derating.start = derated.start, "winding temperature up to which the law asks for up to i_max")
        .unit("K").display_unit("degC").range(1.0..=1e4),
    row!(V, parameter derating.end = derated.end, "winding temperature from which on the law asks for no current; between the two the limit falls linearly")
        .unit("K").display_unit("degC").range(1.0..=1e4),
    row!(V, integer_parameter delay, "communication steps by which the commands act later than measured, which the controller then predicts over (F must be connected); 1 where all outputs are read before any input is set")
        .range(0.0..=DELAY_MAX as f64),
    gain(row!(V, parameter Lambda_position in machine.controller, "inverse-kinematics feedback on the position")).unit("1/s"),
    gain(row!(V, parameter Lambda_orientation in machine.controller, "inverse-kinematics feedback on the orientation"))
        .unit("1/s"),
    gain(row!(V, parameter Lambda_rod in machine.controller, "feedback on the rods' positions if level = actuator"))
        .unit("1/s").min(1e-6),
    gain(row!(V, parameter kappa_KA in machine.controller, "K_A = kappa_KA times the nominal inertia of each body")).unit("1/s"),
    gain(row!(V, parameter K_i in machine.controller, "current feedback")).unit("V/A"),
    gain(row!(V, parameter K_f in machine.controller, "force feedback")).unit("V/N"),
    gain(row!(V, parameter K_v in machine.controller, "velocity feedback on the motor side")).unit("V.s/m"),
    gain(row!(V, parameter lambda_i in machine.controller, "decay rate of the required direct-axis current")).unit("1/s"),
    gain(row!(V, parameter omega_i in machine.controller, "integral rate of the voltage law; 0: the paper's law")).unit("1/s"),
    gain(row!(V, parameter omega_d in machine.controller, "bandwidth of the disturbance observer; 0: the paper's law"))
        .unit("1/s"),
    gain(row!(V, parameter omega_tip in machine.controller, "rate of the integral of the tip's error, read in the modes with integral"))
        .unit("1/s"),
    gain(row!(V, parameter omega_speed in machine.controller, "bandwidth of the observer that makes joint rates of the angles zeta; 0: the measured zeta_dot count, the paper's law"))
        .unit("rad/s"),
    gain(row!(V, parameter reading_age in machine.controller, "age of the measurements when they are read: they are compared with the reference of then; 0: the paper's law"))
        .unit("s").display_unit("ms").max(1.0),
    gain(row!(V, parameter leakage in machine.controller, "rate at which estimated inertias go back to the nominal ones; 0: the paper's law"))
        .unit("1/s"),
    gain(row!(V, parameter gamma in machine.controller, "adaptation gain of the natural adaptation law; larger is slower"))
        .unit("J").min(1e-6),
    gain(row!(V, parameter di_qr_filter_time in machine.controller, "time constant of the filter behind d(i_qr)/dt"))
        .unit("s").display_unit("ms").min(1e-6),
    gain(row!(V, parameter pd_actuator_damping in machine.controller, "rod-velocity damping in mode pd")).unit("N.s/m"),
    row!(V, parameters pd_wrist_damping in machine.controller, "wrist damping in mode pd")
        .unit("N.m.s/rad").tunable().range(0.0..=GAIN_MAX),
    row!(V, parameters inverse_bounds in machine.controller, "bounds on the inverse pseudo-inertia over its nominal value: lower, upper")
        .unit("1").range(1e-6..=1e6),
    row!(V, parameter lyapunov.inertia_scale = true_inertia_scale, "inertia of the plant over nominal, for the lyapunov.* outputs only")
        .unit("1").tunable().range(0.01..=100.0),
    row!(V, boolean_parameter current_loop, "whether the drives regulate their currents themselves: they follow i_q_required, which holds the velocity feedback too, and read no voltages"),
    row!(V, parameter weighing_time, "time after the start in which the payload is weighed at the second wrist joint, and nothing adapts; nominal inertia, gains and bounds of the payload follow; 0: not, the paper's law")
        .unit("s").range(0.0..=1e6),
    row!(V, parameter force_limit, "largest required force of a rod over force_max of the machine file, for short times; 0: only the current is limited, the paper's law")
        .unit("1").tunable().range(0.0..=100.0),
    row!(V, boolean_parameter supervisor, "whether a supervisor watches the rods for swinging and acts on it, at the last by ramp, brakes and gates; without effect if level = actuator"),
    of_supervisor(row!(V, integer_output supervisor.state = supervisor_state, "what the supervisor does").items(&SUPERVISOR)),
    with_supply(row!(V, boolean_outputs enable, "whether the supervisor leaves the drives' gates on; false without supply")),
    with_supply(row!(V, boolean_outputs brake, "whether the supervisor applies the holding brakes; true without supply")),
    row!(V, boolean_inputs tripped in u, "whether a drive has tripped: the supervisor then brakes all").not_in_evaluation(),
    row!(V, inputs theta_m = theta_m.value, "motor angles; until they are set, nothing is concluded from them")
        .counted(|u| &mut u.theta_m.sets).unit("rad").display_unit("deg").range(-1e8..=1e8).not_in_evaluation(),
    row!(V, boolean_input reset in u, "a rising edge makes a stopped machine ready again, unless a drive has tripped or the supply is missing: gates on, then brakes off; it follows commanded rates from where it stands, else it rests there")
        .not_in_evaluation(),
    row!(V, boolean_input supply.ready = supply_ready, "whether the drives' supply is ready; until then their gates are off and their brakes applied"),
    of_supervisor(row!(V, integer_output supervisor.cause = supervisor_cause, "why the supervisor acts").items(&CAUSE)),
    of_supervisor(row!(V, boolean_outputs wrist.enable = wrist_enable, "whether the supervisor leaves the wrist's drives on")),
    of_supervisor(row!(V, boolean_outputs wrist.brake = wrist_brake, "whether the supervisor applies the wrist's brakes")),
    row!(V, parameters kappa_share in machine.controller, "shares of kappa_KA that act on slew, lift and tilt joint on paths, since their motors have a feedback of their own (K_v); 1: the paper's law")
        .unit("1").tunable().range(0.0..=100.0),
    gain(row!(V, parameter omega_friction in machine.controller, "rate at which the model-based laws estimate the friction of the wrist, which they then feed forward, and a steady load, on paths; 0: not, the paper's law"))
        .unit("1/s"),
    row!(V, parameter learning, "share of the tip's error of a lap that is met in the next one, on a path of equal laps; 0: nothing is learnt, the paper's law")
        .unit("1").range(0.0..=1.0),
    row!(V, integer_output lap, "lap of a path of equal laps that is under way, counted from 1; 0: none")
        .depends_on(&[]).initially_depends_on(&[ALL_PARAMETERS]),
    row!(V, outputs learnt.shift = learnt_shift, "shift of the tip's position, in the world, that was learnt on the laps before")
        .unit("m").display_unit("mm").depends_on(&[]).initially_depends_on(&[]).discrete(),
];
