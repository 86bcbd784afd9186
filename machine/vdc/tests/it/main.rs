//! The controller as its users see it. One program, so that it is linked once; `coupled` is the
//! machine that several tests control.
#![allow(non_snake_case)] // the paper's symbols

mod actuator_level;
mod closed_loop;
mod coupled;
mod force_limit;
mod loads;
mod moving_base;
mod outputs;
mod rates;
mod sampling;
mod smallest_gains;
mod warnings;
