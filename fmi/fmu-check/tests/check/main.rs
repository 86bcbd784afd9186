//! `cargo fmu check` on FMUs by the book, and on those FMUs with one mistake at a time: each
//! mistake must be found in the row of the promise that it breaks. The FMUs are written in C
//! (`lag.c`, `lag3.c`): they share no code with fmu-export.

mod description_3;
mod faulty;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod findings;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod running;
