//! FMU `Pendulum`, an example for authors of models and for tests: ordinary differential equations
//! with the derives of fmu-export, written with one variable per line like a table.

// One variable per line.
#[rustfmt::skip]
mod pendulum;
