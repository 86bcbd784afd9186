//! Variables of the FMU `Emla`.

use crate::{EmlaFmu, Parameters};
use emla::Surrogate;
use fmu_export::{
    ALL_PARAMETERS, Enumeration, File, Info, MadeFile, Terminal, Unit, Variable,
    read_parameter_file, read_placed_file,
};
use machine::{EmlaFields, Machine};
use std::path::Path;

pub(crate) const DRIVE_MOTION: i32 = 1;
static DRIVE: Enumeration = Enumeration::new(
    "Drive",
    "who moves the rod",
    &[
        (
            "motion",
            "a mechanism: the rod follows the inputs x and x_dot, F is the answer",
        ),
        (
            "force",
            "the actuator: the rod is a free mass against the input F_ext",
        ),
    ],
);

pub(crate) const AXIS_SLEW: i32 = 1;
static AXIS: Enumeration = Enumeration::new(
    "Axis",
    "actuator of the machine",
    &[
        ("slew", "turns the column"),
        ("lift", "lifts the boom"),
        ("tilt", "tilts the second boom"),
    ],
);

pub(crate) const INFO: Info = Info::new(
    "Emla",
    "Electromechanical linear actuator: permanent-magnet synchronous motor, gear, ball screw and rod, with losses and a \
     surrogate network blended in",
)
.version(env!("CARGO_PKG_VERSION"))
.license("MIT OR Apache-2.0")
.experiment(0.0, 1.0, 1e-3)
.documentation(&[File { path: "index.html", bytes: include_bytes!("../documentation/index.html") }])
.icon(include_bytes!("../model.png"))
.terminals(&[
    Terminal::new("rod", "io.github.hdrm-fmu.rod", "mechanical bond: the rod moves as told, and pushes with F", &[
        ("x", "x"), ("x_dot", "x_dot"), ("F", "F"), ("F_mean", "F_mean"), ("F_hold", "F_hold"),
    ]),
    Terminal::new("dc", "io.github.hdrm-fmu.dc-link", "electrical bond: the DC link that the drive draws from", &[
        ("v_dc", "v_dc"), ("i_dc", "i_dc"),
    ]),
    Terminal::new("voltages", "io.github.hdrm-fmu.voltages", "voltages that the controller commands", &[
        ("v_d", "v_d"), ("v_q", "v_q"),
    ]),
    Terminal::new("measurements", "io.github.hdrm-fmu.measurements", "what can be measured of the drive", &[
        ("i_d", "i_d"), ("i_q", "i_q"), ("theta_m", "theta_m"), ("w_m", "w_m"), ("F", "F"), ("x", "x_rod"), ("x_dot", "x_rod_dot"),
    ]).bus(),
])
.resources(&[
    File { path: "reference_machine.json", bytes: machine::REFERENCE_JSON.as_bytes() },
    File { path: "sized_machine.json", bytes: machine::SIZED_JSON.as_bytes() },
])
.made_resources(&[MadeFile { path: "surrogate.json", make: || Surrogate::reference().to_json().into_bytes() }])
.units(&[
    Unit::new("W.s/(rad.Wb2)").kg(-1).m(-2).s(2).A(2).rad(-1),
    Unit::new("W.s2/(rad2.Wb2)").kg(-1).m(-2).s(3).A(2).rad(-2),
    Unit::new("J/(V.A)").s(1),
])
.with_input_derivatives()
.with_output_derivatives()
.with_directional_derivatives();

type V = Variable<EmlaFmu>;

/// Rod position before anyone sets it, m: inside every stroke of the reference machine.
pub(crate) const X_START: f64 = 0.3;
/// Largest magnitude of the rod position, m.
pub(crate) const X_LARGEST: f64 = 10.0;

/// 20 °C, K.
pub(crate) const ROOM: f64 = 293.15;

/// What current and torque of the start follow from.
const START: &[&str] = &["v_dc", "enable", "x_dot", "F_hold", ALL_PARAMETERS];
/// What the power from the DC side follows from at the start.
const ELECTRICAL_START: &[&str] = &[
    "v_d",
    "v_q",
    "v_dc",
    "enable",
    "x_dot",
    "F_hold",
    ALL_PARAMETERS,
];
/// What the stored energy follows from at the start.
const STORED_START: &[&str] = &["v_dc", "enable", "x", "x_dot", "F_hold", ALL_PARAMETERS];
/// What losses follow from at the start.
const LOSS_START: &[&str] = &[
    "v_dc",
    "enable",
    "brake",
    "x",
    "x_dot",
    "F_hold",
    ALL_PARAMETERS,
];

fn read_machine(p: &mut Parameters, file: &str, resources: Option<&Path>) -> Result<(), String> {
    let machine = match Machine::preset(file) {
        Some(machine) => machine,
        None => read_placed_file(file, resources, Machine::of_file)?,
    };
    p.of_machine = EmlaFields::new(*machine.emla.in_order()[(p.axis - 1) as usize]);
    p.machine_file = file.to_owned();
    Ok(())
}

/// Paths mean the same as those of `machine_file`.
fn read_surrogate(p: &mut Parameters, file: &str, resources: Option<&Path>) -> Result<(), String> {
    p.surrogate = match file {
        "" => Surrogate::reference(),
        _ => read_parameter_file(file, resources, Surrogate::from_json)?,
    };
    p.surrogate_file = file.to_owned();
    Ok(())
}

/// A Real parameter of the machine JSON's `emla` section from its name, range, unit and description.
macro_rules! emla {
    ($field:ident, $min:literal..=$max:literal, $unit:literal, $description:literal) => {
        V::parameter(
            stringify!($field),
            $description,
            |p| &p.of_machine.emla.$field,
            |p| &mut p.of_machine.emla.$field,
        )
        .unit($unit)
        .min($min)
        .max($max)
    };
}

/// A Real parameter of one of its own sections.
macro_rules! section {
    ($section:ident.$field:ident, $min:literal..=$max:literal, $unit:literal, $description:literal) => {
        V::parameter(
            concat!(stringify!($section), ".", stringify!($field)),
            $description,
            |p| &p.of_machine.$section.$field,
            |p| &mut p.of_machine.$section.$field,
        )
        .unit($unit)
        .min($min)
        .max($max)
    };
}

#[rustfmt::skip]
pub(crate) const VARIABLES: &[V] = &[
    // Inputs
    V::input("v_d", "direct-axis voltage (peak); |(v_d, v_q)| is limited to v_max and to v_dc/sqrt(3)", |u| &u.v_d, |u| &mut u.v_d)
        .unit("V").min(-1e4).max(1e4).nominal(100.0),
    V::input("v_q", "quadrature-axis voltage (peak); |(v_d, v_q)| is limited to v_max and to v_dc/sqrt(3)", |u| &u.v_q, |u| &mut u.v_q)
        .unit("V").min(-1e4).max(1e4).nominal(100.0),
    V::input("v_dc", "voltage of the DC link, held over a step; until it is set, inverter.v_dc counts, and where that is 0 sqrt(3)*v_max", |u| &u.v_dc, |u| &mut u.v_dc)
        .unit("V").min(0.0).max(1e5).nominal(500.0).counted(|u| &mut u.v_dc_sets),
    V::boolean_input("enable", "gates of the inverter on; while they are off no current flows and the motor gives no torque; read at the start of a step", |u| &u.enable, |u| &mut u.enable),
    V::boolean_input("brake", "holding brake on the motor's shaft applied; a drive that has tripped applies it too; read at the start of a step", |u| &u.brake, |u| &mut u.brake),
    V::input("T_ambient", "temperature of the air around the actuator; read while heat is on", |u| &u.T_ambient, |u| &mut u.T_ambient)
        .unit("K").display_unit("degC").min(1.0).max(2e3).nominal(300.0),
    V::input("x", "rod position, positive when extended; with drive = force only its value at the start counts", |u| &u.x, |u| &mut u.x)
        .unit("m").display_unit("mm").min(-X_LARGEST).max(X_LARGEST).nominal(0.1).counted(|u| &mut u.x_sets),
    V::input("x_dot", "rod velocity; with drive = force only its value at the start counts", |u| &u.x_dot, |u| &mut u.x_dot)
        .unit("m/s").display_unit("mm/s").min(-100.0).max(100.0).nominal(0.05),
    V::input("F_ext", "external force on the rod against extension; with drive = force only", |u| &u.F_ext, |u| &mut u.F_ext)
        .unit("N").display_unit("kN").min(-1e7).max(1e7).nominal(1e4),
    V::input("F_hold", "force that the actuator delivers at the start; read in initialization only", |u| &u.F_hold, |u| &mut u.F_hold)
        .unit("N").display_unit("kN").min(-1e7).max(1e7).nominal(1e4),
    // Forces and motion
    V::output("F", "force on the load (drive = force: on the rod's mass), positive when pushing", |y| &y.F)
        .unit("N").display_unit("kN").nominal(1e4).depends_on(&["x", "x_dot"]).initially_depends_on(&["x", "x_dot", "F_hold", ALL_PARAMETERS]),
    V::output("F_mean", "mean of F over the last step", |y| &y.F_mean)
        .unit("N").display_unit("kN").nominal(1e4).depends_on(&[]).initially_depends_on(&["F_hold"]),
    V::output("F_phys", "quasi-static force of the physics at this torque and speed", |y| &y.F_phys)
        .unit("N").display_unit("kN").nominal(1e4).depends_on(&[]).initially_depends_on(START),
    V::output("F_hyb", "quasi-static force of the hybrid model, F_phys + alpha*(F_net - F_phys); its network part once a communication step", |y| &y.F_hyb)
        .unit("N").display_unit("kN").nominal(1e4).discrete().depends_on(&[]).initially_depends_on(START),
    V::output("F_net", "force of the surrogate network at this torque and speed, evaluated once a communication step", |y| &y.F_net)
        .unit("N").display_unit("kN").nominal(1e4).discrete().depends_on(&[]).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
    V::output("x_rod", "rod position", |y| &y.x_rod)
        .unit("m").display_unit("mm").nominal(0.1).depends_on(&["x"]).initially_depends_on(&["x"]),
    V::output("x_rod_dot", "rod velocity", |y| &y.x_rod_dot)
        .unit("m/s").display_unit("mm/s").nominal(0.05).depends_on(&["x_dot"]).initially_depends_on(&["x_dot"]),
    V::output("x_dot_net", "rod velocity of the surrogate network, evaluated once a communication step", |y| &y.x_dot_net)
        .unit("m/s").display_unit("mm/s").nominal(0.05).discrete().depends_on(&[]).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
    V::output("x_dot_hyb", "quasi-static rod velocity of the hybrid model; its network part once a communication step", |y| &y.x_dot_hyb)
        .unit("m/s").display_unit("mm/s").nominal(0.05).discrete().depends_on(&[]).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
    // Motor
    V::output("i_d", "direct-axis current (peak)", |y| &y.i_d)
        .unit("A").nominal(10.0).depends_on(&[]).initially_depends_on(&[]),
    V::output("i_q", "quadrature-axis current (peak)", |y| &y.i_q)
        .unit("A").nominal(10.0).depends_on(&[]).initially_depends_on(START),
    V::output("theta_m", "motor angle", |y| &y.theta_m)
        .unit("rad").display_unit("deg").nominal(100.0).depends_on(&[]).initially_depends_on(&["x", "x_dot", "F_hold", ALL_PARAMETERS]),
    V::output("w_m", "motor speed", |y| &y.w_m)
        .unit("rad/s").display_unit("rpm").nominal(100.0).depends_on(&[]).initially_depends_on(&["x_dot", ALL_PARAMETERS]),
    V::output("tau_e", "electromagnetic torque", |y| &y.tau_e)
        .unit("N.m").nominal(10.0).depends_on(&[]).initially_depends_on(START),
    V::boolean_output("tripped", "whether undervoltage has tripped the drive: gates off, brake applied, until enable is false with the voltage back", |y| &y.tripped)
        .depends_on(&[]).initially_depends_on(&["v_dc", "enable", ALL_PARAMETERS]),
    V::output("T_winding", "temperature of the winding", |y| &y.T_winding)
        .unit("K").display_unit("degC").nominal(300.0).discrete().depends_on(&[]).initially_depends_on(&[ALL_PARAMETERS]),
    V::output("T_housing", "temperature of the housing, which the magnets follow", |y| &y.T_housing)
        .unit("K").display_unit("degC").nominal(300.0).discrete().depends_on(&[]).initially_depends_on(&[ALL_PARAMETERS]),
    // Powers and energies
    V::output("P_in", "electrical power from the DC side, core and inverter losses included", |y| &y.P_in)
        .unit("W").display_unit("kW").nominal(1e3).depends_on(&["v_d", "v_q", "v_dc", "enable"]).initially_depends_on(ELECTRICAL_START),
    V::output("P_in_mean", "mean of P_in over the last step", |y| &y.P_in_mean)
        .unit("W").display_unit("kW").nominal(1e3).depends_on(&[]).initially_depends_on(ELECTRICAL_START),
    V::output("i_dc", "current from the DC side: v_dc*i_dc = P_in; 0 while v_dc is below 1 V", |y| &y.i_dc)
        .unit("A").nominal(10.0).depends_on(&["v_d", "v_q", "v_dc", "enable"]).initially_depends_on(ELECTRICAL_START),
    V::output("i_dc_mean", "mean of i_dc over the last step", |y| &y.i_dc_mean)
        .unit("A").nominal(10.0).depends_on(&[]).initially_depends_on(ELECTRICAL_START),
    V::output("P_out", "mechanical power to the load", |y| &y.P_out)
        .unit("W").display_unit("kW").nominal(1e3).depends_on(&["x", "x_dot", "F_ext"]).initially_depends_on(&["x", "x_dot", "F_ext", "F_hold", ALL_PARAMETERS]),
    V::output("P_loss", "all losses; P_in = P_out + P_loss + d(energy.stored)/dt; its network part once a communication step", |y| &y.P_loss)
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["v_dc", "enable", "brake", "x", "x_dot"]).initially_depends_on(LOSS_START),
    V::output("loss.copper", "copper losses", |y| &y.P_copper)
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&[]).initially_depends_on(START),
    V::output("loss.core", "iron losses", |y| &y.P_core)
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["enable"]).initially_depends_on(START),
    V::output("loss.inverter", "conduction and switching losses of the inverter", |y| &y.P_inverter)
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["v_dc"]).initially_depends_on(START),
    V::output("loss.mechanical", "friction of motor, gear, screw, nut and rod, a brake that slips, and the power of the network's residual, taken once a communication step", |y| &y.P_mech)
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["brake", "x", "x_dot"]).initially_depends_on(LOSS_START),
    V::output("energy.in", "energy taken from the DC side since the start", |y| &y.E_in)
        .unit("J").display_unit("kJ").nominal(1e3).depends_on(&[]).initially_depends_on(&[]),
    V::output("energy.out", "energy given to the load since the start", |y| &y.E_out)
        .unit("J").display_unit("kJ").nominal(1e3).depends_on(&[]).initially_depends_on(&[]),
    V::output("energy.shift", "work on the load since the start by setting x elsewhere than the velocity had taken the rod; energy.in = energy.out + energy.shift + energy.loss + change of energy.stored", |y| &y.E_shift)
        .unit("J").display_unit("kJ").nominal(1.0).depends_on(&[]).initially_depends_on(&[]),
    V::output("energy.loss", "energy lost since the start", |y| &y.E_loss)
        .unit("J").display_unit("kJ").nominal(1e3).depends_on(&[]).initially_depends_on(&[]),
    V::output("P_heat", "heat given to the air; 0 while heat is off", |y| &y.P_heat)
        .unit("W").display_unit("kW").nominal(1e2).discrete().depends_on(&["T_ambient"]).initially_depends_on(&["T_ambient", ALL_PARAMETERS]),
    V::output("energy.loss_inverter", "part of energy.loss that was lost in the inverter, whose heat does not reach the motor; counted while heat is on", |y| &y.E_inverter)
        .unit("J").display_unit("kJ").nominal(1e3).discrete().depends_on(&[]).initially_depends_on(&[]),
    V::output("energy.heat", "heat given to the air since the start", |y| &y.E_heat)
        .unit("J").display_unit("kJ").nominal(1e3).discrete().depends_on(&[]).initially_depends_on(&[]),
    V::output("energy.thermal", "heat held in winding and housing; with heat on, energy.loss - energy.loss_inverter = energy.heat + change of energy.thermal", |y| &y.E_thermal)
        .unit("J").display_unit("kJ").nominal(1e4).discrete().depends_on(&[]).initially_depends_on(&[ALL_PARAMETERS]),
    V::output("energy.stored", "energy in magnetic field, rotor and screw, spring and (drive = force) rod", |y| &y.E_stored)
        .unit("J").display_unit("kJ").nominal(10.0).depends_on(&["x"]).initially_depends_on(STORED_START),
    V::output("efficiency", "efficiency of the hybrid model on the quasi-static maps; 0 where it is not defined, its network part once a communication step", |y| &y.efficiency)
        .unit("1").display_unit("%").discrete().depends_on(&["v_dc", "enable"]).initially_depends_on(START),
    V::output("efficiency_phys", "efficiency of the physics; 0 where it is not defined", |y| &y.efficiency_phys)
        .unit("1").display_unit("%").depends_on(&["v_dc", "enable"]).initially_depends_on(START),
    V::output("efficiency_net", "efficiency of the surrogate network; 0 where it is not defined, evaluated once a communication step", |y| &y.efficiency_net)
        .unit("1").display_unit("%").discrete().depends_on(&["v_dc", "enable"]).initially_depends_on(START),
    V::boolean_output("efficiency_valid", "whether the efficiency is defined: tau_e > 0 and w_m not 0 (quadrants I and IV)", |y| &y.efficiency_valid)
        .depends_on(&[]).initially_depends_on(START),
    V::boolean_output("in_trained_range", "whether torque and speed lie where the network was trained", |y| &y.in_trained_range)
        .depends_on(&[]).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
    // Parameters
    V::integer_parameter("drive", "who moves the rod", |p| &p.drive, |p| &mut p.drive).enumeration(&DRIVE),
    V::parameter("alpha", "blending: 0 physics alone, 1 network alone; stable up to 0.9", |p| &p.alpha, |p| &mut p.alpha)
        .unit("1").tunable().min(0.0).max(1.0),
    V::integer_parameter("delay", "communication steps by which F acts later than given, which the actuator then predicts over; 1 where all outputs are read before any input is set",
        |p| &p.delay, |p| &mut p.delay).min(0.0).max(4.0),
    V::integer_parameter("axis", "which of the machine's actuators this is, where machine_file has one section emla for each", |p| &p.axis, |p| &mut p.axis)
        .enumeration(&AXIS).read_by_texts(),
    V::string_parameter("machine_file", "machine JSON, or name of a shipped machine, whose section emla replaces the reference machine's",
        |p| &p.machine_file, read_machine),
    V::string_parameter("surrogate_file", "network JSON to use instead of the embedded network",
        |p| &p.surrogate_file, read_surrogate),
    V::parameter("undervoltage", "voltage of the DC link below which an enabled drive trips; 0: never",
        |p| &p.electric.undervoltage, |p| &mut p.electric.undervoltage).unit("V").min(0.0).max(1e5),
    V::boolean_parameter("heat", "whether the losses warm winding and housing; else these stay at their start", |p| &p.electric.heat, |p| &mut p.electric.heat),
    V::boolean_parameter("temperature", "whether resistance and magnets follow their temperature", |p| &p.electric.temperature, |p| &mut p.electric.temperature),
    V::parameter("T_winding_start", "temperature of the winding at the start", |p| &p.T_start[0], |p| &mut p.T_start[0]).unit("K").display_unit("degC").min(1.0).max(2e3),
    V::parameter("T_housing_start", "temperature of the housing at the start", |p| &p.T_start[1], |p| &mut p.T_start[1]).unit("K").display_unit("degC").min(1.0).max(2e3),
    V::integer_parameter("p", "pole pairs", |p| &p.of_machine.pole_pairs, |p| &mut p.of_machine.pole_pairs).min(1.0).max(1000.0),
    emla!(R_s, 1e-6..=1e3, "Ohm", "stator resistance"),
    emla!(L_d, 1e-7..=10.0, "H", "direct-axis inductance"),
    emla!(L_q, 1e-7..=10.0, "H", "quadrature-axis inductance"),
    emla!(lambda_m, 1e-6..=100.0, "Wb", "flux linkage of the permanent magnets (peak)"),
    emla!(J_m, 1e-8..=1e3, "kg.m2", "rotor inertia"),
    emla!(C_m, 0.0..=1e3, "N.m.s/rad", "viscous friction of the motor"),
    emla!(tau_C, 0.0..=1e4, "N.m", "Coulomb friction of the motor"),
    emla!(w_C, 1e-4..=1e3, "rad/s", "speed over which the Coulomb friction changes sign"),
    emla!(N_gear, 1e-2..=1e4, "1", "gear reduction"),
    emla!(eta_gear, 1e-2..=1.0, "1", "gear efficiency"),
    emla!(w_eta, 1e-4..=1e3, "rad/s", "speed over which the gear loss changes sign"),
    emla!(rho, 1e-4..=10.0, "m", "screw lead, travel per revolution"),
    emla!(J_s, 1e-9..=1e4, "kg.m2", "screw inertia"),
    emla!(C_s, 0.0..=1e4, "N.m.s/rad", "viscous friction of the screw"),
    emla!(EA, 1e3..=1e13, "N", "axial rigidity of the screw"),
    emla!(K_br, 1e3..=1e13, "N/m", "bearing stiffness"),
    emla!(K_n, 1e3..=1e13, "N/m", "nut stiffness"),
    emla!(K_r, 1e3..=1e13, "N/m", "rod stiffness"),
    emla!(GJ, 1e-1..=1e10, "N.m2", "torsional rigidity of the screw"),
    emla!(L_s, 1e-3..=100.0, "m", "distance between the screw's bearings"),
    emla!(C_b, 0.0..=1e9, "N.s/m", "damping between nut and rod"),
    emla!(M_act, 1e-3..=1e6, "kg", "mass of the rod; counts with drive = force only"),
    emla!(C_act, 0.0..=1e9, "N.s/m", "viscous friction of the rod"),
    emla!(i_max, 1e-3..=1e6, "A", "largest phase current (peak): for the controller, the actuator does not enforce it"),
    emla!(v_max, 1e-3..=1e5, "V", "largest phase voltage (peak)"),
    section!(core.k_h, 0.0..=1e9, "W.s/(rad.Wb2)", "hysteresis coefficient of the iron losses"),
    section!(core.k_e, 0.0..=1e9, "W.s2/(rad2.Wb2)", "eddy-current coefficient of the iron losses"),
    section!(inverter.v_dc, 0.0..=1e5, "V", "DC-link voltage until the input v_dc is set"),
    section!(inverter.f_sw, 0.0..=1e7, "Hz", "switching frequency"),
    section!(inverter.k_sw, 0.0..=1.0, "J/(V.A)", "switching energy per volt and ampere, on and off together"),
    section!(inverter.v_0, 0.0..=1e3, "V", "threshold voltage of a device"),
    section!(inverter.r_0, 0.0..=1e3, "Ohm", "differential resistance of a device"),
    section!(brake.torque, 0.0..=1e6, "N.m", "torque up to which the brake holds and with which it slips, at the motor"),
    section!(heat.C_w, 1e-3..=1e9, "J/K", "heat capacity of the winding"),
    section!(heat.R_wh, 1e-6..=1e6, "K/W", "thermal resistance from winding to housing"),
    section!(heat.C_h, 1e-3..=1e9, "J/K", "heat capacity of the housing"),
    section!(heat.R_ha, 1e-6..=1e6, "K/W", "thermal resistance from housing to air"),
    section!(temperature.reference, 1.0..=2e3, "K", "temperature at which R_s and lambda_m hold"),
    section!(temperature.copper, -0.1..=0.1, "1/K", "rise of the winding's resistance"),
    section!(temperature.magnet, -0.1..=0.1, "1/K", "rise of the magnets' flux with the housing's temperature"),
];
