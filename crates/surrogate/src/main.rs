//! surrogate
fn main() {}
