//! The shipped network is read once for all who have it at a time, and is gone with the last of them: a library that is unloaded
//! leaves nothing behind. A test alone in its process, so that nobody else has the network meanwhile; memory is counted on its thread.

use allocation_counter::measure;
use emla::Surrogate;

/// Bytes that `make` leaves allocated, and what it makes.
fn kept<T>(make: impl FnOnce() -> T) -> (i64, T) {
    let mut made = None;
    let bytes = measure(|| made = Some(make())).bytes_current;
    (bytes, made.expect("made"))
}

#[test]
fn the_shipped_network_lives_as_long_as_someone_has_it() {
    for _ in 0..3 {
        let (read, first) = kept(Surrogate::reference);
        assert!(read > 50_000, "it was read: {read} bytes");
        let (more, second) = kept(Surrogate::reference);
        assert_eq!(more, 0, "it is shared");
        let (more, third) = kept(|| {
            drop(first);
            Surrogate::reference()
        });
        assert_eq!(more, 0, "it is kept");
        let (left, ()) = kept(|| drop((second, third)));
        assert_eq!(left, -read, "it is gone");
    }
}
