//! FMU `Pendulum`, an example of a model of ordinary differential equations with the derives of
//! fmu-export, written with one variable per line like a table.

// One variable per line.
#[rustfmt::skip]
mod pendulum;
