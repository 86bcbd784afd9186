//! `ssc:LinearTransformation` of SSP 1.0: what a connection makes of a value on its way.

/// `factor · value + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    /// Factor.
    pub factor: f64,
    /// Offset, in the unit of the end.
    pub offset: f64,
}

impl Linear {
    /// What leaves every value as it is.
    pub const NONE: Self = Self {
        factor: 1.0,
        offset: 0.0,
    };

    /// The value at the end of the connection.
    pub fn of(&self, value: f64) -> f64 {
        self.factor * value + self.offset
    }
}
