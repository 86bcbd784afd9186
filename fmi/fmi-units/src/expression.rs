//! Reads any expression of units, such as `m3/(s.Pa)`, for models whose unit `known` does not have.

use crate::known::KNOWN_UNITS;
use crate::unit::{DisplayUnit, Unit};
use core::f64::consts::PI;

/// A symbol: its unit is `unit` times a power of ten, and it may have a prefix.
struct Symbol {
    unit: Unit,
    tens: i32,
    has_prefixes: bool,
}

const fn si(unit: Unit, tens: i32) -> Symbol {
    Symbol {
        unit,
        tens,
        has_prefixes: true,
    }
}

const fn other(unit: Unit, factor: f64, tens: i32) -> Symbol {
    Symbol {
        unit: unit.factor(factor),
        tens,
        has_prefixes: false,
    }
}

/// SI Brochure, 9th edition, tables 2, 4 and 8, and usual ones of engines.
#[rustfmt::skip]
const SYMBOLS: &[Symbol] = &[
    si(Unit::new("m").m(1), 0), si(Unit::new("g").kg(1), -3), si(Unit::new("s").s(1), 0), si(Unit::new("A").A(1), 0),
    si(Unit::new("K").K(1), 0), si(Unit::new("mol").mol(1), 0), si(Unit::new("cd").cd(1), 0), si(Unit::new("rad").rad(1), 0),
    si(Unit::new("Hz").s(-1), 0), si(Unit::new("Bq").s(-1), 0), si(Unit::new("kat").mol(1).s(-1), 0),
    si(Unit::new("N").kg(1).m(1).s(-2), 0), si(Unit::new("Pa").kg(1).m(-1).s(-2), 0), si(Unit::new("bar").kg(1).m(-1).s(-2), 5),
    si(Unit::new("J").kg(1).m(2).s(-2), 0), si(Unit::new("W").kg(1).m(2).s(-3), 0), si(Unit::new("C").A(1).s(1), 0),
    si(Unit::new("V").kg(1).m(2).s(-3).A(-1), 0), si(Unit::new("F").kg(-1).m(-2).s(4).A(2), 0),
    si(Unit::new("Ohm").kg(1).m(2).s(-3).A(-2), 0), si(Unit::new("S").kg(-1).m(-2).s(3).A(2), 0),
    si(Unit::new("Wb").kg(1).m(2).s(-2).A(-1), 0), si(Unit::new("T").kg(1).s(-2).A(-1), 0),
    si(Unit::new("H").kg(1).m(2).s(-2).A(-2), 0), si(Unit::new("lm").cd(1), 0), si(Unit::new("lx").cd(1).m(-2), 0),
    si(Unit::new("Gy").m(2).s(-2), 0), si(Unit::new("Sv").m(2).s(-2), 0),
    si(Unit::new("l").m(3), -3), si(Unit::new("L").m(3), -3), si(Unit::new("t").kg(1), 3),
    other(Unit::new("1"), 1.0, 0), other(Unit::new("%"), 1.0, -2),
    other(Unit::new("min").s(1), 60.0, 0), other(Unit::new("h").s(1), 3600.0, 0), other(Unit::new("d").s(1), 86400.0, 0),
    other(Unit::new("deg").rad(1), PI / 180.0, 0), other(Unit::new("rev").rad(1), 2.0 * PI, 0),
    other(Unit::new("rpm").rad(1).s(-1), PI / 30.0, 0), other(Unit::new("degC").K(1), 1.0, 0),
];

/// `da` comes before `d`.
#[rustfmt::skip]
const PREFIXES: [(&str, i32); 20] = [
    ("da", 1), ("Y", 24), ("Z", 21), ("E", 18), ("P", 15), ("T", 12), ("G", 9), ("M", 6), ("k", 3), ("h", 2),
    ("d", -1), ("c", -2), ("m", -3), ("u", -6), ("n", -9), ("p", -12), ("f", -15), ("a", -18), ("z", -21), ("y", -24),
];

/// Elsewhere feet, atmospheres, pints, horsepower and gauss: nobody means what the prefix would say.
const MISLEADING: [&str; 5] = ["ft", "at", "pt", "PS", "Gs"];

impl Unit {
    /// The unit with this name: one of [`KNOWN_UNITS`], else the expression that the name is, in the
    /// syntax of Modelica (section 19.1 of its specification): symbols of SI with prefixes, and
    /// `l`, `t`, `bar`, `min`, `h`, `d`, `deg`, `rev`, `rpm`, `degC`, `%`, with exponents (`m2`,
    /// `s-1`) and dots between them; at most one `/` before a symbol or parentheses.
    ///
    /// ```
    /// # use fmi_units::Unit;
    /// let flow = Unit::find("l/min").unwrap();
    /// assert_eq!((flow.exponents, flow.factor), (Unit::new("").m(3).s(-1).exponents, 1e-3 / 60.0));
    /// assert_eq!(Unit::find("m/s/s"), None); // m/s2
    /// ```
    pub const fn find(name: &'static str) -> Option<Self> {
        let mut k = 0;
        while k < KNOWN_UNITS.len() {
            if is_same(KNOWN_UNITS[k].name.as_bytes(), name.as_bytes()) {
                return Some(KNOWN_UNITS[k]);
            }
            k += 1;
        }
        let mut parser = Parser {
            text: name.as_bytes(),
            at: 0,
            is_wrong: false,
        };
        let size = parser.expression();
        if parser.is_wrong || parser.at < name.len() {
            return None;
        }
        let mut unit = Self::new(name);
        let mut k = 0;
        while k < 8 {
            unit.exponents[k] = size.exponents[k] as i8;
            if unit.exponents[k] as i32 != size.exponents[k] {
                return None;
            }
            k += 1;
        }
        unit.factor = match size.tens {
            tens if tens < 0 => size.mantissa / power(10.0, -tens),
            tens => size.mantissa * power(10.0, tens),
        };
        Some(unit)
    }

    /// This unit shown in another one: one of its display units, or any unit of the same dimension.
    pub const fn shown_in(&self, name: &'static str) -> Option<DisplayUnit> {
        let mut k = 0;
        while k < self.display.len() {
            if is_same(self.display[k].name.as_bytes(), name.as_bytes()) {
                return Some(self.display[k]);
            }
            k += 1;
        }
        let Some(shown) = Self::find(name) else {
            return None;
        };
        let mut k = 0;
        while k < 8 {
            if shown.exponents[k] != self.exponents[k] {
                return None;
            }
            k += 1;
        }
        let offset = (self.offset - shown.offset) / shown.factor;
        Some(DisplayUnit::new(name, self.factor / shown.factor).offset(offset))
    }
}

/// A size in base units: mantissa · 10^tens.
struct Size {
    mantissa: f64,
    tens: i32,
    exponents: [i32; 8],
}

impl Size {
    const ONE: Self = Self {
        mantissa: 1.0,
        tens: 0,
        exponents: [0; 8],
    };

    /// Multiplied by a power of another size.
    const fn times(mut self, other: &Self, exponent: i32) -> Self {
        self.mantissa = match exponent {
            n if n < 0 => self.mantissa / power(other.mantissa, -n),
            n => self.mantissa * power(other.mantissa, n),
        };
        self.tens += exponent * other.tens;
        let mut k = 0;
        while k < 8 {
            self.exponents[k] += exponent * other.exponents[k];
            k += 1;
        }
        self
    }
}

/// Reads a text from `at` on.
struct Parser<'a> {
    text: &'a [u8],
    at: usize,
    is_wrong: bool,
}

impl Parser<'_> {
    const fn next(&self) -> u8 {
        if self.at < self.text.len() {
            self.text[self.at]
        } else {
            0
        }
    }

    /// Passes this character, if it is the next one.
    const fn passes(&mut self, character: u8) -> bool {
        let is_next = self.next() == character;
        self.at += is_next as usize;
        is_next
    }

    /// Factors with dots between them, and perhaps what divides them.
    const fn expression(&mut self) -> Size {
        let mut size = self.factor();
        while self.passes(b'.') {
            size = size.times(&self.factor(), 1);
        }
        if self.passes(b'/') {
            size = size.times(&self.factor(), -1);
        }
        size
    }

    /// A symbol with its exponent, or an expression in parentheses.
    const fn factor(&mut self) -> Size {
        if self.passes(b'(') {
            let size = self.expression();
            self.is_wrong |= !self.passes(b')');
            return size;
        }
        let start = self.at;
        if !self.passes(b'1') && !self.passes(b'%') {
            while self.next().is_ascii_alphabetic() {
                self.at += 1;
            }
        }
        let size = self.symbol(start);
        let is_negative = self.passes(b'-');
        let has_sign = is_negative || self.passes(b'+');
        let (mut exponent, from) = (0, self.at);
        while self.next().is_ascii_digit() && self.at < from + 2 {
            exponent = 10 * exponent + (self.next() - b'0') as i32;
            self.at += 1;
        }
        match self.at > from {
            true if is_negative => Size::ONE.times(&size, -exponent),
            true => Size::ONE.times(&size, exponent),
            false => {
                self.is_wrong |= has_sign;
                size
            }
        }
    }

    /// The symbol from `start` to here, with or without a prefix.
    const fn symbol(&mut self, start: usize) -> Size {
        let name = self.text.split_at(self.at).0.split_at(start).1;
        if let Some(size) = symbol(name, 0, false) {
            return size;
        }
        let mut k = 0;
        while k < MISLEADING.len() {
            self.is_wrong |= is_same(name, MISLEADING[k].as_bytes());
            k += 1;
        }
        k = 0;
        while k < PREFIXES.len() {
            let (prefix, tens) = (PREFIXES[k].0.as_bytes(), PREFIXES[k].1);
            if name.len() > prefix.len() {
                let (head, tail) = name.split_at(prefix.len());
                if is_same(head, prefix)
                    && let Some(size) = symbol(tail, tens, true)
                {
                    return size;
                }
            }
            k += 1;
        }
        self.is_wrong = true;
        Size::ONE
    }
}

/// The symbol with this name, times a power of ten.
const fn symbol(name: &[u8], tens: i32, is_prefixed: bool) -> Option<Size> {
    let mut k = 0;
    while k < SYMBOLS.len() {
        let symbol = &SYMBOLS[k];
        if is_same(symbol.unit.name.as_bytes(), name) && (symbol.has_prefixes || !is_prefixed) {
            let mut exponents = [0; 8];
            let mut i = 0;
            while i < 8 {
                exponents[i] = symbol.unit.exponents[i] as i32;
                i += 1;
            }
            return Some(Size {
                mantissa: symbol.unit.factor,
                tens: symbol.tens + tens,
                exponents,
            });
        }
        k += 1;
    }
    None
}

/// x to the power of n ≥ 0.
const fn power(x: f64, n: i32) -> f64 {
    let (mut product, mut k) = (1.0, 0);
    while k < n {
        product *= x;
        k += 1;
    }
    product
}

const fn is_same(a: &[u8], b: &[u8]) -> bool {
    let mut k = 0;
    while k < a.len() && k < b.len() && a[k] == b[k] {
        k += 1;
    }
    k == a.len() && k == b.len()
}
