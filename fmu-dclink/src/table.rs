//! Variables of the FMU `DcLink` for its description and calls: name, unit, bounds, dependencies.

use super::model::DcLinkFmu;
use fmu_export::{ALL_PARAMETERS, File, Info, NO_STATES, Terminal, Unit, Variable, row};

/// 20 °C, K.
pub(crate) const ROOM_TEMPERATURE: f64 = 293.15;

pub(crate) const INFO: Info = Info::new(
    "DcLink",
    "DC link of electric drives: battery pack with two RC pairs and heat, capacitor, precharge, brake chopper, limits of the pack",
)
.version(env!("CARGO_PKG_VERSION"))
.license("MIT OR Apache-2.0")
.experiment(0.0, 24.25, 1e-3)
.documentation(&[File { path: "index.html", bytes: include_bytes!("../documentation/index.html") }])
.icon(include_bytes!("../model.png"))
.terminals(&[Terminal::new("dc", "io.github.hdrm-fmu.dc-link", "electrical bonds: the DC link that three drives draw from", &[
    ("v_dc", "v_dc"), ("i_dc", "i_load"),
])]);

static VOLTAGE_RATE: Unit = Unit::new("V/s").kg(1).m(2).s(-4).A(-1);
static WARMING: Unit = Unit::new("K/s").K(1).s(-1);

type V = Variable<DcLinkFmu>;

/// Dependencies of the pack's current.
const CIRCUIT: &[&str] = &["soc", "v_pairs", "v_dc"];
const CAPACITOR: &[&str] = &["v_dc"];

/// An output that depends on these states, without direct feedthrough.
const fn follows_states(states: &'static [&'static str], row: V) -> V {
    row.depends_on(states)
        .initially_depends_on(&[ALL_PARAMETERS])
}

/// A state, or an output of the mode.
const fn state(row: V) -> V {
    follows_states(&[NO_STATES], row)
}

#[rustfmt::skip]
pub(crate) const VARIABLES: &[V] = &[
    // Inputs
    row!(V, inputs i_load, "currents that the drives draw from the link; negative where they give back")
        .unit("A").range(-1e5..=1e5).nominal(10.0),
    row!(V, input T_ambient, "temperature around the pack").unit("K").display_unit("degC").range(1.0..=1e4),
    // Outputs
    state(row!(V, output v_dc, "voltage of the link: of its capacitor, a state")).unit("V").nominal(600.0),
    state(row!(V, output v_dc_mean, "mean of v_dc over the last step")).unit("V").nominal(600.0),
    follows_states(CIRCUIT, row!(V, output i_battery, "current of the pack, positive where it discharges")).unit("A").nominal(10.0),
    follows_states(CIRCUIT, row!(V, output v_battery, "voltage at the terminals of the pack")).unit("V").nominal(600.0),
    state(row!(V, output soc, "state of charge")).unit("1").nominal(1.0).display_unit("%"),
    follows_states(CAPACITOR, row!(V, output P_brake, "power burnt in the brake resistor")).unit("W").nominal(1e3).display_unit("kW"),
    follows_states(CIRCUIT, row!(V, output P_loss, "power lost in pack, wiring, precharge and limit")).unit("W").nominal(1e2).display_unit("kW"),
    state(row!(V, output T_battery, "temperature of the pack")).unit("K").nominal(300.0).display_unit("degC"),
    state(row!(V, output energy.battery, "energy from the source of the pack since the start, open-circuit voltage times current; = load + brake + loss + rise of stored")).unit("J").nominal(1e3).display_unit("kJ"),
    state(row!(V, output energy.load, "energy given to the drives since the start")).unit("J").nominal(1e3).display_unit("kJ"),
    state(row!(V, output energy.brake, "energy burnt in the brake resistor since the start")).unit("J").nominal(1e3).display_unit("kJ"),
    state(row!(V, output energy.loss, "energy lost in pack, wiring, precharge and limit since the start")).unit("J").nominal(1e3).display_unit("kJ"),
    follows_states(&["v_pairs", "v_dc"], row!(V, output energy.stored = stored, "energy in the capacitor and in the RC pairs")).unit("J").nominal(1e3).display_unit("kJ"),
    state(row!(V, boolean_output ready, "whether precharge is over: the drives may be enabled")),
    state(row!(V, boolean_output precharging, "whether precharge is not over: the opposite of ready, for the brakes that hold the machine meanwhile")),
    state(row!(V, boolean_output braking, "whether the brake resistor is switched on")),
    state(row!(V, boolean_output limited, "whether the pack gives or takes all that it may")),
    follows_states(CAPACITOR, row!(V, boolean_output undervoltage, "whether precharge is over and v_dc is below v_min")),
    // Parameters
    row!(V, integer_parameter battery.cells, "cells in series").range(1.0..=10000.0),
    row!(V, parameter battery.capacity, "capacity").unit("A.h").range(1e-3..=1e6),
    row!(V, parameters battery.ocv, "open-circuit voltage of a cell at states of charge 0, 0.05, ..., 1; straight lines between, nowhere falling")
        .unit("V").range(1e-3..=1e4),
    row!(V, parameter battery.R_0, "series resistance of the pack").unit("Ohm").range(0.0..=1e4),
    row!(V, parameter battery.R_1 = battery.R[0], "resistance of the first RC pair, of the pack; 0: there is none").unit("Ohm").range(0.0..=1e4),
    row!(V, parameter battery.tau_1 = battery.tau[0], "time constant of the first RC pair").unit("s").range(1e-6..=1e9),
    row!(V, parameter battery.R_2 = battery.R[1], "resistance of the second RC pair, of the pack; 0: there is none").unit("Ohm").range(0.0..=1e4),
    row!(V, parameter battery.tau_2 = battery.tau[1], "time constant of the second RC pair").unit("s").range(1e-6..=1e9),
    row!(V, parameter battery.discharge_limit, "largest current that the pack gives").unit("A").range(0.0..=1e5),
    row!(V, parameter battery.charge_limit, "largest current that the pack takes").unit("A").range(0.0..=1e5),
    row!(V, parameter battery.soc_low, "state of charge below which discharge_limit falls in proportion, to 0 at 0").unit("1").range(0.0..=1.0).display_unit("%"),
    row!(V, parameter battery.soc_high, "state of charge above which charge_limit falls in proportion, to 0 at 1").unit("1").range(0.0..=1.0).display_unit("%"),
    row!(V, parameter battery.heat_capacity, "heat capacity of the pack").unit("J/K").range(1e-3..=1e12),
    row!(V, parameter battery.heat_resistance, "heat resistance from the pack to the surroundings").unit("K/W").range(1e-9..=1e9),
    row!(V, parameter battery.soc_start, "state of charge at the start").unit("1").range(0.0..=1.0).display_unit("%"),
    row!(V, parameter battery.T_start, "temperature of the pack at the start").unit("K").range(1.0..=1e4).display_unit("degC"),
    row!(V, parameter link.C, "capacitance of the link").unit("F").range(1e-9..=1e3).display_unit("mF"),
    row!(V, parameter link.R, "resistance between pack and capacitor").unit("Ohm").range(0.0..=1e4),
    row!(V, boolean_parameter brake.fitted, "whether there is a brake chopper"),
    row!(V, parameter brake.R, "brake resistor").unit("Ohm").range(1e-6..=1e9),
    row!(V, parameter brake.v_on, "voltage at which the brake resistor is switched on").unit("V").range(1e-3..=1e6),
    row!(V, parameter brake.v_off, "voltage at which the brake resistor is switched off").unit("V").range(1e-3..=1e6),
    row!(V, boolean_parameter precharge.on, "whether the capacitor is charged in the run; else it has the pack's voltage at the start"),
    row!(V, parameter precharge.R, "precharge: resistor in the way of the current until ready").unit("Ohm").range(0.0..=1e9),
    row!(V, parameter precharge.v_start, "precharge: voltage of the capacitor at the start").unit("V").range(0.0..=1e6),
    row!(V, parameter precharge.share, "precharge: share of the pack's voltage at which it is over").unit("1").range(1e-3..=0.9999).display_unit("%"),
    row!(V, parameter v_min, "voltage below which drives cannot work: undervoltage").unit("V").range(0.0..=1e6),
    row!(V, parameter v_max, "voltage that nothing on the link should see: a warning").unit("V").range(1e-3..=1e6),
    // States for Model Exchange, appended
    row!(V, locals v_pairs, "voltages of the RC pairs").unit("V").nominal(10.0),
];

#[rustfmt::skip]
pub(crate) const DERIVATIVES: &[V] = &[
    V::derivative_of("soc").unit("1/s").depends_on(CIRCUIT),
    V::derivatives_of("v_pairs").own_unit(&VOLTAGE_RATE).depends_on(CIRCUIT),
    V::derivative_of("v_dc").own_unit(&VOLTAGE_RATE).depends_on(&["soc", "v_pairs", "v_dc", "i_load"]),
    V::derivative_of("T_battery").own_unit(&WARMING).depends_on(&["soc", "v_pairs", "v_dc", "T_battery", "T_ambient"]),
    V::derivative_of("energy.battery").unit("W").depends_on(CIRCUIT),
    V::derivative_of("energy.load").unit("W").depends_on(&["v_dc", "i_load"]),
    V::derivative_of("energy.brake").unit("W").depends_on(CAPACITOR),
    V::derivative_of("energy.loss").unit("W").depends_on(CIRCUIT),
];

#[rustfmt::skip]
pub(crate) const INDICATORS: &[V] = &[
    V::indicator("event.limit", "positive where the pack reaches or leaves a limit").unit("A"),
    V::indicator("event.chopper", "positive where v_dc passes a threshold of the chopper").unit("V"),
    V::indicator("event.ready", "positive where precharge is over").unit("V"),
    V::indicator("event.empty", "positive where the capacitor is empty, or is charged again"),
    V::indicator("event.undervoltage", "v_dc above v_min").unit("V"),
    V::indicator("event.overvoltage", "v_dc below v_max").unit("V"),
];
