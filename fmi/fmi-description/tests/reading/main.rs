//! Reading FMUs: what a description says, what is forgiven, and what is refused.

mod archives;
mod fmi2;
mod fmi3;
mod foreign;
mod limits;
