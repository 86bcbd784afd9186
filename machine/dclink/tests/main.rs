//! Tests of the DC link in one program. What counts allocations has a program of its own.
#![allow(non_snake_case)] // symbols

mod balance;
mod oracle;
