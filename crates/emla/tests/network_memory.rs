//! The shipped network is compiled in: having it takes no memory. One that was read is shared by its clones.

use allocation_counter::measure;
use emla::Surrogate;

#[test]
fn the_shipped_network_takes_no_memory_and_a_read_one_is_shared() {
    let counted = measure(|| drop(Surrogate::reference().clone()));
    assert_eq!(counted.count_total, 0, "{} bytes", counted.bytes_total);
    let read = Surrogate::from_json(&Surrogate::reference().to_json()).expect("valid");
    let counted = measure(|| drop(read.clone()));
    assert_eq!(counted.count_total, 0, "{} bytes", counted.bytes_total);
}
