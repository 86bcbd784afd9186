//! Contact of the tip with a plane: against SciPy, and energy while it pushes and slides.
use hdrm::{Contact, DOF, Hdrm, Input, Options, State};
use machine_file::Machine;
use serde::Deserialize;
use std::path::Path;

#[derive(Deserialize)]
struct Golden {
    contact: Contact,
    start: Start,
    drives: Drives,
    rows: Vec<Row>,
}

#[derive(Deserialize)]
struct Start {
    zeta: [f64; DOF],
    zeta_dot: [f64; DOF],
}

#[derive(Deserialize)]
struct Drives {
    f: [f64; 3],
    tau: [f64; 3],
}

#[derive(Deserialize)]
struct Row {
    t: f64,
    zeta: [f64; DOF],
    zeta_dot: [f64; DOF],
    loss: f64,
    force: [f64; 3],
    depth: f64,
}

fn golden() -> Golden {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/oracle/contact.json");
    let text = std::fs::read_to_string(&path).expect("golden file");
    serde_json::from_str(&text).expect("golden format")
}

impl Golden {
    /// The state before the fall, and the drives, which are constant.
    fn beginning(&self) -> (State, Input) {
        let state = State {
            zeta: self.start.zeta,
            zeta_dot: self.start.zeta_dot,
            ..State::default()
        };
        let input = Input {
            f: self.drives.f,
            tau_wrist: self.drives.tau,
            ..Input::default()
        };
        (state, input)
    }
}

fn plant(contact: Contact, joint_viscous: Option<[f64; DOF]>) -> Hdrm {
    let machine = Machine::reference();
    let options = Options::from_machine(&machine);
    let options = Options {
        contact,
        joint_viscous: joint_viscous.unwrap_or(options.joint_viscous),
        ..options
    };
    Hdrm::new(&machine, &options).expect("valid")
}

fn largest<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    (0..N).fold(0.0, |worst: f64, i| worst.max((a[i] - b[i]).abs()))
}

/// The machine falls onto a plane and slides on it, as SciPy's DOP853 (1e-11) has it for the
/// Lagrangian of `tests/oracle/contact.py`. RK4 with 0.1 ms errs by the kink at touch-down: there a
/// step of h misplaces the beginning of a force k·v·h by less than h.
#[test]
fn a_fall_onto_a_plane_is_that_of_scipy() {
    let golden = golden();
    let plant = plant(golden.contact, None);
    let (mut state, input) = golden.beginning();
    let (h, mut k) = (1e-4, 0_u32);
    let mut touched = 0;
    for row in &golden.rows {
        while f64::from(k) * h < row.t - 0.5 * h {
            state = plant
                .step(&state, |_| input, f64::from(k) * h, h)
                .expect("finite");
            k += 1;
        }
        let y = plant.output(&state, &input);
        let errors = [
            largest(&state.zeta, &row.zeta),
            largest(&state.zeta_dot, &row.zeta_dot),
            (y.energy_contact_loss - row.loss).abs() / 100.0,
            largest(&y.contact_force, &row.force) / 1e4,
            (y.contact_penetration - row.depth).abs(),
        ];
        println!("{} s: {errors:?}", row.t);
        assert!(errors.iter().all(|e| *e < 1e-6), "{} s: {errors:?}", row.t);
        touched += usize::from(row.depth > 1e-4);
    }
    assert!(touched > 2, "the tip must touch the plane");
}

/// A plane of 0.7 GN/m with friction that sets in at 50 um/s: a step of 1 ms is divided so that it
/// falls, bounces and slides as with steps of a tenth. The two differ by where in a step the tip
/// touches down and leaves, 1.2e-4 rad in the end; undivided it is 1.6e-2 rad, and 8e-4 rad without
/// the parts that slow sliding needs.
#[test]
fn steps_in_stiff_contact_are_divided() {
    let golden = golden();
    let contact = Contact {
        stiffness: 3000.0 * golden.contact.stiffness,
        slip_velocity: 0.001 * golden.contact.slip_velocity,
        ..golden.contact
    };
    let plant = plant(contact, None);
    let after = |h: f64, steps: u32| {
        let (mut state, input) = golden.beginning();
        for k in 0..steps {
            let t = f64::from(k) * h;
            state = plant.step(&state, |_| input, t, h).expect("finite");
        }
        state
    };
    let (coarse, fine) = (after(1e-3, 600), after(1e-4, 6000));
    let apart = largest(&coarse.zeta, &fine.zeta);
    assert!(apart < 4e-4, "{apart} rad");
    assert!(coarse.contact_loss > 50.0, "{} J", coarse.contact_loss);
}

/// What holds the tip near a point that moves: joint springs and dampers beside the holding forces,
/// N and N·m.
fn drives(plant: &Hdrm, state: &State, wanted: &[f64; DOF]) -> Input {
    let y = plant.output(state, &Input::default());
    let pull = |i: usize, k: f64, d: f64| k * (wanted[i] - state.zeta[i]) - d * state.zeta_dot[i];
    let strokes = plant.tree().configuration(&state.zeta).strokes;
    Input {
        f: std::array::from_fn(|i| y.f_hold[i] + pull(i, 4e5, 6e4) / strokes[i].prime),
        tau_wrist: std::array::from_fn(|j| y.tau_hold[j] + pull(3 + j, 3e3, 600.0)),
        ..Input::default()
    }
}

/// 60 s of pressing on the ground and sliding over it: everything stays finite, the plane never
/// pulls, its losses never shrink, and what the drives work is what the machine gains and the plane
/// takes. Forces are held over a step, so their work is exactly force times travel. Bound: RK4's
/// error at some hundred touch-downs and the friction's reversals, some µJ each.
#[test]
fn pushing_and_sliding_for_a_minute_creates_no_energy() {
    let contact = Contact {
        normal: [0.0, 1.0, 0.0],
        offset: 0.95,
        stiffness: 2e5,
        damping: 2.0,
        friction: 0.4,
        slip_velocity: 0.02,
    };
    let plant = plant(contact, Some([0.0; DOF]));
    let machine = Machine::reference();
    let mut state = State {
        zeta: machine.start.zeta,
        ..State::default()
    };
    let (h, none) = (1e-3, Input::default());
    let energy = |state: &State| {
        let y = plant.output(state, &none);
        y.energy_kinetic + y.energy_potential + y.energy_contact
    };
    let start = energy(&state);
    let (mut work, mut worst, mut touching, mut deepest) = (0.0, 0.0_f64, 0, 0.0_f64);
    for k in 0..60_000_u32 {
        let t = f64::from(k) * h;
        let mut wanted = machine.start.zeta;
        wanted[0] += 0.25 * (0.9 * t).sin();
        wanted[1] -= 0.05 + 0.05 * (0.37 * t).sin();
        wanted[2] += 0.06 * (0.61 * t).sin();
        let input = drives(&plant, &state, &wanted);
        let before = plant.output(&state, &none);
        let next = plant.step(&state, |_| input, t, h).expect("finite");
        let after = plant.output(&next, &none);
        for i in 0..3 {
            work += input.f[i] * (after.x[i] - before.x[i]);
            let tau = input.tau_wrist[i].clamp(
                -machine.limits.tau_wrist_max[i],
                machine.limits.tau_wrist_max[i],
            );
            work += tau * (next.zeta[3 + i] - state.zeta[3 + i]);
        }
        assert!(after.contact_force[1] >= 0.0, "{t} s: the plane pulls");
        assert!(
            next.contact_loss >= state.contact_loss,
            "{t} s: losses shrink"
        );
        state = next;
        let created = energy(&state) + state.contact_loss - start - work;
        worst = worst.max(created.abs());
        touching += usize::from(after.contact_penetration > 0.0);
        deepest = deepest.max(after.contact_penetration);
    }
    println!(
        "in contact {touching} of 60000 ms, to {:.1} mm; work {work:.1} J, lost {:.1} J, balance within {worst:.2e} J",
        1e3 * deepest,
        state.contact_loss
    );
    assert!(touching > 20_000 && touching < 60_000, "{touching}");
    assert!(state.contact_loss > 1000.0);
    assert!(worst < 0.01, "{worst} J of {work} J");
}

/// Without stiffness there is no plane, and no bit changes, wherever it would be.
#[test]
fn without_stiffness_nothing_changes() {
    let [off, none] = [1.9, -900.0].map(|offset| {
        plant(
            Contact {
                offset,
                friction: 0.5,
                ..Contact::default()
            },
            None,
        )
    });
    let mut states = [State {
        zeta: Machine::reference().start.zeta,
        zeta_dot: [0.1, -0.2, 0.1, 0.3, -0.1, 0.2],
        ..State::default()
    }; 2];
    for k in 0..200 {
        let t = f64::from(k) * 1e-3;
        states[0] = off
            .step(&states[0], |_| Input::default(), t, 1e-3)
            .expect("finite");
        states[1] = none
            .step(&states[1], |_| Input::default(), t, 1e-3)
            .expect("finite");
        assert_eq!(states[0], states[1]);
    }
    assert_eq!(states[0].contact_loss, 0.0);
}

/// Output derivatives in contact against differences over 1 µs, whose error is 1e-6 s times the
/// next derivative.
#[test]
fn output_derivatives_hold_in_contact() {
    let contact = Contact {
        normal: [0.2, 1.0, 0.3],
        offset: 1.6,
        stiffness: 2e4,
        damping: 2.0,
        friction: 0.4,
        slip_velocity: 0.1,
    };
    let plant = plant(contact, None);
    let input = Input {
        f: [900.0, 41e3, 31e3],
        base_acceleration: [0.4, -0.3, 0.2],
        base_tilt: [0.1, -0.2],
        ..Input::default()
    };
    let slope = Input {
        f: [3e3, -1e3, 2e3],
        base_acceleration: [0.5, 1.5, -0.7],
        base_tilt: [0.3, 0.2],
        ..Input::default()
    };
    let state = State {
        zeta: [0.31, 0.52, -1.13, 0.41, -0.62, 0.37],
        zeta_dot: [0.11, -0.07, 0.13, 0.3, -0.2, 0.4],
        ..State::default()
    };
    let along = |s: f64| {
        let moved = |a: f64, b: f64| a + s * b;
        Input {
            f: std::array::from_fn(|i| moved(input.f[i], slope.f[i])),
            base_acceleration: std::array::from_fn(|i| {
                moved(input.base_acceleration[i], slope.base_acceleration[i])
            }),
            base_tilt: std::array::from_fn(|i| moved(input.base_tilt[i], slope.base_tilt[i])),
            ..input
        }
    };
    let rate = plant.output_derivative(&state, &input, &slope);
    let h = 1e-6;
    let after = plant.step(&state, along, 0.0, h).expect("finite");
    let [y0, y1] = [
        plant.output(&state, &input),
        plant.output(&after, &along(h)),
    ];
    assert!(y0.contact_penetration > 1e-3, "{}", y0.contact_penetration);
    let near = |name: &str, a: f64, b: f64, rate: f64, scale: f64| {
        let slope = (b - a) / h;
        assert!(
            (slope - rate).abs() < 1e-4 * (scale + rate.abs()),
            "{name}: {slope} {rate}"
        );
    };
    for i in 0..3 {
        near(
            "force",
            y0.contact_force[i],
            y1.contact_force[i],
            rate.contact_force[i],
            1e3,
        );
        near("f_hold", y0.f_hold[i], y1.f_hold[i], rate.f_hold[i], 1e3);
        near(
            "zeta_ddot",
            y0.zeta_ddot[i],
            y1.zeta_ddot[i],
            rate.zeta_ddot[i],
            10.0,
        );
    }
    near(
        "depth",
        y0.contact_penetration,
        y1.contact_penetration,
        rate.contact_penetration,
        1.0,
    );
    near(
        "elastic",
        y0.energy_contact,
        y1.energy_contact,
        rate.energy_contact,
        100.0,
    );
    near(
        "loss",
        y0.energy_contact_loss,
        y1.energy_contact_loss,
        rate.energy_contact_loss,
        100.0,
    );
    near(
        "kinetic",
        y0.energy_kinetic,
        y1.energy_kinetic,
        rate.energy_kinetic,
        1e3,
    );
    near(
        "potential",
        y0.energy_potential,
        y1.energy_potential,
        rate.energy_potential,
        1e3,
    );
}
