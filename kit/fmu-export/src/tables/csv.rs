//! Reads the columns of a CSV file as numbers for `Curve` and `Map`, and converts their units.

use crate::KNOWN_UNITS;

/// The required name, unit and bounds of a column.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    pub(super) name: &'static str,
    unit: &'static str,
    min: f64,
    max: f64,
}

impl Column {
    /// A column with this name and the unit in which the model gets the numbers, `"1"` for none.
    /// The file may use one of the unit's display units, such as `rpm` for `rad/s`.
    #[must_use]
    pub const fn new(name: &'static str, unit: &'static str) -> Self {
        let (min, max) = (f64::NEG_INFINITY, f64::INFINITY);
        Self {
            name,
            unit,
            min,
            max,
        }
    }

    /// With bounds of the numbers, in the model's unit.
    #[must_use]
    pub const fn within(mut self, min: f64, max: f64) -> Self {
        (self.min, self.max) = (min, max);
        self
    }

    /// Factor and offset of the unit that the file uses.
    fn scale(&self, line: usize, head: &str) -> Result<(f64, f64), String> {
        let Self { name, unit, .. } = self;
        let wrong = || format!("line {line}: the column `{head}` must be `{name} [{unit}]`");
        let (found, rest) = head.split_once('[').ok_or_else(wrong)?;
        let written = rest.strip_suffix(']').ok_or_else(wrong)?.trim();
        if found.trim() != *name {
            return Err(wrong());
        }
        if written == *unit {
            return Ok((1.0, 0.0));
        }
        let known = KNOWN_UNITS.iter().find(|known| known.name == *unit);
        let shown = known.into_iter().flat_map(|known| known.display);
        match shown.clone().find(|shown| shown.name == written) {
            Some(shown) => Ok((shown.factor, shown.offset)),
            None => {
                let others: String = shown.map(|shown| format!(" or {}", shown.name)).collect();
                Err(format!(
                    "line {line}: `{name}` is in {written}; it must be in {unit}{others}"
                ))
            }
        }
    }

    fn number(&self, line: usize, text: &str, (factor, offset): (f64, f64)) -> Result<f64, String> {
        let Self {
            name,
            unit,
            min,
            max,
        } = self;
        let wrong = || format!("line {line}: `{name}` = `{text}` must be a finite number");
        let number: f64 = text
            .parse()
            .ok()
            .filter(|x: &f64| x.is_finite())
            .ok_or_else(wrong)?;
        let value = (number - offset) / factor;
        if (*min..=*max).contains(&value) {
            return Ok(value);
        }
        Err(format!(
            "line {line}: `{name}` = {value} {unit} must be from {min} to {max}"
        ))
    }
}

/// The rows of numbers in the columns' units, with line numbers. Cells cannot be quoted.
pub(super) fn rows<const N: usize>(
    text: &str,
    columns: [Column; N],
) -> Result<Vec<(usize, [f64; N])>, String> {
    let text = text.trim_start_matches('\u{feff}');
    let mut lines = (text.lines().enumerate())
        .filter(|(_, text)| !text.trim().is_empty() && !text.starts_with('#'))
        .map(|(k, text)| cells::<N>(k + 1, text));
    let head = lines.next();
    let (line, head) = head.ok_or("there must be a line with the names of the columns")??;
    let mut scales = [(1.0, 0.0); N];
    for (k, column) in columns.iter().enumerate() {
        scales[k] = column.scale(line, head[k])?;
    }
    let mut rows = Vec::new();
    for row in lines {
        let (line, texts) = row?;
        let mut row = [0.0; N];
        for (k, column) in columns.iter().enumerate() {
            row[k] = column.number(line, texts[k], scales[k])?;
        }
        rows.push((line, row));
    }
    Ok(rows)
}

fn cells<const N: usize>(line: usize, text: &str) -> Result<(usize, [&str; N]), String> {
    let cells: Vec<_> = text.split(',').map(str::trim).collect();
    let count = cells.len();
    let wrong = |_| format!("line {line}: there must be {N} columns, not {count}");
    Ok((line, cells.try_into().map_err(wrong)?))
}
