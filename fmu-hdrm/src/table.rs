//! Variables of the FMU `Hdrm`.

use crate::{HdrmFmu, Parameters};
use fmu_export::{ALL_PARAMETERS, File, Info, Terminal, Unit, Variable, read_placed_file};
use machine::Machine;
use std::path::Path;

pub(crate) const INFO: Info = Info::new(
    "Hdrm",
    "Six-joint heavy-duty manipulator with a three-bar lift and a four-bar tilt mechanism, driven by three linear actuators \
     and three wrist torques",
)
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
.resources(&[
    File { path: "reference_machine.json", bytes: machine::REFERENCE_JSON.as_bytes() },
    File { path: "sized_machine.json", bytes: machine::SIZED_JSON.as_bytes() },
])
.with_input_derivatives()
.with_output_derivatives()
.with_directional_derivatives();

static PER_SPEED: Unit = Unit::new("s/m").m(-1).s(1);

type V = Variable<HdrmFmu>;

/// What the start state follows from.
const START: &[&str] = &[ALL_PARAMETERS];

/// The same with what the end-effector carries.
const LOADED_START: &[&str] = &["load.mass", "load.com", ALL_PARAMETERS];

/// What holds the machine depends on how its base stands and moves.
const BASE: &[&str] = &["base.acceleration", "base.tilt"];
const BASE_START: &[&str] = &[
    "base.acceleration",
    "base.tilt",
    "load.mass",
    "load.com",
    ALL_PARAMETERS,
];

fn read_machine(p: &mut Parameters, file: &str, resources: Option<&Path>) -> Result<(), String> {
    let machine = match Machine::preset(file) {
        Some(machine) => machine,
        None => read_placed_file(file, resources, Machine::of_file)?,
    };
    *p = Parameters::of(machine, file.to_owned());
    Ok(())
}

#[rustfmt::skip]
pub(crate) const VARIABLES: &[V] = &[
    // Inputs
    V::inputs("f", "actuator forces of slew, lift and tilt, positive when pushing", |u| &u.f, |u| &mut u.f)
        .unit("N").display_unit("kN").min(-1e7).max(1e7).nominal(3e4).beside_evaluation(),
    V::inputs("tau_wrist", "wrist torques; beyond the machine's limits they saturate", |u| &u.tau_wrist, |u| &mut u.tau_wrist)
        .unit("N.m").min(-1e6).max(1e6).nominal(100.0).beside_evaluation(),
    V::inputs("wrench_env", "wrench of the environment on the end-effector at T4 in T4 axes: forces 1 to 3, moments 4 to 6",
        |u| &u.wrench_env, |u| &mut u.wrench_env).each_unit(&["N", "N", "N", "N.m", "N.m", "N.m"]).min(-1e6).max(1e6).nominal(100.0).beside_evaluation(),

    // Base and load
    V::inputs("base.acceleration", "acceleration of the base, in the axes of the machine's world, which stands on it: a vehicle's", |u| &u.base_acceleration, |u| &mut u.base_acceleration)
        .unit("m/s2").min(-1e3).max(1e3).nominal(1.0),
    V::inputs("base.tilt", "tilt of the base against the ground: roll about x, then pitch about its own z; alone it changes the direction of gravity only",
        |u| &u.base_tilt, |u| &mut u.base_tilt).unit("rad").display_unit("deg").min(-3.2).max(3.2).nominal(0.1),
    V::inputs("base.angular_velocity", "angular velocity of the base, in the same axes: brings centrifugal and Coriolis forces",
        |u| &u.base_angular_velocity, |u| &mut u.base_angular_velocity).unit("rad/s").display_unit("deg/s").min(-100.0).max(100.0).nominal(0.1),
    V::inputs("base.angular_acceleration", "rate of base.angular_velocity: brings Euler forces",
        |u| &u.base_angular_acceleration, |u| &mut u.base_angular_acceleration).unit("rad/s2").display_unit("deg/s2").min(-1e4).max(1e4).nominal(0.1),
    V::input("load.mass", "mass that hangs at load.com, a point, beside the payload; a change acts at the beginning of the next step", |u| &u.load_mass, |u| &mut u.load_mass)
        .unit("kg").min(0.0).max(1e5).nominal(100.0).discrete().beside_evaluation(),
    V::inputs("load.com", "place of the load from the tip T4, in T4's axes", |u| &u.load_com, |u| &mut u.load_com)
        .unit("m").min(-100.0).max(100.0).discrete().beside_evaluation(),

    // Strokes and joints
    V::outputs("x", "strokes of slew, lift and tilt actuator", |y| &y.x)
        .unit("m").display_unit("mm").depends_on(&[]).initially_depends_on(START),
    V::outputs("x_dot", "rod velocities", |y| &y.x_dot)
        .unit("m/s").display_unit("mm/s").depends_on(&[]).initially_depends_on(START),
    V::outputs("zeta", "joint angles: slew, lift, tilt, wrist", |y| &y.zeta)
        .unit("rad").display_unit("deg").depends_on(&[]).initially_depends_on(START),
    V::outputs("zeta_dot", "joint rates", |y| &y.zeta_dot)
        .unit("rad/s").display_unit("deg/s").depends_on(&[]).initially_depends_on(START),
    V::outputs("zeta_ddot", "joint accelerations", |y| &y.zeta_ddot)
        .unit("rad/s2").display_unit("deg/s2")
        .depends_on(&["f", "tau_wrist", "wrench_env", "base.acceleration", "base.tilt", "base.angular_velocity", "base.angular_acceleration"])
        .initially_depends_on(&[
            "f", "tau_wrist", "wrench_env", "base.acceleration", "base.tilt", "base.angular_velocity", "base.angular_acceleration",
            "load.mass", "load.com", ALL_PARAMETERS,
        ]),
    V::outputs("f_hold", "actuator forces that hold the present pose against gravity", |y| &y.f_hold)
        .unit("N").display_unit("kN").depends_on(BASE).initially_depends_on(BASE_START),
    V::outputs("tau_hold", "wrist torques that hold the present pose against gravity", |y| &y.tau_hold)
        .unit("N.m").depends_on(BASE).initially_depends_on(BASE_START),

    // Tip and energy
    V::outputs("tip.position", "tip T4 in the world: x forward, y up, z = x cross y", |y| &y.tip_position)
        .unit("m").depends_on(&[]).initially_depends_on(START),
    V::outputs("tip.orientation", "orientation of T4 in the world, unit quaternion w, x, y, z", |y| &y.tip_orientation)
        .unit("1").depends_on(&[]).initially_depends_on(START),
    V::outputs("tip.velocity", "velocity (1 to 3) and angular velocity (4 to 6) of T4 in world axes", |y| &y.tip_velocity)
        .each_unit(&["m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s"]).depends_on(&[]).initially_depends_on(START),
    V::output("energy.kinetic", "kinetic energy of the motion relative to the base", |y| &y.energy_kinetic)
        .unit("J").depends_on(&[]).initially_depends_on(LOADED_START),
    V::output("energy.potential", "potential energy, zero at the height of the world's origin", |y| &y.energy_potential)
        .unit("J").depends_on(BASE).initially_depends_on(BASE_START),
    V::output("energy.load", "energy that changes of the load have brought since the start: its own, and less what an impact took", |y| &y.energy_load)
        .unit("J").depends_on(&[]).initially_depends_on(START),

    // Contact
    V::outputs("contact.force", "force of the plane on the tip, in the world", |y| &y.contact_force)
        .unit("N").display_unit("kN").depends_on(&[]).initially_depends_on(START),
    V::output("contact.penetration", "depth of the tip below the plane, 0 above it", |y| &y.contact_penetration)
        .unit("m").display_unit("mm").depends_on(&[]).initially_depends_on(START),
    V::output("energy.contact", "elastic energy of the contact", |y| &y.energy_contact)
        .unit("J").depends_on(&[]).initially_depends_on(START),
    V::output("energy.contact_loss", "energy that the contact has turned into heat since the start", |y| &y.energy_contact_loss)
        .unit("J").depends_on(&[]).initially_depends_on(START),

    // Parameters
    V::parameters("zeta_start", "joint angles at the start, within the joint limits", |p| &p.zeta_start, |p| &mut p.zeta_start)
        .unit("rad").display_unit("deg").min(-7.0).max(7.0),
    V::parameters("zeta_dot_start", "joint rates at the start", |p| &p.zeta_dot_start, |p| &mut p.zeta_dot_start)
        .unit("rad/s").display_unit("deg/s").min(-10.0).max(10.0),
    V::parameter("inertia_scale", "factor on mass, first moment and inertia of every body, payload included",
        |p| &p.options.inertia_scale, |p| &mut p.options.inertia_scale).unit("1").min(0.01).max(100.0),
    V::parameter("payload.mass", "mass of the payload before inertia_scale; its inertia goes with it; a change acts at the beginning of the next step",
        |p| &p.options.load.payload_mass, |p| &mut p.options.load.payload_mass).unit("kg").tunable().min(0.0).max(1e5),
    V::parameters("payload.com", "centre of mass of the payload from D4, in D4's axes (the tip lies at r_D4_T4 of the machine file)",
        |p| &p.options.load.payload_com, |p| &mut p.options.load.payload_com).unit("m").tunable().min(-100.0).max(100.0),
    V::boolean_parameter("load.moves_with_tip", "whether what is picked up comes with the velocity of the end-effector, so that no impulse arises",
        |p| &p.load_moves_with_tip, |p| &mut p.load_moves_with_tip).tunable(),
    V::parameters("load.velocity", "velocity in the world with which it comes if load.moves_with_tip is false: the momentum of arm and load is conserved",
        |p| &p.load_velocity, |p| &mut p.load_velocity).unit("m/s").tunable().min(-100.0).max(100.0),
    V::parameters("joint_viscous", "viscous joint friction", |p| &p.options.joint_viscous, |p| &mut p.options.joint_viscous)
        .unit("N.m.s/rad").min(0.0).max(1e6),
    V::parameters("gravity", "acceleration of gravity in the world; not along -y where the machine does not stand plumb",
        |p| &p.options.gravity, |p| &mut p.options.gravity).unit("m/s2").min(-1e3).max(1e3),
    V::parameters("contact.normal", "direction out of the plane towards the machine, in the world; its length does not count",
        |p| &p.options.contact.normal, |p| &mut p.options.contact.normal).unit("1").min(-1e3).max(1e3),
    V::parameter("contact.offset", "distance of the plane from the world's origin along the normal",
        |p| &p.options.contact.offset, |p| &mut p.options.contact.offset).unit("m").min(-1e3).max(1e3),
    V::parameter("contact.stiffness", "stiffness of the plane; 0: there is none",
        |p| &p.options.contact.stiffness, |p| &mut p.options.contact.stiffness).unit("N/m").min(0.0).max(1e8),
    V::parameter("contact.damping", "dissipation of the plane, Hunt-Crossley: a tip that arrives at v leaves with less than its inverse",
        |p| &p.options.contact.damping, |p| &mut p.options.contact.damping).own_unit(&PER_SPEED).min(0.0).max(1e3),
    V::parameter("contact.friction", "coefficient of friction of the tip on the plane",
        |p| &p.options.contact.friction, |p| &mut p.options.contact.friction).unit("1").min(0.0).max(10.0),
    V::parameter("contact.slip_velocity", "velocity below which friction falls to zero",
        |p| &p.options.contact.slip_velocity, |p| &mut p.options.contact.slip_velocity).unit("m/s").display_unit("mm/s").min(1e-4).max(10.0),
    V::string_parameter("machine_file", "machine JSON, or name of a shipped machine, to use instead of the reference machine",
        |p| &p.machine_file, read_machine),
];
