//! Variables of the FMU `Rig` for its description and calls: names, units, bounds, dependencies.

use super::model::{Parameters, RigFmu};
use actuator_table::{
    AXIS, DRIVE, RESOURCES, TERMINALS, UNITS, actuator_inputs, actuator_parameters, energy,
    inverter_parameters,
};
use fmu_export::{ALL_PARAMETERS, File, Info, Unit, Variable, joined, row};
use std::path::Path;

pub(crate) const INFO: Info = Info::new(
    "Rig",
    "Electromechanical linear actuator as built: saturation, temperature, ripple, a sampling inverter, stiction, backlash, compliance \
     and heat, each with a switch; takes the place of Emla by the wiring alone",
)
.named_after(actuator_table::own_name)
.version(env!("CARGO_PKG_VERSION"))
.license("MIT OR Apache-2.0")
.experiment(0.0, 1.0, 1e-3)
.documentation(&[File { path: "index.html", bytes: include_bytes!("../documentation/index.html") }])
.icon(include_bytes!("../model.png"))
.terminals(TERMINALS)
.resources(RESOURCES)
.units(joined!(UNITS, &[Unit::new("N.m.s2/rad2").kg(1).m(2).rad(-2)]));

type V = Variable<RigFmu>;

/// Dependencies: the rod's motion, whether currents flow, and the load at the start.
const ROD: &[&str] = &["x", "x_dot"];
const DRIVE_ON: &[&str] = &["v_dc", "enable"];
const HELD: &[&str] = &["F_hold", ALL_PARAMETERS];
/// Dependencies of the start state.
const START: &[&str] = joined!(ROD, DRIVE_ON, HELD);
/// Dependencies of the losses at the start.
const LOSS_START: &[&str] = joined!(ROD, DRIVE_ON, &["brake"], HELD);
/// Dependencies of voltage and power from the DC side at the start.
const ELECTRICAL_START: &[&str] = joined!(&["v_d", "v_q"], DRIVE_ON, ROD, HELD);

fn read_machine(p: &mut Parameters, file: &str, resources: Option<&Path>) -> Result<(), String> {
    let fields = actuator_table::read_machine(file, p.axis, resources)?;
    p.extras = p.extras.with_machine(&fields.heat, &fields.temperature);
    p.of_machine = fields;
    p.machine_file = file.to_owned();
    Ok(())
}

/// An output that depends on the state alone.
const fn state(row: V) -> V {
    row.depends_on(&[]).initially_depends_on(START)
}

pub(crate) const VARIABLES: &[V] = joined!(
    INPUTS,
    OUTPUTS,
    PARAMETERS,
    EXTRAS,
    OF_MACHINE,
    BRAKE,
    INVERTER,
    OF_PARTS,
    CURRENT_LOOP
);

const INPUTS: &[V] = actuator_inputs!(
    V,
    v_d: "commanded direct-axis voltage (peak)",
    v_q: "commanded quadrature-axis voltage (peak); |(v_d, v_q)| is limited to v_max and v_dc/sqrt(3)",
    T_ambient: "temperature of the air around the actuator"
);

#[rustfmt::skip]
const OUTPUTS: &[V] = &[
    // Force and motion
    row!(V, output F, "force on the load (drive = force: on the rod's mass), positive when pushing")
        .unit("N").display_unit("kN").nominal(1e4).depends_on(&["x", "x_dot"]).initially_depends_on(START),
    row!(V, output F_mean, "mean of F over the last step")
        .unit("N").display_unit("kN").nominal(1e4).depends_on(&[]).initially_depends_on(&["F_hold"]),
    row!(V, output x_rod, "rod position")
        .unit("m").display_unit("mm").nominal(0.1).depends_on(&["x"]).initially_depends_on(&["x"]),
    row!(V, output x_rod_dot, "rod velocity")
        .unit("m/s").display_unit("mm/s").nominal(0.05).depends_on(&["x_dot"]).initially_depends_on(&["x_dot"]),
    state(row!(V, output x_nut, "nut position")).unit("m").display_unit("mm").nominal(0.1),
    state(row!(V, output presliding, "deflection of the friction's bristles")).unit("m").display_unit("mm").nominal(1e-5),
    // Motor
    state(row!(V, output i_d, "direct-axis current (peak)")).unit("A").nominal(10.0),
    state(row!(V, output i_q, "quadrature-axis current (peak)")).unit("A").nominal(10.0),
    state(row!(V, output theta_m, "motor angle")).unit("rad").display_unit("deg").nominal(100.0),
    state(row!(V, output w_m, "motor speed")).unit("rad/s").display_unit("rpm").nominal(100.0),
    state(row!(V, output tau_e, "electromagnetic torque")).unit("N.m").nominal(10.0),
    row!(V, boolean_output tripped, "whether undervoltage has tripped the drive: gates off, brake applied, until enable is false with the voltage back")
        .depends_on(&[]).initially_depends_on(&["v_dc", "enable", ALL_PARAMETERS]),
    row!(V, output v_d_motor, "direct-axis voltage at the motor (peak)")
        .unit("V").nominal(100.0).depends_on(&["v_d", "v_q", "v_dc", "enable"]).initially_depends_on(ELECTRICAL_START),
    row!(V, output v_q_motor, "quadrature-axis voltage at the motor (peak)")
        .unit("V").nominal(100.0).depends_on(&["v_d", "v_q", "v_dc", "enable"]).initially_depends_on(ELECTRICAL_START),
    // Powers and energies
    row!(V, output P_in, "electrical power from the DC side, with core and inverter losses")
        .unit("W").display_unit("kW").nominal(1e3).depends_on(&["v_d", "v_q", "v_dc", "enable"]).initially_depends_on(ELECTRICAL_START),
    row!(V, output P_in_mean, "its mean over the last step")
        .unit("W").display_unit("kW").nominal(1e3).depends_on(&[]).initially_depends_on(ELECTRICAL_START),
    row!(V, output i_dc, "current from the DC side: v_dc*i_dc = P_in; 0 while v_dc is below 1 V")
        .unit("A").nominal(10.0).depends_on(&["v_d", "v_q", "v_dc", "enable"]).initially_depends_on(ELECTRICAL_START),
    row!(V, output i_dc_mean, "mean of i_dc over the last step")
        .unit("A").nominal(10.0).depends_on(&[]).initially_depends_on(ELECTRICAL_START),
    row!(V, output P_out, "mechanical power to the load")
        .unit("W").display_unit("kW").nominal(1e3).depends_on(&["x", "x_dot", "F_ext"]).initially_depends_on(&["x", "x_dot", "F_ext", "v_dc", "F_hold", ALL_PARAMETERS]),
    row!(V, output P_loss, "all losses; P_in = P_out + P_loss + d(energy.stored)/dt")
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["x", "x_dot", "v_dc", "enable", "brake"]).initially_depends_on(LOSS_START),
    row!(V, output P_heat, "heat to the air")
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["T_ambient"]).initially_depends_on(&["T_ambient", ALL_PARAMETERS]),
    state(row!(V, output loss.copper = P_copper, "copper losses")).unit("W").display_unit("kW").nominal(1e2),
    row!(V, output loss.core = P_core, "iron losses")
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["enable"]).initially_depends_on(START),
    row!(V, output loss.inverter = P_inverter, "conduction and switching losses of the inverter")
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["v_dc"]).initially_depends_on(START),
    row!(V, output loss.mechanical = P_mech, "friction of motor, gear, screw, nut and rod")
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["brake", "x", "x_dot"]).initially_depends_on(LOSS_START),
    energy(row!(V, output energy.in = E_in, "energy taken from the DC side since the start")),
    energy(row!(V, output energy.out = E_out, "energy given to the load since the start")),
    row!(V, output energy.shift = E_shift, "work on the load since the start by setting x elsewhere than the velocity had taken the rod; energy.in = energy.out + energy.shift + energy.loss + change of energy.stored")
        .unit("J").display_unit("kJ").nominal(1.0).depends_on(&[]).initially_depends_on(&[]),
    energy(row!(V, output energy.loss = E_loss, "energy lost since the start")),
    energy(row!(V, output energy.loss_inverter = E_inverter, "part of energy.loss that was lost in the inverter, whose heat does not reach the motor")),
    energy(row!(V, output energy.heat = E_heat, "heat given to the air since the start")),
    row!(V, output energy.thermal = E_thermal, "heat held in winding and housing; energy.loss - energy.loss_inverter = energy.heat + change of energy.thermal")
        .unit("J").display_unit("kJ").nominal(1e4).depends_on(&[]).initially_depends_on(&[ALL_PARAMETERS]),
    row!(V, output energy.stored = E_stored, "energy in magnetic field, rotating parts, springs, bristles and (drive = force) rod")
        .unit("J").display_unit("kJ").nominal(10.0).depends_on(&["x"]).initially_depends_on(START),
    row!(V, output T_winding, "temperature of the winding")
        .unit("K").nominal(300.0).depends_on(&[]).initially_depends_on(&[ALL_PARAMETERS]),
    row!(V, output T_housing, "temperature of the housing")
        .unit("K").nominal(300.0).depends_on(&[]).initially_depends_on(&[ALL_PARAMETERS]),
    row!(V, output efficiency, "efficiency of the last step's mean powers, by losses; 0 where it is not defined")
        .unit("1").display_unit("%").depends_on(&[]).initially_depends_on(&["x", "x_dot", "F_ext", "v_dc", "enable", "brake", "F_hold", ALL_PARAMETERS]),
    row!(V, boolean_output efficiency_valid, "whether the efficiency is defined: tau_e > 0 and w_m not 0 (quadrants I and IV)")
        .depends_on(&[]).initially_depends_on(START),
];

#[rustfmt::skip]
const PARAMETERS: &[V] = &[
    row!(V, integer_parameter drive, "who moves the rod").items(&DRIVE),
    row!(V, integer_parameter delay, "communication steps by which F acts later than given, which the actuator then predicts over; 1 where all outputs are read before any input is set").range(0.0..=4.0),
    row!(V, parameter undervoltage, "voltage of the DC link below which an enabled drive trips; 0: never")
        .unit("V").range(0.0..=1e5),
    row!(V, parameter T_winding_start = T_start[0], "temperature of the winding at the start").unit("K").range(1.0..=2e3),
    row!(V, parameter T_housing_start = T_start[1], "temperature of the housing at the start").unit("K").range(1.0..=2e3),
    row!(V, integer_parameter axis, "which of the machine's actuators this is, where machine_file has one section emla for each")
        .items(&AXIS).read_by_string_setters(),
    V::string_parameter("machine_file", "machine JSON, or name of a shipped machine, whose section emla replaces the reference machine's",
        |p| &p.machine_file, read_machine)
        .packed_file(actuator_table::REFERENCE),
];

/// Effects beyond the idealised actuator: each group with its switch.
#[rustfmt::skip]
const EXTRAS: &[V] = &[
    row!(V, boolean_parameter saturation = extras.saturation.on, "whether the quadrature axis saturates"),
    row!(V, parameter saturation.share in extras, "share by which lambda_q/i_q is less at i_max than at 0").unit("1").range(0.0..=0.9).display_unit("%"),
    row!(V, boolean_parameter temperature = extras.temperature.on, "whether winding and magnets follow their temperature"),
    row!(V, parameter temperature.reference in extras, "temperature at which R_s and lambda_m hold").unit("K").range(1.0..=2e3),
    row!(V, parameter temperature.copper in extras, "rise of the winding's resistance").unit("1/K").range(-0.1..=0.1),
    row!(V, parameter temperature.magnet in extras, "rise of the magnets' flux with the housing's temperature").unit("1/K").range(-0.1..=0.1),
    row!(V, boolean_parameter ripple = extras.ripple.on, "whether the magnets' flux has harmonics over the electrical angle"),
    row!(V, parameter ripple.sixth in extras, "6th harmonic as a part of lambda_m").unit("1").range(0.0..=1.0).display_unit("%"),
    row!(V, parameter ripple.twelfth in extras, "12th harmonic as a part of lambda_m").unit("1").range(0.0..=1.0).display_unit("%"),
    row!(V, boolean_parameter cogging = extras.cogging.on, "whether the motor cogs"),
    row!(V, parameter cogging.torque in extras, "amplitude of the cogging torque").unit("N.m").range(0.0..=1e4),
    row!(V, parameter cogging.per_turn in extras, "its periods per turn of the motor").unit("1").range(1.0..=1e4),
    row!(V, boolean_parameter switching = extras.switching.on, "whether the inverter holds voltages in stator coordinates over periods of 1/inverter.f_sw, one and a half periods late"),
    row!(V, boolean_parameter switching.advance in extras, "whether it turns the voltages ahead by what the rotor turns until they act"),
    row!(V, parameter switching.dead_time in extras, "time between two devices of a leg conducting").unit("s").range(0.0..=1e-3),
    row!(V, parameter switching.i_0 in extras, "current over which the dead time's effect changes sign").unit("A").range(1e-3..=1e3),
    row!(V, boolean_parameter friction = extras.friction.on, "whether dry friction sticks, with presliding and load; replaces eta_gear and the smooth tau_C"),
    row!(V, parameter friction.breakaway in extras, "breakaway over Coulomb friction").unit("1").range(1.0..=10.0),
    row!(V, parameter friction.v_stribeck in extras, "Stribeck speed of the nut").unit("m/s").range(1e-6..=10.0).display_unit("mm/s"),
    row!(V, parameter friction.stiffness in extras, "stiffness of the bristles at the nut").unit("N/m").range(1e3..=1e12).display_unit("kN/mm"),
    row!(V, parameter friction.damping in extras, "damping of the bristles at rest").unit("N.s/m").range(0.0..=1e9),
    row!(V, parameter friction.screw_drag in extras, "Coulomb friction of the preloaded screw, at the screw").unit("N.m").range(0.0..=1e4),
    row!(V, parameter friction.screw_loss in extras, "share of the nut's force that its rolling friction takes").unit("1").range(0.0..=1.0).display_unit("%"),
    row!(V, parameter friction.seal in extras, "Coulomb friction of the rod's seals, taken at the nut").unit("N").range(0.0..=1e6),
    row!(V, parameter friction.gear_drag in extras, "Coulomb friction of the gear without load, at the motor").unit("N.m").range(0.0..=1e4),
    row!(V, parameter friction.gear_viscous in extras, "viscous drag of the gear, at the motor").unit("N.m.s/rad").range(0.0..=1e3),
    row!(V, parameter friction.gear_loss in extras, "share of the transmitted torque that the gear's mesh takes").unit("1").range(0.0..=1.0).display_unit("%"),
    row!(V, parameter friction.windage in extras, "windage, at the motor").unit("N.m.s2/rad2").range(0.0..=1.0),
    row!(V, parameter friction.f_smooth in extras, "force over which friction that grows with the load sets in").unit("N").range(1e-3..=1e6),
    row!(V, boolean_parameter backlash = extras.backlash.on, "whether there is play between nut and rod"),
    row!(V, parameter backlash.width in extras, "whole width of the play").unit("m").range(0.0..=0.1).display_unit("mm"),
    row!(V, parameter backlash.contact in extras, "approach over which the contact's damping sets in").unit("m").range(1e-9..=1e-2).display_unit("mm"),
    row!(V, boolean_parameter compliance = extras.compliance.on, "whether mounting, pins and the gear's torsion yield"),
    row!(V, parameter compliance.mount in extras, "stiffness of mounting and pins").unit("N/m").range(1e3..=1e13).display_unit("kN/mm"),
    row!(V, parameter compliance.torsion in extras, "torsional stiffness of gear and coupling, at the screw").unit("N.m/rad").range(1.0..=1e10),
    row!(V, boolean_parameter losses = extras.losses.on, "whether core and inverter losses have the factors that follow"),
    row!(V, parameter losses.core in extras, "core losses over the machine's").unit("1").range(0.0..=100.0),
    row!(V, parameter losses.inverter in extras, "inverter losses over the machine's").unit("1").range(0.0..=100.0),
    row!(V, boolean_parameter heat = extras.heat.on, "whether the losses warm winding and housing; else these stay at their start"),
    row!(V, parameter heat.C_w in extras, "heat capacity of the winding").unit("J/K").range(1e-3..=1e9),
    row!(V, parameter heat.R_wh in extras, "thermal resistance from winding to housing").unit("K/W").range(1e-6..=1e6),
    row!(V, parameter heat.C_h in extras, "heat capacity of the housing").unit("J/K").range(1e-3..=1e9),
    row!(V, parameter heat.R_ha in extras, "thermal resistance from housing to air").unit("K/W").range(1e-6..=1e6),
];

const OF_MACHINE: &[V] = actuator_parameters!(
    V,
    w_C: "speed over which the Coulomb friction changes sign if friction is off",
    eta_gear: "gear efficiency if friction is off",
    w_eta: "speed over which the gear loss changes sign if friction is off",
    i_max: "largest phase current (peak): sizes the saturation; the actuator does not enforce it"
);

#[rustfmt::skip]
const BRAKE: &[V] = &[
    row!(V, parameter brake.torque in of_machine, "torque up to which the holding brake holds and with which it slips, at the motor")
        .unit("N.m").range(0.0..=1e6),
];

#[rustfmt::skip]
const OF_PARTS: &[V] = &[
    row!(V, boolean_parameter damping = extras.damping.on, "whether C_b spans screw, nut and bearings alone, and mounting and pins have a damper of their own; else C_b spans all together"),
    row!(V, parameter damping.mount in extras, "damping of mounting and pins").unit("N.s/m").range(0.0..=1e9),
    row!(V, parameter switching.offset in extras, "error of the rotor's electrical angle in the drive: turns commanded voltages ahead and told currents back").unit("rad").display_unit("deg").range(-1.5..=1.5),
];

const INVERTER: &[V] = inverter_parameters!(
    V,
    f_sw: "switching frequency; at least 100 Hz while switching is on" up to 1e6
);

/// Appended, so that earlier value references are unchanged.
#[rustfmt::skip]
const CURRENT_LOOP: &[V] = &[
    row!(V, input i_q_required in u, "required quadrature-axis current (peak), read instead of the voltages while current_loop is on; held to i_max")
        .unit("A").range(-1e5..=1e5).nominal(10.0),
    row!(V, boolean_parameter current_loop, "whether the drive regulates its currents itself, at the switching frequency: i_d to 0, i_q to i_q_required"),
    row!(V, parameter current_loop.K_p = regulator.K_p, "proportional gain of its current loop").unit("V/A").range(0.0..=1e6),
    row!(V, parameter current_loop.K_i = regulator.K_i, "integral gain of its current loop").unit("V/(A.s)").range(0.0..=1e9),
    row!(V, parameter brake.closing_time in of_machine, "time from the brake's command until its torque acts; it opens at once").unit("s").range(0.0..=10.0).display_unit("ms"),
    row!(V, parameter friction.asymmetry in extras, "share by which dry friction is larger on the way out, and smaller on the way in").unit("1").range(-0.99..=0.99),
];
