//! Results of two platforms compared number by number.

use anyhow::{Result, bail, ensure};

/// Numbers of two CSV files that must be equal in every digit; how many there are. The first that differs is named.
pub fn same(one: &str, other: &str) -> Result<usize> {
    let names: Vec<_> = one.lines().next().unwrap_or_default().split(',').collect();
    ensure!(
        !names.is_empty() && one.lines().count() > 1,
        "there are no numbers"
    );
    ensure!(
        one.lines().count() == other.lines().count(),
        "{} lines and {} lines",
        one.lines().count(),
        other.lines().count()
    );
    let mut numbers = 0;
    for (row, (a, b)) in one.lines().zip(other.lines()).enumerate() {
        if a != b {
            bail!("row {row}: {}", difference(&names, a, b));
        }
        numbers += a.split(',').count();
    }
    Ok(numbers - names.len())
}

fn difference(names: &[&str], a: &str, b: &str) -> String {
    let cells = names.iter().zip(a.split(',').zip(b.split(',')));
    let differing: Vec<_> = cells
        .filter(|(_, (a, b))| a != b)
        .map(|(name, (a, b))| format!("`{name}` is {a} and {b}"))
        .collect();
    match differing.as_slice() {
        [] => "the lines have different lengths".to_string(),
        [first] => first.clone(),
        [first, more @ ..] => format!("{first}, and {} more", more.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::same;

    #[test]
    fn the_last_digit_counts() {
        let one = "time,x\n0,1.5\n0.001,2.25\n";
        assert_eq!(same(one, one).unwrap(), 4);
        let other = one.replace("2.25", "2.2500000000000004");
        let error = same(one, &other).unwrap_err().to_string();
        assert_eq!(error, "row 2: `x` is 2.25 and 2.2500000000000004");
        assert!(same(one, "time,x\n0,1.5\n").is_err());
        assert!(same("time,x\n", "time,x\n").is_err());
    }
}
