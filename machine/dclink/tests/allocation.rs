//! A step needs no heap, events included.

use dclink::{DcLink, Input, Params};

#[test]
fn a_step_does_not_allocate() {
    let mut p = Params::REFERENCE;
    p.battery.soc_start = 1.0; // full: the chopper works
    let link = DcLink::new(p).expect("valid");
    let u = Input {
        i_load: [-20.0, -10.0, 3.0],
        T_ambient: 293.15,
    };
    let mut s = link.start(&u);
    let mut switched = 0;
    let used = allocation_counter::measure(|| {
        for _ in 0..1000 {
            let next = link.step(&s, &u, 0.0, 1e-3).expect("finite");
            switched += u32::from(next.mode.braking != s.mode.braking);
            s = next;
            std::hint::black_box(link.output(&s));
        }
    });
    assert_eq!(used.count_total, 0);
    assert!(switched > 10, "{switched}");
}
