//! Variables of the FMU `Rig`.

use crate::{Parameters, RigFmu};
use fmu_export::{
    ALL_PARAMETERS, Enumeration, File, Info, Terminal, Unit, Variable, read_placed_file,
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
    "Rig",
    "Electromechanical linear actuator as built: saturation, temperature, ripple, a sampling inverter, stiction, backlash, compliance \
     and heat, each with a switch; takes the place of Emla by the wiring alone",
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
.units(&[
    Unit::new("W.s/(rad.Wb2)").kg(-1).m(-2).s(2).A(2).rad(-1),
    Unit::new("W.s2/(rad2.Wb2)").kg(-1).m(-2).s(3).A(2).rad(-2),
    Unit::new("J/(V.A)").s(1),
    Unit::new("N.m.s2/rad2").kg(1).m(2).rad(-2),
]);

type V = Variable<RigFmu>;

/// Rod position before anyone sets it, m: inside every stroke of the reference machine.
pub(crate) const X_START: f64 = 0.3;
/// Largest magnitude of the rod position, m.
pub(crate) const X_LARGEST: f64 = 10.0;
/// 20 °C, K.
pub(crate) const ROOM: f64 = 293.15;

/// What the start state follows from.
const START: &[&str] = &["x", "x_dot", "v_dc", "enable", "F_hold", ALL_PARAMETERS];
/// What losses follow from at the start.
const LOSS_START: &[&str] = &[
    "x",
    "x_dot",
    "v_dc",
    "enable",
    "brake",
    "F_hold",
    ALL_PARAMETERS,
];
/// What voltage and power from the DC side follow from at the start.
const ELECTRICAL_START: &[&str] = &[
    "v_d",
    "v_q",
    "v_dc",
    "enable",
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
    let fields = EmlaFields::new(*machine.emla.in_order()[(p.axis - 1) as usize]);
    p.extras = p.extras.of_machine(&fields.heat, &fields.temperature);
    p.of_machine = fields;
    p.machine_file = file.to_owned();
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

/// A Real parameter of one of its other sections.
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

/// The switch of an extra.
macro_rules! switch {
    ($group:ident, $description:literal) => {
        V::boolean_parameter(
            stringify!($group),
            $description,
            |p| &p.extras.$group.on,
            |p| &mut p.extras.$group.on,
        )
    };
}

/// A size of an extra.
macro_rules! extra {
    ($group:ident.$field:ident, $min:literal..=$max:literal, $unit:literal, $description:literal) => {
        V::parameter(
            concat!(stringify!($group), ".", stringify!($field)),
            $description,
            |p| &p.extras.$group.$field,
            |p| &mut p.extras.$group.$field,
        )
        .unit($unit)
        .min($min)
        .max($max)
    };
}

/// An output that follows the state alone.
macro_rules! state {
    ($name:literal, $field:ident, $unit:literal, $description:literal) => {
        V::output($name, $description, |y| &y.$field)
            .unit($unit)
            .depends_on(&[])
            .initially_depends_on(START)
    };
}

/// An energy since the start.
macro_rules! energy {
    ($name:literal, $field:ident, $description:literal) => {
        V::output($name, $description, |y| &y.$field)
            .unit("J")
            .display_unit("kJ")
            .nominal(1e3)
            .depends_on(&[])
            .initially_depends_on(&[])
    };
}

#[rustfmt::skip]
pub(crate) const VARIABLES: &[V] = &[
    // Inputs
    V::input("v_d", "commanded direct-axis voltage (peak)", |u| &u.u.v_d, |u| &mut u.u.v_d)
        .unit("V").min(-1e4).max(1e4).nominal(100.0),
    V::input("v_q", "commanded quadrature-axis voltage (peak); |(v_d, v_q)| is limited to v_max and v_dc/sqrt(3)", |u| &u.u.v_q, |u| &mut u.u.v_q)
        .unit("V").min(-1e4).max(1e4).nominal(100.0),
    V::input("v_dc", "voltage of the DC link, held over a step; until it is set, inverter.v_dc counts, and where that is 0 sqrt(3)*v_max", |u| &u.u.v_dc, |u| &mut u.u.v_dc)
        .unit("V").min(0.0).max(1e5).nominal(500.0).counted(|u| &mut u.v_dc_sets),
    V::boolean_input("enable", "gates of the inverter on; while they are off no current flows and the motor gives no torque; read at the start of a step", |u| &u.u.enable, |u| &mut u.u.enable),
    V::boolean_input("brake", "holding brake on the motor's shaft applied; a drive that has tripped applies it too; read at the start of a step", |u| &u.u.brake, |u| &mut u.u.brake),
    V::input("T_ambient", "temperature of the air around the actuator", |u| &u.u.T_ambient, |u| &mut u.u.T_ambient).unit("K").min(1.0).max(2e3).nominal(300.0),
    V::input("x", "rod position, positive when extended; with drive = force only its value at the start counts", |u| &u.u.x, |u| &mut u.u.x)
        .unit("m").display_unit("mm").min(-X_LARGEST).max(X_LARGEST).nominal(0.1).counted(|u| &mut u.x_sets),
    V::input("x_dot", "rod velocity; with drive = force only its value at the start counts", |u| &u.u.x_dot, |u| &mut u.u.x_dot)
        .unit("m/s").display_unit("mm/s").min(-100.0).max(100.0).nominal(0.05),
    V::input("F_ext", "external force on the rod against extension; with drive = force only", |u| &u.u.F_ext, |u| &mut u.u.F_ext)
        .unit("N").display_unit("kN").min(-1e7).max(1e7).nominal(1e4),
    V::input("F_hold", "force that the actuator delivers at the start; read in initialization only", |u| &u.u.F_hold, |u| &mut u.u.F_hold)
        .unit("N").display_unit("kN").min(-1e7).max(1e7).nominal(1e4),

    // Force and motion
    V::output("F", "force on the load (drive = force: on the rod's mass), positive when pushing", |y| &y.F)
        .unit("N").display_unit("kN").nominal(1e4).depends_on(&["x", "x_dot"]).initially_depends_on(START),
    V::output("F_mean", "mean of F over the last step", |y| &y.F_mean)
        .unit("N").display_unit("kN").nominal(1e4).depends_on(&[]).initially_depends_on(&["F_hold"]),
    V::output("x_rod", "rod position", |y| &y.x_rod)
        .unit("m").display_unit("mm").nominal(0.1).depends_on(&["x"]).initially_depends_on(&["x"]),
    V::output("x_rod_dot", "rod velocity", |y| &y.x_rod_dot)
        .unit("m/s").display_unit("mm/s").nominal(0.05).depends_on(&["x_dot"]).initially_depends_on(&["x_dot"]),
    state!("x_nut", x_nut, "m", "nut position").display_unit("mm").nominal(0.1),
    state!("presliding", presliding, "m", "deflection of the friction's bristles").display_unit("mm").nominal(1e-5),
    // Motor
    state!("i_d", i_d, "A", "direct-axis current (peak)").nominal(10.0),
    state!("i_q", i_q, "A", "quadrature-axis current (peak)").nominal(10.0),
    state!("theta_m", theta_m, "rad", "motor angle").display_unit("deg").nominal(100.0),
    state!("w_m", w_m, "rad/s", "motor speed").display_unit("rpm").nominal(100.0),
    state!("tau_e", tau_e, "N.m", "electromagnetic torque").nominal(10.0),
    V::boolean_output("tripped", "whether undervoltage has tripped the drive: gates off, brake applied, until enable is false with the voltage back", |y| &y.tripped)
        .depends_on(&[]).initially_depends_on(&["v_dc", "enable", ALL_PARAMETERS]),
    V::output("v_d_motor", "direct-axis voltage at the motor (peak)", |y| &y.v_d_motor)
        .unit("V").nominal(100.0).depends_on(&["v_d", "v_q", "v_dc", "enable"]).initially_depends_on(ELECTRICAL_START),
    V::output("v_q_motor", "quadrature-axis voltage at the motor (peak)", |y| &y.v_q_motor)
        .unit("V").nominal(100.0).depends_on(&["v_d", "v_q", "v_dc", "enable"]).initially_depends_on(ELECTRICAL_START),
    // Powers and energies
    V::output("P_in", "electrical power from the DC side, with core and inverter losses", |y| &y.P_in)
        .unit("W").display_unit("kW").nominal(1e3).depends_on(&["v_d", "v_q", "v_dc", "enable"]).initially_depends_on(ELECTRICAL_START),
    V::output("P_in_mean", "its mean over the last step", |y| &y.P_in_mean)
        .unit("W").display_unit("kW").nominal(1e3).depends_on(&[]).initially_depends_on(ELECTRICAL_START),
    V::output("i_dc", "current from the DC side: v_dc*i_dc = P_in; 0 while v_dc is below 1 V", |y| &y.i_dc)
        .unit("A").nominal(10.0).depends_on(&["v_d", "v_q", "v_dc", "enable"]).initially_depends_on(ELECTRICAL_START),
    V::output("i_dc_mean", "mean of i_dc over the last step", |y| &y.i_dc_mean)
        .unit("A").nominal(10.0).depends_on(&[]).initially_depends_on(ELECTRICAL_START),
    V::output("P_out", "mechanical power to the load", |y| &y.P_out)
        .unit("W").display_unit("kW").nominal(1e3).depends_on(&["x", "x_dot", "F_ext"]).initially_depends_on(&["x", "x_dot", "F_ext", "v_dc", "F_hold", ALL_PARAMETERS]),
    V::output("P_loss", "all losses; P_in = P_out + P_loss + d(energy.stored)/dt", |y| &y.P_loss)
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["x", "x_dot", "v_dc", "enable", "brake"]).initially_depends_on(LOSS_START),
    V::output("P_heat", "heat to the air", |y| &y.P_heat)
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["T_ambient"]).initially_depends_on(&["T_ambient", ALL_PARAMETERS]),
    state!("loss.copper", P_copper, "W", "copper losses").display_unit("kW").nominal(1e2),
    V::output("loss.core", "iron losses", |y| &y.P_core)
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["enable"]).initially_depends_on(START),
    V::output("loss.inverter", "conduction and switching losses of the inverter", |y| &y.P_inverter)
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["v_dc"]).initially_depends_on(START),
    V::output("loss.mechanical", "friction of motor, gear, screw, nut and rod", |y| &y.P_mech)
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["brake", "x", "x_dot"]).initially_depends_on(LOSS_START),
    energy!("energy.in", E_in, "energy taken from the DC side since the start"),
    energy!("energy.out", E_out, "energy given to the load since the start"),
    V::output("energy.shift", "work on the load since the start by setting x elsewhere than the velocity had taken the rod; energy.in = energy.out + energy.shift + energy.loss + change of energy.stored", |y| &y.E_shift)
        .unit("J").display_unit("kJ").nominal(1.0).depends_on(&[]).initially_depends_on(&[]),
    energy!("energy.loss", E_loss, "energy lost since the start"),
    energy!("energy.loss_inverter", E_inverter, "part of energy.loss that was lost in the inverter, whose heat does not reach the motor"),
    energy!("energy.heat", E_heat, "heat given to the air since the start"),
    V::output("energy.thermal", "heat held in winding and housing; energy.loss - energy.loss_inverter = energy.heat + change of energy.thermal", |y| &y.E_thermal)
        .unit("J").display_unit("kJ").nominal(1e4).depends_on(&[]).initially_depends_on(&[ALL_PARAMETERS]),
    V::output("energy.stored", "energy in magnetic field, rotating parts, springs, bristles and (drive = force) rod", |y| &y.E_stored)
        .unit("J").display_unit("kJ").nominal(10.0).depends_on(&["x"]).initially_depends_on(START),
    V::output("T_winding", "temperature of the winding", |y| &y.T_winding)
        .unit("K").nominal(300.0).depends_on(&[]).initially_depends_on(&[ALL_PARAMETERS]),
    V::output("T_housing", "temperature of the housing", |y| &y.T_housing)
        .unit("K").nominal(300.0).depends_on(&[]).initially_depends_on(&[ALL_PARAMETERS]),
    V::output("efficiency", "efficiency of the last step's mean powers, by losses; 0 where it is not defined", |y| &y.efficiency)
        .unit("1").display_unit("%").depends_on(&[]).initially_depends_on(&["x", "x_dot", "F_ext", "v_dc", "enable", "brake", "F_hold", ALL_PARAMETERS]),
    V::boolean_output("efficiency_valid", "whether the efficiency is defined: tau_e > 0 and w_m not 0 (quadrants I and IV)", |y| &y.efficiency_valid)
        .depends_on(&[]).initially_depends_on(START),

    // Parameters
    V::integer_parameter("drive", "who moves the rod", |p| &p.drive, |p| &mut p.drive).enumeration(&DRIVE),
    V::integer_parameter("delay", "communication steps by which F acts later than given, which the actuator then predicts over; 1 where all outputs are read before any input is set",
        |p| &p.delay, |p| &mut p.delay).min(0.0).max(4.0),
    V::parameter("undervoltage", "voltage of the DC link below which an enabled drive trips; 0: never", |p| &p.undervoltage, |p| &mut p.undervoltage)
        .unit("V").min(0.0).max(1e5),
    V::parameter("T_winding_start", "temperature of the winding at the start", |p| &p.T_start[0], |p| &mut p.T_start[0]).unit("K").min(1.0).max(2e3),
    V::parameter("T_housing_start", "temperature of the housing at the start", |p| &p.T_start[1], |p| &mut p.T_start[1]).unit("K").min(1.0).max(2e3),
    V::integer_parameter("axis", "which of the machine's actuators this is, where machine_file has one section emla for each", |p| &p.axis, |p| &mut p.axis)
        .enumeration(&AXIS).read_by_texts(),
    V::string_parameter("machine_file", "machine JSON, or name of a shipped machine, whose section emla replaces the reference machine's",
        |p| &p.machine_file, read_machine),

    switch!(saturation, "whether the quadrature axis saturates"),
    extra!(saturation.share, 0.0..=0.9, "1", "share by which lambda_q/i_q is less at i_max than at 0").display_unit("%"),
    switch!(temperature, "whether winding and magnets follow their temperature"),
    extra!(temperature.reference, 1.0..=2e3, "K", "temperature at which R_s and lambda_m hold"),
    extra!(temperature.copper, -0.1..=0.1, "1/K", "rise of the winding's resistance"),
    extra!(temperature.magnet, -0.1..=0.1, "1/K", "rise of the magnets' flux with the housing's temperature"),
    switch!(ripple, "whether the magnets' flux has harmonics over the electrical angle"),
    extra!(ripple.sixth, 0.0..=1.0, "1", "6th harmonic as a part of lambda_m").display_unit("%"),
    extra!(ripple.twelfth, 0.0..=1.0, "1", "12th harmonic as a part of lambda_m").display_unit("%"),
    switch!(cogging, "whether the motor cogs"),
    extra!(cogging.torque, 0.0..=1e4, "N.m", "amplitude of the cogging torque"),
    extra!(cogging.per_turn, 1.0..=1e4, "1", "its periods per turn of the motor"),
    switch!(switching, "whether the inverter holds voltages in stator coordinates over periods of 1/inverter.f_sw, one and a half periods late"),
    V::boolean_parameter("switching.advance", "whether it turns the voltages ahead by what the rotor turns until they act",
        |p| &p.extras.switching.advance, |p| &mut p.extras.switching.advance),
    extra!(switching.dead_time, 0.0..=1e-3, "s", "time between two devices of a leg conducting"),
    extra!(switching.i_0, 1e-3..=1e3, "A", "current over which the dead time's effect changes sign"),
    switch!(friction, "whether dry friction sticks, with presliding and load; replaces eta_gear and the smooth tau_C"),
    extra!(friction.breakaway, 1.0..=10.0, "1", "breakaway over Coulomb friction"),
    extra!(friction.v_stribeck, 1e-6..=10.0, "m/s", "Stribeck speed of the nut").display_unit("mm/s"),
    extra!(friction.stiffness, 1e3..=1e12, "N/m", "stiffness of the bristles at the nut").display_unit("kN/mm"),
    extra!(friction.damping, 0.0..=1e9, "N.s/m", "damping of the bristles at rest"),
    extra!(friction.screw_drag, 0.0..=1e4, "N.m", "Coulomb friction of the preloaded screw, at the screw"),
    extra!(friction.screw_loss, 0.0..=1.0, "1", "share of the nut's force that its rolling friction takes").display_unit("%"),
    extra!(friction.seal, 0.0..=1e6, "N", "Coulomb friction of the rod's seals, taken at the nut"),
    extra!(friction.gear_drag, 0.0..=1e4, "N.m", "Coulomb friction of the gear without load, at the motor"),
    extra!(friction.gear_viscous, 0.0..=1e3, "N.m.s/rad", "viscous drag of the gear, at the motor"),
    extra!(friction.gear_loss, 0.0..=1.0, "1", "share of the transmitted torque that the gear's mesh takes").display_unit("%"),
    extra!(friction.windage, 0.0..=1.0, "N.m.s2/rad2", "windage, at the motor"),
    extra!(friction.f_smooth, 1e-3..=1e6, "N", "force over which friction that grows with the load sets in"),
    switch!(backlash, "whether there is play between nut and rod"),
    extra!(backlash.width, 0.0..=0.1, "m", "whole width of the play").display_unit("mm"),
    extra!(backlash.contact, 1e-9..=1e-2, "m", "approach over which the contact's damping sets in").display_unit("mm"),
    switch!(compliance, "whether mounting, pins and the gear's torsion yield"),
    extra!(compliance.mount, 1e3..=1e13, "N/m", "stiffness of mounting and pins").display_unit("kN/mm"),
    extra!(compliance.torsion, 1.0..=1e10, "N.m/rad", "torsional stiffness of gear and coupling, at the screw"),
    switch!(losses, "whether core and inverter losses have the factors that follow"),
    extra!(losses.core, 0.0..=100.0, "1", "core losses over the machine's"),
    extra!(losses.inverter, 0.0..=100.0, "1", "inverter losses over the machine's"),
    switch!(heat, "whether the losses warm winding and housing; else these stay at their start"),
    extra!(heat.C_w, 1e-3..=1e9, "J/K", "heat capacity of the winding"),
    extra!(heat.R_wh, 1e-6..=1e6, "K/W", "thermal resistance from winding to housing"),
    extra!(heat.C_h, 1e-3..=1e9, "J/K", "heat capacity of the housing"),
    extra!(heat.R_ha, 1e-6..=1e6, "K/W", "thermal resistance from housing to air"),

    V::integer_parameter("p", "pole pairs", |p| &p.of_machine.pole_pairs, |p| &mut p.of_machine.pole_pairs).min(1.0).max(1000.0),
    emla!(R_s, 1e-6..=1e3, "Ohm", "stator resistance"),
    emla!(L_d, 1e-7..=10.0, "H", "direct-axis inductance"),
    emla!(L_q, 1e-7..=10.0, "H", "quadrature-axis inductance"),
    emla!(lambda_m, 1e-6..=100.0, "Wb", "flux linkage of the permanent magnets (peak)"),
    emla!(J_m, 1e-8..=1e3, "kg.m2", "rotor inertia"),
    emla!(C_m, 0.0..=1e3, "N.m.s/rad", "viscous friction of the motor"),
    emla!(tau_C, 0.0..=1e4, "N.m", "Coulomb friction of the motor"),
    emla!(w_C, 1e-4..=1e3, "rad/s", "speed over which the Coulomb friction changes sign if friction is off"),
    emla!(N_gear, 1e-2..=1e4, "1", "gear reduction"),
    emla!(eta_gear, 1e-2..=1.0, "1", "gear efficiency if friction is off"),
    emla!(w_eta, 1e-4..=1e3, "rad/s", "speed over which the gear loss changes sign if friction is off"),
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
    emla!(i_max, 1e-3..=1e6, "A", "largest phase current (peak): sizes the saturation; the actuator does not enforce it"),
    emla!(v_max, 1e-3..=1e5, "V", "largest phase voltage (peak)"),
    loss!(core.k_h, 0..=1e9, "W.s/(rad.Wb2)", "hysteresis coefficient of the iron losses"),
    loss!(core.k_e, 0..=1e9, "W.s2/(rad2.Wb2)", "eddy-current coefficient of the iron losses"),
    loss!(brake.torque, 0..=1e6, "N.m", "torque up to which the holding brake holds and with which it slips, at the motor"),
    loss!(inverter.v_dc, 0..=1e5, "V", "DC-link voltage until the input v_dc is set"),
    loss!(inverter.f_sw, 0..=1e6, "Hz", "switching frequency; at least 100 Hz while switching is on"),
    loss!(inverter.k_sw, 0..=1.0, "J/(V.A)", "switching energy per volt and ampere, on and off together"),
    loss!(inverter.v_0, 0..=1e3, "V", "threshold voltage of a device"),
    loss!(inverter.r_0, 0..=1e3, "Ohm", "differential resistance of a device"),
];
