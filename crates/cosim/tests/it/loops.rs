//! Algebraic loops that are solved.

use cosim::master::{Master, Schedule};
use cosim::system::System;

use super::support::{link, oscillator_links, settings, ssd, stepping, system};

const SCHEDULES: [Schedule; 2] = [Schedule::Jacobi, Schedule::GaussSeidel];

/// A spring of mass `m_s` that moves with its end: its force depends on the acceleration, which
/// depends on its force.
fn with_loop(name: &str, acceleration: &str) -> System {
    let back = link(("mass", "x_ddot"), ("spring", "x_ddot"), acceleration);
    let structure = ssd(&(oscillator_links("", "", "") + &back));
    let mut system = system(name, &structure).unwrap();
    system.structure.solves_loops = true;
    system
}

fn started(system: &System, texts: &[&str], schedule: Schedule) -> anyhow::Result<Master> {
    Master::new(system, &settings(system, texts)?, stepping(0.01, schedule))
}

/// `F = −k x − d v − m_s F/m`, so `F = −(k x + d v)/(1 + m_s/m)`: to 1e-12 at every point, also
/// where `m_s` is so much larger than `m` that passing values again and again would not converge.
#[test]
fn two_fmus_with_feedthrough_meet_the_closed_form() {
    let system = with_loop("loop", "");
    for schedule in SCHEDULES {
        for (m, m_s) in [(2.0, 0.5), (0.5, 20.0)] {
            let texts = [format!("mass.m={m}"), format!("spring.m={m_s}")];
            let [m_text, s_text] = texts.each_ref().map(String::as_str);
            let texts = [m_text, s_text, "spring.k=23", "spring.d=0.7"];
            let mut master = started(&system, &texts, schedule).unwrap();
            for _ in 0..100 {
                let [x, v, force, a] = ["mass.x", "mass.x_dot", "spring.F", "mass.x_ddot"]
                    .map(|name| master.number(system.port(name).unwrap()).unwrap());
                let exact = -(23.0 * x + 0.7 * v) / (1.0 + m_s / m);
                assert!((force - exact).abs() <= 1e-12 * 23.0, "{force} {exact}");
                assert!((a - exact / m).abs() <= 1e-12 * 23.0 / m, "{a}");
                master.step().unwrap();
            }
        }
    }
}

/// `F = −k x + F`: no solution. It is told with the names, and unsolved loops are refused as before.
#[test]
fn a_loop_without_a_solution_is_named() {
    let negated = "<ssc:LinearTransformation factor=\"-1\"/>";
    let mut system = with_loop("loop_without", negated);
    for schedule in SCHEDULES {
        let error = started(&system, &["mass.m=2", "spring.m=2"], schedule)
            .err()
            .unwrap();
        let text = format!("{error:#}");
        for part in [
            "algebraic loop in initialization",
            "`spring.F` is",
            "`mass.x_ddot` is",
            "no solution",
        ] {
            assert!(text.contains(part), "`{part}` is missing in: {text}");
        }
    }
    system.structure.solves_loops = false;
    let error = started(&system, &[], Schedule::Jacobi).err().unwrap();
    assert!(format!("{error:#}").contains("--solve-loops"), "{error:#}");
}
