//! States of an instance as FMI 3.0 calls them (FMI 3.0.2, sections 2.3 and 4.2.1), for a
//! co-simulation FMU with Event Mode, without clocks. Each function names
//! those in which it is allowed.

use crate::border::call::{C, E, G, I, L, M, N, S, T, U};

/// Step Mode, where values were set since the last step: nothing can be read before the next one
/// (section 4.2.1). What must be exchanged at a communication point goes through Event Mode.
pub(crate) const A: u16 = 128;

/// Every state but the callback within a step.
pub(crate) const ANY: u16 = I | G | N | E | S | A | M | C | T | L;
/// The states in which variables can be read.
pub(crate) const GET: u16 = I | N | E | S | U | M | C | T;
/// The states in which variables can be set.
pub(crate) const SET: u16 = I | N | E | S | A | M;

/// Names of the states.
pub(crate) const STATES: [(u16, &str); 11] = [
    (I, "Instantiated"),
    (G, "Configuration Mode"),
    (N, "Initialization Mode"),
    (E, "Event Mode"),
    (S, "Step Mode"),
    (A, "Step Mode after a set"),
    (U, "Intermediate Update Mode"),
    (M, "Event Mode"),
    (C, "Continuous-Time Mode"),
    (T, "Terminated"),
    (L, "lost by a panic"),
];
