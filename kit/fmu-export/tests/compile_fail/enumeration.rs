use fmu_export::prelude::*;

/// Law of the spring
#[derive(Clone, Copy, Enumeration)]
enum Law {
    Linear,
    /// Force of a table
    Table(f64),
}

/// Gear
#[derive(Clone, Copy, Enumeration)]
enum Gear {
    /// Backwards
    Reverse = 7,
}

#[derive(Clone, Copy, Enumeration)]
enum Undescribed {
    /// Only one
    One,
}

fn main() {}
