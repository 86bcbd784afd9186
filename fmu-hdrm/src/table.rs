//! Variables of the FMU `Hdrm`.

use crate::{HdrmFmu, Parameters};
use fmu_export::{ALL_PARAMETERS, File, Info, Terminal, Variable, read_parameter_file};
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

type V = Variable<HdrmFmu>;

/// What the start state follows from.
const START: &[&str] = &[ALL_PARAMETERS];

fn read_machine(p: &mut Parameters, file: &str, resources: Option<&Path>) -> Result<(), String> {
    let machine = match file {
        "" => Machine::reference(),
        _ => read_parameter_file(file, resources, Machine::from_json)?,
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
        .unit("rad/s2").display_unit("deg/s2").depends_on(&["f", "tau_wrist", "wrench_env"])
        .initially_depends_on(&["f", "tau_wrist", "wrench_env", ALL_PARAMETERS]),
    V::outputs("f_hold", "actuator forces that hold the present pose against gravity", |y| &y.f_hold)
        .unit("N").display_unit("kN").depends_on(&[]).initially_depends_on(START),
    V::outputs("tau_hold", "wrist torques that hold the present pose against gravity", |y| &y.tau_hold)
        .unit("N.m").depends_on(&[]).initially_depends_on(START),

    // Tip and energy
    V::outputs("tip.position", "tip T4 in the world: x forward, y up, z = x cross y", |y| &y.tip_position)
        .unit("m").depends_on(&[]).initially_depends_on(START),
    V::outputs("tip.orientation", "orientation of T4 in the world, unit quaternion w, x, y, z", |y| &y.tip_orientation)
        .unit("1").depends_on(&[]).initially_depends_on(START),
    V::outputs("tip.velocity", "velocity (1 to 3) and angular velocity (4 to 6) of T4 in world axes", |y| &y.tip_velocity)
        .each_unit(&["m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s"]).depends_on(&[]).initially_depends_on(START),
    V::output("energy.kinetic", "kinetic energy", |y| &y.energy_kinetic)
        .unit("J").depends_on(&[]).initially_depends_on(START),
    V::output("energy.potential", "potential energy, zero at the height of the world's origin", |y| &y.energy_potential)
        .unit("J").depends_on(&[]).initially_depends_on(START),

    // Parameters
    V::parameters("zeta_start", "joint angles at the start, within the joint limits", |p| &p.zeta_start, |p| &mut p.zeta_start)
        .unit("rad").display_unit("deg").min(-7.0).max(7.0),
    V::parameters("zeta_dot_start", "joint rates at the start", |p| &p.zeta_dot_start, |p| &mut p.zeta_dot_start)
        .unit("rad/s").display_unit("deg/s").min(-10.0).max(10.0),
    V::parameter("inertia_scale", "factor on mass, first moment and inertia of every body, payload included",
        |p| &p.options.inertia_scale, |p| &mut p.options.inertia_scale).unit("1").min(0.01).max(100.0),
    V::parameter("payload.mass", "mass of the payload before inertia_scale; its inertia goes with it",
        |p| &p.options.payload_mass, |p| &mut p.options.payload_mass).unit("kg").min(0.0).max(1e5),
    V::parameters("joint_viscous", "viscous joint friction", |p| &p.options.joint_viscous, |p| &mut p.options.joint_viscous)
        .unit("N.m.s/rad").min(0.0).max(1e6),
    V::parameters("gravity", "acceleration of gravity in the world; not along -y where the machine does not stand plumb",
        |p| &p.options.gravity, |p| &mut p.options.gravity).unit("m/s2").min(-1e3).max(1e3),
    V::string_parameter("machine_file", "machine JSON to use instead of the embedded reference machine",
        |p| &p.machine_file, read_machine),
];
