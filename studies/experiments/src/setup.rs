//! What a run is set up from: system and world, machine file, control laws and other start values,
//! loads of a path. What is given twice is refused.

pub mod laws;
pub mod loads;
pub mod machine_choice;
pub mod run_setup;
pub mod start_values;
