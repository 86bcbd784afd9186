//! The subcommands of `hdrm-fmu`, for this program and the report's: most read their arguments, run
//! an analysis, print the results and return the verdict.

pub mod compare;
pub mod draws;
pub mod endurance;
pub mod energy;
pub mod evaluate;
pub mod faults;
pub mod machine;
pub mod margins;
pub mod path;
pub mod pictures;
pub mod program;
pub mod python;
pub mod rest;
pub mod run;
pub mod sizing;
pub mod stability;
pub mod table;
pub mod testbed;
pub mod tournament;
pub mod weighing;
