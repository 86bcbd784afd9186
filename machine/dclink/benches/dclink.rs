//! Cost of a step of 1 ms: `cargo bench -p dclink`.

#[path = "../../../tools/benches/measure.rs"]
mod measure;

use dclink::{DcLink, Input, Params};
use std::hint::black_box;

fn main() {
    let bench = measure::Bench::from_arguments();
    let link = DcLink::new(Params::REFERENCE).expect("valid");
    let u = Input {
        i_load: [3.0, 4.0, -1.5],
        T_ambient: 293.15,
    };
    let mut s = link.start(&u);
    bench.call("step of 1 ms", || {
        s = link.step(&s, black_box(&u), 0.0, 1e-3).expect("finite");
        s.soc = 0.8; // or the pack would be empty before the end
        black_box(link.output(&s));
    });
}
