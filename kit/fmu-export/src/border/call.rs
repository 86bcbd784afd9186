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

/// The bit of a phase, of which each has its place: quicker than a table.
const fn bit(phase: Phase) -> u16 {
    1 << phase as u16
}

const _: () = {
    assert!(bit(Phase::Instantiated) == I && bit(Phase::Initialization) == N);
    assert!(bit(Phase::Stepping) == S && bit(Phase::Terminated) == T);
    assert!(bit(Phase::Exchange) == E && bit(Phase::Event) == M);
    assert!(bit(Phase::Continuous) == C && bit(Phase::Configuration) == G);
};

/// The bit of the state of an instance outside a step.
#[inline]
pub(crate) fn state<M: Model>(instance: &Instance<M>) -> u16 {
    match instance.lost {
        true => L,
        false => bit(instance.state.phase),
    }
}

/// A function, the states it is allowed in, and the interfaces that it is of.
#[derive(Clone, Copy)]
pub(crate) struct Call {
    pub(crate) name: &'static str,
    pub(crate) allowed: u16,
}

impl Call {
    /// Of both interfaces, unless one of them is among the states.
    #[inline(always)]
    pub(crate) const fn new(name: &'static str, allowed: u16) -> Self {
        let interfaces = if allowed & (CS | ME) == 0 { CS | ME } else { 0 };
        Self {
            name,
            allowed: allowed | interfaces,
        }
    }
}
