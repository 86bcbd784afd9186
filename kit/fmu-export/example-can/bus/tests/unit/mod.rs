//! The bus with operations of nodes, step by step.

use super::*;
use fmu_export::can::Operations;

/// A bus at 500 kbit/s, and what its nodes receive.
struct Run {
    p: Parameters,
    bus: Bus,
    t: f64,
}

const H: f64 = 1e-5;
const ID: u32 = 0x123;

impl Run {
    fn new() -> Self {
        let (p, u) = Bus::defaults();
        let bus = Bus::initialize(&p, &u, 0.0).unwrap();
        Self { p, bus, t: 0.0 }
    }

    /// Node `K` sends.
    fn send<const K: usize>(&mut self, operations: &[Operation<'_>]) {
        let (p, mut u) = Bus::defaults();
        let mut queue = Queue::<MOST>::default();
        for operation in operations {
            queue.push(operation).unwrap();
        }
        u.node[K].set(queue.bytes());
        let tick = Tick {
            time: self.t,
            interval: H,
        };
        self.bus.receive::<K>(&p, &u, tick).unwrap();
    }

    /// What the nodes receive at the next communication point at which one receives something, and
    /// its time, s; at most 1 ms later.
    fn next(&mut self) -> (f64, [Vec<u8>; NODES]) {
        let (p, (_, u)) = (&self.p, Bus::defaults());
        for _ in 0..100 {
            let u = InputPolynomial::held(u.clone());
            let end = self.bus.step(p, &u, &(), self.t, H).unwrap();
            self.t += H;
            let ticked = self.bus.node.each_mut().map(CanOutput::tick);
            assert_eq!(end.event, ticked.contains(&true));
            assert_eq!(end.reached, None, "triggered clocks allow no early return");
            if end.event {
                break;
            }
        }
        let y = self.bus.output(p, &u, &()).unwrap();
        (self.t, y.node.each_ref().map(|node| node.sent().to_vec()))
    }
}

fn data_frame(id: u32, data: &[u8]) -> Operation<'_> {
    Operation::Transmit(Frame::standard(id, data))
}

fn bytes(operations: &[Operation<'_>]) -> Vec<u8> {
    let mut queue = Queue::<MOST>::default();
    for operation in operations {
        queue.push(operation).unwrap();
    }
    queue.bytes().to_vec()
}

/// A communication point is the first at or after a time, s.
fn is_at(t: f64, expected: f64) {
    assert!(
        t >= expected - 1e-9 && t < expected + H,
        "{t}, not {expected}"
    );
}

#[test]
fn the_table_agrees_with_the_model() {
    assert_eq!(fmu_export::check::<Bus>(), [""; 0]);
}

/// 47 + 8·8 = 111 bits at 500 kbit/s, then at 250 kbit/s, and 67 bits of an extended frame.
#[test]
fn a_frame_takes_the_time_of_its_bits() {
    let mut run = Run::new();
    let frame = data_frame(ID, &[1, 2, 3, 4, 5, 6, 7, 8]);
    run.send::<0>(&[frame]);
    let (t, received) = run.next();
    is_at(t, 222e-6);
    assert_eq!(
        received,
        [bytes(&[Operation::Confirm(ID)]), bytes(&[frame])]
    );
    let slow = Operation::Configuration(Configuration::BaudRate(250_000));
    let from = run.t;
    run.send::<1>(&[slow, frame]);
    let (t, received) = run.next();
    is_at(t, from + 444e-6);
    assert_eq!(
        received,
        [bytes(&[frame]), bytes(&[Operation::Confirm(ID)])]
    );
    let extended = Operation::Transmit(Frame {
        is_extended: true,
        ..Frame::standard(ID, &[])
    });
    let from = run.t;
    run.send::<1>(&[extended]);
    is_at(run.next().0, from + 268e-6);
    assert_eq!((run.bus.frames, run.bus.lost), (3, 0));
}

/// The lesser identifier is first; the other follows at once, without having been sent again.
#[test]
fn the_frame_that_loses_waits() {
    let mut run = Run::new();
    let [high, low] = [data_frame(0x300, &[1]), data_frame(0x200, &[2])];
    run.send::<0>(&[high]);
    run.send::<1>(&[low]);
    let (t, received) = run.next();
    is_at(t, 110e-6);
    assert_eq!(
        received,
        [bytes(&[low]), bytes(&[Operation::Confirm(0x200)])]
    );
    let (t, received) = run.next();
    is_at(t, 220e-6);
    assert_eq!(
        received,
        [bytes(&[Operation::Confirm(0x300)]), bytes(&[high])]
    );
    assert_eq!((run.bus.frames, run.bus.lost), (2, 1));
}

#[test]
fn the_frame_that_loses_is_discarded_where_the_node_says_so() {
    let mut run = Run::new();
    let discard = Configuration::ArbitrationLost(ArbitrationLost::DiscardAndNotify);
    let frames = [data_frame(0x300, &[1]), data_frame(0x100, &[3])];
    run.send::<0>(&[Operation::Configuration(discard), frames[0], frames[1]]);
    run.send::<1>(&[data_frame(0x200, &[2])]);
    let (t, received) = run.next();
    assert_eq!(
        t, H,
        "told when arbitration is lost, not when the other has sent"
    );
    let lost = Operation::ArbitrationLost(0x300);
    assert_eq!(received, [bytes(&[lost]), vec![]]);
    let (t, _) = run.next();
    is_at(t, 110e-6);
    let (t, received) = run.next();
    is_at(t, 220e-6);
    assert_eq!(received[1], bytes(&[frames[1]]));
    assert_eq!((run.bus.frames, run.bus.lost), (2, 1));
}

/// A bus that does not notify confirms nothing, and buffers whatever a node has configured.
#[test]
fn a_bus_without_notifications_keeps_frames() {
    let mut run = Run::new();
    run.p.notifies = false;
    let discard = Configuration::ArbitrationLost(ArbitrationLost::DiscardAndNotify);
    let [high, low] = [data_frame(0x300, &[1]), data_frame(0x200, &[2])];
    run.send::<0>(&[Operation::Configuration(discard), high]);
    run.send::<1>(&[low]);
    assert_eq!(run.next().1, [bytes(&[low]), vec![]]);
    assert_eq!(run.next().1, [vec![], bytes(&[high])]);
}

/// Oracle: bit by bit, dominant (0) wins: 11 bits, RTR or SRR, IDE, 18 bits, RTR.
#[test]
fn arbitration_is_that_of_the_bits_on_the_wire() {
    let frame = |id, is_extended, is_remote| Frame {
        id,
        is_extended,
        format: Format::Can { is_remote },
        data: &[],
    };
    let ids = [0, 1, 0x155, 0x156, 0x7ff];
    let standard = ids
        .iter()
        .flat_map(|&id| [false, true].map(|r| frame(id, false, r)));
    let more = [0, 1, 0x2_aaaa, 0x3_ffff];
    let extended = ids.iter().flat_map(|&id| more.map(|rest| id << 18 | rest));
    let extended = extended.flat_map(|id| [false, true].map(|r| frame(id, true, r)));
    let all = standard.chain(extended).collect::<Vec<_>>();
    let on_wire = |frame: &Frame<'_>| {
        let is_remote = frame.format == Format::Can { is_remote: true };
        let [remote, extended] =
            [is_remote, frame.is_extended].map(|bit| if bit { "1" } else { "0" });
        match frame.is_extended {
            false => format!("{:011b}{remote}{extended}", frame.id),
            true => {
                let id = format!("{:029b}", frame.id);
                format!("{}11{}{remote}", &id[..11], &id[11..])
            }
        }
    };
    for a in &all {
        for b in all.iter().filter(|b| b != &a) {
            // A standard frame's bits after IDE do not matter: it differs there already.
            let wire = on_wire(a).cmp(&on_wire(b));
            assert_eq!(priority(a).cmp(&priority(b)), wire, "{a:?} {b:?}");
        }
    }
    let fd = Frame {
        format: Format::Fd {
            brs: true,
            esi: true,
        },
        ..frame(5, false, false)
    };
    assert_eq!(priority(&fd), priority(&frame(5, false, false)));
}

/// A node that is error passive is behind one that is active; a node off the bus neither sends nor
/// receives, and confirms nothing.
#[test]
fn the_state_of_nodes_counts() {
    let mut run = Run::new();
    let [high, low] = [data_frame(0x300, &[1]), data_frame(0x200, &[2])];
    run.send::<1>(&[Operation::Status(NodeStatus::ErrorPassive), low]);
    run.send::<0>(&[high]);
    assert_eq!(run.next().1[1], bytes(&[high]));
    assert_eq!(run.next().1[0], bytes(&[low]));
    run.send::<1>(&[low, Operation::Status(NodeStatus::BusOff), low]);
    run.send::<0>(&[high]);
    let (_, received) = run.next();
    assert_eq!(received, [vec![], vec![]]);
    assert_eq!(run.bus.frames, 3, "transmitted, but not received");
    run.send::<1>(&[Operation::Status(NodeStatus::ErrorActive)]);
    run.send::<0>(&[high]);
    assert_eq!(run.next().1[1], bytes(&[high]));
}

#[test]
fn others_wake_up_and_corrupt_bytes_are_answered() {
    let mut run = Run::new();
    run.send::<0>(&[Operation::Wakeup]);
    assert_eq!(run.next().1, [vec![], bytes(&[Operation::Wakeup])]);
    let (p, mut u) = Bus::defaults();
    let corrupt = [0x99, 0, 0, 0, 8, 0, 0, 0];
    u.node[1].set(&[&corrupt[..], &bytes(&[data_frame(ID, &[4])])].concat());
    let tick = Tick {
        time: run.t,
        interval: H,
    };
    run.bus.receive::<1>(&p, &u, tick).unwrap();
    let (_, received) = run.next();
    assert_eq!(
        received,
        [vec![], bytes(&[Operation::FormatError(&corrupt)])]
    );
    assert_eq!(
        run.next().1[0],
        bytes(&[data_frame(ID, &[4])]),
        "what follows counts"
    );
    // What only a bus sends, and a rate of 0, have no effect.
    let rate = Operation::Configuration(Configuration::BaudRate(0));
    run.send::<0>(&[Operation::Confirm(1), rate]);
    assert_eq!(
        (run.next().1, run.bus.baud_rate),
        ([vec![], vec![]], 500_000)
    );
}

/// More frames than one step has room for wait, and none is lost.
#[test]
fn a_long_step_keeps_frames() {
    let mut run = Run::new();
    let frame = data_frame(ID, &[1, 2, 3, 4, 5, 6, 7, 8]);
    run.send::<0>(&[frame; 150]);
    let (p, u) = Bus::defaults();
    let mut received = 0;
    for k in 0..2 {
        let u = InputPolynomial::held(u.clone());
        run.bus.step(&p, &u, &(), f64::from(k), 1.0).unwrap();
        assert!(run.bus.node.each_mut().map(CanOutput::tick)[1]);
        received += Operations::new(run.bus.node[1].sent()).flatten().count();
    }
    assert_eq!((received, run.bus.frames), (150, 150));
}

/// Confirmations and frames of a long step leave less room than the largest frame needs, which
/// then waits.
#[test]
fn the_largest_frame_waits_for_room() {
    let mut run = Run::new();
    run.send::<1>(&[data_frame(0x10, &[]); 10]);
    let format = Format::Xl {
        sec: false,
        sdt: 0,
        vcid: 0,
        af: 0,
    };
    let largest = Operation::Transmit(Frame {
        format,
        ..Frame::standard(ID, &[7; 2048])
    });
    run.send::<0>(&[data_frame(ID, &[1, 2, 3, 4, 5, 6, 7, 8]); 80]);
    run.send::<0>(&[largest]);
    let (p, u) = Bus::defaults();
    for (k, received) in [(0, 89), (1, 2)] {
        let u = InputPolynomial::held(u.clone());
        run.bus.step(&p, &u, &(), f64::from(k), 1.0).unwrap();
        assert!(run.bus.node.each_mut().map(CanOutput::tick)[1]);
        let count = Operations::new(run.bus.node[1].sent()).flatten().count();
        assert_eq!(count, received);
    }
}

/// A node that leaves the bus while its frame is transmitted takes the frame with it: one that it
/// sends later has its own time.
#[test]
fn a_frame_of_a_node_that_leaves_is_gone() {
    let mut run = Run::new();
    let (p, u) = Bus::defaults();
    let frame = data_frame(ID, &[1, 2, 3, 4, 5, 6, 7, 8]);
    run.send::<0>(&[frame]);
    let u = InputPolynomial::held(u);
    run.bus.step(&p, &u, &(), 0.0, 2e-4).unwrap();
    run.t = 2e-4;
    let [off, active] = [NodeStatus::BusOff, NodeStatus::ErrorActive].map(Operation::Status);
    run.send::<0>(&[off, active, frame]);
    let (t, received) = run.next();
    is_at(t, 422e-6);
    assert_eq!(
        received,
        [bytes(&[Operation::Confirm(ID)]), bytes(&[frame])]
    );
    assert_eq!(run.bus.frames, 1);
}

/// As many corrupt operations as there is room for, 512 of 8 bytes: half of the queue is answers of
/// 18 bytes to 113 of them and one of 14; the rest has none. The bus goes on.
#[test]
fn corrupt_operations_stop_nothing() {
    let mut run = Run::new();
    let (p, mut u) = Bus::defaults();
    u.node[0].set(&[0x43, 0, 0, 0, 8, 0, 0, 0].repeat(MOST / 8));
    let tick = Tick {
        time: run.t,
        interval: H,
    };
    run.bus.receive::<0>(&p, &u, tick).unwrap();
    let (_, [answers, other]) = run.next();
    assert_eq!(Operations::new(&answers).count(), 113 + 1);
    assert_eq!(answers.len(), MOST / 2);
    assert!(other.is_empty());
    let frame = data_frame(ID, &[1]);
    run.send::<0>(&[frame]);
    assert_eq!(run.next().1[1], bytes(&[frame]));
}
