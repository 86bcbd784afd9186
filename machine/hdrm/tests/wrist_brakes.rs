//! Brakes of the wrist: what they hold, when they act, and how they slip.

use hdrm::{Hdrm, Input, Options, State};
use machine_file::Machine;

const H: f64 = 1e-3;
/// A load of 300 kg whose centre is off the axes, so that gravity turns all three joints.
const COM: [f64; 3] = [0.05, -0.15, 0.1];

fn plant(change: impl FnOnce(&mut Options)) -> (Hdrm, State) {
    let machine = Machine::reference();
    let mut options = Options::from_machine(&machine);
    (options.load.payload_mass, options.load.payload_com) = (300.0, COM);
    change(&mut options);
    let plant = Hdrm::new(&machine, &options).expect("valid");
    let mut zeta = machine.start.zeta;
    (zeta[3], zeta[5]) = (0.3, -0.2);
    let state = State {
        zeta,
        ..State::default()
    };
    (plant, state)
}

/// The rods are held by springs on `state`'s strokes; the wrist is off, and braked as told.
fn run(plant: &Hdrm, start: State, brake: [bool; 3], tau: [f64; 3], steps: u32) -> State {
    let strokes = |s: &State| plant.tree().configuration(&s.zeta).strokes;
    let rest = strokes(&start).map(|stroke| stroke.x);
    let (f_hold, _) = plant.holding(&start.zeta);
    (0..steps).fold(start, |now, _| {
        let at = strokes(&now);
        let input = Input {
            f: std::array::from_fn(|i| {
                let x_dot = at[i].prime * now.zeta_dot[i];
                f_hold[i] - 2e7 * (at[i].x - rest[i]) - 2e5 * x_dot
            }),
            tau_wrist: tau,
            wrist_enable: [tau != [0.0; 3]; 3],
            wrist_brake: brake,
            ..Input::default()
        };
        plant.step(&now, |_| input, 0.0, H).expect("finite")
    })
}

/// A braked wrist that is off yields by what gravity bends its elastic anchors or gears, and stays.
/// Oracle: `τ/K` with the torques that hold the pose; with drives as built also half the play, a
/// fifth more for what the bent joints change, and 2e-5 rad for rods that are springs.
#[test]
fn brakes_hold_a_full_hook() {
    for on in [false, true] {
        let (plant, start) = plant(|options| options.wrist.on = on);
        let (_, hold) = plant.holding(&start.zeta);
        let begin = Input {
            wrist_brake: [true; 3],
            wrist_enable: [false; 3],
            ..Input::default()
        };
        let start = plant.start_state(start, &begin);
        let early = run(&plant, start, [true; 3], [0.0; 3], 3000);
        let late = run(&plant, early, [true; 3], [0.0; 3], 10_000);
        let options = Options::from_machine(&Machine::reference());
        for i in 0..3 {
            let play = if on { options.wrist.play } else { 0.0 };
            let bent = hold[i].abs() / options.wrist.stiffness[i] + play;
            let moved = early.zeta[3 + i] - start.zeta[3 + i];
            assert!(hold[i].abs() > 50.0, "{hold:?}");
            assert!(moved.abs() < 1.2 * bent + 2e-5, "{on} {i}: {moved}, {bent}");
            let crept = late.zeta[3 + i] - early.zeta[3 + i];
            assert!(crept.abs() < 1e-6, "{on} {i}: {crept}");
        }
        let free = run(&plant, start, [false; 3], [0.0; 3], 500);
        assert!((free.zeta[4] - start.zeta[4]).abs() > 0.1, "it falls");
    }
}

/// Until its closing time has passed a brake does nothing, to the last bit; then it stops the falling
/// joint, also where the time ends within a step.
#[test]
fn brakes_take_time_to_close() {
    for (on, closing_time) in [(false, 0.05), (true, 0.05), (false, 0.0503), (true, 0.0503)] {
        let (plant, start) = plant(|options| {
            options.wrist.on = on;
            options.brake.closing_time = closing_time;
        });
        let start = plant.start_state(start, &Input::default());
        let [braked, free] =
            [true, false].map(|brake| run(&plant, start, [brake; 3], [0.0; 3], 50));
        assert_eq!((braked.zeta, braked.zeta_dot), (free.zeta, free.zeta_dot));
        let [braked, free] = [(braked, true), (free, false)]
            .map(|(now, brake)| run(&plant, now, [brake; 3], [0.0; 3], 200));
        assert!(braked.zeta_dot[4].abs() < 0.05 * free.zeta_dot[4].abs());
    }
}

/// A brake slips with its torque: once the anchor has yielded, a drive that gives 2000 N·m against
/// one of 1500 moves the wrist as 500 would, from the same state on. Tolerance: the anchor yields
/// wholly only in the limit; after 20 ms its torque lacks less than 0.1 %, 0.3 % of the rest.
#[test]
fn a_brake_slips_with_its_torque() {
    let gravity_free = |options: &mut Options| {
        options.gravity = [0.0; 3];
        options.brake.torque = [1500.0; 3];
    };
    let (plant, start) = plant(gravity_free);
    let slips = |from, steps| {
        run(
            &plant,
            from,
            [true, false, false],
            [2000.0, 0.0, 0.0],
            steps,
        )
    };
    let yielded = slips(start, 20);
    let slipping = slips(yielded, 130);
    let driven = run(&plant, yielded, [false; 3], [500.0, 0.0, 0.0], 130);
    let [a, b] = [slipping, driven].map(|s| s.zeta[3] - yielded.zeta[3]);
    assert!(b > 0.2 && (a - b).abs() < 3e-3 * b, "{a} {b}");
    // With all three braked and no torque it comes to rest, farther on.
    let rest = run(&plant, slipping, [true; 3], [0.0; 3], 3000);
    assert!(rest.zeta_dot[3].abs() < 1e-4, "{:?}", rest.zeta_dot);
    assert!(
        rest.zeta[3] > slipping.zeta[3],
        "{} {}",
        rest.zeta[3],
        slipping.zeta[3]
    );
}
