//! All tests of this crate from outside, as one program.
#![forbid(unsafe_code)]

mod allocation;
mod c_types;
mod faults;
mod foreign;
mod inputs;

mod oscillator;
mod program;
mod support;
mod trouble;
mod wires;
