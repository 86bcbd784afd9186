//! Results of two platforms compared number by number.

use anyhow::{Result, bail, ensure};

/// Numbers of two CSV files that must be equal in every digit; how many there are. The first that
/// differs is named.
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

/// Numbers of two CSV files, which may differ by a part of the largest value of their signal; how
/// many there are, and the largest such part.
pub fn close(one: &str, other: &str, tolerance: f64) -> Result<(usize, f64)> {
    let (mut rows, mut others) = (one.lines(), other.lines());
    let names = rows.next().unwrap_or_default();
    ensure!(Some(names) == others.next(), "the signals differ");
    let names: Vec<_> = names.split(',').collect();
    // Of each signal: its largest value, and the largest difference.
    let mut largest = vec![[0.0_f64; 2]; names.len()];
    let mut numbers = 0;
    for (a, b) in rows.zip(others) {
        let values = [a, b].map(|row| row.split(',').map(str::parse::<f64>));
        let [a, b] = values.map(Iterator::collect::<Result<Vec<_>, _>>);
        for (k, (a, b)) in a?.into_iter().zip(b?).enumerate() {
            let [value, difference] = &mut largest[k];
            ensure!(
                a.is_finite() && b.is_finite(),
                "`{}` is {a} and {b}",
                names[k]
            );
            *value = value.max(a.abs());
            *difference = difference.max((a - b).abs());
            numbers += 1;
        }
    }
    let lines = one.lines().count();
    ensure!(
        lines > 1 && lines == other.lines().count(),
        "{lines} lines and {}",
        other.lines().count()
    );
    let mut worst = 0.0_f64;
    for (name, [value, difference]) in names.iter().zip(largest) {
        let part = if difference == 0.0 {
            0.0
        } else {
            difference / value
        };
        ensure!(
            part <= tolerance,
            "`{name}` differs by {difference:e}, which is {part:e} of its largest value"
        );
        worst = worst.max(part);
    }
    Ok((numbers, worst))
}

#[cfg(test)]
mod tests {
    use super::{close, same};

    #[test]
    fn differences_are_parts_of_the_largest_value() {
        let one = "time,x\n0,-4\n1,0.5\n";
        assert_eq!(close(one, one, 0.0).unwrap(), (4, 0.0));
        let other = one.replace("0.5", "0.25");
        assert_eq!(close(one, &other, 0.0625).unwrap(), (4, 0.0625));
        let error = close(one, &other, 0.06).unwrap_err().to_string();
        assert_eq!(
            error,
            "`x` differs by 2.5e-1, which is 6.25e-2 of its largest value"
        );
        assert!(close(one, &one.replace("0.5", "NaN"), 1.0).is_err());
        assert!(close(one, "time,x\n0,-4\n", 1.0).is_err());
        assert!(close(one, &one.replace('x', "y"), 1.0).is_err());
    }

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
