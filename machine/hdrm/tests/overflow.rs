//! Joint friction that is stiff for RK4, and friction that is too stiff.
use hdrm::{DOF, Hdrm, Input, Options, State, StepError};
use machine_file::Machine;

/// Substep in free motion, s.
const SUBSTEP: f64 = 1e-3;
/// Joint whose friction is stiff: the last of the wrist, the lightest.
const STIFF: usize = 5;
/// Where RK4's growth factor 1 + z + z²/2 + z³/6 + z⁴/24 becomes 1 on the negative axis.
const RK4_LIMIT: f64 = 2.785_293_563;

fn plant(viscous: f64) -> (Hdrm, State, Input) {
    let machine = Machine::reference();
    let mut options = Options::from_machine(&machine);
    options.joint_viscous[STIFF] = viscous;
    let hdrm = Hdrm::new(&machine, &options).expect("working machine");
    let mut state = State {
        zeta: machine.start.zeta,
        zeta_dot: [0.0; DOF],
        ..State::default()
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

/// The joint decays with d·(M⁻¹)₆₆, which whole substeps would not follow from RK4's limit on.
/// Substeps look at friction, so that the rate of the reference machine dies away with whatever
/// friction the FMU allows (10⁶).
#[test]
fn stiff_friction_decays() {
    let limit = RK4_LIMIT / (SUBSTEP * mobility());
    println!("joint_viscous[6] up to {limit} N.m.s/rad in whole substeps");
    for viscous in [0.95 * limit, 1.05 * limit, 1e6] {
        let left = rate(viscous, 400).unwrap();
        assert!(left < 1e-5, "{viscous} N.m.s/rad: {left:e} rad/s");
    }
}

/// Beyond RK4's limit for the shortest substep, a 200th of the longest, the rate of the stiff joint
/// grows from substep to substep and the step is refused; just below it decays.
#[test]
fn friction_beyond_all_substeps_is_refused() {
    let limit = 200.0 * RK4_LIMIT / (SUBSTEP * mobility());
    assert!(rate(0.95 * limit, 100).expect("stable") < 1e-5);
    let refused = rate(1.05 * limit, 100);
    assert!(
        matches!(refused, Err(StepError::NotFinite { .. })),
        "{refused:?}"
    );
}
