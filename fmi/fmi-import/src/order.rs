//! The call order for co-simulation.

use crate::standard::Function;
pub use crate::standard::Mode;

/// Whether the function of this name, of either version, may be called in this state.
///
/// # Panics
/// FMI has no such function.
#[must_use]
pub fn is_allowed(name: &str, mode: Mode) -> bool {
    let function = Function::named(name);
    function.expect("a function of FMI").is_allowed(mode)
}
