//! The border of FMI 3.0.

mod derivatives;
mod life;
mod log;
mod misuse;
mod order;
mod saved;
mod update;
mod xml;
