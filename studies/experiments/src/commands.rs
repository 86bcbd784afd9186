//! The subcommands of `hdrm-fmu`: each reads its arguments, runs an analysis, prints the results
//! and returns the verdict. Only the programs use them.

pub mod compare;
pub mod draws;
pub mod endurance;
pub mod energy;
pub mod evaluate;
pub mod machine;
pub mod margins;
pub mod path;
pub mod pictures;
pub mod program;
pub mod python;
pub mod run;
pub mod sizing;
pub mod stability;
pub mod table;
pub mod testbed;
pub mod tournament;
