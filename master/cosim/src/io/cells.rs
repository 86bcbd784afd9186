//! Splits lines of CSV files into cells for input tables, and quotes the cells of written files.

use std::borrow::Cow;

/// A text as a cell, quoted if necessary: names of array elements contain commas, `a[1,2]`.
pub fn cell(text: &str) -> Cow<'_, str> {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")).into(),
        false => text.into(),
    }
}

/// The cells of a line, without quotes and surrounding blanks.
pub(crate) fn cells(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let (mut is_quoted, mut letters) = (false, line.trim().chars().peekable());
    while let Some(letter) = letters.next() {
        let last = cells.last_mut().expect("there is always one");
        match letter {
            '"' if is_quoted && letters.next_if_eq(&'"').is_some() => last.push('"'),
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(String::new()),
            _ => last.push(letter),
        }
    }
    cells.iter().map(|cell| cell.trim().to_string()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_commas_and_quotes_read_back() {
        let names = ["a.J[1,2]", "a.\"q\"", "a.x"];
        let line = names.map(cell).join(",");
        assert_eq!(line, "\"a.J[1,2]\",\"a.\"\"q\"\"\",a.x");
        assert_eq!(cells(&line), names);
        assert_eq!(cells(" a , \"b\",,"), ["a", "b", "", ""]);
    }
}
