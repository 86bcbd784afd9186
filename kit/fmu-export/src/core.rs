//! Everything about a model as an FMU that is the same in every version of FMI: the table of
//! variables and its elements, access, phases, steps, derivatives, saved states, messages, and the
//! mark of an instance in use.
//!
//! A border over it translates: element numbers into the version's references,
//! [`Fault`](fault::Fault)s into its statuses, [`Phase`](phase::Phase)s into its states, queued
//! messages into calls of its logger.

pub(crate) mod access;
pub(crate) mod binary;
pub(crate) mod blocks;
pub(crate) mod carried;
pub(crate) mod causality;
pub(crate) mod configuration;
pub(crate) mod continuous;
pub(crate) mod copied;
pub(crate) mod course;
pub(crate) mod dependencies;
pub(crate) mod derivatives;
pub(crate) mod enumeration;
pub(crate) mod error;
pub(crate) mod event;
pub(crate) mod exchange;
pub(crate) mod fault;
pub(crate) mod guard;
pub(crate) mod info;
pub(crate) mod input;
pub(crate) mod instance;
pub(crate) mod joined;
pub(crate) mod layout;
pub(crate) mod length;
pub(crate) mod log;
pub(crate) mod message;
pub(crate) mod model;
pub(crate) mod numbers;
pub(crate) mod panic;
pub(crate) mod parameter_file;
pub(crate) mod parameters;
pub(crate) mod phase;
pub(crate) mod place;
#[cfg(target_arch = "wasm32")]
pub(crate) mod placed_files;
pub(crate) mod rates;
pub(crate) mod room;
mod row;
pub(crate) mod saved;
pub(crate) mod setters;
pub(crate) mod sizes;
#[cfg(feature = "derive")]
pub(crate) mod solving;
pub(crate) mod state;
pub(crate) mod step;
pub(crate) mod step_end;
pub(crate) mod value;
