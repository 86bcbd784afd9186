//! Joins rows of nested structs to one table at compile time, for derives and `derived!`.

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
            rows[n] = table[k].derivative();
            n += 1;
        }
        k += 1;
    }
    rows
}
