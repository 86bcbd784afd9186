//! vdc
