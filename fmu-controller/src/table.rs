//! Variables of the FMU `Controller`.

use crate::{ControllerFmu, Parameters};
use emla::Surrogate;
use fmu_export::{
    ALL_PARAMETERS, DisplayUnit, Enumeration, File, Info, Terminal, Unit, Variable,
    read_parameter_file, read_placed_file,
};
use machine::Machine;
use std::path::Path;
use tip_path::{BUILT_IN, PathFile};
use vdc::{DELAY_MAX, Derating};

pub(crate) const MODE_ADAPTIVE: i32 = 1;
pub(crate) const MODE_MODULAR: i32 = 2;
pub(crate) const MODE_PD: i32 = 3;
pub(crate) const MODE_MODULAR_INTEGRAL: i32 = 4;
pub(crate) const MODE_PD_INTEGRAL: i32 = 5;
pub(crate) const MODE_PD_GRAVITY: i32 = 6;
pub(crate) const MODE_PD_GRAVITY_INTEGRAL: i32 = 7;
static MODE: Enumeration = Enumeration::new(
    "Mode",
    "how much of the controller is at work",
    &[
        (
            "adaptive",
            "model-based, with natural adaptation of the inertias",
        ),
        ("modular", "model-based, with the nominal inertias"),
        (
            "pd",
            "no model: inverse kinematics, damping and decoupling only",
        ),
        (
            "modular_integral",
            "as modular, with the integral of the tip's error",
        ),
        ("pd_integral", "as pd, with the integral of the tip's error"),
        (
            "pd_gravity",
            "as pd, with the forces that hold the nominal machine against gravity",
        ),
        (
            "pd_gravity_integral",
            "as pd_gravity, with the integral of the tip's error",
        ),
        (
            "adaptive_integral",
            "as adaptive, with the integral of the tip's error",
        ),
    ],
);

pub(crate) const TRAJECTORY_CUBIC: i32 = 1;
pub(crate) const TRAJECTORY_TRIANGULAR: i32 = 2;
pub(crate) const TRAJECTORY_RATES: i32 = 4;
pub(crate) const RATE_COMMAND_JOINT: i32 = 1;
pub(crate) const TRAJECTORY_PATH: i32 = 5;
pub(crate) const LEVEL_MACHINE: i32 = 1;
static LEVEL: Enumeration = Enumeration::new(
    "Level",
    "what the controller follows",
    &[
        (
            "machine",
            "the tip's reference, through inverse kinematics and decomposition",
        ),
        (
            "actuator",
            "the inputs reference.rod_*, each actuator by itself",
        ),
    ],
);

static TRAJECTORY: Enumeration = Enumeration::new(
    "Trajectory",
    "desired motion of the tip",
    &[
        ("cubic", "edges of a cube"),
        ("triangular", "a triangle in the boom plane"),
        ("external", "the inputs reference.*"),
        ("rates", "the inputs rate.joint or rate.tip, an operator's"),
        ("path", "the path that path_file names"),
    ],
);

static RATE_COMMAND: Enumeration = Enumeration::new(
    "RateCommand",
    "what commanded rates are of",
    &[
        ("joint", "the six joints, by the inputs rate.joint"),
        ("tip", "the tip in the world, by the inputs rate.tip"),
    ],
);

pub(crate) const INFO: Info = Info::new(
    "Controller",
    "Adaptive modular controller of an all-electric heavy-duty manipulator: virtual decomposition control with natural \
     adaptation, and a voltage law for each actuator",
)
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
.resources(&[
    File { path: "reference_machine.json", bytes: machine::REFERENCE_JSON.as_bytes() },
    File { path: "sized_machine.json", bytes: machine::SIZED_JSON.as_bytes() },
])
.units(&[
    Unit::new("V/N").m(1).s(-1).A(-1).display(&[DisplayUnit::new("V/kN", 1e3)]),
    Unit::new("N/A").kg(1).m(1).s(-2).A(-1),
    Unit::new("A/N").kg(-1).m(-1).s(2).A(1),
    Unit::new("m/N").kg(-1).s(2),
]);

type V = Variable<ControllerFmu>;

/// What the required twists depend on, and further inputs: joint motion and reference without the acceleration.
macro_rules! twists_and {
    ($($more:expr),*) => {
        &[
            "zeta", "zeta_dot", "reference.position", "reference.velocity", "reference.orientation",
            "reference.angular_velocity", $($more),*
        ]
    };
}

/// What the required wrenches depend on, and further inputs: joint motion, reference, and what the base does.
macro_rules! motion_and {
    ($($more:expr),*) => {
        twists_and!("reference.acceleration", "base.tilt", "base.acceleration", "base.angular_velocity", "base.angular_acceleration" $(, $more)*)
    };
}

/// [`motion_and`] the rods' own references and measurements.
macro_rules! motion_rod_and {
    ($($more:expr),*) => {
        motion_and!(
            "x[i]", "x_dot[i]", "reference.rod_position[i]", "reference.rod_velocity[i]",
            "reference.rod_acceleration[i]", "reference.rod_force[i]" $(, $more)*
        )
    };
}

/// What the required rod velocities depend on, and further inputs.
macro_rules! rates_and_rods_and {
    ($($more:expr),*) => {
        &[
            "zeta", "reference.position", "reference.velocity", "reference.orientation", "reference.angular_velocity",
            "x[i]", "reference.rod_position[i]", "reference.rod_velocity[i]", $($more),*
        ]
    };
}

/// An output that is as it is from the beginning on: it depends on the same inputs initially, and on all parameters.
macro_rules! depends {
    ($row:expr, $list:ident $(, $input:literal)*) => {
        $row.depends_on($list!($($input),*)).initially_depends_on($list!($($input,)* ALL_PARAMETERS)).discrete()
    };
}

/// Inputs by name.
macro_rules! on {
    ($($input:expr),*) => { &[$($input),*] };
}

/// The row of a gain in `machine.controller` from its name, unit and description.
macro_rules! gain {
    ($field:ident, $unit:literal, $description:literal) => {
        V::parameter(
            stringify!($field),
            $description,
            |p| &p.machine.controller.$field,
            |p| &mut p.machine.controller.$field,
        )
        .unit($unit)
        .tunable()
        .min(0.0)
        .max(GAIN_MAX)
    };
}

/// The estimated mass of a body.
macro_rules! mass_hat {
    ($name:literal, $body:ident) => {
        V::output(
            concat!("mass_hat.", $name),
            concat!("estimated mass of body ", $name),
            |y| &y.mass_hat[hdrm::Body::$body as usize],
        )
        .unit("kg")
        .depends_on(&[])
        .initially_depends_on(&[ALL_PARAMETERS])
        .discrete()
    };
}

/// A number of the low-level law's stability conditions.
macro_rules! condition {
    ($field:ident, $unit:literal, $description:literal) => {
        V::output(
            concat!("stability.", stringify!($field)),
            $description,
            |y| &y.conditions.$field,
        )
        .unit($unit)
        .depends_on(&[])
        .initially_depends_on(&[ALL_PARAMETERS])
        .discrete()
    };
}

fn read_machine(p: &mut Parameters, file: &str, resources: Option<&Path>) -> Result<(), String> {
    p.machine = match Machine::preset(file) {
        Some(machine) => machine,
        None => read_placed_file(file, resources, Machine::of_file)?,
    };
    p.machine_file = file.to_owned();
    Ok(())
}

fn read_surrogate(p: &mut Parameters, file: &str, resources: Option<&Path>) -> Result<(), String> {
    p.surrogate = match file {
        "" => Surrogate::reference(),
        _ => read_parameter_file(file, resources, Surrogate::from_json)?,
    };
    p.surrogate_file = file.to_owned();
    Ok(())
}

fn read_path(p: &mut Parameters, file: &str, resources: Option<&Path>) -> Result<(), String> {
    p.path = match PathFile::built_in(file) {
        _ if file.is_empty() => None,
        Some(test) => Some(test.map_err(|e| format!("path `{file}`: {e}"))?),
        None => Some(
            read_parameter_file(file, resources, PathFile::parse).map_err(|e| {
                let is_found =
                    Path::new(file).exists() || resources.is_some_and(|r| r.join(file).exists());
                if is_found {
                    return e;
                }
                format!("{e}; the built-in paths are {}", BUILT_IN.join(" and "))
            })?,
        ),
    };
    p.path_file = file.to_owned();
    Ok(())
}

/// 20 °C, K.
pub(crate) const ROOM: f64 = 293.15;
/// Class F insulation, 155 °C, reached at no current; full current up to 120 °C.
pub(crate) const DERATED: Derating = Derating {
    start: 393.15,
    end: 428.15,
};

const ANGLE_MAX: f64 = 100.0;
const RATE_MAX: f64 = 1e4;
const CURRENT_MAX: f64 = 1e5;
const FORCE_MAX: f64 = 1e8;
/// Far beyond use; with it no product of a gain and an input leaves the range of numbers.
const GAIN_MAX: f64 = 1e9;

#[rustfmt::skip]
pub(crate) const VARIABLES: &[V] = &[
    // Measurements
    V::inputs("zeta", "joint angles: slew, lift, tilt, wrist", |u| &u.zeta, |u| &mut u.zeta)
        .unit("rad").display_unit("deg").min(-ANGLE_MAX).max(ANGLE_MAX),
    V::inputs("zeta_dot", "joint rates", |u| &u.zeta_dot, |u| &mut u.zeta_dot)
        .unit("rad/s").display_unit("deg/s").min(-RATE_MAX).max(RATE_MAX),
    V::inputs("i_d", "direct-axis currents of slew, lift and tilt actuator (peak)", |u| &u.i_d, |u| &mut u.i_d)
        .unit("A").min(-CURRENT_MAX).max(CURRENT_MAX),
    V::inputs("i_q", "quadrature-axis currents (peak)", |u| &u.i_q, |u| &mut u.i_q)
        .unit("A").min(-CURRENT_MAX).max(CURRENT_MAX),
    V::inputs("w_m", "motor speeds", |u| &u.w_m, |u| &mut u.w_m)
        .unit("rad/s").display_unit("rpm").min(-1e6).max(1e6),
    V::inputs("x", "rod positions, read if level = actuator", |u| &u.x, |u| &mut u.x)
        .unit("m").display_unit("mm").min(-10.0).max(10.0),
    V::inputs("x_dot", "rod velocities; read by the virtual power flows and if level = actuator", |u| &u.x_dot, |u| &mut u.x_dot)
        .unit("m/s").display_unit("mm/s").min(-100.0).max(100.0),
    V::inputs("F", "actuator forces, positive when pushing; read by the virtual power flows and, in a step, by the disturbance observer", |u| &u.F, |u| &mut u.F)
        .unit("N").display_unit("kN").min(-FORCE_MAX).max(FORCE_MAX).beside_evaluation(),
    V::input("v_dc", "voltage of the DC link: its voltage limit is min(v_max, v_dc/sqrt(3)); until it is set, the nominal machine's counts", |u| &u.v_dc, |u| &mut u.v_dc)
        .unit("V").min(0.0).max(1e5).nominal(500.0).counted(|u| &mut u.v_dc_sets),
    V::inputs("T_winding", "temperatures of the windings, read while derating is on", |u| &u.T_winding, |u| &mut u.T_winding)
        .unit("K").display_unit("degC").min(1.0).max(1e4).nominal(300.0),
    // External reference
    V::inputs("reference.position", "desired tip position in the world, read if trajectory = external",
        |u| &u.reference_position, |u| &mut u.reference_position).unit("m").min(-100.0).max(100.0),
    V::inputs("reference.velocity", "desired tip velocity in the world, read if trajectory = external",
        |u| &u.reference_velocity, |u| &mut u.reference_velocity).unit("m/s").min(-100.0).max(100.0),
    V::inputs("reference.acceleration", "desired tip acceleration in the world, read if trajectory = external",
        |u| &u.reference_acceleration, |u| &mut u.reference_acceleration).unit("m/s2").min(-1e4).max(1e4),
    V::inputs("reference.orientation", "desired tip orientation, quaternion w, x, y, z of length 1, read if trajectory = external",
        |u| &u.reference_orientation, |u| &mut u.reference_orientation).unit("1").min(-1.001).max(1.001),
    V::inputs("reference.angular_velocity", "desired angular velocity of the tip in the world, read if trajectory = external",
        |u| &u.reference_angular_velocity, |u| &mut u.reference_angular_velocity).unit("rad/s").display_unit("deg/s").min(-RATE_MAX).max(RATE_MAX),

    V::inputs("reference.rod_position", "desired rod positions, read if level = actuator",
        |u| &u.reference_rod_position, |u| &mut u.reference_rod_position).unit("m").display_unit("mm").min(-10.0).max(10.0),
    V::inputs("reference.rod_velocity", "desired rod velocities, read if level = actuator",
        |u| &u.reference_rod_velocity, |u| &mut u.reference_rod_velocity).unit("m/s").display_unit("mm/s").min(-100.0).max(100.0),
    V::inputs("reference.rod_acceleration", "desired rod accelerations, read if level = actuator",
        |u| &u.reference_rod_acceleration, |u| &mut u.reference_rod_acceleration).unit("m/s2").min(-1e4).max(1e4),
    V::inputs("reference.rod_force", "desired forces on the load, read if level = actuator",
        |u| &u.reference_rod_force, |u| &mut u.reference_rod_force).unit("N").display_unit("kN").min(-FORCE_MAX).max(FORCE_MAX),

    V::inputs("base.tilt", "what the controller is told of the base's tilt against the ground: roll about x, then pitch about its own z", |u| &u.base_tilt, |u| &mut u.base_tilt)
        .unit("rad").display_unit("deg").min(-3.2).max(3.2).nominal(0.1),
    V::inputs("base.acceleration", "what it is told of the base's acceleration, in the axes of the machine's world", |u| &u.base_acceleration, |u| &mut u.base_acceleration)
        .unit("m/s2").min(-1e3).max(1e3).nominal(1.0),
    V::inputs("base.angular_velocity", "what it is told of the base's angular velocity, in the same axes",
        |u| &u.base_angular_velocity, |u| &mut u.base_angular_velocity).unit("rad/s").display_unit("deg/s").min(-100.0).max(100.0).nominal(0.1),
    V::inputs("base.angular_acceleration", "what it is told of the rate of that",
        |u| &u.base_angular_acceleration, |u| &mut u.base_angular_acceleration).unit("rad/s2").display_unit("deg/s2").min(-1e4).max(1e4).nominal(0.1),

    V::inputs("rate.joint", "commanded joint rates, read in a step if trajectory = rates and rate.command = joint", |u| &u.rate_joint, |u| &mut u.rate_joint)
        .unit("rad/s").display_unit("deg/s").min(-RATE_MAX).max(RATE_MAX).beside_evaluation(),
    V::inputs("rate.tip", "commanded velocity (1 to 3) and angular velocity (4 to 6) of the tip in the world, read in a step if trajectory = rates and rate.command = tip",
        |u| &u.rate_tip, |u| &mut u.rate_tip).each_unit(&["m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s"]).min(-RATE_MAX).max(RATE_MAX).beside_evaluation(),

    // Commands
    depends!(V::outputs("v_d", "direct-axis voltages (peak)", |y| &y.v_d)
        .unit("V"), on, "i_d[i]", "i_q[i]", "w_m[i]"),
    depends!(V::outputs("v_q", "quadrature-axis voltages (peak)", |y| &y.v_q)
        .unit("V"), motion_rod_and, "i_d[i]", "i_q[i]", "w_m[i]", "T_winding[i]"),
    depends!(V::outputs("tau_wrist", "wrist torques, held to their limits", |y| &y.tau_wrist)
        .unit("N.m"), motion_and),
    depends!(V::outputs("f_required", "required actuator forces", |y| &y.f_required)
        .unit("N").display_unit("kN"), motion_rod_and),
    depends!(V::outputs("x_dot_required", "required rod velocities", |y| &y.x_dot_required)
        .unit("m/s").display_unit("mm/s"), rates_and_rods_and),
    depends!(V::outputs("i_q_required", "required quadrature-axis currents (peak)", |y| &y.i_q_required)
        .unit("A"), motion_rod_and, "i_d[i]", "i_q[i]", "w_m[i]", "T_winding[i]"),
    V::output("motion_end", "time at which the reference has come to its end; the start time if trajectory = external", |y| &y.motion_end)
        .unit("s").depends_on(&[]).initially_depends_on(&["zeta", ALL_PARAMETERS]).discrete(),
    V::outputs("desired.position", "desired tip position in the world", |y| &y.desired_position)
        .unit("m").depends_on(&["reference.position"]).initially_depends_on(&["zeta", "reference.position", ALL_PARAMETERS]).discrete(),
    depends!(V::outputs("tip_error", "desired minus actual tip position in the world", |y| &y.tip_error)
        .unit("m").display_unit("mm"), on, "zeta", "reference.position"),
    depends!(V::output("tip_error_norm", "length of the tip error", |y| &y.tip_error_norm)
        .unit("m").display_unit("mm"), on, "zeta", "reference.position"),
    V::outputs("desired.orientation", "desired tip orientation in the world, quaternion w, x, y, z", |y| &y.desired_orientation)
        .unit("1").depends_on(&["reference.orientation"]).initially_depends_on(&["zeta", "reference.orientation", ALL_PARAMETERS]).discrete(),
    depends!(V::output("orientation_error_norm", "angle between desired and actual tip orientation", |y| &y.orientation_error_norm)
        .unit("rad").display_unit("deg"), on, "zeta", "reference.orientation"),

    V::output("load.mass", "mass that the path has the end-effector carry beside its payload", |y| &y.load.mass)
        .unit("kg").depends_on(&[]).initially_depends_on(&["zeta", ALL_PARAMETERS]).discrete(),
    V::outputs("load.com", "place of that load from the tip T4, in T4's axes", |y| &y.load.com)
        .unit("m").depends_on(&[]).initially_depends_on(&["zeta", ALL_PARAMETERS]).discrete(),

    // Adaptation
    mass_hat!("T1", T1), mass_hat!("A2", A2), mass_hat!("C2", C2), mass_hat!("D2", D2), mass_hat!("A3", A3),
    mass_hat!("C3", C3), mass_hat!("D3", D3), mass_hat!("RK", RK), mass_hat!("CP", CP), mass_hat!("A4", A4),
    mass_hat!("C4", C4), mass_hat!("D4", D4), mass_hat!("PL", PL),

    // Stability in numbers
    depends!(V::output("lyapunov.nu_velocity", "sum of 1/2 s'Ms over the bodies, s = V_r - V, with the plant's inertias", |y| &y.nu_velocity)
        .unit("J"), twists_and, "base.angular_velocity"),
    V::output("lyapunov.nu_adaptation", "sum of gamma D_F(L||L_hat) over the bodies", |y| &y.nu_adaptation)
        .unit("J").depends_on(&[]).initially_depends_on(&[ALL_PARAMETERS]).discrete(),
    depends!(V::outputs("lyapunov.nu_actuator", "accompanying function of each actuator", |y| &y.nu_actuator)
        .unit("J"), motion_rod_and, "i_d[i]", "i_q[i]", "w_m[i]", "T_winding[i]"),
    depends!(V::output("lyapunov.dissipation", "sum of s'K_A s over the bodies", |y| &y.dissipation)
        .unit("W"), twists_and, "base.angular_velocity"),
    depends!(V::outputs("lyapunov.vpf", "virtual power flow (x_dot_r - x_dot)(f_r - F) at each rod", |y| &y.vpf)
        .unit("W"), motion_rod_and, "F[i]"),

    depends!(V::outputs("lyapunov.force_error", "required minus actual force of each actuator by its currents", |y| &y.force_error)
        .unit("N").display_unit("kN"), motion_rod_and, "i_d[i]", "i_q[i]", "w_m[i]", "T_winding[i]"),
    depends!(V::outputs("lyapunov.dissipation_actuator", "dissipation of each actuator in the bound on its accompanying function", |y| &y.dissipation_actuator)
        .unit("W"), motion_rod_and, "i_d[i]", "i_q[i]", "w_m[i]", "T_winding[i]"),

    condition!(beta_1, "N/A", "beta_1 at i_d = 0"),
    condition!(beta_2, "N/A", "beta_2 at i_q = i_max"),
    condition!(printed_margin, "1", "first stability condition as printed, left over right side at i_max: it holds from 1 on"),
    condition!(epsilon_max, "A/N", "largest weight of Young's inequality for which the first condition holds at i_max"),
    condition!(K_1, "m/N", "K_1 of the accompanying function, by the third condition"),
    condition!(K_2, "H", "K_2 of the accompanying function: twice the least that the second condition allows with half the largest weight"),

    // Parameters
    V::integer_parameter("level", "what the controller follows", |p| &p.level, |p| &mut p.level)
        .enumeration(&LEVEL),
    V::integer_parameter("mode", "how much of the controller is at work", |p| &p.mode, |p| &mut p.mode)
        .enumeration(&MODE).tunable(),
    V::integer_parameter("trajectory", "desired motion of the tip", |p| &p.trajectory, |p| &mut p.trajectory)
        .enumeration(&TRAJECTORY),
    V::integer_parameter("rate.command", "what commanded rates are of, if trajectory = rates", |p| &p.rate_command, |p| &mut p.rate_command)
        .enumeration(&RATE_COMMAND).tunable(),
    V::parameters("rate.joint_max", "largest joint rates, under commands of the tip too; the reference takes 98 % of them, the rest is for the feedback", |p| &p.rates.joint, |p| &mut p.rates.joint)
        .unit("rad/s").display_unit("deg/s").min(1e-6).max(100.0),
    V::parameters("rate.joint_acceleration_max", "largest accelerations of the joints' reference, under commands of the tip too", |p| &p.rates.joint_acceleration, |p| &mut p.rates.joint_acceleration)
        .unit("rad/s2").display_unit("deg/s2").min(1e-6).max(1e4),
    V::parameters("rate.tip_max", "largest commanded velocity and angular velocity of the tip", |p| &p.rates.tip, |p| &mut p.rates.tip)
        .each_unit(&["m/s", "rad/s"]).min(1e-6).max(100.0),
    V::parameters("rate.tip_acceleration_max", "largest acceleration and angular acceleration under commands of the tip",
        |p| &p.rates.tip_acceleration, |p| &mut p.rates.tip_acceleration).each_unit(&["m/s2", "rad/s2"]).min(1e-6).max(1e4),
    V::parameter("rate.smoothing", "time constant with which rates follow commands", |p| &p.rates.smoothing, |p| &mut p.rates.smoothing)
        .unit("s").display_unit("ms").min(1e-3).max(10.0),
    V::boolean_parameter("load.told", "whether the nominal machine takes over the loads that the path picks up and sets down", |p| &p.load_told, |p| &mut p.load_told)
        .tunable(),
    V::string_parameter("machine_file", "machine JSON, or name of a shipped machine, to use for the nominal parameters and gains instead of the reference machine",
        |p| &p.machine_file, read_machine),
    V::string_parameter("surrogate_file", "network JSON of the hybrid actuators to use instead of the embedded network",
        |p| &p.surrogate_file, read_surrogate),
    V::string_parameter("path_file", "path to follow if trajectory = path: JSON or CSV file of waypoints or samples, or iso9283-cube, iso9283-rectangle",
        |p| &p.path_file, read_path),
    V::boolean_parameter("path_check", "whether a path that the nominal machine cannot do is refused before the start", |p| &p.path_check, |p| &mut p.path_check),
    V::parameter("alpha", "blending factor of the hybrid actuators that the voltage law reckons with; 0: it knows the physics only",
        |p| &p.alpha, |p| &mut p.alpha).unit("1").tunable().min(0.0).max(1.0),
    V::parameter("settle_time", "time for which the start pose is held before the trajectory begins",
        |p| &p.machine.controller.settle_time, |p| &mut p.machine.controller.settle_time).unit("s").min(0.0).max(1e6),
    V::parameter("sample_time", "time between two samples: outputs change at its multiples after the start only; 0: every communication point is a sample",
        |p| &p.sample_time, |p| &mut p.sample_time).unit("s").display_unit("ms").min(0.0).max(10.0),
    V::boolean_parameter("derating", "whether the largest current falls with the winding's temperature", |p| &p.derating, |p| &mut p.derating),
    V::parameter("derating.start", "winding temperature up to which the law asks for up to i_max", |p| &p.derated.start, |p| &mut p.derated.start)
        .unit("K").display_unit("degC").min(1.0).max(1e4),
    V::parameter("derating.end", "winding temperature from which on the law asks for no current; between the two the limit falls linearly",
        |p| &p.derated.end, |p| &mut p.derated.end).unit("K").display_unit("degC").min(1.0).max(1e4),
    V::integer_parameter("delay", "communication steps by which the commands act later than measured, which the controller then predicts over (F must be connected); 1 where all outputs are read before any input is set",
        |p| &p.delay, |p| &mut p.delay).min(0.0).max(DELAY_MAX as f64),
    gain!(Lambda_position, "1/s", "inverse-kinematics feedback on the position"),
    gain!(Lambda_orientation, "1/s", "inverse-kinematics feedback on the orientation"),
    gain!(Lambda_rod, "1/s", "feedback on the rods' positions if level = actuator").min(1e-6),
    gain!(kappa_KA, "1/s", "K_A = kappa_KA times the nominal inertia of each body"),
    gain!(K_i, "V/A", "current feedback"),
    gain!(K_f, "V/N", "force feedback"),
    gain!(K_v, "V.s/m", "velocity feedback on the motor side"),
    gain!(lambda_i, "1/s", "decay rate of the required direct-axis current"),
    gain!(omega_i, "1/s", "integral rate of the voltage law; 0: the paper's law"),
    gain!(omega_d, "1/s", "bandwidth of the disturbance observer; 0: the paper's law"),
    gain!(omega_tip, "1/s", "rate of the integral of the tip's error, read in the modes with integral"),
    gain!(omega_speed, "rad/s", "bandwidth of the observer that makes joint rates of the angles zeta; 0: the measured zeta_dot count, the paper's law"),
    gain!(reading_age, "s", "age of the measurements when they are read: they are compared with the reference of then; 0: the paper's law").display_unit("ms").max(1.0),
    gain!(leakage, "1/s", "rate at which estimated inertias go back to the nominal ones; 0: the paper's law"),
    gain!(gamma, "J", "adaptation gain of the natural adaptation law; larger is slower").min(1e-6),
    gain!(di_qr_filter_time, "s", "time constant of the filter behind d(i_qr)/dt").display_unit("ms").min(1e-6),
    gain!(pd_actuator_damping, "N.s/m", "rod-velocity damping in mode pd"),
    V::parameters("pd_wrist_damping", "wrist damping in mode pd",
        |p| &p.machine.controller.pd_wrist_damping, |p| &mut p.machine.controller.pd_wrist_damping).unit("N.m.s/rad").tunable().min(0.0).max(GAIN_MAX),
    V::parameters("inverse_bounds", "bounds on the inverse pseudo-inertia over its nominal value: lower, upper",
        |p| &p.machine.controller.inverse_bounds, |p| &mut p.machine.controller.inverse_bounds).unit("1").min(1e-6).max(1e6),
    V::parameter("lyapunov.inertia_scale", "inertia of the plant over nominal, for the lyapunov.* outputs only",
        |p| &p.true_inertia_scale, |p| &mut p.true_inertia_scale).unit("1").tunable().min(0.01).max(100.0),
];
