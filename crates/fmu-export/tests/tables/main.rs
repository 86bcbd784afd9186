//! Tables of variables, written by hand and by derives: what they become, and how each mistake in
//! one is named.
#![allow(missing_docs)]

mod check;
mod compile_fail;
mod derive;
mod hash;
mod ode;
mod table;
