//! The C border, called as an importer calls it: by C name, through pointers. Each unsafe call gets
//! an instance that is live or NULL, and pointers that are NULL or valid for the number beside
//! them.
#![allow(missing_docs, clippy::undocumented_unsafe_blocks)]

mod client;
mod client3;
mod derivatives;
mod evaluation;
mod fmi3;
mod life;
mod memory;
mod misuse;
mod order;
mod panics;
mod parameters;
mod probe;
mod random;
mod reentrancy;
mod saved;
mod states;
mod time;
mod xml;
mod xorshift;
