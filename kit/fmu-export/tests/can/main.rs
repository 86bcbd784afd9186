//! CAN by FMI-LS-BUS: operations as bytes, ports, and what a description says of them.
#![allow(missing_docs)]

mod described;
mod driven;
mod ports;
mod random;

use fmu_export::can::{
    ArbitrationLost, Configuration, Corrupt, ErrorCode, ErrorFlag, Format, Frame, NodeStatus,
    Operation, Operations, Queue, Reason, Unsent,
};

type Room = Queue<8192>;

/// The bytes of an operation.
fn bytes(operation: &Operation<'_>) -> Vec<u8> {
    let mut queue = Room::default();
    queue.push(operation).unwrap();
    queue.bytes().to_vec()
}

fn read(bytes: &[u8]) -> Vec<Result<Operation<'_>, Corrupt<'_>>> {
    Operations::new(bytes).collect()
}

fn reason(bytes: &[u8]) -> Reason {
    match read(bytes)[..] {
        [Err(Corrupt { data, reason })] => {
            assert_eq!(data, bytes);
            reason
        }
        ref other => panic!("{bytes:?}: {other:?}"),
    }
}

fn frame<'a>(id: u32, is_extended: bool, format: Format, data: &'a [u8]) -> Operation<'a> {
    Operation::Transmit(Frame {
        id,
        is_extended,
        format,
        data,
    })
}

/// Every operation, with the bytes that the tables of FMI-LS-BUS 1.0 give it: sections 4.2.1 (Format
/// Error) and 4.4.1.2 (CAN). Each argument has bytes of its own, so that swapped ones show. The
/// macros of the standard's headers (fmi3LsBusUtilCan.h) write the same.
fn all() -> Vec<(Operation<'static>, Vec<u8>)> {
    let can = |is_remote| Format::Can { is_remote };
    let fd = |brs, esi| Format::Fd { brs, esi };
    let xl = Format::Xl {
        sec: true,
        sdt: 0x5d,
        vcid: 0xc1,
        af: 0xa1b2_c3d4,
    };
    let bus_error = |code, flag, is_sender| Operation::BusError {
        id: 0x0102_0304,
        code,
        flag,
        is_sender,
    };
    let configuration = Operation::Configuration;
    let behavior = |of| configuration(Configuration::ArbitrationLost(of));
    let mut all: Vec<(Operation<'static>, Vec<u8>)> = vec![
        (
            Operation::FormatError(&[9, 8, 7]),
            vec![1, 0, 0, 0, 13, 0, 0, 0, 3, 0, 9, 8, 7],
        ),
        (
            frame(0x7ab, false, can(false), &[0x11, 0x22, 0x33]),
            vec![
                0x10, 0, 0, 0, 19, 0, 0, 0, 0xab, 7, 0, 0, 0, 0, 3, 0, 0x11, 0x22, 0x33,
            ],
        ),
        (
            frame(0x1234_5678, true, can(true), &[]),
            vec![
                0x10, 0, 0, 0, 16, 0, 0, 0, 0x78, 0x56, 0x34, 0x12, 1, 1, 0, 0,
            ],
        ),
        (
            frame(0x1234_5678, true, fd(true, false), &[5]),
            vec![
                0x11, 0, 0, 0, 18, 0, 0, 0, 0x78, 0x56, 0x34, 0x12, 1, 1, 0, 1, 0, 5,
            ],
        ),
        (
            frame(0x7ff, false, fd(false, true), &[]),
            vec![0x11, 0, 0, 0, 17, 0, 0, 0, 0xff, 7, 0, 0, 0, 0, 1, 0, 0],
        ),
        (
            frame(0x321, false, xl, &[6, 7]),
            vec![
                0x12, 0, 0, 0, 24, 0, 0, 0, 0x21, 3, 0, 0, 0, 1, 0x5d, 0xc1, 0xd4, 0xc3, 0xb2,
                0xa1, 2, 0, 6, 7,
            ],
        ),
        (
            Operation::Confirm(0x1fff_ffff),
            vec![0x20, 0, 0, 0, 12, 0, 0, 0, 0xff, 0xff, 0xff, 0x1f],
        ),
        (
            Operation::ArbitrationLost(0x0102_0304),
            vec![0x30, 0, 0, 0, 12, 0, 0, 0, 4, 3, 2, 1],
        ),
        (
            configuration(Configuration::BaudRate(500_000)),
            vec![0x40, 0, 0, 0, 13, 0, 0, 0, 1, 0x20, 0xa1, 7, 0],
        ),
        (
            configuration(Configuration::FdBaudRate(2_000_000)),
            vec![0x40, 0, 0, 0, 13, 0, 0, 0, 2, 0x80, 0x84, 0x1e, 0],
        ),
        (
            configuration(Configuration::XlBaudRate(10_000_000)),
            vec![0x40, 0, 0, 0, 13, 0, 0, 0, 3, 0x80, 0x96, 0x98, 0],
        ),
        (
            behavior(ArbitrationLost::BufferAndRetransmit),
            vec![0x40, 0, 0, 0, 10, 0, 0, 0, 4, 1],
        ),
        (
            behavior(ArbitrationLost::DiscardAndNotify),
            vec![0x40, 0, 0, 0, 10, 0, 0, 0, 4, 2],
        ),
        (Operation::Wakeup, vec![0x42, 0, 0, 0, 8, 0, 0, 0]),
    ];
    let codes = [
        ErrorCode::Bit,
        ErrorCode::BitStuffing,
        ErrorCode::Form,
        ErrorCode::Crc,
        ErrorCode::Ack,
        ErrorCode::BrokenErrorFrame,
    ];
    let flags = [
        (ErrorFlag::Primary, 1, true),
        (ErrorFlag::Secondary, 2, false),
    ];
    for (number, code) in (1..).zip(codes) {
        for (flag, flag_number, is_sender) in flags {
            let bytes = vec![
                0x31,
                0,
                0,
                0,
                15,
                0,
                0,
                0,
                4,
                3,
                2,
                1,
                number,
                flag_number,
                is_sender.into(),
            ];
            all.push((bus_error(code, flag, is_sender), bytes));
        }
    }
    let states = [
        NodeStatus::ErrorActive,
        NodeStatus::ErrorPassive,
        NodeStatus::BusOff,
    ];
    for (number, status) in (1..).zip(states) {
        let bytes = vec![0x41, 0, 0, 0, 9, 0, 0, 0, number];
        all.push((Operation::Status(status), bytes));
    }
    all
}

#[test]
fn every_operation_has_the_bytes_of_the_standard() {
    for (operation, expected) in all() {
        assert_eq!(bytes(&operation), expected, "{operation:?}");
        assert_eq!(read(&expected), [Ok(operation)]);
    }
}

/// All operations in one value, as a sender may join them, and a corrupt one between them.
#[test]
fn operations_follow_each_other() {
    let all = all();
    let joined = all.iter().map(|(_, bytes)| &bytes[..]).collect::<Vec<_>>();
    let operations = all.iter().map(|(operation, _)| Ok(*operation));
    assert_eq!(read(&joined.concat()), operations.collect::<Vec<_>>());
    let corrupt = [0x43, 0, 0, 0, 9, 0, 0, 0, 1];
    for (operation, bytes) in &all {
        let with_corrupt = [bytes, &corrupt[..], bytes].concat();
        let found = read(&with_corrupt);
        let reason = Reason::Code(0x43);
        let data = &corrupt[..];
        assert_eq!(
            found,
            [
                Ok(*operation),
                Err(Corrupt { data, reason }),
                Ok(*operation)
            ]
        );
    }
}

/// Each operation cut anywhere, and with one byte more or less than its arguments have.
#[test]
fn wrong_lengths_are_corrupt() {
    for (operation, bytes) in all() {
        for n in 1..bytes.len() {
            let expected = match n {
                ..8 => Reason::NoHeader { left: n },
                left => Reason::Length {
                    length: bytes.len() as u32,
                    left,
                },
            };
            assert_eq!(reason(&bytes[..n]), expected, "{operation:?}");
        }
        let code = u32::from(bytes[0]);
        for change in [-1, 1] {
            let length = (bytes.len() as i32 + change) as usize;
            if length < 8 {
                continue;
            }
            let mut other = bytes.clone();
            other.resize(length, 0);
            other[4] = length as u8;
            assert_eq!(
                reason(&other),
                Reason::Arguments { code, length },
                "{other:?}"
            );
        }
    }
    for length in [0, 7, 9, u32::MAX] {
        let bytes = [&0x42_u32.to_le_bytes()[..], &length.to_le_bytes()].concat();
        assert_eq!(reason(&bytes), Reason::Length { length, left: 8 });
    }
    assert_eq!(read(&[]), []);
}

/// Each argument with values next to those that the standard allows.
#[test]
fn wrong_arguments_are_corrupt() {
    let argument = |bytes: &[u8], name, value, allowed| {
        let expected = Reason::Argument {
            name,
            value,
            allowed,
        };
        assert_eq!(reason(bytes), expected);
    };
    let (frames, ids) = ("0 or 1", "at most 2047 (11 bits)");
    let all = all();
    let with = |k: usize, at: usize, value: u8, name, allowed| {
        let mut bytes = all[k].1.clone();
        bytes[at] = value;
        argument(&bytes, name, value.into(), allowed);
    };
    with(1, 12, 2, "Ide", frames);
    with(1, 13, 2, "Rtr", frames);
    with(3, 13, 2, "Brs", frames);
    with(3, 14, 255, "Esi", frames);
    with(5, 13, 2, "Sec", frames);
    with(8, 8, 0, "Parameter Type", "from 1 to 4");
    with(8, 8, 5, "Parameter Type", "from 1 to 4");
    with(11, 9, 0, "Arbitration Lost Behavior", "1 or 2");
    with(11, 9, 3, "Arbitration Lost Behavior", "1 or 2");
    with(14, 12, 0, "Error Code", "from 1 to 6");
    with(14, 12, 7, "Error Code", "from 1 to 6");
    with(14, 13, 0, "Error Flag", "1 or 2");
    with(14, 13, 3, "Error Flag", "1 or 2");
    with(14, 14, 2, "Is Sender", frames);
    with(26, 8, 0, "Status", "from 1 to 3");
    with(26, 8, 4, "Status", "from 1 to 3");
    let mut high = all[1].1.clone();
    high[9] = 8;
    argument(&high, "ID", 0x8ab, ids);
    for k in [2, 6, 7, 14] {
        let mut high = all[k].1.clone();
        high[11] = 0x20;
        let id = u32::from_le_bytes(*high[8..].first_chunk().unwrap());
        argument(&high, "ID", id, "at most 536870911 (29 bits)");
    }
}

/// Lengths of data of each format, next to those that ISO 11898-1 (CAN, CAN FD) and CiA 610-1 (CAN
/// XL) have.
#[test]
fn frames_have_the_lengths_of_their_format() {
    let formats = [
        (Format::Can { is_remote: false }, "at most 8"),
        (
            Format::Fd {
                brs: false,
                esi: false,
            },
            "0 to 8, 12, 16, 20, 24, 32, 48 or 64",
        ),
        (
            Format::Xl {
                sec: false,
                sdt: 0,
                vcid: 0,
                af: 0,
            },
            "from 1 to 2048",
        ),
    ];
    let data = [7; 2100];
    for n in 0..data.len() {
        let fits = [
            n <= 8,
            n <= 8 || [12, 16, 20, 24, 32, 48, 64].contains(&n),
            (1..=2048).contains(&n),
        ];
        for ((format, allowed), fits) in formats.into_iter().zip(fits) {
            let operation = frame(3, false, format, &data[..n]);
            let mut queue = Room::default();
            let sent = queue.push(&operation);
            if fits {
                assert_eq!(sent, Ok(()));
                assert_eq!(read(queue.bytes()), [Ok(operation)]);
                continue;
            }
            let reason = Reason::Argument {
                name: "Data Length",
                value: n as u32,
                allowed,
            };
            assert_eq!(sent, Err(Unsent::Corrupt(reason)));
            assert_eq!(queue.bytes(), []);
        }
    }
}

#[test]
fn reasons_name_argument_value_and_what_is_allowed() {
    let text = |bytes: &[u8]| reason(bytes).to_string();
    assert_eq!(
        text(&[0x42, 0, 0]),
        "3 bytes at the end; OP code and length of an operation have 8"
    );
    assert_eq!(
        text(&[0x42, 0, 0, 0, 9, 0, 0, 0]),
        "Length = 9; it must be from 8 to 8"
    );
    assert_eq!(
        text(&[0x43, 0, 0, 0, 8, 0, 0, 0]),
        "OP Code = 0x43 is none of CAN"
    );
    assert_eq!(
        text(&[0x41, 0, 0, 0, 8, 0, 0, 0]),
        "OP Code = 0x41: its arguments do not fill its Length = 8"
    );
    assert_eq!(
        text(&[0x41, 0, 0, 0, 9, 0, 0, 0, 4]),
        "Status = 4; it must be from 1 to 3"
    );
}
