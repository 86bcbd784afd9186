//! Variables of the FMU `Sensors`.

use crate::SensorsFmu;
use fmu_export::{ALL_PARAMETERS, Enumeration, File, Info, Terminal, Unit, Variable};

pub(crate) const SPEED_IDEAL: i32 = 1;
pub(crate) const SPEED_DIFFERENCE: i32 = 2;
static SPEED: Enumeration = Enumeration::new(
    "Speed",
    "where speeds come from",
    &[
        ("ideal", "the speeds at the inputs pass as they are"),
        (
            "difference",
            "difference of two position readings over the communication step, and a first-order filter",
        ),
        (
            "observer",
            "tracking observer of third order on the position readings",
        ),
    ],
);

pub(crate) const FORCE_IDEAL: i32 = 1;
pub(crate) const FORCE_SENSOR: i32 = 2;
static FORCE: Enumeration = Enumeration::new(
    "Force",
    "what gives the rod forces",
    &[
        ("ideal", "the forces at the inputs pass as they are"),
        ("sensor", "a sensor with bias, noise and bandwidth"),
        (
            "absent",
            "no sensor: F_measured is force.per_current times i_q_measured; whoever needs the true force must do without",
        ),
    ],
);

pub(crate) const INFO: Info = Info::new(
    "Sensors",
    "Sensors between the plants of the manipulator and its controller: encoders, speeds, currents, forces, calibration errors and \
     delay; every effect is off at the start, and values then pass bit for bit",
)
.version(env!("CARGO_PKG_VERSION"))
.license("MIT OR Apache-2.0")
.experiment(0.0, 24.25, 1e-3)
.documentation(&[File { path: "index.html", bytes: include_bytes!("../documentation/index.html") }])
.icon(include_bytes!("../model.png"))
.terminals(&[
    Terminal::new("plant", "io.github.hdrm-fmu.measurements", "the plant as it is", &[
        ("zeta", "zeta"), ("theta_m", "theta_m"), ("i_d", "i_d"), ("i_q", "i_q"), ("F", "F"), ("x", "x"),
    ]).bus(),
    Terminal::new("measurements", "io.github.hdrm-fmu.measurements", "the plant as it is measured", &[
        ("zeta", "zeta_measured"), ("zeta_dot", "zeta_dot_measured"), ("i_d", "i_d_measured"), ("i_q", "i_q_measured"),
        ("w_m", "w_m_measured"), ("x_dot", "x_dot_measured"), ("F", "F_measured"),
    ]).bus(),
])
.units(&[Unit::new("N/A").kg(1).m(1).s(-2).A(-1)]);

type V = Variable<SensorsFmu>;

/// An input that is measured, within the bounds that the controller's inputs have; setting it makes a new sample.
macro_rules! measured {
    ($field:ident, $unit:literal, $display:literal, $largest:literal, $description:literal) => {
        V::inputs(
            stringify!($field),
            $description,
            |u| &u.u.$field,
            |u| &mut u.u.$field,
        )
        .unit($unit)
        .display_unit($display)
        .min(-$largest)
        .max($largest)
        .counted(|u| &mut u.sets)
    };
}

/// A reading, of the output of the same name without suffix. It follows the inputs at once where `delay` is 0, but for others the same
/// dependencies are told: FMI 2.0 has one list for all values of the parameters, and none of these inputs depends on a reading at once.
macro_rules! reading {
    ($name:literal, $field:ident, $unit:literal, $display:literal, [$($input:literal),*], $description:literal) => {
        V::outputs($name, $description, |y| &y.$field)
            .unit($unit)
            .display_unit($display)
            .depends_on(&[$($input),*])
            .initially_depends_on(&[$($input,)* ALL_PARAMETERS])
            .discrete()
    };
}

/// A Real parameter from its place in the parameters, its range, unit and description.
macro_rules! size {
    ($name:literal, $($field:ident).+, 0..=$max:literal, $unit:literal, $description:literal) => {
        V::parameter($name, $description, |p| &p.p.$($field).+, |p| &mut p.p.$($field).+).unit($unit).min(0.0).max($max)
    };
}

/// The switch of an effect.
macro_rules! switch {
    ($name:literal, $($field:ident).+, $description:literal) => {
        V::boolean_parameter($name, $description, |p| &p.p.$($field).+, |p| &mut p.p.$($field).+)
    };
}

/// The bits of a converter or an encoder.
macro_rules! bits {
    ($name:literal, $($field:ident).+, $description:literal) => {
        V::integer_parameter($name, $description, |p| &p.p.$($field).+, |p| &mut p.p.$($field).+).min(1.0).max(48.0)
    };
}

#[rustfmt::skip]
pub(crate) const VARIABLES: &[V] = &[
    // What is measured
    measured!(zeta, "rad", "deg", 100.0, "joint angles: slew, lift, tilt, wrist"),
    measured!(zeta_dot, "rad/s", "deg/s", 1e4, "joint rates; read if speed = ideal"),
    measured!(theta_m, "rad", "deg", 1e8, "motor angles of slew, lift and tilt actuator"),
    measured!(w_m, "rad/s", "rpm", 1e6, "motor speeds; read if speed = ideal"),
    V::inputs("i_d", "direct-axis currents (peak)", |u| &u.u.i_d, |u| &mut u.u.i_d).unit("A").min(-1e5).max(1e5).counted(|u| &mut u.sets),
    V::inputs("i_q", "quadrature-axis currents (peak)", |u| &u.u.i_q, |u| &mut u.u.i_q).unit("A").min(-1e5).max(1e5).counted(|u| &mut u.sets),
    measured!(F, "N", "kN", 1e8, "rod forces, positive when pushing"),
    measured!(x, "m", "mm", 10.0, "rod positions, positive when extended"),
    measured!(x_dot, "m/s", "mm/s", 100.0, "rod velocities; read if speed = ideal"),

    // Readings
    reading!("zeta_measured", zeta, "rad", "deg", ["zeta[i]"], "joint angles by their encoders"),
    reading!("zeta_dot_measured", zeta_dot, "rad/s", "deg/s", ["zeta[i]", "zeta_dot[i]"], "joint rates"),
    reading!("theta_m_measured", theta_m, "rad", "deg", ["theta_m[i]"], "motor angles by their encoders"),
    reading!("w_m_measured", w_m, "rad/s", "rpm", ["theta_m[i]", "w_m[i]"], "motor speeds"),
    V::outputs("i_d_measured", "direct-axis currents (peak), from two phases and the measured motor angle", |y| &y.i_d)
        .unit("A").depends_on(&["i_d[i]", "i_q[i]", "theta_m[i]"]).initially_depends_on(&["i_d[i]", "i_q[i]", "theta_m[i]", ALL_PARAMETERS]).discrete(),
    V::outputs("i_q_measured", "quadrature-axis currents (peak), from two phases and the measured motor angle", |y| &y.i_q)
        .unit("A").depends_on(&["i_d[i]", "i_q[i]", "theta_m[i]"]).initially_depends_on(&["i_d[i]", "i_q[i]", "theta_m[i]", ALL_PARAMETERS]).discrete(),
    reading!("F_measured", F, "N", "kN", ["F[i]", "i_d[i]", "i_q[i]", "theta_m[i]"], "rod forces"),
    reading!("x_measured", x, "m", "mm", ["x[i]"], "rod positions"),
    reading!("x_dot_measured", x_dot, "m/s", "mm/s", ["x[i]", "x_dot[i]"], "rod velocities"),

    // Parameters
    V::integer_parameter("seed", "seed of the noise and of the drawn errors; another number for each effect, whatever others are on", |p| &p.seed, |p| &mut p.seed).min(0.0),
    V::integer_parameter("delay", "communication steps from measurement to reading", |p| &p.delay, |p| &mut p.delay).min(0.0).max(4.0),
    switch!("motor_encoder", motor_encoder.on, "whether motor angles are counted"),
    bits!("motor_encoder.bits", motor_encoder.bits, "motor encoder: counts per turn as a power of two"),
    size!("motor_encoder.noise", motor_encoder.noise, 0..=1e3, "1", "motor encoder: standard deviation of the noise, counts"),
    switch!("joint_encoder", joint_encoder.on, "whether joint angles are counted"),
    bits!("joint_encoder.bits", joint_encoder.bits, "joint encoder: counts per turn as a power of two"),
    size!("joint_encoder.noise", joint_encoder.noise, 0..=1e3, "1", "joint encoder: standard deviation of the noise, counts"),
    switch!("rod_encoder", rod_encoder.on, "whether rod positions are counted"),
    bits!("rod_encoder.bits", rod_encoder.bits, "rod encoder: counts per metre as a power of two"),
    size!("rod_encoder.noise", rod_encoder.noise, 0..=1e3, "1", "rod encoder: standard deviation of the noise, counts"),
    switch!("joint_zero", joint_zero.on, "whether the joint encoders' zeros err"),
    size!("joint_zero.bound", joint_zero.bound, 0..=1.0, "rad", "zeros are drawn by the seed, uniformly between minus and plus this").display_unit("deg"),
    V::parameters("joint_zero.given", "zeros that are added to the drawn ones", |p| &p.p.joint_zero.given, |p| &mut p.p.joint_zero.given)
        .unit("rad").display_unit("deg").min(-7.0).max(7.0),
    V::integer_parameter("speed", "where speeds come from", |p| &p.speed, |p| &mut p.speed).enumeration(&SPEED),
    size!("speed.filter_time", speed.filter_time, 0..=10.0, "s", "speed = difference: time constant of the filter, 0: none").display_unit("ms"),
    size!("speed.bandwidth", speed.bandwidth, 0..=1e5, "rad/s", "speed = observer: its bandwidth"),
    switch!("current", current.on, "whether the currents are measured in the phases, with errors"),
    size!("current.gain", current.gain, 0..=1.0, "1", "current: relative gain errors are drawn by the seed, uniformly between minus and plus this").display_unit("%"),
    size!("current.offset", current.offset, 0..=1e4, "A", "current: offsets of the phases are drawn by the seed, uniformly between minus and plus this"),
    size!("current.noise", current.noise, 0..=1e4, "A", "current: standard deviation of the noise in a phase"),
    bits!("current.bits", current.bits, "current: bits of the converter"),
    size!("current.range", current.range, 0..=1e6, "A", "current: the converter goes from minus to plus this").min(1e-3),
    V::integer_parameter("current.pole_pairs", "current: pole pairs of the motors", |p| &p.p.current.pole_pairs, |p| &mut p.p.current.pole_pairs).min(1.0).max(1000.0),
    V::integer_parameter("force", "what gives the rod forces", |p| &p.force, |p| &mut p.force).enumeration(&FORCE),
    size!("force.bias", force.bias, 0..=1e7, "N", "force = sensor: biases are drawn by the seed, uniformly between minus and plus this").display_unit("kN"),
    size!("force.noise", force.noise, 0..=1e7, "N", "force = sensor: standard deviation of the noise"),
    size!("force.bandwidth", force.bandwidth, 0..=1e6, "Hz", "force = sensor: bandwidth of its first-order lag").min(1e-3),
    V::parameter("force.per_current", "force = absent: force that the reading gives for an ampere of quadrature current, 3/2 p lambda_m 2 pi N/rho of the reference actuator",
        |p| &p.p.force.per_current, |p| &mut p.p.force.per_current).unit("N/A").min(-1e6).max(1e6),
];
