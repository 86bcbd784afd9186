//! Tests of the actuator as built in one program. What counts allocations has a program of its own.
#![allow(non_snake_case)] // symbols

mod balance;
mod electric;
mod idealised;
mod oracle;
