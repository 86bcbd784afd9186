//! Sets a run up, for commands, analyses, report and Python: system and world, machine file,
//! control laws and other start values, loads of a path. Values given twice are refused.

pub mod laws;
pub mod loads;
pub mod machine_choice;
pub mod packed_machine;
pub mod run_setup;
pub mod start_values;
