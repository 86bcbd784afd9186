//! [`CanInput`] and [`CanOutput`], the two ends of a node's connection to a network, as fields of
//! models with derives.

use super::MIME_TYPE;
use super::corrupt::{Corrupt, Reason};
use super::operation::{Operation, Operations};
use crate::derive::{Input, Name, Output, Part, Path, Rows, StatePart, Vector};
use crate::{Binary, Fields, Model, ModelError, Variable};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::marker::PhantomData;
use std::slice::{from_mut, from_ref};

/// Received operations, at most `N` bytes: the variable `Rx_Data` of the field, among the inputs.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CanInput<const N: usize> {
    data: Queue<N>,
}

impl<const N: usize> CanInput<N> {
    /// Takes these bytes for what was received, as tests of a model do.
    pub fn set(&mut self, bytes: &[u8]) {
        self.data.clear();
        self.data.bytes.extend(bytes);
    }

    /// The operations that were received, at a tick of `Rx_Clock`.
    pub fn operations(&self) -> Operations<'_> {
        Operations::new(&self.data.bytes)
    }
}

/// Operations to send, at most `N` bytes at a time: the variable `Tx_Data` of the field. It belongs
/// to the state, and to the outputs of an `impl Model`, which copy it there.
///
/// What is sent waits until `Tx_Clock` ticks, which is in the next Event Mode, or once more in the
/// present one.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CanOutput<const N: usize> {
    data: Queue<N>,
    waiting: Queue<N>,
}

/// Why an operation is not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unsent {
    /// It is no operation of the standard.
    Corrupt(Reason),
    /// There is no room for it until others have left the queue.
    Full {
        /// Number of bytes of the operation.
        bytes: usize,
        /// Room that is left, bytes.
        left: usize,
        /// Room altogether, bytes.
        most: usize,
    },
}

impl fmt::Display for Unsent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Corrupt(reason) => write!(f, "an operation cannot be sent: {reason}"),
            Self::Full { bytes, left, most } => write!(
                f,
                "an operation of {bytes} bytes does not fit: {left} of {most} bytes are left"
            ),
        }
    }
}

impl From<Unsent> for ModelError {
    fn from(unsent: Unsent) -> Self {
        Self::new(unsent.to_string())
    }
}

/// Operations that wait, at most `N` bytes, the first first. Simulated buses keep frames in it.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Queue<const N: usize> {
    bytes: Binary,
}

impl<const N: usize> Queue<N> {
    /// Appends an operation. On `Err` the queue is as before.
    pub fn push(&mut self, operation: &Operation<'_>) -> Result<(), Unsent> {
        let (start, bytes, left) = (self.bytes.len(), operation.len(), self.room());
        if bytes > left {
            let most = N;
            return Err(Unsent::Full { bytes, left, most });
        }
        operation.write(&mut self.bytes);
        match Operations::new(&self.bytes[start..]).next() {
            Some(Err(Corrupt { reason, .. })) => {
                self.bytes.truncate(start);
                Err(Unsent::Corrupt(reason))
            }
            _ => Ok(()),
        }
    }

    /// The operations, one after the other.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The operation that has waited longest.
    pub fn first(&self) -> Option<Operation<'_>> {
        Operations::new(&self.bytes).next()?.ok()
    }

    /// Removes that operation.
    pub fn remove_first(&mut self) {
        let bytes = self.first().map_or(0, |operation| operation.len());
        self.bytes.drain(..bytes);
    }

    /// Removes all operations.
    pub fn clear(&mut self) {
        self.bytes.clear();
    }

    /// The room that is left, bytes.
    pub fn room(&self) -> usize {
        N.saturating_sub(self.bytes.len())
    }
}

impl<const N: usize> CanOutput<N> {
    /// Sends an operation at the next tick of `Tx_Clock`. On `Err` nothing is sent.
    pub fn send(&mut self, operation: &Operation<'_>) -> Result<(), Unsent> {
        self.waiting.push(operation)
    }

    /// Answers a corrupt operation with a Format Error that holds as much of it as there is room
    /// for. The last half of the queue is kept for what the node itself sends, which the corrupt
    /// operations of others shall not hinder: what would need it is not answered. Nor is a corrupt
    /// Format Error, else two FMUs could go on forever.
    pub fn reject(&mut self, corrupt: &Corrupt<'_>) {
        let taken = N / 2 + Operation::FormatError(&[]).len();
        if let Some(room) = self.room().checked_sub(taken)
            && !corrupt.data.starts_with(&1_u32.to_le_bytes())
        {
            let data = &corrupt.data[..room.min(corrupt.data.len()).min(u16::MAX.into())];
            self.send(&Operation::FormatError(data)).expect("it fits");
        }
    }

    /// The value of `Tx_Data`.
    pub fn sent(&self) -> &[u8] {
        self.data.bytes()
    }

    /// The room that is left until the next tick of `Tx_Clock`, bytes.
    pub fn room(&self) -> usize {
        self.waiting.room()
    }

    /// Whether operations wait for the next tick of `Tx_Clock`: a step then ends with
    /// [`StepEnd::event`](crate::StepEnd::event).
    pub fn is_waiting(&self) -> bool {
        self.waiting.first().is_some()
    }

    /// Makes what waits the value of `Tx_Data`; returns whether there is any. What
    /// [`can_clocks!`](crate::can_clocks) calls.
    #[doc(hidden)]
    pub fn tick(&mut self) -> bool {
        self.data.clear();
        std::mem::swap(&mut self.data, &mut self.waiting);
        !self.sent().is_empty()
    }
}

/// Room for all bytes from the start on, so that steps do not allocate.
impl<const N: usize> Default for Queue<N> {
    fn default() -> Self {
        let bytes = Binary(Vec::with_capacity(N));
        Self { bytes }
    }
}

/// The derived `clone_from` would allocate.
macro_rules! clone {
    ($($name:ident $field:ident $(. $index:tt)? $(and $more:ident)?;)*) => {$(
        impl<const N: usize> Clone for $name<N> {
            fn clone(&self) -> Self {
                let mut new = Self::default();
                new.clone_from(self);
                new
            }

            fn clone_from(&mut self, from: &Self) {
                self.$field $(.$index)? .clone_from(&from.$field $(.$index)?);
                $(self.$more.clone_from(&from.$more);)?
            }
        }
    )*};
}

clone! { Queue bytes.0; CanInput data; CanOutput data and waiting; }

/// The names of a port's variables, where the path `At` leads to it.
struct Names<At>(PhantomData<At>);

impl<At: Path> Names<At> {
    const ALL: &'static [Name; 4] = &[
        At::NAME.join("Rx_Data"),
        At::NAME.join("Rx_Clock"),
        At::NAME.join("Tx_Data"),
        At::NAME.join("Tx_Clock"),
    ];
    const RX_CLOCK: &'static [&'static str] = &[Self::ALL[1].text()];
    const TX_CLOCK: &'static [&'static str] = &[Self::ALL[3].text()];
}

impl<M: Model, At: Path<From = M::Input, To = Self>, const N: usize> Rows<M, At> for CanInput<N> {
    const ROWS: &'static [Part<M>] = &[Part::Row(
        Variable::input_of(
            Names::<At>::ALL[0].text(),
            "Received operations of the bus",
            Fields::Binary(
                |u| from_ref(&At::get(u).data.bytes),
                |u| from_mut(&mut At::get_mut(u).data.bytes),
            ),
        )
        .mime_type(MIME_TYPE)
        .max_size(N as u32)
        .clocks(Names::<At>::RX_CLOCK),
    )];
}

impl<M: Model, At: Path<From = M::Output, To = Self>, const N: usize> Rows<M, At> for CanOutput<N> {
    const ROWS: &'static [Part<M>] = &[Part::Row(
        Variable::output_of(
            Names::<At>::ALL[2].text(),
            "Sent operations of the bus",
            Fields::Binary(
                |y| from_ref(&At::get(y).data.bytes),
                |y| from_mut(&mut At::get_mut(y).data.bytes),
            ),
        )
        .mime_type(MIME_TYPE)
        .max_size(N as u32)
        .clocks(Names::<At>::TX_CLOCK)
        .depends_on(&[])
        .initially_depends_on(&[]),
    )];
}

impl<const N: usize> Input for CanInput<N> {
    fn start() -> Self {
        Self::default()
    }
}

impl<const N: usize> Output for CanOutput<N> {}
impl<const N: usize> StatePart for CanOutput<N> {}

/// No continuous states.
impl<const N: usize> Vector for CanOutput<N> {
    fn len(&self) -> usize {
        0
    }

    fn read<'a>(&self, to: &'a mut [f64]) -> &'a mut [f64] {
        to
    }

    fn write<'a>(&mut self, from: &'a [f64]) -> &'a [f64] {
        from
    }

    fn not_finite(&self) -> Option<(&'static str, f64)> {
        None
    }
}

/// The clocks of a model's connections to CAN networks: `"name" = field: function`, where `name` is
/// that of the [terminal](crate::Terminal::can) and of the [`CanInput`], `field` a
/// [`CanOutput`] of the model, and `function` is called when operations were received.
///
/// Other clocks of the model follow by [`joined!`](crate::joined).
#[macro_export]
macro_rules! can_clocks {
    ($($name:literal = $field:ident $([$k:literal])? : $receive:expr),+ $(,)?) => {
        &[$(
            $crate::Clock::triggered(concat!($name, ".Rx_Clock"), "Operations are received", $receive),
            $crate::Clock::output(concat!($name, ".Tx_Clock"), "Operations are sent", |model: &mut Self| {
                model.$field $([$k])? .tick()
            })
            .in_next_instant(),
        )+]
    };
}
