//! Files of FMI-LS-REF, which say what an FMU's default experiment gives: `pack` puts them into the
//! FMU with a manifest, and `verify` finds them by it. They lie in `reference/` next to the package's
//! Cargo.toml: results (CSV), inputs over time (`…_in.csv`), and parameter sets (SSV).

use anyhow::{Context, Result, bail};
use csv::ReaderBuilder;
use fmi_description::Entries;
use fmi_description::xml::{Element, quoted};

/// The folder next to the package's Cargo.toml.
pub const SOURCE: &str = "reference";
/// The folder in the FMU.
const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";
const MANIFEST: &str = "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml";
/// The version of the draft that the Reference-FMUs carry.
const VERSION: &str = "1.0.0-alpha.1";

/// Role, type, and description of a file by its name; None if it is none of these.
fn kind(name: &str) -> Option<[&'static str; 3]> {
    match name.rsplit_once('.')?.1 {
        "ssv" => Some([
            "parameter",
            "application/x-ssp-parameter-set",
            "Parameters of the default experiment",
        ]),
        "csv" if name.ends_with("_in.csv") => {
            Some(["input", "text/csv", "Input of the default experiment"])
        }
        "csv" => Some(["result", "text/csv", "Output of the default experiment"]),
        _ => None,
    }
}

/// Moves the files of [`SOURCE`] to their folder in the FMU, and adds the manifest.
///
/// # Errors
/// One of them is of no kind that belongs there.
pub fn place(entries: &mut Entries) -> Result<()> {
    let prefix = format!("{SOURCE}/");
    let is_own = |path: &String| path.starts_with(&prefix);
    let paths: Vec<_> = entries
        .keys()
        .filter(|path| is_own(path))
        .cloned()
        .collect();
    if paths.is_empty() {
        return Ok(());
    }
    let mut related = String::new();
    for path in paths {
        let name = &path[prefix.len()..];
        let Some([role, media, description]) = kind(name) else {
            bail!("{path} must be a result (.csv), an input (_in.csv) or a parameter set (.ssv)");
        };
        related += &format!(
            "    <Related type=\"{media}\" source={} role=\"{role}\" description=\"{description}\"/>\n",
            quoted(name)
        );
        let bytes = entries.remove(&path).expect("a key of it");
        entries.insert(format!("{FOLDER}/{name}"), bytes);
    }
    let manifest = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiReferences\n    xmlns:fmi-ls=\"http://fmi-standard.org/fmi-ls-manifest\"\n    \
         fmi-ls:fmi-ls-name=\"org.fmi-standard.fmi-ls-ref\"\n    fmi-ls:fmi-ls-version=\"{VERSION}\"\n    \
         fmi-ls:fmi-ls-description=\"Results of the default experiment\">\n{related}</fmiReferences>\n"
    );
    entries.insert(MANIFEST.to_owned(), manifest.into_bytes());
    Ok(())
}

/// The files that a manifest names.
#[derive(Debug, Default)]
pub struct References {
    /// Names and values of parameters, one after the other.
    pub parameters: Vec<(String, String)>,
    /// Inputs over time.
    pub input: Option<Table>,
    /// Results, each with the name of its file.
    pub results: Vec<(String, Table)>,
}

/// A table of texts by time.
#[derive(Debug, PartialEq)]
pub struct Table {
    /// Names of the columns after `time`.
    pub names: Vec<String>,
    /// Times, s, and the other cells.
    pub rows: Vec<(f64, Vec<String>)>,
}

impl References {
    /// Those of an FMU with these files.
    ///
    /// # Errors
    /// It has no manifest, or a file is missing or cannot be read.
    pub fn read(entries: &Entries) -> Result<Self> {
        let text = |path: &str| {
            let bytes = entries.get(path);
            let bytes = bytes.with_context(|| format!("the FMU has no file {path}"))?;
            std::str::from_utf8(bytes).with_context(|| format!("{path} must be UTF-8"))
        };
        let manifest =
            text(MANIFEST).context("without FMI-LS-REF there is nothing to compare with")?;
        let root = Element::parse(manifest, MANIFEST, "fmiReferences")?;
        let mut found = Self::default();
        for related in root.all("Related") {
            let source = related.required("source")?;
            let path = format!("{FOLDER}/{source}");
            match related.get("role").unwrap_or_default() {
                "parameter" => found.parameters.extend(parameters(text(&path)?, &path)?),
                "input" => found.input = Some(Table::parse(text(&path)?).context(path)?),
                "result" => {
                    let table = Table::parse(text(&path)?).context(path)?;
                    found.results.push((source, table));
                }
                _ => {} // further roles of the draft need nothing here
            }
        }
        Ok(found)
    }
}

/// The parameters of a parameter set of SSP.
fn parameters(text: &str, path: &str) -> Result<Vec<(String, String)>> {
    let root = Element::parse(text, path, "ParameterSet")?;
    let each = root.listed("Parameters", "Parameter");
    each.map(|parameter| {
        let value = parameter
            .children
            .iter()
            .find_map(|value| value.get("value"));
        let name = parameter.required("name")?;
        let value = value.with_context(|| format!("{path}: parameter `{name}` has no value"))?;
        Ok((name, value.to_owned()))
    })
    .collect()
}

impl Table {
    /// Reads CSV, whose first column is `time` and ascends.
    ///
    /// # Errors
    /// A row has another number of cells, or a time is no number or before the last one.
    pub fn parse(text: &str) -> Result<Self> {
        let mut reader = ReaderBuilder::new();
        let mut reader = reader
            .has_headers(false)
            .flexible(true)
            .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
        let is_row = |row: &csv::Result<Vec<String>>| !matches!(row.as_deref(), Ok([cell]) if cell.trim().is_empty());
        let mut lines = reader.deserialize().filter(is_row);
        let mut next = || lines.next().transpose();
        let head = next()?.context("it is empty")?;
        let mut rows: Vec<(f64, Vec<String>)> = Vec::new();
        while let Some(mut row) = next()? {
            let (n, line) = (row.len(), rows.len() + 2);
            if n != head.len() {
                bail!("row {line} has {n} cells; it must have {}", head.len());
            }
            let first = row.remove(0);
            let time = first.trim().parse().ok().filter(|t: &f64| t.is_finite());
            match (time, rows.last()) {
                (Some(t), Some((last, _))) if t < *last => {
                    bail!("row {line}: time {t} s is before {last} s");
                }
                (Some(t), _) => rows.push((t, row)),
                (None, _) => bail!("row {line}: time `{first}` must be a finite number"),
            }
        }
        if rows.is_empty() {
            bail!("it has no rows");
        }
        let names = head[1..].to_vec();
        Ok(Self { names, rows })
    }

    /// The cells of the last row at or before `t`, s, and those of the next one with the part of the
    /// way to it.
    pub fn at(&self, t: f64) -> (&[String], Option<(&[String], f64)>) {
        let near = 1e-9 * t.abs().max(1.0);
        let after = self.rows.partition_point(|(time, _)| *time <= t + near);
        let (from, row) = &self.rows[after.saturating_sub(1)];
        let next = self.rows.get(after).filter(|_| after > 0);
        let next = next.map(|(to, next)| (&next[..], ((t - from) / (to - from)).max(0.0)));
        (row, next)
    }
}

#[cfg(test)]
mod tests {
    use super::{References, SOURCE, Table, place};
    use fmi_description::Entries;

    #[test]
    fn what_is_packed_is_found() {
        let set = "<ssv:ParameterSet xmlns:ssv=\"v\"><ssv:Parameters><ssv:Parameter name=\"k\"><ssv:Real value=\"2.5\"/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet>";
        let mut entries = Entries::new();
        for (name, text) in [
            ("A_out.csv", "time,y\n0,1\n0.5,2\n"),
            ("A_in.csv", "time,u\n0,0\n1,4"),
            ("A.ssv", set),
        ] {
            entries.insert(format!("{SOURCE}/{name}"), text.into());
        }
        place(&mut entries).unwrap();
        assert!(
            entries
                .keys()
                .all(|path| path.starts_with("extra/org.fmi-standard.fmi-ls-ref/"))
        );
        let found = References::read(&entries).unwrap();
        assert_eq!(found.parameters, [("k".to_owned(), "2.5".to_owned())]);
        assert_eq!(found.results[0].0, "A_out.csv");
        assert_eq!(found.results[0].1.rows[1], (0.5, vec!["2".to_owned()]));
        let input = found.input.unwrap();
        assert_eq!(
            input.at(0.25),
            (&["0".to_owned()][..], Some((&["4".to_owned()][..], 0.25)))
        );
        // The row of a time counts from there on, also if the time is rounded.
        for t in [1.0 - 1e-12, 1.0, 3.0] {
            assert_eq!(input.at(t), (&["4".to_owned()][..], None));
        }
        entries.insert(format!("{SOURCE}/notes.txt"), Vec::new());
        let error = place(&mut entries).unwrap_err().to_string();
        assert!(
            error.contains("reference/notes.txt must be a result"),
            "{error}"
        );
    }

    #[test]
    fn a_wrong_table_is_refused() {
        for (text, words) in [
            ("", "it is empty"),
            ("time,y", "no rows"),
            ("time,y\n0", "row 2 has 1 cells; it must have 2"),
            ("time,y\nx,1", "time `x`"),
            ("time,y\n1,1\n0,1", "row 3: time 0 s is before 1 s"),
        ] {
            let error = Table::parse(text).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
        let quoted = Table::parse("time,\"a,b\"\n0,\"1\"\r\n").unwrap();
        assert_eq!(
            (&quoted.names[0][..], &quoted.rows[0].1[0][..]),
            ("a,b", "1")
        );
        let quoted = Table::parse("time,y\n0,\"say \"\"no\"\"\"\n \n").unwrap();
        assert_eq!(quoted.rows, [(0.0, vec!["say \"no\"".to_owned()])]);
    }
}
