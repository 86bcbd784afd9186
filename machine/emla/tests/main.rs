//! Tests of the actuator in one program. What counts allocations has a program of its own.
#![allow(non_snake_case)] // symbols

mod blending;
mod dc_link;
mod derivatives;
mod electric;
mod golden;
mod identities;
mod oracle;
mod oracle_derivatives;
mod oracle_heat;
mod random;
mod robustness;
