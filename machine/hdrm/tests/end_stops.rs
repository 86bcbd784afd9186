//! With nobody in control the machine stays finite and inside its end stops.

use crate::seeded::Random;
use hdrm::{DOF, Hdrm, Input, Options, State};
use machine_file::Machine;

fn plant() -> (Machine, Hdrm) {
    let machine = Machine::reference();
    let hdrm = Hdrm::new(&machine, &Options::from_machine(&machine)).expect("valid reference");
    (machine, hdrm)
}

/// Strokes (m) and wrist angles (rad) as the stops see them.
fn stop_coordinates(hdrm: &Hdrm, zeta: &[f64; DOF]) -> [f64; DOF] {
    let strokes = hdrm.tree().configuration(zeta).strokes;
    std::array::from_fn(|i| strokes.get(i).map_or(zeta[i], |stroke| stroke.x))
}

/// Deepest penetration of the strokes, m, and of the wrist, rad, over `seconds` at 1 ms.
fn run(
    hdrm: &Hdrm,
    start: State,
    seconds: u32,
    mut input: impl FnMut(u32) -> Input,
) -> (f64, f64, State) {
    let (mut stroke, mut wrist): (f64, f64) = (0.0, 0.0);
    let mut state = start;
    for k in 0..seconds * 1000 {
        let u = input(k);
        let t = f64::from(k) * 1e-3;
        state = hdrm.step(&state, |_| u, t, 1e-3).expect("finite");
        for (i, y) in stop_coordinates(hdrm, &state.zeta).into_iter().enumerate() {
            let [min, max] = hdrm.end_stops()[i].range;
            let beyond = (min - y).max(y - max);
            let worst = if i < 3 { &mut stroke } else { &mut wrist };
            *worst = worst.max(beyond);
        }
    }
    (stroke, wrist, state)
}

/// A few millimetres and degrees at most.
fn assert_inside(stroke: f64, wrist: f64) {
    println!("deepest: {} mm, {}°", 1e3 * stroke, wrist.to_degrees());
    assert!(stroke < 4e-3, "{stroke} m beyond a stroke's end");
    assert!(
        wrist.to_degrees() < 3.0,
        "{}° beyond a joint's end",
        wrist.to_degrees()
    );
}

#[test]
fn falls_into_its_stops_and_stays() {
    let (machine, hdrm) = plant();
    let start = State {
        zeta: machine.start.zeta,
        zeta_dot: [0.0; DOF],
        ..State::default()
    };
    let (stroke, wrist, end) = run(&hdrm, start, 60, |_| Input::default());
    assert_inside(stroke, wrist);
    // It ends lying on its lower lift stop; the tilt may still swing.
    let lift = stop_coordinates(&hdrm, &end.zeta)[1];
    assert!(
        (lift - hdrm.end_stops()[1].range[0]).abs() < 2e-3,
        "{end:?}"
    );
}

/// Forces to ±70 kN and torques to the drives' limits, held for 1 ms to 1 s, from random states.
#[test]
fn stays_inside_under_random_forces() {
    let (machine, hdrm) = plant();
    let limits = machine.limits.zeta();
    for (seed, seconds) in [
        (0x9E37_79B9_7F4A_7C15, 60),
        (0xC2B2_AE3D_27D4_EB4F, 10),
        (0x1656_67B1_9E37_79F9, 10),
    ] {
        let mut random = Random(seed);
        let start = State {
            zeta: limits.map(|[a, b]| 0.5 * (a + b) + 0.5 * (b - a) * random.next()),
            zeta_dot: std::array::from_fn(|_| 2.0 * random.next()),
            ..State::default()
        };
        let mut held = (0, Input::default());
        let (stroke, wrist, _) = run(&hdrm, start, seconds, |k| {
            if k >= held.0 {
                let duration = 1 + (999.0 * random.next().powi(2)) as u32;
                let full = random.next() > 0.0;
                let mut draw = || match random.next() {
                    x if full => x.signum(),
                    x => x,
                };
                let u = Input {
                    f: std::array::from_fn(|_| 70e3 * draw()),
                    tau_wrist: std::array::from_fn(|i| machine.limits.tau_wrist_max[i] * draw()),
                    wrench_env: [0.0; 6],
                    ..Input::default()
                };
                held = (k + duration, u);
            }
            held.1
        });
        println!("seed {seed:#x}");
        assert_inside(stroke, wrist);
    }
}

/// Forces away from the stops are exactly those of the free machine.
#[test]
fn stops_are_silent_in_free_range() {
    let (machine, hdrm) = plant();
    let coordinates = stop_coordinates(&hdrm, &machine.start.zeta);
    for (stop, y) in hdrm.end_stops().iter().zip(coordinates) {
        assert_eq!(stop.force(y, 3.0), 0.0);
        assert_eq!(stop.force_rate(y, 3.0, 5.0), 0.0);
    }
}

/// A stop pushes inwards, never pulls, and gives back no more energy than it took.
#[test]
fn stops_push_and_dissipate() {
    let (_, hdrm) = plant();
    let mut random = Random(0x0123_4567_89AB_CDEF);
    for stop in hdrm.end_stops() {
        let [min, max] = stop.range;
        for _ in 0..200 {
            let d = 5e-3 * random.next().abs();
            let rate = random.next();
            let elastic = stop.stiffness * d;
            for (force, into) in [
                (stop.force(min - d, rate), rate < 0.0),
                (-stop.force(max + d, -rate), rate < 0.0),
            ] {
                assert!(force >= 0.0);
                assert!(if into {
                    force > elastic
                } else {
                    force < elastic
                });
            }
        }
    }
}
