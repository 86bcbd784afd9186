//! Algebraic loops that are solved.

use cosim::master::{Master, Schedule};
use cosim::structure::system::System;
use fmi_description::Version;

use super::support::{assert_contains, edited_of, link, oscillator_links, settings, ssd, stepping};

pub const SCHEDULES: [Schedule; 2] = [Schedule::Jacobi, Schedule::GaussSeidel];
const VERSIONS: [Version; 2] = [Version::Fmi2, Version::Fmi3];

/// A spring of mass `m_s` that moves with its end: its force depends on the acceleration, which
/// depends on its force. `edit` changes the model descriptions.
fn edited_loop(
    version: Version,
    name: &str,
    acceleration: &str,
    edit: impl Fn(&str, &str) -> String,
) -> System {
    let back = link(("mass", "x_ddot"), ("spring", "x_ddot"), acceleration);
    let structure = ssd(&(oscillator_links("", "", "") + &back));
    let name = format!("{name}_{version:?}");
    let mut system = edited_of(version, &name, &structure, edit).unwrap();
    system.structure.solves_loops = true;
    system
}

/// A description that says something else about directional derivatives.
fn changed(text: &str, values: [&str; 2]) -> String {
    let said = ["", "s"]
        .map(|end| values.map(|value| format!("providesDirectionalDerivative{end}=\"{value}\"")));
    said.iter()
        .fold(text.to_string(), |text, [from, to]| text.replace(from, to))
}

fn with_loop(version: Version, name: &str, acceleration: &str) -> System {
    edited_loop(version, name, acceleration, |_, text| text.to_string())
}

pub fn started(system: &System, texts: &[&str], schedule: Schedule) -> anyhow::Result<Master> {
    Master::new(system, &settings(system, texts)?, stepping(H, schedule))
}

const H: f64 = 0.01;

pub fn numbers<const N: usize>(system: &System, master: &Master, names: [&str; N]) -> [f64; N] {
    names.map(|name| master.number(system.port(name).unwrap()).unwrap())
}

const MOTION_AND_LOOP: [&str; 4] = ["mass.x", "mass.x_dot", "spring.F", "mass.x_ddot"];

/// A light and a heavy spring: passing values again and again would not converge for the second.
fn with_masses(mut of: impl FnMut(f64, f64, &[&str])) {
    for (m, m_s) in [(2.0, 0.5), (0.5, 20.0)] {
        let texts = [format!("mass.m={m}"), format!("spring.m={m_s}")];
        let [m_text, s_text] = texts.each_ref().map(String::as_str);
        of(m, m_s, &[m_text, s_text, "spring.k=23", "spring.d=0.7"]);
    }
}

#[track_caller]
fn assert_solved([force, a]: [f64; 2], exact: f64, m: f64) {
    assert!((force - exact).abs() <= 1e-12 * 23.0, "{force} {exact}");
    assert!((a - exact / m).abs() <= 1e-12 * 23.0 / m, "{a}");
}

/// `F = −k x − d v − m_s F/m`, so `F = −(k x + d v)/(1 + m_s/m)`: to 1e-12 at every point. What the
/// mass does with the force its directional derivatives say, unless its description has none; of
/// the spring there are differences. FMI 3.0 is in Event Mode.
#[test]
fn two_fmus_with_feedthrough_meet_the_closed_form() {
    let without = |_: &str, text: &str| changed(text, ["true", "false"]);
    for version in VERSIONS {
        let system = with_loop(version, "loop", "");
        let differences = edited_loop(version, "loop_differences", "", without);
        for (system, has) in [(&system, true), (&differences, false)] {
            let found = &system.fmus[1].description.capabilities;
            assert_eq!(found.directional_derivatives, has);
            for schedule in SCHEDULES {
                with_masses(|m, m_s, texts| {
                    let mut master = started(system, texts, schedule).unwrap();
                    for _ in 0..100 {
                        let [x, v, solved @ ..] = numbers(system, &master, MOTION_AND_LOOP);
                        let exact = -(23.0 * x + 0.7 * v) / (1.0 + m_s / m);
                        assert_solved(solved, exact, m);
                        master.step().unwrap();
                    }
                });
            }
        }
    }
}

/// A spring that says it has directional derivatives is asked for them, and its refusal told.
#[test]
fn directional_derivatives_are_asked_for_where_there_are_some() {
    for (version, call) in [
        (Version::Fmi2, "fmi2GetDirectionalDerivative of F"),
        (Version::Fmi3, "fmi3GetDirectionalDerivative of F"),
    ] {
        let claims = |_: &str, text: &str| changed(text, ["false", "true"]);
        let system = edited_loop(version, "loop_claimed", "", claims);
        let error = started(&system, &["spring.m=1"], Schedule::Jacobi).err();
        let text = format!("{:#}", error.unwrap());
        assert!(text.contains(call), "{text}");
    }
}

/// With the schedule `standard` a step is repeated from saved states. Where the motion does not
/// belong to the loop, it is that of the point before, `F = −(k x_k + d v_k)/(1 + m_s/m)`; where
/// nobody declares dependencies all belongs to it: `F = −(k x + d v)/(1 + m_s/m)` at the end of a
/// step over which that very force has moved the mass.
#[test]
fn repeated_steps_meet_the_closed_form() {
    let undeclared = |_: &str, text: &str| {
        let parts = text.split(" dependencies=\"").enumerate();
        let rest = parts.map(|(k, part)| match k {
            0 => part,
            _ => part.split_once('"').unwrap().1,
        });
        rest.collect::<String>()
    };
    for version in VERSIONS {
        let declared = with_loop(version, "loop_steps", "");
        let undeclared = edited_loop(version, "loop_steps_undeclared", "", undeclared);
        for (system, is_declared) in [(&declared, true), (&undeclared, false)] {
            with_masses(|m, m_s, texts| {
                let mut master = started(system, texts, Schedule::Standard).unwrap();
                for _ in 0..100 {
                    let [x, v, ..] = numbers(system, &master, MOTION_AND_LOOP);
                    master.step().unwrap();
                    let [end, v_end, solved @ ..] = numbers(system, &master, MOTION_AND_LOOP);
                    let a = solved[0] / m;
                    assert!((v_end - v - H * a).abs() < 1e-12 && (end - x).abs() < 1.0);
                    let (x, v) = if is_declared { (x, v) } else { (end, v_end) };
                    assert_solved(solved, -(23.0 * x + 0.7 * v) / (1.0 + m_s / m), m);
                }
            });
        }
    }
    let cannot = |_: &str, text: &str| {
        text.replace("canGetAndSetFMUstate=\"true\"", "")
            .replace("canSerializeFMUstate=\"true\"", "")
    };
    let system = edited_loop(Version::Fmi2, "loop_unsaved", "", cannot);
    let error = started(&system, &[], Schedule::Standard).err().unwrap();
    let text = format!("{error:#}");
    assert_contains(
        &text,
        &["repeated steps", "spring (FMU", "cannot save its state"],
    );
}

/// `F = −k x + F`: no solution. It is told with the names, and unsolved loops are refused as before.
#[test]
fn a_loop_without_a_solution_is_named() {
    let negated = "<ssc:LinearTransformation factor=\"-1\"/>";
    let mut system = with_loop(Version::Fmi2, "loop_without", negated);
    for schedule in SCHEDULES {
        let error = started(&system, &["mass.m=2", "spring.m=2"], schedule)
            .err()
            .unwrap();
        let text = format!("{error:#}");
        assert_contains(
            &text,
            &[
                "algebraic loop in initialization",
                "after 0 iterations",
                "`spring.F` is",
                "`mass.x_ddot` is",
                "no solution",
            ],
        );
    }
    system.structure.solves_loops = false;
    let error = started(&system, &[], Schedule::Jacobi).err().unwrap();
    assert!(format!("{error:#}").contains("--solve-loops"), "{error:#}");
}
