//! Random bytes: whatever a peer sends is operations or corrupt, and never a panic.

use super::{Room, all, read};
use fmu_export::can::Operations;

/// Marsaglia's xorshift, as elsewhere in these tests.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        for shift in [13, -7, 17] {
            self.0 ^= if shift > 0 {
                self.0 << shift
            } else {
                self.0 >> -shift
            };
        }
        self.0
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
}

/// The operations and what is corrupt make up all bytes; each operation is written as it was read.
fn look_at(bytes: &[u8]) -> (usize, usize) {
    let (mut at, mut good, mut corrupt) = (0, 0, 0);
    for operation in Operations::new(bytes) {
        match operation {
            Ok(operation) => {
                let mut queue = Room::default();
                queue.push(&operation).unwrap();
                assert!(bytes[at..].starts_with(queue.bytes()), "{bytes:?}");
                (at, good) = (at + queue.bytes().len(), good + 1);
            }
            Err(found) => {
                assert!(bytes[at..].starts_with(found.data) && !found.data.is_empty());
                assert!(!found.reason.to_string().is_empty());
                (at, corrupt) = (at + found.data.len(), corrupt + 1);
            }
        }
    }
    assert_eq!(at, bytes.len(), "{bytes:?}");
    (good, corrupt)
}

/// Half of the million are noise, with plausible codes and lengths; half are operations of the
/// standard with a few bytes changed, cut, or joined.
#[test]
fn a_million_random_values_are_read() {
    let (valid, mut random) = (all(), Random(0x9e37_79b9_7f4a_7c15));
    let (mut good, mut corrupt) = (0, 0);
    let mut bytes = Vec::new();
    for k in 0..1_000_000 {
        bytes.clear();
        if k % 2 == 0 {
            let n = random.below(40);
            bytes.extend((0..n).map(|_| random.next() as u8));
            if n >= 8 {
                bytes[..8].fill(0);
                (bytes[0], bytes[4]) = (random.below(0x48) as u8, random.below(n + 2) as u8);
            }
        } else {
            for _ in 0..=random.below(3) {
                bytes.extend(&valid[random.below(valid.len())].1);
            }
            for _ in 0..random.below(3) {
                let at = random.below(bytes.len());
                bytes[at] = random.next() as u8;
            }
            bytes.truncate(bytes.len() - random.below(8) / 7 * random.below(8));
        }
        let (more_good, more_corrupt) = look_at(&bytes);
        (good, corrupt) = (good + more_good, corrupt + more_corrupt);
    }
    assert!(good > 500_000 && corrupt > 500_000, "{good} and {corrupt}");
    assert_eq!(read(&[]), []);
}
