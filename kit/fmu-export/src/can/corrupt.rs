//! Bytes that are no operation, for `operation`, which finds them, and `port`, which answers them.

use std::fmt;

/// Bytes that are no operation of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corrupt<'a> {
    /// The bytes of the operation; all that are left if it does not end among them.
    pub data: &'a [u8],
    /// What is wrong with them.
    pub reason: Reason,
}

/// Why bytes are no operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The operation has no OP code and length.
    NoHeader {
        /// Number of bytes.
        left: usize,
    },
    /// The operation does not end among the bytes, or is shorter than OP code and length.
    Length {
        /// Its length by its header.
        length: u32,
        /// Number of bytes.
        left: usize,
    },
    /// The OP code is not one of CAN.
    Code(u32),
    /// The arguments are longer or shorter than the operation.
    Arguments {
        /// OP code.
        code: u32,
        /// Length of the operation.
        length: usize,
    },
    /// An argument has a value that it must not have.
    Argument {
        /// Name of the argument.
        name: &'static str,
        /// Its value.
        value: u32,
        /// The values that it may have.
        allowed: &'static str,
    },
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NoHeader { left } => write!(
                f,
                "{left} bytes at the end; OP code and length of an operation have 8"
            ),
            Self::Length { length, left } => {
                write!(f, "Length = {length}; it must be from 8 to {left}")
            }
            Self::Code(code) => write!(f, "OP Code = {code:#x} is none of CAN"),
            Self::Arguments { code, length } => write!(
                f,
                "OP Code = {code:#x}: its arguments do not fill its Length = {length}"
            ),
            Self::Argument {
                name,
                value,
                allowed,
            } => write!(f, "{name} = {value}; it must be {allowed}"),
        }
    }
}
