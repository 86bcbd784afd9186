//! A communication step of the master allocates nothing.
//!
//! This counts the allocations of this program; the FMUs have an allocator of their own, which the
//! tests of their crates watch.

use allocation_counter::measure;
use cosim::exchange::faults::Faults;
use cosim::master::{Master, Schedule, Stepping};
use cosim::schedule::Between;
use cosim::structure::system::System;

use super::support::{link, oscillator_links, settings, ssd, stepping, system};

#[test]
fn a_step_allocates_nothing() {
    let scaled = "<ssc:LinearTransformation factor=\"2\"/>";
    let links = oscillator_links(scaled, "", "")
        + &link(("mass", "is_left"), ("spring", "off"), "")
        + &link(("mass", "steps"), ("spring", "stage"), "");
    let system = system("allocation", &ssd(&links)).unwrap();
    for schedule in [
        Schedule::Standard,
        Schedule::GaussSeidel,
        Schedule::Jacobi,
        Schedule::JacobiDerivatives,
    ] {
        for threads in [1, 2] {
            stepped(&system, stepping(1e-3, schedule), threads);
        }
    }
    let between = Between::Balanced;
    for schedule in [Schedule::Standard, Schedule::GaussSeidel] {
        let stepping = stepping(1e-3, schedule);
        stepped(
            &system,
            Stepping {
                between,
                ..stepping
            },
            1,
        );
    }
    let links = oscillator_links("", "", "") + &link(("mass", "x_ddot"), ("spring", "x_ddot"), "");
    let mut solved = super::support::system("allocation_loop", &ssd(&links)).unwrap();
    solved.structure.solves_loops = true;
    let settings = settings(&solved, &["spring.m=0.5"]).unwrap();
    let jacobi = stepping(1e-3, Schedule::Jacobi);
    let mut master = Master::new(&solved, &settings, jacobi).unwrap();
    let steps = measure(|| (0..100).for_each(|_| master.step().unwrap()));
    assert_eq!(steps.count_total, 0, "with a loop");
}

fn stepped(system: &System, stepping: Stepping, threads: usize) {
    let mut master = None;
    let start = measure(|| {
        master = Some(Master::with_threads(system, &[], stepping, threads).unwrap());
    });
    assert_ne!(start.count_total, 0, "the counter counts");
    let mut master = master.expect("made");
    let mut faults = Faults::default();
    for effect in [
        "bias:1e-9",
        "gain:1",
        "freeze@2",
        "drop:0.5",
        "delay:0.01",
        "noise:1e-9",
    ] {
        faults.add(system, &format!("spring.x={effect}")).unwrap();
    }
    faults.add(system, "mass.f=delay:0.001").unwrap();
    master.apply_faults(system, &faults).unwrap();
    // Buffers that go between threads are made once.
    (0..5).for_each(|_| master.step().unwrap());
    let steps = measure(|| (0..100).for_each(|_| master.step().unwrap()));
    assert_eq!(steps.count_total, 0, "{stepping:?}, {threads} threads");
}
