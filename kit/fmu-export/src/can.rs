//! CAN, CAN FD and CAN XL by FMI-LS-BUS 1.0 (Network Abstraction): the operations that FMUs send
//! each other as bytes, and the variables, clocks and terminals through which they pass.
//!
//! A node receives by a [`CanInput`] among its inputs and sends by a [`CanOutput`], a field of its
//! state. [`can_clocks!`](crate::can_clocks) makes their clocks, and
//! [`Terminal::can`](crate::Terminal::can) the terminal and the manifest. A whole node is in
//! `docs/kit/can.md` of the repository.

mod corrupt;
mod operation;
mod port;

pub use corrupt::{Corrupt, Reason};
pub use operation::{
    ArbitrationLost, Configuration, ErrorCode, ErrorFlag, Format, Frame, NodeStatus, Operation,
    Operations,
};
pub use port::{CanInput, CanOutput, Queue, Unsent};

/// The type of the bytes that a network passes.
pub const MIME_TYPE: &str = "application/org.fmi-standard.fmi-ls-bus.can; version=\"1.0.0\"";
