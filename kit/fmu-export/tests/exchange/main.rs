//! Model Exchange in both versions of FMI, called as an importer calls it: by C name, through
//! pointers that are valid for the number beside them.
#![allow(missing_docs, clippy::undocumented_unsafe_blocks)]

mod client;
mod model;
mod order;
mod random;
#[path = "../border/xorshift.rs"]
mod xorshift;

use client::*;
use fmu_export::{Model, check, model_description, model_description3};
use model::{Ball, GRAVITY, KICK};
use std::ptr;

/// Value references: of a vector, that of its first element.
pub mod vr {
    pub const RESTITUTION: u32 = 0;
    pub const WIND: u32 = 4;
    pub const KICK: u32 = 6;
    pub const FAULT: u32 = 7;
    pub const POSITION: u32 = 8;
    pub const VELOCITY: u32 = 10;
    pub const BOUNCES: u32 = 12;
    pub const ENERGY: u32 = 14;
    pub const DER_POSITION: u32 = 15;
    pub const DER_VELOCITY: u32 = 17;
    pub const FLOOR: u32 = 19;
}

const DRAG: f64 = 0.5;
const RESTITUTION: f64 = 0.75;
const H: f64 = 1.0 / 512.0;

/// Where a ball flies within `t` s, from position and velocity: of v' = k (w − v) − g.
fn flight(x: [f64; 4], wind: [f64; 2], t: f64) -> [f64; 4] {
    let end = [wind[0], wind[1] - GRAVITY / DRAG];
    let gone = -(-DRAG * t).exp_m1();
    let [px, py, vx, vy] = x;
    let rest = [vx - end[0], vy - end[1]];
    [
        px + end[0] * t + rest[0] * gone / DRAG,
        py + end[1] * t + rest[1] * gone / DRAG,
        vx - rest[0] * gone,
        vy - rest[1] * gone,
    ]
}

/// When it falls on the floor, s.
fn fall(x: [f64; 4], wind: [f64; 2]) -> f64 {
    let (mut low, mut high) = (1e-6, 10.0);
    while high - low > 1e-14 {
        let middle = 0.5 * (low + high);
        *if flight(x, wind, middle)[1] > 0.0 {
            &mut low
        } else {
            &mut high
        } = middle;
    }
    high
}

/// A step of the importer's own Runge–Kutta method, from `t` and the states `x`.
fn step(fmu: &Fmu, t: f64, x: [f64; 4], h: f64) -> [f64; 4] {
    let rate = |s: f64, x: [f64; 4]| {
        assert_eq!(fmu.set_time(t + s), 0, "{}", fmu.last());
        assert_eq!(fmu.set_states(&x), 0, "{}", fmu.last());
        fmu.derivatives()
    };
    let plus = |x: [f64; 4], h: f64, k: [f64; 4]| [0, 1, 2, 3].map(|i| x[i] + h * k[i]);
    let a = rate(0.0, x);
    let b = rate(0.5 * h, plus(x, 0.5 * h, a));
    let c = rate(0.5 * h, plus(x, 0.5 * h, b));
    let d = rate(h, plus(x, h, c));
    let end = plus(
        plus(plus(plus(x, h / 6.0, a), h / 3.0, b), h / 3.0, c),
        h / 6.0,
        d,
    );
    assert_eq!([fmu.set_time(t + h), fmu.set_states(&end)], [0, 0]);
    end
}

/// Integrates from `t` until the ball has just reached the floor, or until `end`: the time.
fn fly(fmu: &Fmu, mut t: f64, end: f64) -> f64 {
    while t < end {
        let (before, h) = (fmu.states(), H.min(end - t));
        step(fmu, t, before, h);
        if fmu.floor() <= 0.0 {
            let (mut low, mut high) = (0.0, h);
            while high - low > 1e-13 {
                let middle = 0.5 * (low + high);
                step(fmu, t, before, middle);
                *if fmu.floor() > 0.0 {
                    &mut low
                } else {
                    &mut high
                } = middle;
            }
            step(fmu, t, before, high);
            assert_eq!(fmu.completed(), [false; 2]);
            return t + high;
        }
        assert_eq!(fmu.completed(), [false; 2]);
        t += h;
    }
    end
}

/// Oracle: the closed form of each flight. The importer's method of order 4 misses it by less than
/// (k h)⁴/120 of it, 1e-14, besides rounding of 1000 steps: 1e-12. An event is located to 1e-13 s.
#[test]
fn an_importer_integrates_and_finds_the_events() {
    let results = [2, 3].map(|version| {
        let fmu = Fmu::new(version);
        let wind = [1.5, -0.25];
        assert_eq!(fmu.set(vr::WIND, &wind), 0);
        fmu.initialize();
        let told = fmu.update();
        assert_eq!(
            told,
            Told {
                next: Some(KICK),
                ..Told::default()
            }
        );
        assert_eq!(
            fmu.call([fmi2EnterContinuousTimeMode, fmi3EnterContinuousTimeMode]),
            0
        );
        let x = [0.0, 1.0, 3.0, 0.5];
        assert_eq!((fmu.states(), fmu.floor()), (x, 1.0));
        let near = |found: [f64; 4], exact: [f64; 4]| {
            let error = (0..4)
                .map(|i| (found[i] - exact[i]).abs())
                .fold(0.0, f64::max);
            assert!(error < 1e-11, "{found:?} {exact:?}");
        };
        let t = fly(&fmu, 0.0, KICK);
        let exact = fall(x, wind);
        assert!((t - exact).abs() < 1e-11, "{t} {exact}");
        near(fmu.states(), flight(x, wind, t));
        let told = fmu.event();
        assert_eq!(
            told,
            Told {
                moved: true,
                next: Some(KICK),
                ..Told::default()
            }
        );
        let mut x = fmu.states();
        assert!((x[3] + RESTITUTION * flight([0.0, 1.0, 3.0, 0.5], wind, t)[3]).abs() < 1e-11);
        assert_eq!(fmu.integer(vr::BOUNCES), 1);
        // The kick is a discrete input, which is set in Event Mode.
        assert_eq!(fly(&fmu, t, KICK), KICK);
        x = flight(x, wind, KICK - t);
        near(fmu.states(), x);
        assert_eq!(fmu.call([fmi2EnterEventMode, fmi3EnterEventMode]), 0);
        assert_eq!(fmu.set(vr::KICK, &[2.25]), 0);
        assert_eq!(
            fmu.update(),
            Told {
                moved: true,
                ..Told::default()
            }
        );
        assert_eq!(fmu.update(), Told::default());
        assert_eq!(
            fmu.call([fmi2EnterContinuousTimeMode, fmi3EnterContinuousTimeMode]),
            0
        );
        x[2] += 2.25;
        near(fmu.states(), x);
        // What is computed is there as variables too.
        let rates = fmu.derivatives();
        assert_eq!(
            [fmu.get::<2>(vr::DER_POSITION), fmu.get(vr::DER_VELOCITY)].concat(),
            rates
        );
        assert_eq!(
            [fmu.get::<2>(vr::POSITION), fmu.get(vr::VELOCITY)].concat(),
            fmu.states()
        );
        assert_eq!(fmu.get(vr::FLOOR), [fmu.floor()]);
        let energy = 0.5 * (x[2] * x[2] + x[3] * x[3]) + GRAVITY * x[1];
        assert!((fmu.get::<1>(vr::ENERGY)[0] - energy).abs() < 1e-10);
        // A continuous input acts at once.
        assert_eq!(fmu.set(vr::WIND, &[0.0, 4.0]), 0);
        let state = fmu.states();
        assert_eq!(fmu.derivatives()[3], DRAG * (4.0 - state[3]) - GRAVITY);
        [fmu.states(), fmu.derivatives()]
            .concat()
            .iter()
            .map(|x| x.to_bits())
            .collect::<Vec<_>>()
    });
    assert_eq!(results[0], results[1], "FMI 2.0 and FMI 3.0 differ");
}

/// Oracle: the closed form, as above; the solver has steps of 1 ms. Beyond the event the states are
/// those of order 3 within one of them, (k h)³/24 of its 10 mm: 5e-14.
#[test]
fn co_simulation_finds_the_same_events() {
    let fmu = Fmu::of(2, 1);
    fmu.initialize();
    for k in 0..6 {
        let h = 0.125;
        assert_eq!(
            unsafe { fmi2DoStep(fmu.c, f64::from(k) * h, h, 0) },
            0,
            "{}",
            fmu.last()
        );
    }
    let mut x = [0.0, 1.0, 3.0, 0.5];
    let t = fall(x, [0.0; 2]);
    x = flight(x, [0.0; 2], t);
    x[3] *= -RESTITUTION;
    let exact = flight(x, [0.0; 2], 0.75 - t);
    let found = [fmu.get::<2>(vr::POSITION), fmu.get(vr::VELOCITY)].concat();
    let error = (0..4)
        .map(|i| (found[i] - exact[i]).abs())
        .fold(0.0, f64::max);
    assert!(error < 1e-11, "{found:?} {exact:?}");
    assert_eq!(fmu.integer(vr::BOUNCES), 1);
}

#[test]
fn wrong_numbers_are_refused_and_nothing_changes() {
    for version in [2, 3] {
        let fmu = Fmu::running(version);
        let before = fmu.bytes();
        let names =
            [["nx", "ni"], ["nContinuousStates", "nEventIndicators"]][usize::from(version - 2)];
        let refused = |status, text: &str| {
            let last = fmu.last();
            assert!(status != 0 && last.ends_with(text), "{last}\n{text}");
        };
        let [states, indicators] = names;
        refused(
            fmu.set_states(&[1.0; 3]),
            &format!("{states} = 3 must be 4, the number of continuous states"),
        );
        let wrong = fmu
            .try_read::<5>([fmi2GetDerivatives, fmi3GetContinuousStateDerivatives])
            .unwrap_err();
        assert!(
            wrong.ends_with(&format!(
                "{states} = 5 must be 4, the number of continuous states"
            )),
            "{wrong}"
        );
        let wrong = fmu
            .try_read::<2>([fmi2GetEventIndicators, fmi3GetEventIndicators])
            .unwrap_err();
        assert!(
            wrong.ends_with(&format!(
                "{indicators} = 2 must be 1, the number of event indicators"
            )),
            "{wrong}"
        );
        refused(
            fmu.set_states(&[1.0, 2.0, 3.0, f64::NAN]),
            "state `velocity[2]` = NaN must be finite",
        );
        refused(
            fmu.set_time(f64::INFINITY),
            "time = inf s must be finite and at least 0 s, the time of the last event",
        );
        refused(
            fmu.set_time(-1e-9),
            "time = -0.000000001 s must be finite and at least 0 s, the time of the last event",
        );
        refused(
            fmu.set(vr::KICK, &[1.0]),
            "in Continuous-Time Mode only continuous inputs can be set",
        );
        refused(
            fmu.set(vr::RESTITUTION, &[1.0]),
            "in Continuous-Time Mode only continuous inputs can be set",
        );
        refused(
            fmu.set(vr::DER_POSITION, &[1.0, 1.0]),
            "in Continuous-Time Mode only continuous inputs can be set",
        );
        refused(fmu.set(vr::WIND, &[f64::NAN, 1.0]), "must be finite");
        assert!(fmu.bytes() == before, "something has changed");
        let nominals = fmu.try_read([
            fmi2GetNominalsOfContinuousStates,
            fmi3GetNominalsOfContinuousStates,
        ]);
        assert_eq!(nominals, Ok([2.0, 2.0, 1.0, 1.0]));
    }
}

#[test]
fn a_model_that_cannot_compute_says_so_and_goes_on() {
    for version in [2, 3] {
        let fmu = Fmu::running(version);
        let derivatives =
            || fmu.try_read::<4>([fmi2GetDerivatives, fmi3GetContinuousStateDerivatives]);
        let (before, saved) = (derivatives(), fmu.save());
        for (fault, text) in [
            (30, "`der(velocity[2])` became NaN; it must be finite"),
            (20, "asked for"),
        ] {
            assert_eq!(fmu.call([fmi2EnterEventMode, fmi3EnterEventMode]), 0);
            assert_eq!(fmu.set_integer(vr::FAULT, fault), 0);
            let error = derivatives().unwrap_err();
            assert!(error.contains(text), "{error}");
            assert_eq!(
                fmu.call([fmi2EnterContinuousTimeMode, fmi3EnterContinuousTimeMode]) == 0,
                fault == 30
            );
        }
        // A panic loses the instance, until a state is restored. Another instance goes on.
        assert!(fmu.set_time(0.1) != 0);
        assert_eq!(Fmu::running(version).derivatives(), before.clone().unwrap());
        assert_eq!(fmu.restore(saved), 0);
        assert_eq!(derivatives(), before);
    }
}

#[test]
fn states_are_saved_and_belong_to_the_interface() {
    for version in [2, 3] {
        let fmu = Fmu::running(version);
        step(&fmu, 0.0, fmu.states(), 0.125);
        let (states, bytes) = (fmu.states(), fmu.bytes());
        let saved = fmu.save();
        let course = || {
            fly(&fmu, 0.125, KICK);
            let told = fmu.event();
            (
                told,
                fmu.states().map(f64::to_bits),
                fmu.integer(vr::BOUNCES),
            )
        };
        let first = course();
        assert_eq!(fmu.restore(saved), 0);
        assert_eq!(fmu.states(), states);
        assert_eq!(course(), first);
        // In another instance, straight after instantiation.
        let other = Fmu::new(version);
        let read = other.deserialize(&bytes).unwrap();
        assert_eq!(other.restore(read), 0);
        assert_eq!(
            (other.states(), other.derivatives()[3]),
            (states, -DRAG * states[3] - GRAVITY)
        );
        assert_eq!(
            other.set_time(0.25),
            0,
            "in Continuous-Time Mode: {}",
            other.last()
        );
    }
    let [exchange, stepping] = [0, 1].map(|kind| Fmu::of(2, kind));
    let error = stepping.deserialize(&exchange.bytes()).unwrap_err();
    let text =
        "serialized state is of an instance of FMI 2.0 for Model Exchange; it must be of FMI 2.0";
    assert!(error.ends_with(text), "{error}");
}

/// Oracle: the equations' Jacobian. Central differences of ∛ε of the nominal values err by ε^⅔.
#[test]
fn derivatives_of_derivatives_are_those_of_the_equations() {
    let unknowns = [vr::DER_POSITION, vr::DER_VELOCITY, vr::ENERGY, vr::FLOOR];
    for version in [2, 3] {
        let fmu = Fmu::running(version);
        let x = [0.25, 1.5, -2.0, 3.0];
        assert_eq!(fmu.set_states(&x), 0);
        // Along these: x by 0.5 and −1, v by 2 and 0.25, the wind by 3 and −4.
        let (seed, expected) = (
            [0.5, -1.0, 2.0, 0.25, 3.0, -4.0],
            [
                2.0,
                0.25,
                DRAG * (3.0 - 2.0),
                DRAG * (-4.0 - 0.25),
                -GRAVITY + x[2] * 2.0 + x[3] * 0.25,
                -1.0,
            ],
        );
        let mut found = [f64::NAN; 6];
        let status = if version == 2 {
            let unknowns = [15, 16, 17, 18, 14, 19];
            let knowns = [8, 9, 10, 11, 4, 5];
            unsafe {
                fmi2GetDirectionalDerivative(
                    fmu.c,
                    unknowns.as_ptr(),
                    6,
                    knowns.as_ptr(),
                    6,
                    seed.as_ptr(),
                    found.as_mut_ptr(),
                )
            }
        } else {
            let knowns = [vr::POSITION, vr::VELOCITY, vr::WIND];
            unsafe {
                fmi3GetDirectionalDerivative(
                    fmu.c,
                    unknowns.as_ptr(),
                    4,
                    knowns.as_ptr(),
                    3,
                    seed.as_ptr(),
                    6,
                    found.as_mut_ptr(),
                    6,
                )
            }
        };
        assert_eq!(status, 0, "{}", fmu.last());
        let error = (0..6)
            .map(|i| (found[i] - expected[i]).abs())
            .fold(0.0, f64::max);
        assert!(error < 1e-8, "{found:?} {expected:?}");
        if version == 3 {
            let weights = [1.0, 2.0, -0.5, 0.75, 1.5, 0.25];
            let mut adjoint = [f64::NAN; 6];
            let knowns = [vr::POSITION, vr::VELOCITY, vr::WIND];
            let status = unsafe {
                fmi3GetAdjointDerivative(
                    fmu.c,
                    unknowns.as_ptr(),
                    4,
                    knowns.as_ptr(),
                    3,
                    weights.as_ptr(),
                    6,
                    adjoint.as_mut_ptr(),
                    6,
                )
            };
            assert_eq!(status, 0, "{}", fmu.last());
            let [forward, backward] = [(&weights[..], &expected[..]), (&adjoint[..], &seed[..])]
                .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>());
            assert!((forward - backward).abs() < 1e-7, "{forward} {backward}");
        }
        let mut result = 0.0;
        if version == 2 {
            let status = unsafe {
                fmi2GetDirectionalDerivative(fmu.c, &15, 1, &vr::ENERGY, 1, &1.0, &mut result)
            };
            assert!(
                status != 0
                    && fmu
                        .last()
                        .ends_with("it must be a Real input or a continuous state"),
                "{}",
                fmu.last()
            );
        }
        assert_eq!((fmu.states(), result), (x, 0.0));
    }
}

#[test]
fn the_description_says_what_there_is() {
    assert_eq!(check::<Ball>(), [""; 0]);
    assert!(<Ball as Model>::MODEL_EXCHANGE.is_some());
    let [two, three] = [
        model_description::<Ball>().unwrap(),
        model_description3::<Ball>().unwrap(),
    ];
    for (xml, parts) in [
        (
            &two,
            &[
                r#" numberOfEventIndicators="1""#,
                r#"<ModelExchange modelIdentifier="Ball""#,
                r#"<ScalarVariable name="der(velocity[2])" valueReference="18" description="Time derivative" causality="local" variability="continuous" initial="calculated">"#,
                r#"<Real unit="m/s2" derivative="12"/>"#,
                // 1-based: position 9, 10; velocity 11, 12; energy 15; their derivatives 16 to 19; wind 5, 6; fault 8.
                r#"<Unknown index="16" dependencies="11"/>"#,
                r#"<Unknown index="19" dependencies="6 8 12"/>"#,
                r#"<Unknown index="10" dependencies="10"/>"#,
                r#"<Unknown index="13" dependencies=""/>"#,
                r#"<Unknown index="15" dependencies="10 11 12"/>"#,
            ][..],
        ),
        (
            &three,
            &[
                r#"<ModelExchange modelIdentifier="Ball""#,
                r#"name="der(velocity)" valueReference="17""#,
                r#"unit="m/s2" derivative="10""#,
                r#"<ContinuousStateDerivative valueReference="17" dependencies="4 7 10" dependenciesKind="dependent dependent dependent"/>"#,
                r#"<EventIndicator valueReference="19" dependencies="8" dependenciesKind="dependent"/>"#,
                r#"<InitialUnknown valueReference="10""#,
            ],
        ),
    ] {
        for part in parts {
            assert!(xml.contains(part), "{part}\n{xml}");
        }
        assert!(xml.find("<ModelExchange") < xml.find("<CoSimulation"));
    }
    let fmu = Fmu::new(3);
    let (mut states, mut indicators) = (0, 0);
    unsafe {
        assert_eq!(fmi3GetNumberOfContinuousStates(fmu.c, &mut states), 0);
        assert_eq!(fmi3GetNumberOfEventIndicators(fmu.c, &mut indicators), 0);
        assert!(fmi3GetNumberOfContinuousStates(fmu.c, ptr::null_mut()) != 0);
    }
    assert_eq!((states, indicators), (4, 1));
}
