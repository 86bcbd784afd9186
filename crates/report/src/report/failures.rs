//! What failed is told in the page, and the rest is shown.

use anyhow::Result;

/// The results that are there; the others go to `failures`.
pub fn kept<T>(results: Vec<Result<T>>, failures: &mut Vec<String>) -> Vec<T> {
    let mut there = Vec::new();
    for result in results {
        match result {
            Ok(value) => there.push(value),
            Err(error) => failures.push(format!("{error:#}")),
        }
    }
    there
}
