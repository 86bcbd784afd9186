//! Rows of the variable table that the FMUs `Emla` and `Rig` both have.

use fmu_export::{Model, Variable};

/// An output that is an energy since the start.
pub const fn energy<M: Model>(row: Variable<M>) -> Variable<M> {
    let row = row.unit("J").display_unit("kJ").nominal(1e3);
    row.depends_on(&[]).initially_depends_on(&[])
}

/// Rows of the inputs, for `$V = Variable<Model>`. Given are the model's own descriptions of the
/// voltages and of the ambient temperature, and the latter's display unit.
#[macro_export]
macro_rules! actuator_inputs {
    ($V:ty, v_d: $v_d:literal, v_q: $v_q:literal, T_ambient: $T_ambient:literal $(in $unit:literal)?) => {
        &[
            fmu_export::row!($V, input v_d in u, $v_d).unit("V").range(-1e4..=1e4).nominal(100.0),
            fmu_export::row!($V, input v_q in u, $v_q).unit("V").range(-1e4..=1e4).nominal(100.0),
            fmu_export::row!($V, counted_input v_dc, "voltage of the DC link, held over a step; until it is set, inverter.v_dc counts, and where that is 0 sqrt(3)*v_max")
                .unit("V").range(0.0..=1e5).nominal(500.0),
            fmu_export::row!($V, boolean_input enable in u, "gates of the inverter on; while they are off no current flows and the motor gives no torque; read at the start of a step"),
            fmu_export::row!($V, boolean_input brake in u, "holding brake on the motor's shaft applied; a drive that has tripped applies it too; read at the start of a step"),
            fmu_export::row!($V, input T_ambient in u, $T_ambient).unit("K")$(.display_unit($unit))?.range(1.0..=2e3).nominal(300.0),
            fmu_export::row!($V, counted_input x, "rod position, positive when extended; with drive = force only its value at the start counts")
                .unit("m").display_unit("mm").range(-$crate::X_LARGEST..=$crate::X_LARGEST).nominal(0.1),
            fmu_export::row!($V, input x_dot in u, "rod velocity; with drive = force only its value at the start counts")
                .unit("m/s").display_unit("mm/s").range(-100.0..=100.0).nominal(0.05).rate_of("x"),
            fmu_export::row!($V, input F_ext in u, "external force on the rod against extension; with drive = force only")
                .unit("N").display_unit("kN").range(-1e7..=1e7).nominal(1e4),
            fmu_export::row!($V, input F_hold in u, "force that the actuator delivers at the start; read in initialization only")
                .unit("N").display_unit("kN").range(-1e7..=1e7).nominal(1e4),
        ]
    };
}

/// Rows of the parameters of the machine file's section `emla`, except inverter, brake, heat and
/// temperature, for `$V = Variable<Model>`. The model's parameters hold them in a field
/// `of_machine: machine_file::EmlaFields`. Given are the descriptions that differ between models.
#[macro_export]
macro_rules! actuator_parameters {
    ($V:ty, w_C: $w_C:literal, eta_gear: $eta_gear:literal, w_eta: $w_eta:literal, i_max: $i_max:literal) => {
        &[
            fmu_export::row!($V, integer_parameter p = of_machine.pole_pairs, "pole pairs").range(1.0..=1000.0),
            fmu_export::row!($V, parameter R_s in of_machine.emla, "stator resistance").unit("Ohm").range(1e-6..=1e3),
            fmu_export::row!($V, parameter L_d in of_machine.emla, "direct-axis inductance").unit("H").range(1e-7..=10.0),
            fmu_export::row!($V, parameter L_q in of_machine.emla, "quadrature-axis inductance").unit("H").range(1e-7..=10.0),
            fmu_export::row!($V, parameter lambda_m in of_machine.emla, "flux linkage of the permanent magnets (peak)").unit("Wb").range(1e-6..=100.0),
            fmu_export::row!($V, parameter J_m in of_machine.emla, "rotor inertia").unit("kg.m2").range(1e-8..=1e3),
            fmu_export::row!($V, parameter C_m in of_machine.emla, "viscous friction of the motor").unit("N.m.s/rad").range(0.0..=1e3),
            fmu_export::row!($V, parameter tau_C in of_machine.emla, "Coulomb friction of the motor").unit("N.m").range(0.0..=1e4),
            fmu_export::row!($V, parameter w_C in of_machine.emla, $w_C).unit("rad/s").range(1e-4..=1e3),
            fmu_export::row!($V, parameter N_gear in of_machine.emla, "gear reduction").unit("1").range(1e-2..=1e4),
            fmu_export::row!($V, parameter eta_gear in of_machine.emla, $eta_gear).unit("1").range(1e-2..=1.0),
            fmu_export::row!($V, parameter w_eta in of_machine.emla, $w_eta).unit("rad/s").range(1e-4..=1e3),
            fmu_export::row!($V, parameter rho in of_machine.emla, "screw lead, travel per revolution").unit("m").range(1e-4..=10.0),
            fmu_export::row!($V, parameter J_s in of_machine.emla, "screw inertia").unit("kg.m2").range(1e-9..=1e4),
            fmu_export::row!($V, parameter C_s in of_machine.emla, "viscous friction of the screw").unit("N.m.s/rad").range(0.0..=1e4),
            fmu_export::row!($V, parameter EA in of_machine.emla, "axial rigidity of the screw").unit("N").range(1e3..=1e13),
            fmu_export::row!($V, parameter K_br in of_machine.emla, "bearing stiffness").unit("N/m").range(1e3..=1e13),
            fmu_export::row!($V, parameter K_n in of_machine.emla, "nut stiffness").unit("N/m").range(1e3..=1e13),
            fmu_export::row!($V, parameter K_r in of_machine.emla, "rod stiffness").unit("N/m").range(1e3..=1e13),
            fmu_export::row!($V, parameter GJ in of_machine.emla, "torsional rigidity of the screw").unit("N.m2").range(1e-1..=1e10),
            fmu_export::row!($V, parameter L_s in of_machine.emla, "distance between the screw's bearings").unit("m").range(1e-3..=100.0),
            fmu_export::row!($V, parameter C_b in of_machine.emla, "damping between nut and rod").unit("N.s/m").range(0.0..=1e9),
            fmu_export::row!($V, parameter M_act in of_machine.emla, "mass of the rod; counts with drive = force only").unit("kg").range(1e-3..=1e6),
            fmu_export::row!($V, parameter C_act in of_machine.emla, "viscous friction of the rod").unit("N.s/m").range(0.0..=1e9),
            fmu_export::row!($V, parameter i_max in of_machine.emla, $i_max).unit("A").range(1e-3..=1e6),
            fmu_export::row!($V, parameter v_max in of_machine.emla, "largest phase voltage (peak)").unit("V").range(1e-3..=1e5),
            fmu_export::row!($V, parameter core.k_h in of_machine, "hysteresis coefficient of the iron losses").unit("W.s/(rad.Wb2)").range(0.0..=1e9),
            fmu_export::row!($V, parameter core.k_e in of_machine, "eddy-current coefficient of the iron losses").unit("W.s2/(rad2.Wb2)").range(0.0..=1e9),
        ]
    };
}

/// Rows of the inverter's parameters, in the same field.
#[macro_export]
macro_rules! inverter_parameters {
    ($V:ty, f_sw: $f_sw:literal up to $largest:literal) => {
        &[
            fmu_export::row!($V, parameter inverter.v_dc in of_machine, "DC-link voltage until the input v_dc is set").unit("V").range(0.0..=1e5),
            fmu_export::row!($V, parameter inverter.f_sw in of_machine, $f_sw).unit("Hz").range(0.0..=$largest),
            fmu_export::row!($V, parameter inverter.k_sw in of_machine, "switching energy per volt and ampere, on and off together").unit("J/(V.A)").range(0.0..=1.0),
            fmu_export::row!($V, parameter inverter.v_0 in of_machine, "threshold voltage of a device").unit("V").range(0.0..=1e3),
            fmu_export::row!($V, parameter inverter.r_0 in of_machine, "differential resistance of a device").unit("Ohm").range(0.0..=1e3),
        ]
    };
}
