//! The CSV file with the rows of a campaign on the rig, or with measurements of a user's own, that
//! the network is trained on, for `data`, `train` and `plots`; `experiments` uses its `sha256`.
//!
//! The header names each column and may give its unit in brackets: `tau_e [N.m]`. Training needs
//! `tau_e`, `w_m`, `F_ext` and `x_dot`; other columns are allowed. Lines that begin with `#` are
//! comments. A column `profile` numbers the run that a row belongs to: whole runs are then held out
//! of the training. Rows of backward motion are mirrored. Each error names the file, the line and
//! the column.

use std::path::Path;

use anyhow::{Context as _, Result, anyhow, bail};

/// One operating point; SI, dq quantities peak-valued.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row {
    /// Direct-axis voltage, V.
    pub v_d: f64,
    /// Quadrature-axis voltage, V.
    pub v_q: f64,
    /// Direct-axis current, A.
    pub i_d: f64,
    /// Quadrature-axis current, A.
    pub i_q: f64,
    /// Air-gap torque, N·m.
    pub tau_e: f64,
    /// Motor speed, rad/s.
    pub w_m: f64,
    /// Load force, N, positive against extension.
    pub f_ext: f64,
    /// Rod speed, m/s.
    pub x_dot: f64,
    /// Temperature of the winding, K.
    pub T_winding: f64,
    /// Temperature of the housing, K.
    pub T_housing: f64,
    /// Rod position, m.
    pub x: f64,
}

/// Name, unit and value of a column.
type Column = (&'static str, &'static str, fn(&Row) -> f64);

/// Columns in the order of the file.
const COLUMNS: [Column; 11] = [
    ("v_d", "V", |row| row.v_d),
    ("v_q", "V", |row| row.v_q),
    ("i_d", "A", |row| row.i_d),
    ("i_q", "A", |row| row.i_q),
    ("tau_e", "N.m", |row| row.tau_e),
    ("w_m", "rad/s", |row| row.w_m),
    ("F_ext", "N", |row| row.f_ext),
    ("x_dot", "m/s", |row| row.x_dot),
    ("T_winding", "K", |row| row.T_winding),
    ("T_housing", "K", |row| row.T_housing),
    ("x", "m", |row| row.x),
];

/// Column that numbers the runs.
const PROFILE: &str = "profile";

/// The four of [`COLUMNS`] that training needs: two inputs, two targets.
const NEEDED: [usize; 4] = [4, 5, 6, 7];

/// Smallest number of rows that can be split and fitted.
pub const FEWEST_ROWS: usize = 50;

/// CSV text of `rows` after a comment line; `profiles` are the numbers of the rows' profiles, or
/// empty.
pub fn to_csv(rows: &[Row], profiles: &[u32], comment: &str) -> String {
    let names = COLUMNS
        .iter()
        .map(|(name, unit, _)| format!("{name} [{unit}]"));
    let header = profiles.first().map(|_| PROFILE.to_string());
    let header: Vec<String> = header.into_iter().chain(names).collect();
    let mut text = format!("# {comment}\n{}\n", header.join(","));
    for (k, row) in rows.iter().enumerate() {
        let number = profiles.get(k).map(ToString::to_string);
        let values = COLUMNS.map(|(.., of)| of(row).to_string());
        let cells: Vec<String> = number.into_iter().chain(values).collect();
        text += &(cells.join(",") + "\n");
    }
    text
}

/// The content of a file as far as training needs it.
#[derive(Clone, Debug)]
pub struct Data {
    /// [tau_e, w_m], N·m and rad/s.
    pub inputs: Vec<[f64; 2]>,
    /// [F_ext, x_dot], N and m/s.
    pub targets: Vec<[f64; 2]>,
    /// Profile of each row; empty if the file has no such column.
    pub profiles: Vec<u32>,
    /// First comment line, or the file's name.
    pub origin: String,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
}

/// Reads a CSV file for training.
pub fn read_csv(path: &Path) -> Result<Data> {
    let name = path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
    parse_csv(&name, &text)
}

/// Reads CSV text for training; errors call the file `name`.
pub fn parse_csv(name: &str, text: &str) -> Result<Data> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let header = reader
        .headers()
        .with_context(|| format!("{name}: cannot read the header"))?
        .clone();
    let line = line_of(text, header.position());
    let places = find_columns(name, line, &header)?;
    let profile = header.iter().position(|h| h.trim() == PROFILE);
    let (mut cells, mut profiles) = (Vec::new(), Vec::new());
    for record in reader.records() {
        let record = record.with_context(|| format!("{name}: not a table"))?;
        let line = || line_of(text, record.position());
        let mut row = [0.0; 4];
        for ((cell, &place), &column) in row.iter_mut().zip(&places).zip(&NEEDED) {
            *cell = number(name, &line, COLUMNS[column].0, &record[place])?;
        }
        if row[1] < 0.0 {
            // Odd symmetry: the actuator works the same in both directions.
            row = row.map(|value| -value);
        }
        cells.push(row);
        if let Some(place) = profile {
            let cell = &record[place];
            let number = cell.parse().map_err(|_| {
                anyhow!(
                    "{name}, line {}, column {PROFILE}: `{cell}` must be a whole number from 0 on",
                    line()
                )
            })?;
            profiles.push(number);
        }
    }
    check_columns(name, line, &cells)?;
    let comment = text.lines().find_map(|line| line.strip_prefix('#'));
    Ok(Data {
        inputs: cells.iter().map(|r| [r[0], r[1]]).collect(),
        targets: cells.iter().map(|r| [r[2], r[3]]).collect(),
        profiles,
        origin: comment.map_or_else(|| name.to_owned(), |c| c.trim().to_owned()),
        sha256: sha256(text.as_bytes()),
    })
}

/// Line of a record, counted from 1. The reader's position is that of the comments and empty lines
/// before the record.
fn line_of(text: &str, position: Option<&csv::Position>) -> u64 {
    let start = position.map_or(1, csv::Position::line);
    let skipped = text
        .lines()
        .skip(start as usize - 1)
        .take_while(|line| line.is_empty() || line.starts_with('#'));
    start + skipped.count() as u64
}

fn find_columns(name: &str, line: u64, header: &csv::StringRecord) -> Result<[usize; 4]> {
    let mut places = [0; 4];
    for (place, &column) in places.iter_mut().zip(&NEEDED) {
        let (wanted, unit, _) = COLUMNS[column];
        let found = header
            .iter()
            .position(|h| h.split('[').next().unwrap_or(h).trim() == wanted);
        let Some(found) = found else {
            bail!("{name}, line {line}: column {wanted} [{unit}] is missing");
        };
        let given = header[found]
            .split_once('[')
            .map(|(_, u)| u.trim_end_matches(']').trim());
        if given.is_some_and(|u| u != unit) {
            let given = given.unwrap_or_default();
            bail!("{name}, line {line}, column {wanted}: unit [{given}] where [{unit}] is needed");
        }
        *place = found;
    }
    Ok(places)
}

fn number(name: &str, line: &dyn Fn() -> u64, column: &str, cell: &str) -> Result<f64> {
    match cell.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => bail!(
            "{name}, line {}, column {column}: `{cell}` is not a finite number",
            line()
        ),
    }
}

fn check_columns(name: &str, header_line: u64, cells: &[[f64; 4]]) -> Result<()> {
    if cells.len() < FEWEST_ROWS {
        bail!(
            "{name}, after line {header_line}: {} rows, at least {FEWEST_ROWS} are needed",
            cells.len()
        );
    }
    for (k, &column) in NEEDED.iter().enumerate() {
        let first = cells[0][k];
        if cells.iter().all(|row| row[k] == first) {
            let column = COLUMNS[column].0;
            bail!(
                "{name}, after line {header_line}, column {column}: constant ({first} in every row), \
                 nothing can be learnt from it"
            );
        }
    }
    Ok(())
}

/// SHA-256, hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    use sha2::Digest as _;
    let digest = sha2::Sha256::digest(bytes);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}
