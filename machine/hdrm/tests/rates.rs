//! The rates of Model Exchange against the steps of Co-Simulation.

use hdrm::{Contact, Hdrm, Input, Options, State};
use machine_file::Machine;

/// In contact with the plane, with the wrist as built: what moves in a very short step, over its
/// length, in the order zeta, zeta_dot, heat of the contact, drives of the wrist. The step errs by
/// half of its length times the second derivative: of the drives ω² = K/J = 1e5 1/s² times the
/// rate, some 1e-3 of theirs, and less of the rest.
#[test]
fn a_short_step_follows_the_rates() {
    let machine = Machine::reference();
    let mut options = Options::from_machine(&machine);
    (options.wrist.on, options.wrist.play) = (true, 1e-4);
    let zeta = machine.start.zeta;
    let free = Hdrm::new(&machine, &options).expect("valid");
    let tip = free.output(
        &State {
            zeta,
            ..State::default()
        },
        &Input::default(),
    );
    options.contact = Contact {
        offset: tip.tip_position[1] + 2e-3,
        stiffness: 1e6,
        friction: 0.4,
        ..Contact::default()
    };
    let plant = Hdrm::new(&machine, &options).expect("valid");
    let zeta_dot = [0.2, -0.1, 0.15, 0.3, -0.2, 0.4];
    let mut start = plant.start_state(
        State {
            zeta,
            zeta_dot,
            ..State::default()
        },
        &Input::default(),
    );
    for (i, drive) in start.wrist.iter_mut().enumerate() {
        let [torque, angle, _] = drive.moving();
        drive.set_moving([torque, angle + 2e-4, zeta_dot[3 + i] + 0.1]);
    }
    let start = plant.with_gear_torques(start);
    let input = Input {
        f: [1e3, 4e4, 3e4],
        tau_wrist: [500.0, -300.0, 100.0],
        ..Input::default()
    };
    let slips = start.wrist.map(|drive| drive.moving()[2].signum());
    assert!(slips.contains(&1.0) && slips.contains(&-1.0));
    let rates = plant.derivative(&plant.dynamics_with(&start, &input), &input, &slips);
    let numbers = |s: &State| -> Vec<f64> {
        let wrist = s.wrist.iter().flat_map(|drive| drive.moving());
        (s.zeta
            .into_iter()
            .chain(s.zeta_dot)
            .chain([s.contact_loss])
            .chain(wrist))
        .collect()
    };
    let h = 1e-7;
    let next = plant.step(&start, |_| input, 0.0, h).expect("finite");
    for (k, ((after, before), rate)) in (numbers(&next)
        .into_iter()
        .zip(numbers(&start))
        .zip(numbers(&rates)))
    .enumerate()
    {
        let found = (after - before) / h;
        let tol = 1e-3 * rate.abs() + 1e-6;
        assert!((found - rate).abs() < tol, "{k}: {found} {rate}");
    }
    assert!(rates.contact_loss > 1.0);
}
