//! A plant out of a damaged saved state: its numbers need not make sense, but it must not panic.

use hdrm::{Hdrm, Input, Options, State};
use machine_file::Machine;
use serde_json::json;

/// Found by fuzzing: torque limits with the wrong sign made `clamp` panic.
#[test]
fn negative_torque_limits_do_not_panic() {
    let machine = Machine::reference();
    let sound = Hdrm::new(&machine, &Options::from_machine(&machine)).expect("working machine");
    let mut saved = serde_json::to_value(&sound).expect("serializable");
    let limits = &mut saved["tau_wrist_max"];
    assert!(limits[0].as_f64().is_some_and(|l| l > 0.0), "{limits}");
    *limits = json!([-1e132, -1.0, -1.0]);
    let damaged: Hdrm = serde_json::from_value(saved).expect("numbers");
    let state = State {
        zeta: machine.start.zeta,
        zeta_dot: [0.0; 6],
        ..State::default()
    };
    let _ = damaged.step(&state, |_| Input::default(), 0.0, 1e-3); // refused or not, without a panic
}
