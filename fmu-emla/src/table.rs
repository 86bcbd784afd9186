//! Variables of the FMU `Emla` for its description and calls: names, units, bounds, dependencies.

use super::model::{EmlaFmu, Parameters};
use actuator_table::{
    AXIS, DRIVE, RESOURCES, TERMINALS, UNITS, actuator_inputs, actuator_parameters, energy,
    inverter_parameters,
};
use emla::Surrogate;
use fmu_export::{
    ALL_PARAMETERS, File, Info, MadeFile, NO_STATES, PackedFile, Unit, Variable, joined,
    read_parameter_file, row,
};
use std::path::Path;

/// The network that is compiled in.
const NETWORK: MadeFile = MadeFile {
    path: "surrogate.json",
    make: || Surrogate::reference().to_json().into_bytes(),
};
/// The digest of [`NETWORK`], which a test compares.
const NETWORK_DIGEST: u64 = 0xCE78_03AE_A976_E0C9;

pub(crate) const INFO: Info = Info::new(
    "Emla",
    "Electromechanical linear actuator: permanent-magnet synchronous motor, gear, ball screw and rod, with losses and a \
     surrogate network blended in",
)
.named_after(actuator_table::own_name)
.version(env!("CARGO_PKG_VERSION"))
.license("MIT OR Apache-2.0")
.experiment(0.0, 1.0, 1e-3)
.documentation(&[File { path: "index.html", bytes: include_bytes!("../documentation/index.html") }])
.icon(include_bytes!("../model.png"))
.terminals(TERMINALS)
.resources(RESOURCES)
.made_resources(&[NETWORK])
.units(UNITS)
.with_input_derivatives()
.with_output_derivatives()
.with_directional_derivatives();

type V = Variable<EmlaFmu>;

/// Dependencies of the start: whether currents flow, and the load in steady motion.
const DRIVE_ON: &[&str] = &["v_dc", "enable"];
const HELD: &[&str] = &["x_dot", "F_hold", ALL_PARAMETERS];
/// Dependencies of current and torque at the start.
const START: &[&str] = joined!(DRIVE_ON, HELD);
/// Dependencies of the power from the DC side at the start.
const ELECTRICAL_START: &[&str] = joined!(&["v_d", "v_q"], START);
/// Dependencies of the stored energy at the start.
const STORED_START: &[&str] = joined!(DRIVE_ON, &["x"], HELD);
/// No dependency on states: held, or changed at events and completed steps only.
const HELD_YET: &[&str] = &[NO_STATES];
/// Torque and speed, by the flux with its temperature.
const TORQUE: &[&str] = &["i_d", "i_q", "w_m", "T_housing"];
/// Position and velocity of nut and rod.
const FORCE: &[&str] = &["x", "x_dot", "theta_m", "w_m", "x_free", "x_free_dot"];
const VOLTAGE: &[&str] = &["v_d", "v_q", "v_dc", "enable"];
const POWER: &[&str] = joined!(VOLTAGE, TORQUE);
const EFFICIENCY: &[&str] = joined!(DRIVE_ON, TORQUE, &["T_winding"]);
const STORED: &[&str] = &["x", "i_d", "i_q", "theta_m", "w_m", "x_free", "x_free_dot"];
const MECHANICAL: &[&str] = joined!(&["brake", "i_d", "i_q", "T_housing"], FORCE);
const LOSSES: &[&str] = joined!(DRIVE_ON, MECHANICAL, &["T_winding"]);
/// Dependencies of the losses at the start.
const LOSS_START: &[&str] = joined!(DRIVE_ON, &["brake", "x"], HELD);

fn read_machine(p: &mut Parameters, file: &str, resources: Option<&Path>) -> Result<(), String> {
    p.of_machine = actuator_table::read_machine(file, p.axis, resources)?;
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

pub(crate) const VARIABLES: &[V] = joined!(
    INPUTS,
    OUTPUTS,
    PARAMETERS,
    OF_MACHINE,
    INVERTER,
    BRAKE_AND_HEAT,
    INTERVAL,
    FREE_ROD,
    CLOSING
);

const INPUTS: &[V] = actuator_inputs!(
    V,
    v_d: "direct-axis voltage (peak); |(v_d, v_q)| is limited to v_max and to v_dc/sqrt(3)",
    v_q: "quadrature-axis voltage (peak); |(v_d, v_q)| is limited to v_max and to v_dc/sqrt(3)",
    T_ambient: "temperature of the air around the actuator; read while heat is on" in "degC"
);

#[rustfmt::skip]
const OUTPUTS: &[V] = &[
    // Forces and motion
    row!(V, output F, "force on the load (drive = force: on the rod's mass), positive when pushing")
        .unit("N").display_unit("kN").nominal(1e4).depends_on(FORCE).initially_depends_on(&["x", "x_dot", "F_hold", ALL_PARAMETERS]),
    row!(V, output F_mean, "mean of F over the last step")
        .unit("N").display_unit("kN").nominal(1e4).depends_on(HELD_YET).initially_depends_on(&["F_hold"]),
    row!(V, output F_phys, "quasi-static force of the physics at this torque and speed")
        .unit("N").display_unit("kN").nominal(1e4).depends_on(TORQUE).initially_depends_on(START),
    row!(V, output F_hyb, "quasi-static force of the hybrid model, F_phys + alpha*(F_net - F_phys); its network part once a communication step")
        .unit("N").display_unit("kN").nominal(1e4).discrete().depends_on(TORQUE).initially_depends_on(START),
    row!(V, output F_net, "force of the surrogate network at this torque and speed, evaluated once a communication step")
        .unit("N").display_unit("kN").nominal(1e4).discrete().depends_on(HELD_YET).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
    row!(V, output x_rod, "rod position")
        .unit("m").display_unit("mm").nominal(0.1).depends_on(&["x", "x_free"]).initially_depends_on(&["x"]),
    row!(V, output x_rod_dot, "rod velocity")
        .unit("m/s").display_unit("mm/s").nominal(0.05).depends_on(&["x_dot", "x_free_dot"]).initially_depends_on(&["x_dot"]),
    row!(V, output x_dot_net, "rod velocity of the surrogate network, evaluated once a communication step")
        .unit("m/s").display_unit("mm/s").nominal(0.05).discrete().depends_on(HELD_YET).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
    row!(V, output x_dot_hyb, "quasi-static rod velocity of the hybrid model; its network part once a communication step")
        .unit("m/s").display_unit("mm/s").nominal(0.05).discrete().depends_on(&["w_m"]).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
    // Motor
    row!(V, output i_d, "direct-axis current (peak)")
        .unit("A").nominal(10.0).depends_on(&[]).initially_depends_on(&[]),
    row!(V, output i_q, "quadrature-axis current (peak)")
        .unit("A").nominal(10.0).depends_on(&[]).initially_depends_on(START),
    row!(V, output theta_m, "motor angle")
        .unit("rad").display_unit("deg").nominal(100.0).depends_on(&[]).initially_depends_on(&["x", "x_dot", "F_hold", ALL_PARAMETERS]),
    row!(V, output w_m, "motor speed")
        .unit("rad/s").display_unit("rpm").nominal(100.0).depends_on(&[]).initially_depends_on(&["x_dot", ALL_PARAMETERS]),
    row!(V, output tau_e, "electromagnetic torque")
        .unit("N.m").nominal(10.0).depends_on(&["i_d", "i_q", "T_housing"]).initially_depends_on(START),
    row!(V, boolean_output tripped, "whether undervoltage has tripped the drive: gates off, brake applied, until enable is false with the voltage back")
        .depends_on(HELD_YET).initially_depends_on(&["v_dc", "enable", ALL_PARAMETERS]),
    row!(V, output T_winding, "temperature of the winding")
        .unit("K").display_unit("degC").nominal(300.0).depends_on(&[]).initially_depends_on(&[ALL_PARAMETERS]),
    row!(V, output T_housing, "temperature of the housing, which the magnets follow")
        .unit("K").display_unit("degC").nominal(300.0).depends_on(&[]).initially_depends_on(&[ALL_PARAMETERS]),
    // Powers and energies
    row!(V, output P_in, "electrical power from the DC side, core and inverter losses included")
        .unit("W").display_unit("kW").nominal(1e3).depends_on(POWER).initially_depends_on(ELECTRICAL_START),
    row!(V, output P_in_mean, "mean of P_in over the last step")
        .unit("W").display_unit("kW").nominal(1e3).depends_on(HELD_YET).initially_depends_on(ELECTRICAL_START),
    row!(V, output i_dc, "current from the DC side: v_dc*i_dc = P_in; 0 while v_dc is below 1 V")
        .unit("A").nominal(10.0).depends_on(POWER).initially_depends_on(ELECTRICAL_START),
    row!(V, output i_dc_mean, "mean of i_dc over the last step")
        .unit("A").nominal(10.0).depends_on(HELD_YET).initially_depends_on(ELECTRICAL_START),
    row!(V, output P_out, "mechanical power to the load")
        .unit("W").display_unit("kW").nominal(1e3).depends_on(joined!(FORCE, &["F_ext"])).initially_depends_on(&["x", "x_dot", "F_ext", "F_hold", ALL_PARAMETERS]),
    row!(V, output P_loss, "all losses; P_in = P_out + P_loss + d(energy.stored)/dt; its network part once a communication step")
        .unit("W").display_unit("kW").nominal(1e2).depends_on(LOSSES).initially_depends_on(LOSS_START),
    row!(V, output loss.copper = P_copper, "copper losses")
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["i_d", "i_q", "T_winding"]).initially_depends_on(START),
    row!(V, output loss.core = P_core, "iron losses")
        .unit("W").display_unit("kW").nominal(1e2).depends_on(joined!(&["enable"], TORQUE)).initially_depends_on(START),
    row!(V, output loss.inverter = P_inverter, "conduction and switching losses of the inverter")
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["v_dc", "i_d", "i_q"]).initially_depends_on(START),
    row!(V, output loss.mechanical = P_mech, "friction of motor, gear, screw, nut and rod, a brake that slips, and the power of the network's residual, taken once a communication step")
        .unit("W").display_unit("kW").nominal(1e2).depends_on(MECHANICAL).initially_depends_on(LOSS_START),
    energy(row!(V, output energy.in = E_in, "energy taken from the DC side since the start")),
    energy(row!(V, output energy.out = E_out, "energy given to the load since the start")),
    row!(V, output energy.shift = E_shift, "work on the load since the start by setting x elsewhere than the velocity had taken the rod; energy.in = energy.out + energy.shift + energy.loss + change of energy.stored")
        .unit("J").display_unit("kJ").nominal(1.0).depends_on(HELD_YET).initially_depends_on(&[]),
    energy(row!(V, output energy.loss = E_loss, "energy lost since the start")),
    row!(V, output P_heat, "heat given to the air; 0 while heat is off")
        .unit("W").display_unit("kW").nominal(1e2).depends_on(&["T_ambient", "T_housing"]).initially_depends_on(&["T_ambient", ALL_PARAMETERS]),
    row!(V, output energy.loss_inverter = E_inverter, "part of energy.loss that was lost in the inverter, whose heat does not reach the motor; counted while heat is on")
        .unit("J").display_unit("kJ").nominal(1e3).depends_on(&[]).initially_depends_on(&[]),
    row!(V, output energy.heat = E_heat, "heat given to the air since the start")
        .unit("J").display_unit("kJ").nominal(1e3).depends_on(&[]).initially_depends_on(&[]),
    row!(V, output energy.thermal = E_thermal, "heat held in winding and housing; with heat on, energy.loss - energy.loss_inverter = energy.heat + change of energy.thermal")
        .unit("J").display_unit("kJ").nominal(1e4).depends_on(&["T_winding", "T_housing"]).initially_depends_on(&[ALL_PARAMETERS]),
    row!(V, output energy.stored = E_stored, "energy in magnetic field, rotor and screw, spring and (drive = force) rod")
        .unit("J").display_unit("kJ").nominal(10.0).depends_on(STORED).initially_depends_on(STORED_START),
    row!(V, output efficiency, "efficiency of the hybrid model on the quasi-static maps; 0 where it is not defined, its network part once a communication step")
        .unit("1").display_unit("%").discrete().depends_on(EFFICIENCY).initially_depends_on(START),
    row!(V, output efficiency_phys, "efficiency of the physics; 0 where it is not defined")
        .unit("1").display_unit("%").depends_on(EFFICIENCY).initially_depends_on(START),
    row!(V, output efficiency_net, "efficiency of the surrogate network; 0 where it is not defined, evaluated once a communication step")
        .unit("1").display_unit("%").discrete().depends_on(EFFICIENCY).initially_depends_on(START),
    row!(V, boolean_output efficiency_valid, "whether the efficiency is defined: tau_e > 0 and w_m not 0 (quadrants I and IV)")
        .depends_on(TORQUE).initially_depends_on(START),
    row!(V, boolean_output in_trained_range, "whether torque and speed lie where the network was trained")
        .depends_on(HELD_YET).initially_depends_on(&["x_dot", "F_hold", ALL_PARAMETERS]),
];

#[rustfmt::skip]
const PARAMETERS: &[V] = &[
    row!(V, integer_parameter drive, "who moves the rod").items(&DRIVE),
    row!(V, parameter alpha, "blending: 0 physics alone, 1 network alone; stable up to 0.9")
        .unit("1").tunable().range(0.0..=1.0),
    row!(V, integer_parameter delay, "communication steps by which F acts later than given, which the actuator then predicts over; 1 where all outputs are read before any input is set").range(0.0..=4.0),
    row!(V, integer_parameter axis, "which of the machine's actuators this is, where machine_file has one section emla for each")
        .items(&AXIS).read_by_string_setters(),
    V::string_parameter("machine_file", "machine JSON, or name of a shipped machine, whose section emla replaces the reference machine's",
        |p| &p.machine_file, read_machine)
        .packed_file(actuator_table::REFERENCE),
    V::string_parameter("surrogate_file", "network JSON to use instead of the embedded network",
        |p| &p.surrogate_file, read_surrogate)
        .packed_file(PackedFile { path: NETWORK.path, digest: NETWORK_DIGEST }),
    row!(V, parameter undervoltage in electric, "voltage of the DC link below which an enabled drive trips; 0: never").unit("V").range(0.0..=1e5),
    row!(V, boolean_parameter heat in electric, "whether the losses warm winding and housing; else these stay at their start"),
    row!(V, boolean_parameter temperature in electric, "whether resistance and magnets follow their temperature"),
    row!(V, parameter T_winding_start = T_start[0], "temperature of the winding at the start").unit("K").display_unit("degC").range(1.0..=2e3),
    row!(V, parameter T_housing_start = T_start[1], "temperature of the housing at the start").unit("K").display_unit("degC").range(1.0..=2e3),
];

const OF_MACHINE: &[V] = actuator_parameters!(
    V,
    w_C: "speed over which the Coulomb friction changes sign",
    eta_gear: "gear efficiency",
    w_eta: "speed over which the gear loss changes sign",
    i_max: "largest phase current (peak): for the controller, the actuator does not enforce it"
);

const INVERTER: &[V] = inverter_parameters!(V, f_sw: "switching frequency" up to 1e7);

#[rustfmt::skip]
const BRAKE_AND_HEAT: &[V] = &[
    row!(V, parameter brake.torque in of_machine, "torque up to which the brake holds and with which it slips, at the motor").unit("N.m").range(0.0..=1e6),
    row!(V, parameter heat.C_w in of_machine, "heat capacity of the winding").unit("J/K").range(1e-3..=1e9),
    row!(V, parameter heat.R_wh in of_machine, "thermal resistance from winding to housing").unit("K/W").range(1e-6..=1e6),
    row!(V, parameter heat.C_h in of_machine, "heat capacity of the housing").unit("J/K").range(1e-3..=1e9),
    row!(V, parameter heat.R_ha in of_machine, "thermal resistance from housing to air").unit("K/W").range(1e-6..=1e6),
    row!(V, parameter temperature.reference in of_machine, "temperature at which R_s and lambda_m hold").unit("K").range(1.0..=2e3),
    row!(V, parameter temperature.copper in of_machine, "rise of the winding's resistance").unit("1/K").range(-0.1..=0.1),
    row!(V, parameter temperature.magnet in of_machine, "rise of the magnets' flux with the housing's temperature").unit("1/K").range(-0.1..=0.1),
];

#[rustfmt::skip]
const INTERVAL: &[V] = &[
    row!(V, boolean_parameter interval, "whether efficiency_interval is given; the network's file must have an efficiency_bound"),
    row!(V, outputs efficiency_interval, "lower and upper end of the interval in which the efficiency of the actuator as built lies with the probability that the network's file says (90 %), pointwise; 0 and 1 while interval is false and where efficiency_valid is false; its network part once a communication step")
        .unit("1").display_unit("%").discrete().depends_on(EFFICIENCY).initially_depends_on(START),
];

#[rustfmt::skip]
const FREE_ROD: &[V] = &[
    row!(V, local x_free, "position of the rod with drive = force; with drive = motion that of the start").unit("m").display_unit("mm").nominal(0.1),
    row!(V, local x_free_dot, "velocity of the rod with drive = force; with drive = motion that of the start").unit("m/s").display_unit("mm/s").nominal(0.05),
];

/// Behind derivatives and indicators, so that earlier value references are unchanged.
#[rustfmt::skip]
const CLOSING: &[V] = &[
    row!(V, parameter brake.closing_time in of_machine, "time from the brake's command until its torque acts; it opens at once").unit("s").range(0.0..=10.0).display_unit("ms").at(126),
];

static CURRENT_RATE: Unit = Unit::new("A/s").A(1).s(-1);
static WARMING: Unit = Unit::new("K/s").K(1).s(-1);

/// In the order of `emla::State::moving`.
#[rustfmt::skip]
pub(crate) const DERIVATIVES: &[V] = &[
    V::derivative_of("i_d").at(108).own_unit(&CURRENT_RATE).depends_on(joined!(VOLTAGE, &["i_d", "i_q", "w_m", "T_winding"])),
    V::derivative_of("i_q").own_unit(&CURRENT_RATE).depends_on(joined!(VOLTAGE, TORQUE, &["T_winding"])),
    V::derivative_of("theta_m").unit("rad/s").depends_on(&["w_m"]),
    V::derivative_of("w_m").unit("rad/s2").depends_on(MECHANICAL),
    V::derivative_of("x_free").unit("m/s").depends_on(&["x_free_dot"]),
    V::derivative_of("x_free_dot").unit("m/s2").depends_on(&["F_ext", "theta_m", "w_m", "x_free", "x_free_dot"]),
    V::derivative_of("energy.in").unit("W").depends_on(POWER),
    V::derivative_of("energy.out").unit("W").depends_on(joined!(FORCE, &["F_ext"])),
    V::derivative_of("energy.loss").unit("W").depends_on(LOSSES),
    V::derivative_of("T_winding").own_unit(&WARMING).depends_on(&["i_d", "i_q", "T_winding", "T_housing"]),
    V::derivative_of("T_housing").own_unit(&WARMING).depends_on(joined!(LOSSES, &["T_ambient"])),
    V::derivative_of("energy.heat").unit("W").depends_on(&["T_ambient", "T_housing"]),
    V::derivative_of("energy.loss_inverter").unit("W").depends_on(&["v_dc", "i_d", "i_q"]),
];

#[rustfmt::skip]
pub(crate) const INDICATORS: &[V] = &[
    V::indicator("event.speed", "motor speed").unit("rad/s"),
    V::indicator("event.load", "torque on the screw, at whose sign the gear factor jumps").unit("N.m"),
    V::indicator("event.torque", "electromagnetic torque").unit("N.m"),
    V::indicator("event.undervoltage", "v_dc above undervoltage").unit("V"),
    V::indicator("event.brake", "torque in N.m that an applied brake has in hand while it holds, or the speed in rad/s at which it slips"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_that_of_the_packed_network() {
        let packed = PackedFile::new(NETWORK.path, &(NETWORK.make)());
        assert_eq!(packed.digest, NETWORK_DIGEST, "{:#x}", packed.digest);
    }
}
