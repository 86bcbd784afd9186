//! A communication step of the master allocates nothing.
//!
//! This counts the allocations of this program; the FMUs have an allocator of their own, which the
//! tests of their crates watch.

use allocation_counter::measure;
use cosim::faults::Faults;
use cosim::master::{Master, Schedule};

use super::support::{link, oscillator_links, ssd, stepping, system};

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
        let mut master = None;
        let start = measure(|| {
            master = Some(Master::new(&system, &[], stepping(1e-3, schedule)).unwrap());
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
            faults.add(&system, &format!("spring.x={effect}")).unwrap();
        }
        faults.add(&system, "mass.f=delay:0.001").unwrap();
        master.alter(&system, &faults).unwrap();
        let steps = measure(|| (0..100).for_each(|_| master.step().unwrap()));
        assert_eq!(steps.count_total, 0, "{schedule:?}");
    }
}
