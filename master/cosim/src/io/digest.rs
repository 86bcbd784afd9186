//! SHA-256 of bytes and of files, for keys of kept results and snapshots: a file counts by its
//! content, together with the files that it names.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use sha2::{Digest as _, Sha256};

/// SHA-256 of bytes, as hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of the regular file `path` and, if it is JSON, of the files that its texts name, relative
/// to its folder; None if there is no such file.
pub(crate) fn sha256_of_file(path: &Path) -> Option<String> {
    let mut parts = String::new();
    add_file(path, &mut Vec::new(), &mut parts).then(|| sha256(parts.as_bytes()))
}

/// Adds the digests of a file and of those that it names to `parts`, each file once.
fn add_file(path: &Path, seen: &mut Vec<PathBuf>, parts: &mut String) -> bool {
    let Some(file) = path.canonicalize().ok().filter(|file| file.is_file()) else {
        return false;
    };
    if seen.contains(&file) {
        return true;
    }
    let Ok(bytes) = fs::read(&file) else {
        return false;
    };
    seen.push(file);
    *parts += &sha256(&bytes);
    if let Ok(content) = serde_json::from_slice(&bytes) {
        let folder = path.parent().unwrap_or(Path::new(""));
        add_named(&content, folder, seen, parts);
    }
    true
}

fn add_named(content: &Value, folder: &Path, seen: &mut Vec<PathBuf>, parts: &mut String) {
    match content {
        Value::String(name) if !name.is_empty() => {
            add_file(&folder.join(name), seen, parts);
        }
        Value::Array(items) => items.iter().for_each(|v| add_named(v, folder, seen, parts)),
        Value::Object(items) => (items.values()).for_each(|v| add_named(v, folder, seen, parts)),
        _ => {}
    }
}
