//! Call order: the states of an instance, and what a function says of itself: its name, and the
//! states in which it is allowed.

use crate::Model;
use crate::core::instance::Instance;
use crate::core::phase::Phase;

/// Made or reset; nothing has been computed.
pub(crate) const I: u16 = 1;
/// Initialization Mode.
pub(crate) const N: u16 = 2;
/// At a communication point, ready for a step.
pub(crate) const S: u16 = 4;
/// Terminated.
pub(crate) const T: u16 = 8;
/// Lost by a panic, the state Error of FMI 2.0: a restored state or a reset leads out of it.
pub(crate) const L: u16 = 16;
/// At a communication point, where values are exchanged until they agree: Event Mode of FMI 3.0.
pub(crate) const E: u16 = 32;
/// Within a step, from the importer's callback: Intermediate Update Mode of FMI 3.0.
pub(crate) const U: u16 = 64;

/// Event Mode of Model Exchange.
pub(crate) const M: u16 = 256;
/// Continuous-Time Mode of Model Exchange.
pub(crate) const C: u16 = 512;
/// Before initialization, where sizes are set: Configuration Mode of FMI 3.0.
pub(crate) const G: u16 = 4096;
/// The states of Model Exchange alone.
pub(crate) const EXCHANGE_STATES: u16 = M | C;
/// The states of both interfaces.
pub(crate) const COMMON_STATES: u16 = I | G | N | T | L;

/// Beside the states: for instances of Co-Simulation only.
pub(crate) const CS: u16 = 1024;
/// For instances of Model Exchange only.
pub(crate) const ME: u16 = 2048;

/// The bit of the state of an instance outside a step.
#[inline]
pub(crate) fn state<M: Model>(instance: &Instance<M>) -> u16 {
    match instance.state.phase {
        _ if instance.lost => L,
        Phase::Instantiated => I,
        Phase::Initialization => N,
        Phase::Stepping => S,
        Phase::Terminated => T,
        Phase::Exchange => E,
        Phase::Event => M,
        Phase::Continuous => C,
        Phase::Configuration => G,
    }
}

/// A function, the states it is allowed in, and the interface that it is of, where not of both.
#[derive(Clone, Copy)]
pub(crate) struct Call {
    pub(crate) name: &'static str,
    pub(crate) allowed: u16,
}
