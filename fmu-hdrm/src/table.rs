//! Variables of the FMU `Hdrm` for its description and calls: names, units, bounds, dependencies.

use super::model::{HdrmFmu, Parameters};
use fmu_export::{ALL_PARAMETERS, File, Info, NO_STATES, Terminal, Unit, Variable, joined, row};
use std::path::Path;

pub(crate) const INFO: Info = Info::new(
    "Hdrm",
    "Six-joint heavy-duty manipulator with a three-bar lift and a four-bar tilt mechanism, driven by three linear actuators \
     and three wrist torques",
)
.named_after(actuator_table::own_name)
.version(env!("CARGO_PKG_VERSION"))
.license("MIT OR Apache-2.0")
.experiment(0.0, 24.25, 1e-3)
.documentation(&[File { path: "index.html", bytes: include_bytes!("../documentation/index.html") }])
.icon(include_bytes!("../model.png"))
.terminals(&[
    Terminal::new("rods", "io.github.hdrm-fmu.rod", "mechanical bonds of slew, lift and tilt actuator: rods that move, and are pushed with F", &[
        ("x", "x"), ("x_dot", "x_dot"), ("F", "f"), ("F_hold", "f_hold"),
    ]),
    Terminal::new("wrist", "io.github.hdrm-fmu.torques", "torques of the wrist", &[("tau", "tau_wrist")]),
    Terminal::new("measurements", "io.github.hdrm-fmu.measurements", "what can be measured of the manipulator", &[
        ("zeta", "zeta"), ("zeta_dot", "zeta_dot"), ("x", "x"), ("x_dot", "x_dot"),
    ]).bus(),
])
.resources(actuator_table::RESOURCES)
.with_input_derivatives()
.with_output_derivatives()
.with_directional_derivatives();

static PER_SPEED: Unit = Unit::new("s/m").m(-1).s(1);
static TORQUE_RATE: Unit = Unit::new("N.m/s").kg(1).m(2).s(-3);

type V = Variable<HdrmFmu>;

/// Dependencies of the start state.
const START: &[&str] = &[ALL_PARAMETERS];

/// Dependencies of the start state with the load.
const LOADED_START: &[&str] = &["load.mass", "load.com", ALL_PARAMETERS];

/// The machine's motion.
const MOTION: &[&str] = &["zeta", "zeta_dot"];

/// Dependencies of the holding forces: tilt and motion of the base.
const BASE: &[&str] = &["base.acceleration", "base.tilt"];
const HOLDING: &[&str] = joined!(BASE, &["zeta"]);
const BASE_START: &[&str] = joined!(BASE, LOADED_START);

/// Dependencies of the joint accelerations.
const FORCES: &[&str] = joined!(
    &["f", "tau_wrist", "wrench_env"],
    BASE,
    &["base.angular_velocity", "base.angular_acceleration"],
    MOTION,
    &["wrist.angle", "wrist.rate", "wrist.enable"],
);

fn read_machine(p: &mut Parameters, file: &str, resources: Option<&Path>) -> Result<(), String> {
    *p = Parameters::new(actuator_table::machine(file, resources)?, file.to_owned());
    Ok(())
}

#[rustfmt::skip]
pub(crate) const VARIABLES: &[V] = &[
    // Inputs
    row!(V, inputs f in u, "actuator forces of slew, lift and tilt, positive when pushing")
        .unit("N").display_unit("kN").range(-1e7..=1e7).nominal(3e4).not_in_evaluation(),
    row!(V, inputs tau_wrist in u, "wrist torques; beyond the machine's limits they saturate")
        .unit("N.m").range(-1e6..=1e6).nominal(100.0).not_in_evaluation(),
    row!(V, inputs wrench_env in u, "wrench of the environment on the end-effector at T4 in T4 axes: forces 1 to 3, moments 4 to 6").each_unit(&["N", "N", "N", "N.m", "N.m", "N.m"]).range(-1e6..=1e6).nominal(100.0).not_in_evaluation(),

    // Base and load
    row!(V, inputs base.acceleration = u.base_acceleration, "acceleration of the base, in the axes of the machine's world, which stands on it: a vehicle's")
        .unit("m/s2").range(-1e3..=1e3).nominal(1.0),
    row!(V, inputs base.tilt = u.base_tilt, "tilt of the base against the ground: roll about x, then pitch about its own z; alone it changes the direction of gravity only").unit("rad").display_unit("deg").range(-3.2..=3.2).nominal(0.1),
    row!(V, inputs base.angular_velocity = u.base_angular_velocity, "angular velocity of the base, in the same axes: brings centrifugal and Coriolis forces").unit("rad/s").display_unit("deg/s").range(-100.0..=100.0).nominal(0.1),
    row!(V, inputs base.angular_acceleration = u.base_angular_acceleration, "rate of base.angular_velocity: brings Euler forces").unit("rad/s2").display_unit("deg/s2").range(-1e4..=1e4).nominal(0.1),
    row!(V, input load.mass = load_mass, "mass that hangs at load.com, a point, beside the payload; a change acts at the beginning of the next step")
        .unit("kg").range(0.0..=1e5).nominal(100.0).discrete().not_in_evaluation(),
    row!(V, inputs load.com = load_com, "place of the load from the tip T4, in T4's axes")
        .unit("m").range(-100.0..=100.0).discrete().not_in_evaluation(),

    // Strokes and joints
    row!(V, outputs x, "strokes of slew, lift and tilt actuator")
        .unit("m").display_unit("mm").depends_on(&["zeta[i]"]).initially_depends_on(START),
    row!(V, outputs x_dot, "rod velocities")
        .unit("m/s").display_unit("mm/s").depends_on(&["zeta[i]", "zeta_dot[i]"]).initially_depends_on(START),
    row!(V, outputs zeta, "joint angles: slew, lift, tilt, wrist")
        .unit("rad").display_unit("deg").depends_on(&[]).initially_depends_on(START),
    row!(V, outputs zeta_dot, "joint rates")
        .unit("rad/s").display_unit("deg/s").depends_on(&[]).initially_depends_on(START),
    row!(V, outputs zeta_ddot, "joint accelerations")
        .unit("rad/s2").display_unit("deg/s2")
        .depends_on(FORCES).initially_depends_on(joined!(FORCES, &["wrist.brake"], LOADED_START)),
    row!(V, outputs f_hold, "actuator forces that hold the present pose against gravity")
        .unit("N").display_unit("kN").depends_on(HOLDING).initially_depends_on(BASE_START),
    row!(V, outputs tau_hold, "wrist torques that hold the present pose against gravity")
        .unit("N.m").depends_on(HOLDING).initially_depends_on(BASE_START),

    // Tip and energy
    row!(V, outputs tip.position = tip_position, "tip T4 in the world: x forward, y up, z = x cross y")
        .unit("m").depends_on(&["zeta"]).initially_depends_on(START),
    row!(V, outputs tip.orientation = tip_orientation, "orientation of T4 in the world, unit quaternion w, x, y, z")
        .unit("1").depends_on(&["zeta"]).initially_depends_on(START),
    row!(V, outputs tip.velocity = tip_velocity, "velocity (1 to 3) and angular velocity (4 to 6) of T4 in world axes")
        .each_unit(&["m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s"]).depends_on(MOTION).initially_depends_on(START),
    row!(V, output energy.kinetic = energy_kinetic, "kinetic energy of the motion relative to the base")
        .unit("J").depends_on(MOTION).initially_depends_on(LOADED_START),
    row!(V, output energy.potential = energy_potential, "potential energy, zero at the height of the world's origin")
        .unit("J").depends_on(HOLDING).initially_depends_on(BASE_START),
    row!(V, output energy.load = energy_load, "energy that changes of the load have brought since the start: its own, and less what an impact took")
        .unit("J").depends_on(&[NO_STATES]).initially_depends_on(START),

    // Contact
    row!(V, outputs contact.force = contact_force, "force of the plane on the tip, in the world")
        .unit("N").display_unit("kN").depends_on(MOTION).initially_depends_on(START),
    row!(V, output contact.penetration = contact_penetration, "depth of the tip below the plane, 0 above it")
        .unit("m").display_unit("mm").depends_on(&["zeta"]).initially_depends_on(START),
    row!(V, output energy.contact = energy_contact, "elastic energy of the contact")
        .unit("J").depends_on(&["zeta"]).initially_depends_on(START),
    row!(V, output energy.contact_loss = energy_contact_loss, "energy that the contact has turned into heat since the start")
        .unit("J").depends_on(&[]).initially_depends_on(START),

    // Parameters
    row!(V, parameters zeta_start, "joint angles at the start, within the joint limits")
        .unit("rad").display_unit("deg").range(-7.0..=7.0),
    row!(V, parameters zeta_dot_start, "joint rates at the start")
        .unit("rad/s").display_unit("deg/s").range(-10.0..=10.0),
    row!(V, parameter inertia_scale in options, "factor on mass, first moment and inertia of every body, payload included").unit("1").range(0.01..=100.0),
    row!(V, parameter payload.mass = options.load.payload_mass, "mass of the payload before inertia_scale; its inertia goes with it; a change acts at the beginning of the next step").unit("kg").tunable().range(0.0..=1e5),
    row!(V, parameters payload.com = options.load.payload_com, "centre of mass of the payload from D4, in D4's axes (the tip lies at r_D4_T4 of the machine file)").unit("m").tunable().range(-100.0..=100.0),
    row!(V, boolean_parameter load.moves_with_tip = load_moves_with_tip, "whether what is picked up comes with the velocity of the end-effector, so that no impulse arises").tunable(),
    row!(V, parameters load.velocity = load_velocity, "velocity in the world with which it comes if load.moves_with_tip is false: the momentum of arm and load is conserved").unit("m/s").tunable().range(-100.0..=100.0),
    row!(V, parameters joint_viscous in options, "viscous joint friction")
        .unit("N.m.s/rad").range(0.0..=1e6),
    row!(V, parameters gravity in options, "acceleration of gravity in the world; not along -y where the machine does not stand plumb").unit("m/s2").range(-1e3..=1e3),
    row!(V, parameters contact.normal in options, "direction out of the plane towards the machine, in the world; its length does not count").unit("1").range(-1e3..=1e3),
    row!(V, parameter contact.offset in options, "distance of the plane from the world's origin along the normal").unit("m").range(-1e3..=1e3),
    row!(V, parameter contact.stiffness in options, "stiffness of the plane; 0: there is none").unit("N/m").range(0.0..=1e8),
    row!(V, parameter contact.damping in options, "dissipation of the plane, Hunt-Crossley: a tip that arrives at v leaves with less than its inverse").own_unit(&PER_SPEED).range(0.0..=1e3),
    row!(V, parameter contact.friction in options, "coefficient of friction of the tip on the plane").unit("1").range(0.0..=10.0),
    row!(V, parameter contact.slip_velocity in options, "velocity below which friction falls to zero").unit("m/s").display_unit("mm/s").range(1e-4..=10.0),
    V::string_parameter("machine_file", "machine JSON, or name of a shipped machine, to use instead of the reference machine",
        |p| &p.machine_file, read_machine)
        .packed_file(actuator_table::REFERENCE),

    // The machine as built
    row!(V, parameters joint_dry.torque in options, "dry friction of slew, lift and tilt joint in fast motion").unit("N.m").range(0.0..=1e6),
    row!(V, parameter joint_dry.breakaway in options, "their breakaway torque over that").unit("1").range(1.0..=10.0),
    row!(V, boolean_parameter wrist = options.wrist.on, "whether the wrist's drives are as built: lag, dry friction, inertia, gears that yield and have play; else torques act at once"),
    row!(V, parameter wrist.lag in options, "wrist: time constant from command to torque").unit("s").display_unit("ms").range(0.0..=10.0),
    row!(V, parameters wrist.friction in options, "wrist: dry friction of the drives").unit("N.m").range(0.0..=1e6),
    row!(V, parameter wrist.play in options, "wrist: whole play of the gears").unit("rad").display_unit("deg").range(0.0..=0.1),
    row!(V, parameters wrist.stiffness in options, "wrist: stiffness of the gears").unit("N.m/rad").range(1.0..=1e10),
    row!(V, parameters wrist.inertia in options, "wrist: inertia of the motors as the joints feel it").unit("kg.m2").range(1e-6..=1e6),
    row!(V, parameters push.force, "push on the tip in T4's axes, beside wrench_env").unit("N").range(-1e6..=1e6),
    row!(V, parameter push.start, "time at which it begins; held over a step").unit("s").range(-1e9..=1e9),
    row!(V, parameter push.duration, "how long it acts").unit("s").range(0.0..=1e9),

    // States for Model Exchange, appended
    row!(V, locals wrist.torque = wrist_torque, "wrist as built: torques of the motors").unit("N.m").nominal(100.0),
    row!(V, locals wrist.angle = wrist_angle, "wrist as built: angles of the motors as the joints feel them").unit("rad").display_unit("deg").nominal(1.0),
    row!(V, locals wrist.rate = wrist_rate, "wrist as built: rates of these angles").unit("rad/s").display_unit("deg/s").nominal(1.0),

    // Behind derivatives and indicators, so that earlier value references are unchanged
    row!(V, boolean_inputs wrist.enable = u.wrist_enable, "whether the wrist's drives give torque").at(183),
    row!(V, boolean_inputs wrist.brake = u.wrist_brake, "whether the wrist's brakes are applied: they hold up to brake.torque").not_in_evaluation(),
    row!(V, parameter brake.closing_time in options, "time from the command of a brake of the wrist until its torque acts; it opens at once").unit("s").display_unit("ms").range(0.0..=10.0),
    row!(V, parameters brake.torque in options, "torque up to which the brakes of the wrist hold, and with which they slip").unit("N.m").range(1e-6..=1e7),
    row!(V, parameters wrist.asymmetry in options, "wrist: share by which dry friction is larger at positive, and smaller at negative rates").unit("1").range(-0.99..=0.99),
    row!(V, parameter joint_dry.asymmetry in options, "the same of slew, lift and tilt joint").unit("1").range(-0.99..=0.99),
];

#[rustfmt::skip]
pub(crate) const DERIVATIVES: &[V] = &[
    V::derivatives_of("zeta").at(148).unit("rad/s").depends_on(&["zeta_dot[i]"]),
    V::derivatives_of("zeta_dot").unit("rad/s2").depends_on(FORCES),
    V::derivative_of("energy.contact_loss").unit("W").depends_on(MOTION),
    V::derivatives_of("wrist.torque").own_unit(&TORQUE_RATE).depends_on(&["tau_wrist[i]", "wrist.torque[i]"]),
    V::derivatives_of("wrist.angle").unit("rad/s").each_depends_on(&[
        &["zeta[4]", "zeta_dot[4]", "wrist.angle[1]", "wrist.rate[1]"],
        &["zeta[5]", "zeta_dot[5]", "wrist.angle[2]", "wrist.rate[2]"],
        &["zeta[6]", "zeta_dot[6]", "wrist.angle[3]", "wrist.rate[3]"],
    ]),
    V::derivatives_of("wrist.rate").unit("rad/s2").each_depends_on(&[
        &["tau_wrist[1]", "zeta[4]", "zeta_dot[4]", "wrist.torque[1]", "wrist.angle[1]", "wrist.rate[1]"],
        &["tau_wrist[2]", "zeta[5]", "zeta_dot[5]", "wrist.torque[2]", "wrist.angle[2]", "wrist.rate[2]"],
        &["tau_wrist[3]", "zeta[6]", "zeta_dot[6]", "wrist.torque[3]", "wrist.angle[3]", "wrist.rate[3]"],
    ]),
];

#[rustfmt::skip]
pub(crate) const INDICATORS: &[V] = &[
    V::indicator("event.stop_slew", "distance of the slew actuator from its nearer end stop").unit("m"),
    V::indicator("event.stop_lift", "distance of the lift actuator from its nearer end stop").unit("m"),
    V::indicator("event.stop_tilt", "distance of the tilt actuator from its nearer end stop").unit("m"),
    V::indicator("event.stop_wrist_1", "distance of the first wrist joint from its nearer end stop").unit("rad"),
    V::indicator("event.stop_wrist_2", "distance of the second wrist joint from its nearer end stop").unit("rad"),
    V::indicator("event.stop_wrist_3", "distance of the third wrist joint from its nearer end stop").unit("rad"),
    V::indicator("event.contact", "height of the tip above the plane").unit("m"),
    V::indicator("event.play_1", "first wrist joint: by how much its gear is out of its play").unit("rad"),
    V::indicator("event.play_2", "second wrist joint: by how much its gear is out of its play").unit("rad"),
    V::indicator("event.play_3", "third wrist joint: by how much its gear is out of its play").unit("rad"),
    V::indicator("event.friction_1", "first wrist joint: torque in N.m by which dry friction holds the motor, or its rate in rad/s while it slips"),
    V::indicator("event.friction_2", "second wrist joint: torque in N.m by which dry friction holds the motor, or its rate in rad/s while it slips"),
    V::indicator("event.friction_3", "third wrist joint: torque in N.m by which dry friction holds the motor, or its rate in rad/s while it slips"),
];
