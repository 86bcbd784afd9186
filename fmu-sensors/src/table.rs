//! Variables of the FMU `Sensors` for its description and calls: name, unit, bounds, dependencies.

use super::model::{FORCE, SPEED, SensorsFmu};
use fmu_export::{ALL_PARAMETERS, File, Info, Terminal, Unit, Variable, row};
use sensors::{W_M_MAX, X_DOT_MAX, ZETA_DOT_MAX};

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

/// An input that is measured: setting it makes a new sample.
const fn measured(row: V) -> V {
    row.counted(|u| &mut u.sets)
}

#[rustfmt::skip]
pub(crate) const VARIABLES: &[V] = &[
    // What is measured
    measured(row!(V, inputs zeta in u, "joint angles: slew, lift, tilt, wrist")).unit("rad").display_unit("deg").range(-100.0..=100.0),
    measured(row!(V, inputs zeta_dot in u, "joint rates; read if speed = ideal")).unit("rad/s").display_unit("deg/s").range(-ZETA_DOT_MAX..=ZETA_DOT_MAX),
    measured(row!(V, inputs theta_m in u, "motor angles of slew, lift and tilt actuator")).unit("rad").display_unit("deg").range(-1e8..=1e8),
    measured(row!(V, inputs w_m in u, "motor speeds; read if speed = ideal")).unit("rad/s").display_unit("rpm").range(-W_M_MAX..=W_M_MAX),
    measured(row!(V, inputs i_d in u, "direct-axis currents (peak)")).unit("A").range(-1e5..=1e5),
    measured(row!(V, inputs i_q in u, "quadrature-axis currents (peak)")).unit("A").range(-1e5..=1e5),
    measured(row!(V, inputs F in u, "rod forces, positive when pushing")).unit("N").display_unit("kN").range(-1e8..=1e8),
    measured(row!(V, inputs x in u, "rod positions, positive when extended")).unit("m").display_unit("mm").range(-10.0..=10.0),
    measured(row!(V, inputs x_dot in u, "rod velocities; read if speed = ideal")).unit("m/s").display_unit("mm/s").range(-X_DOT_MAX..=X_DOT_MAX),

    // Readings depend directly on the inputs if `delay` is 0. The dependencies are the same for
    // other delays, because FMI 2.0 has one list for all parameter values.
    row!(V, outputs zeta_measured = zeta, "joint angles by their encoders")
        .unit("rad").display_unit("deg").depends_on(&["zeta[i]"]).initially_also_on(&[ALL_PARAMETERS]).discrete(),
    row!(V, outputs zeta_dot_measured = zeta_dot, "joint rates")
        .unit("rad/s").display_unit("deg/s").depends_on(&["zeta[i]", "zeta_dot[i]"]).initially_also_on(&[ALL_PARAMETERS]).discrete(),
    row!(V, outputs theta_m_measured = theta_m, "motor angles by their encoders")
        .unit("rad").display_unit("deg").depends_on(&["theta_m[i]"]).initially_also_on(&[ALL_PARAMETERS]).discrete(),
    row!(V, outputs w_m_measured = w_m, "motor speeds")
        .unit("rad/s").display_unit("rpm").depends_on(&["theta_m[i]", "w_m[i]"]).initially_also_on(&[ALL_PARAMETERS]).discrete(),
    row!(V, outputs i_d_measured = i_d, "direct-axis currents (peak), from two phases and the measured motor angle")
        .unit("A").depends_on(&["i_d[i]", "i_q[i]", "theta_m[i]"]).initially_also_on(&[ALL_PARAMETERS]).discrete(),
    row!(V, outputs i_q_measured = i_q, "quadrature-axis currents (peak), from two phases and the measured motor angle")
        .unit("A").depends_on(&["i_d[i]", "i_q[i]", "theta_m[i]"]).initially_also_on(&[ALL_PARAMETERS]).discrete(),
    row!(V, outputs F_measured = F, "rod forces")
        .unit("N").display_unit("kN").depends_on(&["F[i]", "i_d[i]", "i_q[i]", "theta_m[i]"]).initially_also_on(&[ALL_PARAMETERS]).discrete(),
    row!(V, outputs x_measured = x, "rod positions")
        .unit("m").display_unit("mm").depends_on(&["x[i]"]).initially_also_on(&[ALL_PARAMETERS]).discrete(),
    row!(V, outputs x_dot_measured = x_dot, "rod velocities")
        .unit("m/s").display_unit("mm/s").depends_on(&["x[i]", "x_dot[i]"]).initially_also_on(&[ALL_PARAMETERS]).discrete(),

    // Parameters
    row!(V, integer_parameter seed, "seed of the noise and of the drawn errors; another number for each effect, whatever others are on").min(0.0),
    row!(V, integer_parameter delay, "communication steps from measurement to reading").range(0.0..=4.0),
    row!(V, boolean_parameter motor_encoder = p.motor_encoder.on, "whether motor angles are counted"),
    row!(V, integer_parameter motor_encoder.bits in p, "motor encoder: counts per turn as a power of two").range(1.0..=48.0),
    row!(V, parameter motor_encoder.noise in p, "motor encoder: standard deviation of the noise, counts").unit("1").range(0.0..=1e3),
    row!(V, boolean_parameter joint_encoder = p.joint_encoder.on, "whether joint angles are counted"),
    row!(V, integer_parameter joint_encoder.bits in p, "joint encoder: counts per turn as a power of two").range(1.0..=48.0),
    row!(V, parameter joint_encoder.noise in p, "joint encoder: standard deviation of the noise, counts").unit("1").range(0.0..=1e3),
    row!(V, boolean_parameter rod_encoder = p.rod_encoder.on, "whether rod positions are counted"),
    row!(V, integer_parameter rod_encoder.bits in p, "rod encoder: counts per metre as a power of two").range(1.0..=48.0),
    row!(V, parameter rod_encoder.noise in p, "rod encoder: standard deviation of the noise, counts").unit("1").range(0.0..=1e3),
    row!(V, boolean_parameter joint_zero = p.joint_zero.on, "whether the joint encoders' zeros err"),
    row!(V, parameter joint_zero.bound in p, "zeros are drawn by the seed, uniformly between minus and plus this").unit("rad").range(0.0..=1.0).display_unit("deg"),
    row!(V, parameters joint_zero.given in p, "zeros that are added to the drawn ones")
        .unit("rad").display_unit("deg").range(-7.0..=7.0),
    row!(V, integer_parameter speed, "where speeds come from").items(&SPEED),
    row!(V, parameter speed.filter_time in p, "speed = difference: time constant of the filter, 0: none").unit("s").range(0.0..=10.0).display_unit("ms"),
    row!(V, parameter speed.bandwidth in p, "speed = observer: its bandwidth").unit("rad/s").range(0.0..=1e5),
    row!(V, boolean_parameter current = p.current.on, "whether the currents are measured in the phases, with errors"),
    row!(V, parameter current.gain in p, "current: relative gain errors are drawn by the seed, uniformly between minus and plus this").unit("1").range(0.0..=1.0).display_unit("%"),
    row!(V, parameter current.offset in p, "current: offsets of the phases are drawn by the seed, uniformly between minus and plus this").unit("A").range(0.0..=1e4),
    row!(V, parameter current.noise in p, "current: standard deviation of the noise in a phase").unit("A").range(0.0..=1e4),
    row!(V, integer_parameter current.bits in p, "current: bits of the converter").range(1.0..=48.0),
    row!(V, parameter current.range in p, "current: the converter goes from minus to plus this").unit("A").range(1e-3..=1e6),
    row!(V, integer_parameter current.pole_pairs in p, "current: pole pairs of the motors").range(1.0..=1000.0),
    row!(V, integer_parameter force, "what gives the rod forces").items(&FORCE),
    row!(V, parameter force.bias in p, "force = sensor: biases are drawn by the seed, uniformly between minus and plus this").unit("N").range(0.0..=1e7).display_unit("kN"),
    row!(V, parameter force.noise in p, "force = sensor: standard deviation of the noise").unit("N").range(0.0..=1e7),
    row!(V, parameter force.bandwidth in p, "force = sensor: bandwidth of its first-order lag").unit("Hz").range(1e-3..=1e6),
    row!(V, parameter force.per_current in p, "force = absent: force that the reading gives for an ampere of quadrature current, 3/2 p lambda_m 2 pi N/rho of the reference actuator").unit("N/A").range(-1e6..=1e6),
    row!(V, parameter force.gain in p, "force = sensor: relative gain errors are drawn by the seed, uniformly between minus and plus this").unit("1").range(0.0..=1.0).display_unit("%"),
    row!(V, parameter force.hysteresis in p, "force = sensor: width of the loop between rising and falling force").unit("N").range(0.0..=1e7).display_unit("kN"),
    row!(V, parameter speed.bandwidth_motor in p, "speed = observer: its bandwidth at the motors, 0: speed.bandwidth").unit("rad/s").range(0.0..=1e5),
];
