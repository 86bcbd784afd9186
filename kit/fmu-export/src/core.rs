//! All of a model as an FMU that is the same in both versions of FMI, for `c_api`, `fmi2`, `fmi3`
//! and `check`: variables and access to them, phases, steps, derivatives, saved states, messages.
//!
//! The C interface of a version translates: value references into element numbers,
//! [`Fault`](fault::Fault)s into statuses, [`Phase`](phase::Phase)s into states, queued messages
//! into calls of the importer's logger.

pub(crate) mod binary;
pub(crate) mod block_access;
pub(crate) mod causality;
pub(crate) mod clock;
pub(crate) mod clock_state;
pub(crate) mod configuration;
pub(crate) mod continuous;
pub(crate) mod counted_input;
pub(crate) mod dependencies;
pub(crate) mod derivatives;
pub(crate) mod edited_files;
pub(crate) mod element_access;
pub(crate) mod enumeration;
pub(crate) mod equation_cache;
pub(crate) mod error;
pub(crate) mod event;
pub(crate) mod exclusive;
pub(crate) mod fault;
pub(crate) mod impl_copy;
pub(crate) mod info;
pub(crate) mod input;
pub(crate) mod input_over_step;
pub(crate) mod instance;
pub(crate) mod layout;
pub(crate) mod length;
pub(crate) mod log;
pub(crate) mod message;
pub(crate) mod model;
pub(crate) mod model_exchange;
pub(crate) mod number_access;
pub(crate) mod packed_file;
pub(crate) mod panic;
pub(crate) mod parameter_file;
pub(crate) mod parameters;
pub(crate) mod phase;
#[cfg(target_arch = "wasm32")]
pub(crate) mod placed_files;
mod row;
pub(crate) mod saved;
pub(crate) mod setters;
pub(crate) mod sizes;
pub(crate) mod solver;
pub(crate) mod solver_step;
pub(crate) mod solver_workspace;
pub(crate) mod state;
pub(crate) mod step;
pub(crate) mod step_end;
pub(crate) mod storage;
pub(crate) mod table_macros;
pub(crate) mod ticking;
pub(crate) mod ticks;
pub(crate) mod type_definition;
pub(crate) mod value;
