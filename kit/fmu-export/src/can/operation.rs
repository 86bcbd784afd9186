//! The operations of CAN as bytes, for `port`: FMI-LS-BUS 1.0, sections 4.2 and 4.4.1. Numbers are
//! little-endian. Any bytes are operations or [`Corrupt`], and reading them allocates nothing.

use super::corrupt::{Corrupt, Reason};

/// An operation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operation<'a> {
    /// A corrupt operation was received: its bytes.
    FormatError(&'a [u8]),
    /// A frame is to be sent, or was received.
    Transmit(Frame<'a>),
    /// The frame with this ID was received by at least one node.
    Confirm(u32),
    /// The frame with this ID lost arbitration and was discarded.
    ArbitrationLost(u32),
    /// An error on the bus.
    BusError {
        /// ID of the frame that was transmitted.
        id: u32,
        /// The error.
        code: ErrorCode,
        /// Whether the node is the first to detect it.
        flag: ErrorFlag,
        /// Whether the frame is the node's own.
        is_sender: bool,
    },
    /// Configures the bus simulation.
    Configuration(Configuration),
    /// The state of a node, after it has changed.
    Status(NodeStatus),
    /// Wakes up the other nodes.
    Wakeup,
}

/// A frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Identifier, a number.
    pub id: u32,
    /// Whether the identifier is an extended one of 29 bits, not of 11.
    pub is_extended: bool,
    /// CAN, CAN FD or CAN XL.
    pub format: Format,
    /// The data, with padding.
    pub data: &'a [u8],
}

impl<'a> Frame<'a> {
    /// A data frame of classical CAN with an identifier of 11 bits.
    pub const fn standard(id: u32, data: &'a [u8]) -> Self {
        Self {
            id,
            is_extended: false,
            format: Format::Can { is_remote: false },
            data,
        }
    }
}

/// What the formats of frames differ in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// CAN: at most 8 bytes.
    Can {
        /// Whether it is a remote transmission request.
        is_remote: bool,
    },
    /// CAN FD: 0 to 8, 12, 16, 20, 24, 32, 48 or 64 bytes.
    Fd {
        /// Bit rate switch.
        brs: bool,
        /// Error state indicator.
        esi: bool,
    },
    /// CAN XL: 1 to 2048 bytes.
    Xl {
        /// Simple extended content.
        sec: bool,
        /// Type of the data.
        sdt: u8,
        /// ID of the virtual network.
        vcid: u8,
        /// Acceptance field.
        af: u32,
    },
}

/// A parameter of the bus simulation; rates are in bit/s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Configuration {
    /// Baud rate of CAN.
    BaudRate(u32),
    /// Baud rate of CAN FD.
    FdBaudRate(u32),
    /// Baud rate of CAN XL.
    XlBaudRate(u32),
    /// What becomes of a frame that lost arbitration.
    ArbitrationLost(ArbitrationLost),
}

/// Enumerations that are one byte: their variants with docs, and the names of arguments.
macro_rules! bytes {
    ($($(#[$doc:meta])* $name:ident $argument:literal $allowed:literal { $($(#[$about:meta])* $variant:ident = $value:literal,)* })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $name {
            $($(#[$about])* $variant = $value,)*
        }

        impl Byte for $name {
            fn of(byte: u8) -> Result<Self, Reason> {
                match byte {
                    $($value => Ok(Self::$variant),)*
                    _ => Err(Reason::Argument { name: $argument, value: byte.into(), allowed: $allowed }),
                }
            }
        }
    )*};
}

trait Byte: Sized {
    fn of(byte: u8) -> Result<Self, Reason>;
}

bytes! {
    /// What a bus simulation does with a frame that lost arbitration.
    ArbitrationLost "Arbitration Lost Behavior" "1 or 2" {
        /// It sends the frame as soon as possible.
        BufferAndRetransmit = 1,
        /// It discards the frame and tells the node.
        DiscardAndNotify = 2,
    }
    /// An error on the bus.
    ErrorCode "Error Code" "from 1 to 6" {
        /// The sender reads another bit than it has sent.
        Bit = 1,
        /// Six bits of equal value.
        BitStuffing = 2,
        /// The end of the frame is wrong.
        Form = 3,
        /// The checksum is wrong.
        Crc = 4,
        /// No node acknowledges the frame.
        Ack = 5,
        /// The error frame is wrong.
        BrokenErrorFrame = 6,
    }
    /// Who has detected an error.
    ErrorFlag "Error Flag" "1 or 2" {
        /// This node.
        Primary = 1,
        /// Another node.
        Secondary = 2,
    }
    /// The state of a node that counts its errors.
    NodeStatus "Status" "from 1 to 3" {
        /// Takes part, and signals errors.
        ErrorActive = 1,
        /// Takes part, and waits longer before it sends again.
        ErrorPassive = 2,
        /// Does not take part.
        BusOff = 3,
    }
}

/// OP codes.
mod code {
    pub(super) const FORMAT_ERROR: u32 = 0x01;
    pub(super) const TRANSMIT: u32 = 0x10;
    pub(super) const FD_TRANSMIT: u32 = 0x11;
    pub(super) const XL_TRANSMIT: u32 = 0x12;
    pub(super) const CONFIRM: u32 = 0x20;
    pub(super) const ARBITRATION_LOST: u32 = 0x30;
    pub(super) const BUS_ERROR: u32 = 0x31;
    pub(super) const CONFIGURATION: u32 = 0x40;
    pub(super) const STATUS: u32 = 0x41;
    pub(super) const WAKEUP: u32 = 0x42;
}

const HEADER: usize = 8;

impl<'a> Operation<'a> {
    /// OP code, number of bytes of the arguments without data, and data, if it has some.
    fn shape(&self) -> (u32, usize, &'a [u8]) {
        match *self {
            Self::FormatError(data) => (code::FORMAT_ERROR, 2, data),
            Self::Transmit(Frame { format, data, .. }) => match format {
                Format::Can { .. } => (code::TRANSMIT, 8, data),
                Format::Fd { .. } => (code::FD_TRANSMIT, 9, data),
                Format::Xl { .. } => (code::XL_TRANSMIT, 14, data),
            },
            Self::Confirm(_) => (code::CONFIRM, 4, &[]),
            Self::ArbitrationLost(_) => (code::ARBITRATION_LOST, 4, &[]),
            Self::BusError { .. } => (code::BUS_ERROR, 7, &[]),
            Self::Configuration(Configuration::ArbitrationLost(_)) => (code::CONFIGURATION, 2, &[]),
            Self::Configuration(_) => (code::CONFIGURATION, 5, &[]),
            Self::Status(_) => (code::STATUS, 1, &[]),
            Self::Wakeup => (code::WAKEUP, 0, &[]),
        }
    }

    /// The number of bytes.
    pub(super) fn len(&self) -> usize {
        let (_, arguments, data) = self.shape();
        HEADER + arguments + data.len()
    }

    /// Appends the bytes; data that are longer than their field can say make them corrupt.
    pub(super) fn write(&self, to: &mut Vec<u8>) {
        let (code, _, data) = self.shape();
        to.extend(code.to_le_bytes());
        to.extend((self.len() as u32).to_le_bytes());
        match *self {
            Self::FormatError(_) => {}
            Self::Transmit(frame) => {
                to.extend(frame.id.to_le_bytes());
                to.push(frame.is_extended.into());
                match frame.format {
                    Format::Can { is_remote } => to.push(is_remote.into()),
                    Format::Fd { brs, esi } => to.extend([brs, esi].map(u8::from)),
                    Format::Xl { sec, sdt, vcid, af } => {
                        to.extend([sec.into(), sdt, vcid]);
                        to.extend(af.to_le_bytes());
                    }
                }
            }
            Self::Confirm(id) | Self::ArbitrationLost(id) => to.extend(id.to_le_bytes()),
            Self::BusError {
                id,
                code,
                flag,
                is_sender,
            } => {
                to.extend(id.to_le_bytes());
                to.extend([code as u8, flag as u8, is_sender.into()]);
            }
            Self::Configuration(configuration) => {
                let (kind, rate) = match configuration {
                    Configuration::BaudRate(rate) => (1, rate),
                    Configuration::FdBaudRate(rate) => (2, rate),
                    Configuration::XlBaudRate(rate) => (3, rate),
                    Configuration::ArbitrationLost(what) => return to.extend([4, what as u8]),
                };
                to.push(kind);
                to.extend(rate.to_le_bytes());
            }
            Self::Status(status) => to.push(status as u8),
            Self::Wakeup => {}
        }
        if matches!(self, Self::FormatError(_) | Self::Transmit(_)) {
            to.extend((data.len() as u16).to_le_bytes());
            to.extend(data);
        }
    }
}

/// The operations in some bytes, in their order. After an operation that does not end among the
/// bytes there are no more.
#[derive(Clone, Debug)]
pub struct Operations<'a> {
    left: &'a [u8],
}

impl<'a> Operations<'a> {
    /// Those in the value of a `Tx_Data` or `Rx_Data`.
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self { left: bytes }
    }
}

impl<'a> Iterator for Operations<'a> {
    type Item = Result<Operation<'a>, Corrupt<'a>>;

    fn next(&mut self) -> Option<Self::Item> {
        let all = std::mem::take(&mut self.left);
        if all.is_empty() {
            return None;
        }
        let corrupt = |data, reason| Some(Err(Corrupt { data, reason }));
        let left = all.len();
        let mut header = Arguments(all);
        let (Some(code), Some(length)) = (header.u32(), header.u32()) else {
            return corrupt(all, Reason::NoHeader { left });
        };
        let operation = match usize::try_from(length) {
            Ok(n @ HEADER..) => all.split_at_checked(n),
            _ => None,
        };
        let Some((operation, rest)) = operation else {
            return corrupt(all, Reason::Length { length, left });
        };
        self.left = rest;
        match read(code, &operation[HEADER..]) {
            Ok(read) => Some(Ok(read)),
            Err(reason) => corrupt(operation, reason),
        }
    }
}

/// What is left of the arguments of an operation.
struct Arguments<'a>(&'a [u8]);

impl<'a> Arguments<'a> {
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (array, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*array)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u8(&mut self) -> Option<u8> {
        self.array().map(u8::from_le_bytes)
    }

    /// Data with its length, up to the end of the operation.
    fn data(&mut self) -> Option<&'a [u8]> {
        let length = self.array().map(u16::from_le_bytes)?;
        let data = std::mem::take(&mut self.0);
        (data.len() == usize::from(length)).then_some(data)
    }
}

/// Reads the arguments of the operation with this OP code.
fn read(code: u32, bytes: &[u8]) -> Result<Operation<'_>, Reason> {
    let mut arguments = Arguments(bytes);
    let from = &mut arguments;
    let wrong = Reason::Arguments {
        code,
        length: HEADER + bytes.len(),
    };
    let operation = match code {
        code::FORMAT_ERROR => Operation::FormatError(from.data().ok_or(wrong)?),
        code::TRANSMIT | code::FD_TRANSMIT | code::XL_TRANSMIT => {
            let id = from.u32().ok_or(wrong)?;
            let is_extended = boolean("Ide", from.u8().ok_or(wrong)?)?;
            let format = match code {
                code::TRANSMIT => Format::Can {
                    is_remote: boolean("Rtr", from.u8().ok_or(wrong)?)?,
                },
                code::FD_TRANSMIT => Format::Fd {
                    brs: boolean("Brs", from.u8().ok_or(wrong)?)?,
                    esi: boolean("Esi", from.u8().ok_or(wrong)?)?,
                },
                _ => Format::Xl {
                    sec: boolean("Sec", from.u8().ok_or(wrong)?)?,
                    sdt: from.u8().ok_or(wrong)?,
                    vcid: from.u8().ok_or(wrong)?,
                    af: from.u32().ok_or(wrong)?,
                },
            };
            let data = from.data().ok_or(wrong)?;
            check_length(format, data.len())?;
            Operation::Transmit(Frame {
                id: identifier(id, is_extended)?,
                is_extended,
                format,
                data,
            })
        }
        code::CONFIRM => Operation::Confirm(identifier(from.u32().ok_or(wrong)?, true)?),
        code::ARBITRATION_LOST => {
            Operation::ArbitrationLost(identifier(from.u32().ok_or(wrong)?, true)?)
        }
        code::BUS_ERROR => Operation::BusError {
            id: identifier(from.u32().ok_or(wrong)?, true)?,
            code: Byte::of(from.u8().ok_or(wrong)?)?,
            flag: Byte::of(from.u8().ok_or(wrong)?)?,
            is_sender: boolean("Is Sender", from.u8().ok_or(wrong)?)?,
        },
        code::CONFIGURATION => Operation::Configuration(match from.u8().ok_or(wrong)? {
            1 => Configuration::BaudRate(from.u32().ok_or(wrong)?),
            2 => Configuration::FdBaudRate(from.u32().ok_or(wrong)?),
            3 => Configuration::XlBaudRate(from.u32().ok_or(wrong)?),
            4 => Configuration::ArbitrationLost(Byte::of(from.u8().ok_or(wrong)?)?),
            kind => return Err(argument("Parameter Type", kind, "from 1 to 4")),
        }),
        code::STATUS => Operation::Status(Byte::of(from.u8().ok_or(wrong)?)?),
        code::WAKEUP => Operation::Wakeup,
        _ => return Err(Reason::Code(code)),
    };
    match arguments.0 {
        [] => Ok(operation),
        _ => Err(wrong),
    }
}

fn argument(name: &'static str, value: impl Into<u32>, allowed: &'static str) -> Reason {
    let value = value.into();
    Reason::Argument {
        name,
        value,
        allowed,
    }
}

fn boolean(name: &'static str, byte: u8) -> Result<bool, Reason> {
    match byte {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(argument(name, byte, "0 or 1")),
    }
}

fn identifier(id: u32, is_extended: bool) -> Result<u32, Reason> {
    match (id, is_extended) {
        (..=0x7ff, _) | (..=0x1fff_ffff, true) => Ok(id),
        (_, true) => Err(argument("ID", id, "at most 536870911 (29 bits)")),
        (_, false) => Err(argument("ID", id, "at most 2047 (11 bits)")),
    }
}

/// Checks the number of bytes of a frame's data.
fn check_length(format: Format, length: usize) -> Result<(), Reason> {
    let allowed = match (format, length) {
        (Format::Can { .. }, ..=8)
        | (Format::Fd { .. }, ..=8 | 12 | 16 | 20 | 24 | 32 | 48 | 64)
        | (Format::Xl { .. }, 1..=2048) => return Ok(()),
        (Format::Can { .. }, _) => "at most 8",
        (Format::Fd { .. }, _) => "0 to 8, 12, 16, 20, 24, 32, 48 or 64",
        (Format::Xl { .. }, _) => "from 1 to 2048",
    };
    Err(argument("Data Length", length as u32, allowed))
}
