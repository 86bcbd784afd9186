//! Call order: the states of an instance, and what a function says of itself: its name, and the
//! states in which it is allowed.

use crate::Model;
use crate::core::instance::Instance;
use crate::core::phase::Phase;

/// Made or reset; nothing has been computed.
pub(crate) const I: u8 = 1;
/// Initialization Mode.
pub(crate) const N: u8 = 2;
/// At a communication point, ready for a step.
pub(crate) const S: u8 = 4;
/// Terminated.
pub(crate) const T: u8 = 8;
/// Lost by a panic, the state Error of FMI 2.0: a restored state or a reset leads out of it.
pub(crate) const L: u8 = 16;
/// At a communication point, where values are exchanged until they agree: Event Mode of FMI 3.0.
pub(crate) const E: u8 = 32;
/// Within a step, from the importer's callback: Intermediate Update Mode of FMI 3.0.
pub(crate) const U: u8 = 64;

/// The bit of the state of an instance outside a step.
#[inline]
pub(crate) fn state<M: Model>(instance: &Instance<M>) -> u8 {
    match instance.state.phase {
        _ if instance.lost => L,
        Phase::Instantiated => I,
        Phase::Initialization => N,
        Phase::Stepping => S,
        Phase::Terminated => T,
        Phase::Exchange => E,
    }
}

/// A function and the states it is allowed in.
#[derive(Clone, Copy)]
pub(crate) struct Call {
    pub(crate) name: &'static str,
    pub(crate) allowed: u8,
}
