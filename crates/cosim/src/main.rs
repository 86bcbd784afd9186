//! cosim
fn main() {}
