//! Converts fmuResourceLocation, a URI, to the resources folder, for fmi2Instantiate.

use percent_encoding::percent_decode_str;
use std::path::PathBuf;

/// The folder of a `file:` URI such as `file:/C:/x`, `file:///x` or `file://localhost/x`, also with
/// extra or trailing slashes and percent-encoding. A plain absolute path is also accepted.
pub(crate) fn folder(uri: &str) -> Result<PathBuf, String> {
    let path = match uri.get(..5) {
        Some(scheme) if scheme.eq_ignore_ascii_case("file:") => {
            let decoded = percent_decode_str(local_part(uri, &uri[5..])?).decode_utf8();
            decoded.map_err(|_| {
                format!("resource location `{uri}` is not UTF-8 after percent-decoding")
            })?
        }
        _ if uri.starts_with('/') || has_drive(uri) => uri.into(),
        _ => {
            return Err(format!(
                "resource location `{uri}` is neither a file: URI nor an absolute path"
            ));
        }
    };
    let inner = path.trim_start_matches('/');
    let absolute = if has_drive(inner) {
        inner.to_owned()
    } else {
        format!("/{inner}")
    };
    // The slash of a root is kept: `C:` alone would mean the current folder of the drive.
    let end = absolute.trim_end_matches('/').len().max(1);
    let end = if absolute[..end].ends_with(':') {
        end + 1
    } else {
        end
    };
    Ok(PathBuf::from(&absolute[..end.min(absolute.len())]))
}

/// The part after `file:` without an empty or `localhost` host.
fn local_part<'a>(uri: &str, rest: &'a str) -> Result<&'a str, String> {
    let Some(authority) = rest.strip_prefix("//") else {
        return if rest.starts_with('/') || has_drive(rest) {
            Ok(rest)
        } else {
            Err(format!("resource location `{uri}` is not absolute"))
        };
    };
    let end = authority.find('/').unwrap_or(authority.len());
    match &authority[..end] {
        "" => Ok(&authority[end..]),
        host if host.eq_ignore_ascii_case("localhost") => Ok(&authority[end..]),
        drive if has_drive(drive) => Ok(authority),
        host => Err(format!(
            "resource location `{uri}` is on host `{host}`; it must be local"
        )),
    }
}

/// Whether a path starts with a drive: `C:` or `C:/…`.
fn has_drive(path: &str) -> bool {
    let bytes = path.as_bytes();
    matches!(bytes, [letter, b':'] | [letter, b':', b'/' | b'\\', ..] if letter.is_ascii_alphabetic())
}

#[cfg(test)]
mod tests {
    use super::folder;

    #[test]
    fn every_form_of_uri_gives_its_folder() {
        for (uri, path) in [
            ("file:///tmp/a/resources", "/tmp/a/resources"),
            ("file:/tmp/a/resources", "/tmp/a/resources"),
            ("FILE:///tmp/a/resources/", "/tmp/a/resources"),
            ("file://localhost/tmp/a/resources", "/tmp/a/resources"),
            ("file://LocalHost/tmp/a/resources///", "/tmp/a/resources"),
            ("file:////tmp/a/resources", "/tmp/a/resources"),
            ("file://///tmp/a/resources", "/tmp/a/resources"),
            (
                "file:///tmp/mit%20Leerzeichen/%C3%BCber%23%25",
                "/tmp/mit Leerzeichen/über#%",
            ),
            (
                "file:///tmp/mit Leerzeichen/über",
                "/tmp/mit Leerzeichen/über",
            ),
            ("file:///C:/a/resources", "C:/a/resources"),
            ("file:/C:/a/resources/", "C:/a/resources"),
            ("file:C:/a/resources", "C:/a/resources"),
            ("file://C:/a/resources", "C:/a/resources"),
            ("file:///c%3A/a/resources", "c:/a/resources"),
            ("file:////C:/a", "C:/a"),
            ("file:///C:/", "C:/"),
            ("file:///", "/"),
            ("/tmp/100%25/a/", "/tmp/100%25/a"),
            ("C:\\a\\resources", "C:\\a\\resources"),
        ] {
            assert_eq!(
                folder(uri).as_deref(),
                Ok(std::path::Path::new(path)),
                "{uri}"
            );
        }
    }

    #[test]
    fn what_is_no_local_folder_is_named() {
        for (uri, reason) in [
            ("file://server/share", "host `server`"),
            (
                "http://localhost/a",
                "neither a file: URI nor an absolute path",
            ),
            ("", "neither"),
            ("file:", "not absolute"),
            ("file:a/b", "not absolute"),
            ("resources", "neither"),
            ("file:///%FF", "not UTF-8"),
        ] {
            let error = folder(uri).expect_err(uri);
            assert!(error.contains(reason) && error.contains(uri), "{error}");
        }
    }
}
