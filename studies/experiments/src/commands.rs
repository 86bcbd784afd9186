//! Subcommands: from arguments to an analysis, its print and the verdict. Nothing imports them but
//! the programs.

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
