//! Joins rows of nested structs to one table at compile time, for derives and `derived!`.

use fmi_units::{BASE, KNOWN_UNITS, Unit};

use crate::{Model, Variable};

/// A part of a table: a row, or the rows of a nested struct.
#[expect(
    clippy::large_enum_variant,
    reason = "made by the compiler, where there are no boxes, and gone when the table is made"
)]
pub enum Part<M: Model> {
    /// A row.
    Row(Variable<M>),
    /// The rows of a struct.
    Struct(&'static [Part<M>]),
}

/// The rows of a struct that the path `At` leads to, for the model `M`.
pub trait Rows<M: Model, At> {
    /// The rows in the order of the fields.
    const ROWS: &'static [Part<M>];
}

impl<M: Model, At> Rows<M, At> for () {
    const ROWS: &'static [Part<M>] = &[];
}

/// The number of rows in all structs.
pub const fn count<M: Model>(structs: &[&'static [Part<M>]]) -> usize {
    let (mut n, mut i) = (0, 0);
    while i < structs.len() {
        let mut k = 0;
        while k < structs[i].len() {
            n += match &structs[i][k] {
                Part::Row(_) => 1,
                Part::Struct(parts) => count(&[*parts]),
            };
            k += 1;
        }
        i += 1;
    }
    n
}

/// All `N` rows, in order.
pub const fn assemble<M: Model, const N: usize>(
    structs: &[&'static [Part<M>]],
) -> [Variable<M>; N] {
    let table = [Variable::<M>::NOTHING; N];
    let (mut table, mut n, mut i) = (table, 0, 0);
    while i < structs.len() {
        (table, n) = append(table, n, structs[i]);
        i += 1;
    }
    assert!(n == N, "`N` is the number of rows");
    table
}

const fn append<M: Model, const N: usize>(
    mut table: [Variable<M>; N],
    mut n: usize,
    parts: &'static [Part<M>],
) -> ([Variable<M>; N], usize) {
    let mut k = 0;
    while k < parts.len() {
        match &parts[k] {
            Part::Row(row) => {
                table[n] = *row;
                n += 1;
            }
            Part::Struct(parts) => (table, n) = append(table, n, parts),
        }
        k += 1;
    }
    (table, n)
}

/// The number of rows that are continuous states.
pub const fn count_states<M: Model>(table: &[Variable<M>]) -> usize {
    let (mut n, mut k) = (0, 0);
    while k < table.len() {
        n += table[k].is_continuous() as usize;
        k += 1;
    }
    n
}

/// The rows of the derivatives of all `N` continuous states.
pub const fn derivatives<M: Model, const N: usize>(table: &[Variable<M>]) -> [Variable<M>; N] {
    let rows = [Variable::<M>::NOTHING; N];
    let (mut rows, mut n, mut k) = (rows, 0, 0);
    while k < table.len() {
        if table[k].is_continuous() {
            rows[n] = table[k].derivative(match table[k].unit {
                Some(unit) => per_second(unit),
                None => None,
            });
            n += 1;
        }
        k += 1;
    }
    rows
}

/// The known unit of the rate of change of values in a known unit.
const fn per_second(unit: &str) -> Option<&'static str> {
    let Some(unit) = find(unit) else { return None };
    let (mut rate, mut k) = (None, 0);
    while k < KNOWN_UNITS.len() {
        if is_rate_of(&KNOWN_UNITS[k], unit) {
            rate = Some(KNOWN_UNITS[k].name); // the last: `1/s`, not `Hz`
        }
        k += 1;
    }
    rate
}

/// Whether `rate` is the unit of a change of `unit` per second.
const fn is_rate_of(rate: &Unit, unit: &Unit) -> bool {
    let mut is_it = rate.factor == unit.factor && rate.offset == 0.0;
    let mut k = 0;
    while k < BASE.len() {
        is_it &= rate.exponents[k] == unit.exponents[k] - (k == 2) as i8; // s
        k += 1;
    }
    is_it
}

/// Whether [`KNOWN_UNITS`] has a unit with this name.
pub const fn is_known_unit(name: &str) -> bool {
    find(name).is_some()
}

/// Whether values in `unit`, one of [`KNOWN_UNITS`], can be shown in `display`.
pub const fn is_display_unit(unit: &str, display: &str) -> bool {
    let Some(unit) = find(unit) else { return false };
    let mut k = 0;
    while k < unit.display.len() {
        if is_same(unit.display[k].name, display) {
            return true;
        }
        k += 1;
    }
    false
}

const fn find(name: &str) -> Option<&'static Unit> {
    let mut k = 0;
    while k < KNOWN_UNITS.len() {
        if is_same(KNOWN_UNITS[k].name, name) {
            return Some(&KNOWN_UNITS[k]);
        }
        k += 1;
    }
    None
}

const fn is_same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut k = 0;
    while k < a.len() && k < b.len() && a[k] == b[k] {
        k += 1;
    }
    k == a.len() && k == b.len()
}
