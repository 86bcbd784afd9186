//! fmi2-export
