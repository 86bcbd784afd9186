//! Queues and outputs: room, answers to corrupt operations, clocks, allocations.

use super::{all, bytes, read};
use allocation_counter::measure;
use fmu_export::can::{
    CanInput, CanOutput, Corrupt, Frame, Operation, Operations, Queue, Reason, Unsent,
};

#[test]
fn what_does_not_fit_is_refused_and_changes_nothing() {
    let mut output = CanOutput::<40>::default();
    assert_eq!((output.room(), output.is_waiting()), (40, false));
    let frame = Operation::Transmit(Frame::standard(5, &[1, 2, 3, 4]));
    output.send(&frame).unwrap();
    output.send(&frame).unwrap();
    assert_eq!((output.room(), output.is_waiting()), (0, true));
    let refused = output.send(&Operation::Wakeup).unwrap_err();
    let (bytes, left, most) = (8, 0, 40);
    assert_eq!(refused, Unsent::Full { bytes, left, most });
    let text = "an operation of 8 bytes does not fit: 0 of 40 bytes are left";
    assert_eq!(refused.to_string(), text);
    let wrong = output.clone().send(&Operation::Confirm(1 << 29));
    assert!(matches!(wrong, Err(Unsent::Full { bytes: 12, .. })));
    assert!(output.tick());
    let wrong = output.send(&Operation::Confirm(1 << 29)).unwrap_err();
    let text =
        "an operation cannot be sent: ID = 536870912; it must be at most 536870911 (29 bits)";
    assert_eq!(wrong.to_string(), text);
    assert_eq!((output.room(), output.is_waiting()), (40, false));
    assert!(!output.tick());
}

#[test]
fn a_queue_gives_operations_in_their_order() {
    let mut queue = Queue::<8192>::default();
    assert_eq!(queue.first(), None);
    for (operation, _) in all() {
        queue.push(&operation).unwrap();
    }
    let mut room = queue.room();
    assert_eq!(
        room,
        8192 - all().iter().map(|(_, bytes)| bytes.len()).sum::<usize>()
    );
    for (operation, bytes) in all() {
        assert_eq!(queue.first(), Some(operation));
        queue.remove_first();
        room += bytes.len();
        assert_eq!(queue.room(), room);
    }
    queue.remove_first();
    queue.push(&Operation::Wakeup).unwrap();
    queue.clear();
    assert_eq!((queue.first(), queue.room()), (None, 8192));
}

/// The answer to corrupt bytes holds them, as much of them as there is room for in the first half of
/// the queue, and none answers an answer.
#[test]
fn corrupt_operations_are_answered_once() {
    let corrupt = |data| Corrupt {
        data,
        reason: Reason::Code(0x43),
    };
    let unknown = [0x43, 0, 0, 0, 12, 0, 0, 0, 1, 2, 3, 4];
    let mut output = CanOutput::<60>::default();
    output.reject(&corrupt(&unknown));
    assert_eq!(output.room(), 60 - 10 - 12);
    output.reject(&corrupt(&unknown));
    assert_eq!(
        output.room(),
        60 - 10 - 12,
        "8 bytes of the first half are no room for an empty one"
    );
    let mut output = CanOutput::<20>::default();
    output.reject(&corrupt(&unknown));
    assert!(output.tick());
    assert_eq!(output.sent(), [1, 0, 0, 0, 10, 0, 0, 0, 0, 0]);
    let mut output = CanOutput::<40>::default();
    output.reject(&corrupt(&unknown));
    assert!(output.tick());
    let answer = [
        1, 0, 0, 0, 20, 0, 0, 0, 10, 0, 0x43, 0, 0, 0, 12, 0, 0, 0, 1, 2,
    ];
    assert_eq!(output.sent(), answer);
    let mut output = CanOutput::<60>::default();
    output.reject(&corrupt(&[1, 0, 0, 0, 8, 0, 0, 0]));
    assert!(!output.is_waiting());
    let long = [0x43; 70_000];
    let mut output = CanOutput::<160_000>::default();
    output.reject(&corrupt(&long));
    assert_eq!(output.room(), 160_000 - 10 - 65_535);
}

/// Corrupt operations of others, as many as fit into a message, leave room for what the node sends.
#[test]
fn corrupt_operations_do_not_hinder_a_node_that_sends() {
    let mut output = CanOutput::<2048>::default();
    let empty = [0x43, 0, 0, 0, 8, 0, 0, 0].repeat(256);
    let mut n = 0;
    for corrupt in Operations::new(&empty).filter_map(Result::err) {
        output.reject(&corrupt);
        n += 1;
    }
    assert_eq!(
        (n, output.room()),
        (256, 1024),
        "the last answer holds less"
    );
    let frame = Operation::Transmit(Frame::standard(0x101, &[7; 8]));
    assert_eq!(output.send(&frame), Ok(()));
}

/// A saved state gives the operations back, and room for as many as before.
#[test]
fn ports_are_saved() {
    let mut output = CanOutput::<64>::default();
    output.send(&Operation::Confirm(7)).unwrap();
    assert!(output.tick());
    output.send(&Operation::Wakeup).unwrap();
    let copy = output.clone();
    assert_eq!((&copy, copy.room()), (&output, 56));
    let mut other = CanOutput::<64>::default();
    other.send(&Operation::Confirm(3)).unwrap();
    other.clone_from(&output);
    assert_eq!(other, output);
    assert_eq!(CanInput::<64>::default().operations().count(), 0);
    // Nothing of it is integrated.
    assert_eq!(fmu_export::derive::Vector::len(&output), 0);
}

/// Oracle: an allocator that counts.
#[test]
fn sending_reading_and_copying_do_not_allocate() {
    let all = all();
    let joined = all.iter().flat_map(|(_, bytes)| bytes.clone());
    let joined = joined.collect::<Vec<_>>();
    let mut output = CanOutput::<2048>::default();
    let mut copy = output.clone();
    let hot = || {
        for _ in 0..100 {
            for operation in Operations::new(&joined) {
                output.send(&operation.unwrap()).unwrap();
            }
            for corrupt in Operations::new(&joined[..joined.len() - 1]).filter_map(Result::err) {
                output.reject(&corrupt);
            }
            assert!(output.send(&Operation::FormatError(&[0; 2000])).is_err());
            copy.clone_from(&output);
            assert!(output.tick());
        }
    };
    assert_eq!(measure(hot).count_total, 0);
    assert_ne!(measure(|| assert_ne!(output.clone(), copy)).count_total, 0);
    assert_eq!(bytes(&Operation::Wakeup).len(), 8);
    assert_eq!(read(&[]), []);
}
