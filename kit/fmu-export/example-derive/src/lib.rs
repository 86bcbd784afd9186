//! FMU `Pendulum`: a model of ordinary differential equations, written with the derives of
//! fmu-export, a row a line as in a table.

// One row a line.
#[rustfmt::skip]
mod pendulum;
