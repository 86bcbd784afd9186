//! Variables of the FMU `Emla`.

use crate::{EmlaFmu, Parameters};
use emla::Surrogate;
use fmu_export::{
    ALL_PARAMETERS, Enumeration, File, Info, MadeFile, Unit, Variable, read_parameter_file,
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
.resources(&[File { path: "reference_machine.json", bytes: machine::REFERENCE_JSON.as_bytes() }])
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

/// What the power from the DC side follows from at the start.
const ELECTRICAL_START: &[&str] = &["v_d", "v_q", "v_dc", "x_dot", "F_hold", ALL_PARAMETERS];

fn read_machine(p: &mut Parameters, file: &str, resources: Option<&Path>) -> Result<(), String> {
    let machine = match file {
        "" => Machine::reference(),
        _ => read_parameter_file(file, resources, Machine::from_json)?,
    };
    p.of_machine = EmlaFields::new(machine.emla);
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

/// A Real parameter of one of its loss sections.
macro_rules! loss {
    ($section:ident.$field:ident, 0..=$max:literal, $unit:literal, $description:literal) => {
        V::parameter(
            concat!(stringify!($section), ".", stringify!($field)),
            $description,
            |p| &p.of_machine.$section.$field,
            |p| &mut p.of_machine.$section.$field,
        )
        .unit($unit)
        .min(0.0)
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
        .unit("N").display_unit("kN").nominal(1e4).depends_on(&[]).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
    V::output("F_hyb", "quasi-static force of the hybrid model, F_phys + alpha*(F_net - F_phys); its network part once a communication step", |y| &y.F_hyb)
        .unit("N").display_unit("kN").nominal(1e4).discrete().depends_on(&[]).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
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
        .unit("A").nominal(10.0).depends_on(&[]).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
    V::output("theta_m", "motor angle", |y| &y.theta_m)
        .unit("rad").display_unit("deg").nominal(100.0).depends_on(&[]).initially_depends_on(&["x", "x_dot", "F_hold", ALL_PARAMETERS]),
    V::output("w_m", "motor speed", |y| &y.w_m)
        .unit("rad/s").display_unit("rpm").nominal(100.0).depends_on(&[]).initially_depends_on(&["x_dot", ALL_PARAMETERS]),
    V::output("tau_e", "electromagnetic torque", |y| &y.tau_e)
        .unit("N.m").nominal(10.0).depends_on(&[]).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
    // Powers and energies
    V::output("P_in", "electrical power from the DC side, core and inverter losses included", |y| &y.P_in)
        .unit("W").display_unit("kW").nominal(1e3).depends_on(&["v_d", "v_q", "v_dc"]).initially_depends_on(ELECTRICAL_START),
    V::output("P_in_mean", "mean of P_in over the last step", |y| &y.P_in_mean)
        .unit("W").display_unit("kW").nominal(1e3).depends_on(&[]).initially_depends_on(ELECTRICAL_START),
    V::output("i_dc", "current from the DC side: v_dc*i_dc = P_in; 0 while v_dc is below 1 V", |y| &y.i_dc)
        .unit("A").nominal(10.0).depends_on(&["v_d", "v_q", "v_dc"]).initially_depends_on(ELECTRICAL_START),
    V::output("i_dc_mean", "mean of i_dc over the last step", |y| &y.i_dc_mean)
        .unit("A").nominal(10.0).depends_on(&[]).initially_depends_on(ELECTRICAL_START),
    V::output("P_out", "mechanical power to the load", |y| &y.P_out)
        .unit("W").display_unit("kW").nominal(1e3).depends_on(&["x", "x_dot", "F_ext"]).initially_depends_on(&["x", "x_dot", "F_ext", "F_hold", ALL_PARAMETERS]),
    V::output("P_loss", "all losses; P_in = P_out + P_loss + d(energy.stored)/dt; its network part once a communication step", |y| &y.P_loss)
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["v_dc", "x", "x_dot"]).initially_depends_on(&["v_dc", "x", "x_dot", "F_hold", ALL_PARAMETERS]),
    V::output("loss.copper", "copper losses", |y| &y.P_copper)
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&[]).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
    V::output("loss.core", "iron losses", |y| &y.P_core)
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&[]).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
    V::output("loss.inverter", "conduction and switching losses of the inverter", |y| &y.P_inverter)
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["v_dc"]).initially_depends_on(&["v_dc", "x_dot", "F_hold", ALL_PARAMETERS]),
    V::output("loss.mechanical", "friction of motor, gear, screw, nut and rod, and the power of the network's residual, taken once a communication step", |y| &y.P_mech)
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["x", "x_dot"]).initially_depends_on(&["x", "x_dot", "F_hold", ALL_PARAMETERS]),
    V::output("energy.in", "energy taken from the DC side since the start", |y| &y.E_in)
        .unit("J").display_unit("kJ").nominal(1e3).depends_on(&[]).initially_depends_on(&[]),
    V::output("energy.out", "energy given to the load since the start", |y| &y.E_out)
        .unit("J").display_unit("kJ").nominal(1e3).depends_on(&[]).initially_depends_on(&[]),
    V::output("energy.loss", "energy lost since the start", |y| &y.E_loss)
        .unit("J").display_unit("kJ").nominal(1e3).depends_on(&[]).initially_depends_on(&[]),
    V::output("energy.stored", "energy in magnetic field, rotor and screw, spring and (drive = force) rod", |y| &y.E_stored)
        .unit("J").display_unit("kJ").nominal(10.0).depends_on(&["x"]).initially_depends_on(&["x", "x_dot", "F_hold", ALL_PARAMETERS]),
    V::output("efficiency", "efficiency of the hybrid model on the quasi-static maps; 0 where it is not defined, its network part once a communication step", |y| &y.efficiency)
        .unit("1").display_unit("%").discrete().depends_on(&["v_dc"]).initially_depends_on(&["v_dc", "x_dot", "F_hold", ALL_PARAMETERS]),
    V::output("efficiency_phys", "efficiency of the physics; 0 where it is not defined", |y| &y.efficiency_phys)
        .unit("1").display_unit("%").depends_on(&["v_dc"]).initially_depends_on(&["v_dc", "x_dot", "F_hold", ALL_PARAMETERS]),
    V::output("efficiency_net", "efficiency of the surrogate network; 0 where it is not defined, evaluated once a communication step", |y| &y.efficiency_net)
        .unit("1").display_unit("%").discrete().depends_on(&["v_dc"]).initially_depends_on(&["v_dc", "x_dot", "F_hold", ALL_PARAMETERS]),
    V::boolean_output("efficiency_valid", "whether the efficiency is defined: tau_e > 0 and w_m not 0 (quadrants I and IV)", |y| &y.efficiency_valid)
        .depends_on(&[]).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
    V::boolean_output("in_trained_range", "whether torque and speed lie where the network was trained", |y| &y.in_trained_range)
        .depends_on(&[]).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
    // Parameters
    V::integer_parameter("drive", "who moves the rod", |p| &p.drive, |p| &mut p.drive).enumeration(&DRIVE),
    V::parameter("alpha", "blending: 0 physics alone, 1 network alone; stable up to 0.9", |p| &p.alpha, |p| &mut p.alpha)
        .unit("1").tunable().min(0.0).max(1.0),
    V::integer_parameter("delay", "communication steps by which F acts later than given, which the actuator then predicts over; 1 where all outputs are read before any input is set",
        |p| &p.delay, |p| &mut p.delay).min(0.0).max(4.0),
    V::string_parameter("machine_file", "machine JSON whose section emla replaces the embedded reference machine's",
        |p| &p.machine_file, read_machine),
    V::string_parameter("surrogate_file", "network JSON to use instead of the embedded network",
        |p| &p.surrogate_file, read_surrogate),
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
    loss!(core.k_h, 0..=1e9, "W.s/(rad.Wb2)", "hysteresis coefficient of the iron losses"),
    loss!(core.k_e, 0..=1e9, "W.s2/(rad2.Wb2)", "eddy-current coefficient of the iron losses"),
    loss!(inverter.v_dc, 0..=1e5, "V", "DC-link voltage until the input v_dc is set"),
    loss!(inverter.f_sw, 0..=1e7, "Hz", "switching frequency"),
    loss!(inverter.k_sw, 0..=1.0, "J/(V.A)", "switching energy per volt and ampere, on and off together"),
    loss!(inverter.v_0, 0..=1e3, "V", "threshold voltage of a device"),
    loss!(inverter.r_0, 0..=1e3, "Ohm", "differential resistance of a device"),
];
