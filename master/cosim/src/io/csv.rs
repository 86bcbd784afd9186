//! Logs the signals of a run to a CSV file (`--csv` of `cosim` and the studies): names, then a row
//! for each communication point or interval. The units are in a second file, `NAME.units.csv`.

use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result};
use fmi_description::Kind;
use output_file::OutputFile;

use crate::io::cells::cell;
use crate::master::{LastStep, Master, Stepping};
use crate::run::observer::Observer;
use crate::run::signals::Signals;
use crate::schedule::steps_in;
use crate::structure::system::System;
use crate::wiring::Port;
use fmi_import::digits::short;
use fmi_import::value::is_non_numeric;

/// A CSV file that gets its name when it is complete. If it is dropped before that, nothing is left.
pub struct CsvFile {
    out: OutputFile,
    row: Vec<u8>,
}

impl CsvFile {
    /// Create a file with the columns `time` and `names`.
    pub fn create(path: &Path, names: &[String]) -> Result<Self> {
        let mut csv = Self {
            out: OutputFile::create(path)?,
            row: b"time".to_vec(),
        };
        for name in names {
            csv.row.push(b',');
            csv.row.extend_from_slice(cell(name).as_bytes());
        }
        csv.write_row()?;
        Ok(csv)
    }

    /// Add a row. Numbers have the fewest digits that read back bit for bit.
    pub fn row(&mut self, time: f64, values: &[f64]) -> Result<()> {
        self.row_with(time, values, &[])
    }

    /// Add a row with texts, each with its column, counted from 0 after the time.
    fn row_with(&mut self, time: f64, values: &[f64], texts: &[(usize, String)]) -> Result<()> {
        let mut digits = zmij::Buffer::new();
        self.row.extend_from_slice(digits.format(time).as_bytes());
        let (mut values, mut texts) = (values.iter(), texts.iter().peekable());
        for column in 0..values.len() + texts.len() {
            self.row.push(b',');
            match texts.next_if(|(k, _)| *k == column) {
                Some((_, text)) => self.row.extend_from_slice(cell(text).as_bytes()),
                None => {
                    let value = values.next().context("a text in no column")?;
                    self.row.extend_from_slice(digits.format(*value).as_bytes());
                }
            }
        }
        self.write_row()
    }

    fn write_row(&mut self) -> Result<()> {
        self.row.push(b'\n');
        let written = self.out.write_all(&self.row);
        self.row.clear();
        Ok(written?)
    }

    /// Complete the file.
    pub fn finish(self) -> Result<()> {
        Ok(self.out.commit()?)
    }
}

/// Logs signals of a run to a file, and their units to a second one.
pub struct Log {
    file: CsvFile,
    signals: Signals,
    /// Columns of values that an f64 cannot hold, and their present texts.
    non_numeric: Vec<(usize, Port)>,
    texts: Vec<(usize, String)>,
    /// The units file, unless the rows go to a pipe or a device.
    units: Option<OutputFile>,
    /// Time of the last row, s.
    last: Option<f64>,
    /// Communication steps between rows.
    stride: u64,
    /// The last columns are the length and the error of the step.
    has_steps: bool,
}

impl Log {
    /// Log the variables `ports` every `interval`, s, or at every communication point. With
    /// `has_steps`, for chosen step lengths, the last columns are `step`, s, and `step_error`,
    /// relative to the allowed error.
    pub fn create(
        path: &Path,
        system: &System,
        ports: &[Port],
        interval: Option<f64>,
        stepping: Stepping,
        has_steps: bool,
    ) -> Result<Self> {
        let stride = stride(interval, stepping.step)?;
        let mut names: Vec<String> = ports.iter().map(|p| system.name(*p)).collect();
        let unit = |p: &Port| system.variable(*p).unit.clone().unwrap_or("1".into());
        let mut units = String::from("signal,unit\ntime,s\n");
        for (name, port) in names.iter().zip(ports) {
            units += &format!("{},{}\n", cell(name), cell(&unit(port)));
        }
        if has_steps {
            names.extend(["step", "step_error"].map(String::from));
            units += "step,s\nstep_error,1\n";
        }
        let columns = ports.iter().copied().enumerate();
        let (non_numeric, numbers): (Vec<_>, Vec<_>) =
            columns.partition(|(_, port)| is_text(system, *port));
        let numbers: Vec<Port> = numbers.into_iter().map(|(_, port)| port).collect();
        let file = CsvFile::create(path, &names)?;
        let units = (!file.out.is_stream()).then(|| {
            let mut file = OutputFile::create(&path.with_extension("units.csv"))?;
            file.write_all(units.as_bytes()).map(|()| file)
        });
        Ok(Self {
            file,
            units: units.transpose()?,
            last: None,
            signals: Signals::new(system, &numbers)?,
            non_numeric,
            texts: Vec::new(),
            stride,
            has_steps,
        })
    }

    fn add_row(&mut self, master: &Master) -> Result<()> {
        self.texts.clear();
        for (column, port) in &self.non_numeric {
            self.texts.push((*column, master.text(*port)?));
        }
        let values = self.signals.read(master)?;
        self.last = Some(master.time());
        if self.has_steps {
            let LastStep { length, error } = master.last_step;
            let values = [values, &[length, error]].concat();
            return self.file.row_with(master.time(), &values, &self.texts);
        }
        self.file.row_with(master.time(), values, &self.texts)
    }

    /// Path of the rows.
    pub fn path(&self) -> &Path {
        self.file.out.path()
    }

    /// Completes the files, unless they hold no row; the time of the last row, s.
    pub fn finish(self) -> Result<Option<f64>> {
        if self.last.is_some() {
            self.file.finish()?;
            self.units.map_or(Ok(()), OutputFile::commit)?;
        }
        Ok(self.last)
    }
}

/// Whether a variable has values that an f64 cannot hold.
pub fn is_text(system: &System, port: Port) -> bool {
    let v = system.variable(port);
    is_non_numeric(v.access()) && !matches!(v.kind, Kind::Enumeration(_))
}

/// A row for each communication point at which one is due.
impl Observer for Log {
    fn observe(&mut self, master: &Master) -> Result<()> {
        match master.steps().is_multiple_of(self.stride) {
            true => self.add_row(master),
            false => Ok(()),
        }
    }

    fn end(&mut self, master: &Master) -> Result<()> {
        match self.last == Some(master.time()) {
            true => Ok(()),
            false => self.add_row(master),
        }
    }
}

/// Number of communication steps in an interval, s, which must be a multiple of the step; 1 without
/// an interval.
pub fn stride(interval: Option<f64>, step: f64) -> Result<u64> {
    let steps = interval.map_or(Some(1), |interval| steps_in(interval, step));
    steps.with_context(|| {
        let interval = interval.unwrap_or_default();
        format!(
            "an interval of {} s must be a multiple of the communication step, {} s",
            short(interval),
            short(step)
        )
    })
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("cosim-csv-{}-{name}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn rows_read_back_bit_for_bit() {
        let folder = folder("rows");
        let path = folder.join("a.csv");
        let values = [1.0 / 3.0, -1e-300, 6.02e23, 0.0];
        let names = ["a.w", "a.x", "a.y", "a.z"].map(String::from);
        let mut csv = CsvFile::create(&path, &names).unwrap();
        csv.row(0.001, &values).unwrap();
        csv.finish().unwrap();
        let text = fs::read_to_string(&path).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("time,a.w,a.x,a.y,a.z"));
        let back = lines.next().unwrap().split(',').map(|v| v.parse().unwrap());
        let back: Vec<f64> = back.collect();
        assert_eq!((back[0], &back[1..]), (0.001, &values[..]));
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_file_that_was_not_completed_leaves_nothing_and_keeps_the_old_one() {
        let folder = folder("part");
        let path = folder.join("a.csv");
        fs::write(&path, "old").unwrap();
        let mut csv = CsvFile::create(&path, &[]).unwrap();
        csv.row(1.0, &[]).unwrap();
        drop(csv);
        let files: Vec<_> = fs::read_dir(&folder).unwrap().collect();
        assert_eq!(files.len(), 1, "{files:?}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn an_interval_is_a_multiple_of_the_step() {
        assert_eq!(stride(None, 0.3).unwrap(), 1);
        assert_eq!(stride(Some(0.02), 1e-3).unwrap(), 20);
        for interval in [0.0, -1.0, 1.5e-3, 4e-4, f64::NAN, f64::INFINITY] {
            let error = stride(Some(interval), 1e-3).unwrap_err().to_string();
            assert!(error.contains("multiple"), "{error}");
        }
    }
}
