//! Joint friction that is too stiff for RK4, and what becomes of it.
#![allow(non_snake_case)]

use hdrm::{DOF, Hdrm, Input, Options, State, StepError};
use machine::Machine;

/// Substep in free motion, s.
const SUBSTEP: f64 = 1e-3;
/// Joint whose friction is stiff: the last of the wrist, the lightest.
const STIFF: usize = 5;
/// Where RK4's growth factor 1 + z + z²/2 + z³/6 + z⁴/24 becomes 1 on the negative axis.
const RK4_LIMIT: f64 = 2.785_293_563;

fn plant(viscous: f64) -> (Hdrm, State, Input) {
    let machine = Machine::reference();
    let mut options = Options::of(&machine);
    options.joint_viscous[STIFF] = viscous;
    let hdrm = Hdrm::new(&machine, &options).expect("working machine");
    let mut state = State {
        zeta: machine.start.zeta,
        zeta_dot: [0.0; DOF],
    };
    let hold = hdrm.output(&state, &Input::default());
    state.zeta_dot[STIFF] = 1e-3;
    let input = Input {
        f: hold.f_hold,
        tau_wrist: hold.tau_hold,
        ..Input::default()
    };
    (hdrm, state, input)
}

/// Acceleration of the stiff joint per torque on it, 1/(kg·m²).
fn mobility() -> f64 {
    let (hdrm, state, input) = plant(0.0);
    let mut du = Input::default();
    du.tau_wrist[STIFF - 3] = 1.0;
    let along = hdrm.directional_derivative(&state, &input, &du);
    along.zeta_ddot[STIFF]
}

/// Rate of the stiff joint after so many substeps.
fn rate(viscous: f64, substeps: u32) -> Result<f64, StepError> {
    let (hdrm, mut state, input) = plant(viscous);
    for k in 0..substeps {
        state = hdrm.step(&state, |_| input, f64::from(k) * SUBSTEP, SUBSTEP)?;
    }
    Ok(state.zeta_dot[STIFF].abs())
}

/// The joint decays with d·(M⁻¹)₆₆, which is unstable from RK4's limit on: 5 % below it the rate dies away, 5 % above it grows (to some
/// rad/s, where fast motion makes the substeps shorter). Far beyond, a substep multiplies the rate by z⁴/24 until the step is refused.
/// So it is the integrator and not the model that overflows.
#[test]
fn stiff_friction_is_stable_up_to_the_limit_of_the_integrator() {
    let limit = RK4_LIMIT / (SUBSTEP * mobility());
    println!("joint_viscous[6] up to {limit} N.m.s/rad");
    assert!(rate(0.95 * limit, 400).unwrap() < 1e-5);
    let growing = rate(1.05 * limit, 20).unwrap();
    assert!(growing > 5e-3, "{growing:e}");
    assert!(rate(1.05 * limit, 10_000).unwrap() < 10.0);
    let refused = rate(1000.0 * limit, 1000).unwrap_err();
    let StepError::NotFinite { signal, value, .. } = refused else {
        panic!("{refused}");
    };
    assert!(signal.starts_with("zeta") && value.abs() > 1e9, "{refused}");
    assert!(
        value.is_finite(),
        "refused before numbers overflow: {refused}"
    );
}
