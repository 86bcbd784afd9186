//! Variables of the FMU `DcLink`.

use crate::DcLinkFmu;
use fmu_export::{ALL_PARAMETERS, File, Info, Terminal, Variable};

/// 20 °C, K.
pub(crate) const ROOM: f64 = 293.15;

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

type V = Variable<DcLinkFmu>;

/// A Real parameter from its place in the parameters, its range, unit and description.
macro_rules! size {
    ($name:literal, $($field:ident).+ $([$k:literal])?, $min:literal..=$max:literal, $unit:literal, $description:literal) => {
        V::parameter($name, $description, |p| &p.$($field).+ $([$k])?, |p| &mut p.$($field).+ $([$k])?).unit($unit).min($min).max($max)
    };
}

/// An output of the state, which no input acts on at once.
macro_rules! shown {
    ($name:literal, $($field:ident).+, $unit:literal, $nominal:literal, $description:literal) => {
        V::output($name, $description, |y| &y.$($field).+)
            .unit($unit).nominal($nominal).depends_on(&[]).initially_depends_on(&[ALL_PARAMETERS])
    };
}

/// The same of a truth.
macro_rules! told {
    ($name:literal, $field:ident, $description:literal) => {
        V::boolean_output($name, $description, |y| &y.$field)
            .depends_on(&[])
            .initially_depends_on(&[ALL_PARAMETERS])
    };
}

#[rustfmt::skip]
pub(crate) const VARIABLES: &[V] = &[
    // Inputs
    V::inputs("i_load", "currents that the drives draw from the link; negative where they give back", |u| &u.i_load, |u| &mut u.i_load)
        .unit("A").min(-1e5).max(1e5).nominal(10.0),
    V::input("T_ambient", "temperature around the pack", |u| &u.T_ambient, |u| &mut u.T_ambient).unit("K").display_unit("degC").min(1.0).max(1e4),
    // Outputs
    shown!("v_dc", v_dc, "V", 600.0, "voltage of the link: of its capacitor, a state"),
    shown!("v_dc_mean", v_dc_mean, "V", 600.0, "mean of v_dc over the last step"),
    shown!("i_battery", i_battery, "A", 10.0, "current of the pack, positive where it discharges"),
    shown!("v_battery", v_battery, "V", 600.0, "voltage at the terminals of the pack"),
    shown!("soc", soc, "1", 1.0, "state of charge").display_unit("%"),
    shown!("P_brake", P_brake, "W", 1e3, "power burnt in the brake resistor").display_unit("kW"),
    shown!("P_loss", P_loss, "W", 1e2, "power lost in pack, wiring, precharge and limit").display_unit("kW"),
    shown!("T_battery", T_battery, "K", 300.0, "temperature of the pack").display_unit("degC"),
    shown!("energy.battery", energy.battery, "J", 1e3, "energy from the source of the pack since the start, open-circuit voltage times current; = load + brake + loss + rise of stored").display_unit("kJ"),
    shown!("energy.load", energy.load, "J", 1e3, "energy given to the drives since the start").display_unit("kJ"),
    shown!("energy.brake", energy.brake, "J", 1e3, "energy burnt in the brake resistor since the start").display_unit("kJ"),
    shown!("energy.loss", energy.loss, "J", 1e3, "energy lost in pack, wiring, precharge and limit since the start").display_unit("kJ"),
    shown!("energy.stored", stored, "J", 1e3, "energy in the capacitor and in the RC pairs").display_unit("kJ"),
    told!("ready", ready, "whether precharge is over: the drives may be enabled"),
    told!("precharging", precharging, "whether precharge is not over: the opposite of ready, for the brakes that hold the machine meanwhile"),
    told!("braking", braking, "whether the brake resistor is switched on"),
    told!("limited", limited, "whether the pack gives or takes all that it may"),
    told!("undervoltage", undervoltage, "whether precharge is over and v_dc is below v_min"),
    // Parameters
    V::integer_parameter("battery.cells", "cells in series", |p| &p.battery.cells, |p| &mut p.battery.cells).min(1.0).max(10000.0),
    size!("battery.capacity", battery.capacity, 1e-3..=1e6, "A.h", "capacity"),
    V::parameters("battery.ocv", "open-circuit voltage of a cell at states of charge 0, 0.05, ..., 1; straight lines between, nowhere falling", |p| &p.battery.ocv, |p| &mut p.battery.ocv)
        .unit("V").min(1e-3).max(1e4),
    size!("battery.R_0", battery.R_0, 0.0..=1e4, "Ohm", "series resistance of the pack"),
    size!("battery.R_1", battery.R[0], 0.0..=1e4, "Ohm", "resistance of the first RC pair, of the pack; 0: there is none"),
    size!("battery.tau_1", battery.tau[0], 1e-6..=1e9, "s", "time constant of the first RC pair"),
    size!("battery.R_2", battery.R[1], 0.0..=1e4, "Ohm", "resistance of the second RC pair, of the pack; 0: there is none"),
    size!("battery.tau_2", battery.tau[1], 1e-6..=1e9, "s", "time constant of the second RC pair"),
    size!("battery.discharge_limit", battery.discharge_limit, 0.0..=1e5, "A", "largest current that the pack gives"),
    size!("battery.charge_limit", battery.charge_limit, 0.0..=1e5, "A", "largest current that the pack takes"),
    size!("battery.soc_low", battery.soc_low, 0.0..=1.0, "1", "state of charge below which discharge_limit falls in proportion, to 0 at 0").display_unit("%"),
    size!("battery.soc_high", battery.soc_high, 0.0..=1.0, "1", "state of charge above which charge_limit falls in proportion, to 0 at 1").display_unit("%"),
    size!("battery.heat_capacity", battery.heat_capacity, 1e-3..=1e12, "J/K", "heat capacity of the pack"),
    size!("battery.heat_resistance", battery.heat_resistance, 1e-9..=1e9, "K/W", "heat resistance from the pack to the surroundings"),
    size!("battery.soc_start", battery.soc_start, 0.0..=1.0, "1", "state of charge at the start").display_unit("%"),
    size!("battery.T_start", battery.T_start, 1.0..=1e4, "K", "temperature of the pack at the start").display_unit("degC"),
    size!("link.C", link.C, 1e-9..=1e3, "F", "capacitance of the link").display_unit("mF"),
    size!("link.R", link.R, 0.0..=1e4, "Ohm", "resistance between pack and capacitor"),
    V::boolean_parameter("brake.fitted", "whether there is a brake chopper", |p| &p.brake.fitted, |p| &mut p.brake.fitted),
    size!("brake.R", brake.R, 1e-6..=1e9, "Ohm", "brake resistor"),
    size!("brake.v_on", brake.v_on, 1e-3..=1e6, "V", "voltage at which the brake resistor is switched on"),
    size!("brake.v_off", brake.v_off, 1e-3..=1e6, "V", "voltage at which the brake resistor is switched off"),
    V::boolean_parameter("precharge.on", "whether the capacitor is charged in the run; else it has the pack's voltage at the start", |p| &p.precharge.on, |p| &mut p.precharge.on),
    size!("precharge.R", precharge.R, 0.0..=1e9, "Ohm", "precharge: resistor in the way of the current until ready"),
    size!("precharge.v_start", precharge.v_start, 0.0..=1e6, "V", "precharge: voltage of the capacitor at the start"),
    size!("precharge.share", precharge.share, 1e-3..=0.9999, "1", "precharge: share of the pack's voltage at which it is over").display_unit("%"),
    size!("v_min", v_min, 0.0..=1e6, "V", "voltage below which drives cannot work: undervoltage"),
    size!("v_max", v_max, 1e-3..=1e6, "V", "voltage that nothing on the link should see: a warning"),
];
