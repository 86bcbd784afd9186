//! Joins names of nested variables at compile time, for generated code, `path` and `ode`.

/// Longest name, bytes.
const LONGEST: usize = 128;

/// A name such as `motor.winding.R`.
#[derive(Clone, Copy)]
pub struct Name {
    bytes: [u8; LONGEST],
    len: usize,
}

impl Name {
    /// The empty prefix of the fields of a model's own structs.
    pub const EMPTY: Self = Self {
        bytes: [0; LONGEST],
        len: 0,
    };

    /// Whether it is that of a model's own struct.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The name of a field in the struct with this name.
    #[must_use]
    pub const fn join(mut self, field: &str) -> Self {
        if self.len > 0 {
            self = self.push(b'.');
        }
        let field = field.as_bytes();
        let mut k = 0;
        while k < field.len() {
            self = self.push(field[k]);
            k += 1;
        }
        self
    }

    /// The name of the struct with this index, from 0, in an array with this name.
    #[must_use]
    pub const fn element(mut self, index: usize) -> Self {
        let number = index + 1;
        self = self.push(b'[');
        if number > 9 {
            self = self.push(b'0' + (number / 10) as u8); // at most 32
        }
        self.push(b'0' + (number % 10) as u8).push(b']')
    }

    const fn push(mut self, byte: u8) -> Self {
        assert!(
            self.len < LONGEST,
            "the name of a variable is longer than 128 bytes"
        );
        self.bytes[self.len] = byte;
        self.len += 1;
        self
    }

    /// The name as text.
    pub const fn text(&'static self) -> &'static str {
        match std::str::from_utf8(self.bytes.split_at(self.len).0) {
            Ok(text) => text,
            Err(_) => panic!("made of texts"),
        }
    }
}
