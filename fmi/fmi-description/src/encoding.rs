//! Decodes the bytes of an XML file by its byte order mark or by the encoding named in its first
//! line: model descriptions for `parse` and the check, files of SSP for the master.

use thiserror::Error;

/// Why bytes are no text.
#[derive(Debug, Error)]
#[error("{0}")]
pub struct EncodingError(String);

/// The letters of Windows-1252 from 0x80 to 0x9F, where ISO-8859-1 has control characters; U+FFFD
/// for unused codes.
const WINDOWS: [char; 32] = [
    '€', '\u{fffd}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{fffd}', 'Ž',
    '\u{fffd}', '\u{fffd}', '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{fffd}',
    'ž', 'Ÿ',
];

/// Decodes an XML file in UTF-8, UTF-16, ASCII, ISO-8859-1 or Windows-1252.
///
/// # Errors
/// It is in another encoding, or not in the one that it names.
pub fn text(bytes: &[u8]) -> Result<String, EncodingError> {
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => utf8(rest),
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes),
        [b'<', 0, ..] => utf16(bytes, u16::from_le_bytes),
        [0, b'<', ..] => utf16(bytes, u16::from_be_bytes),
        _ => named(bytes),
    }
}

/// Decodes by the name in the first line, which is ASCII in all of these; UTF-8 if there is none.
fn named(bytes: &[u8]) -> Result<String, EncodingError> {
    let end = bytes.windows(2).position(|two| two == b"?>");
    let head = end.filter(|_| bytes.starts_with(b"<?xml"));
    let head = String::from_utf8_lossy(&bytes[..head.unwrap_or(0)]);
    let name = head.split_once("encoding").map_or("", |(_, rest)| rest);
    let name = name.trim_start_matches(|c: char| c.is_whitespace() || c == '=');
    let name = name.split(['"', '\'']).nth(1).unwrap_or("UTF-8");
    match name.to_ascii_lowercase().as_str() {
        // Programs convert a file to UTF-8 and leave `UTF-16` in its first line.
        "utf-8" | "utf8" | "us-ascii" | "ascii" | "utf-16" => utf8(bytes),
        "iso-8859-1" | "iso8859-1" | "latin1" | "latin-1" => {
            Ok(bytes.iter().map(|byte| char::from(*byte)).collect())
        }
        "windows-1252" | "cp1252" => Ok(bytes.iter().map(|byte| windows(*byte)).collect()),
        _ => Err(EncodingError(format!(
            "it is in `{name}`, but must be in UTF-8, UTF-16, ISO-8859-1 or Windows-1252"
        ))),
    }
}

fn windows(byte: u8) -> char {
    match byte {
        0x80..=0x9f => WINDOWS[usize::from(byte - 0x80)],
        _ => char::from(byte),
    }
}

fn utf8(bytes: &[u8]) -> Result<String, EncodingError> {
    let text = std::str::from_utf8(bytes);
    let text = text.map_err(|e| EncodingError(format!("it is not UTF-8: {e}")))?;
    Ok(text.to_string())
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<String, EncodingError> {
    let (pairs, rest) = bytes.as_chunks::<2>();
    let units: Vec<u16> = pairs.iter().map(|pair| unit(*pair)).collect();
    match String::from_utf16(&units) {
        Ok(text) if rest.is_empty() => Ok(text),
        _ => Err(EncodingError("it is not UTF-16".into())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_first_line_names_is_obeyed() {
        let latin = b"<?xml version='1.0' encoding = 'iso-8859-1' ?><a b='\xfc\x96'/>";
        assert!(text(latin).unwrap().ends_with("<a b='ü\u{96}'/>"));
        let windows = b"<?xml version=\"1.0\" encoding=\"Windows-1252\"?><a b='\xfc\x96\x80'/>";
        assert!(text(windows).unwrap().ends_with("<a b='ü–€'/>"));
        let plain = "<a encoding=\"iso-8859-1\" b='ü'/>";
        assert_eq!(text(plain.as_bytes()).unwrap(), plain);
        let refused = text(b"<?xml version='1.0' encoding='EBCDIC-US'?><a/>").unwrap_err();
        assert!(refused.to_string().contains("`EBCDIC-US`"), "{refused}");
        assert!(text(b"<a b='\xfc'/>").is_err());
        let converted = "<?xml version='1.0' encoding='utf-16'?><a b='ü'/>";
        assert_eq!(text(converted.as_bytes()).unwrap(), converted);
    }

    #[test]
    fn byte_order_marks_are_obeyed() {
        let xml = "<?xml version='1.0' encoding='UTF-16'?><a b='ü𝛀'/>";
        let little: Vec<u8> = xml.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = xml.encode_utf16().flat_map(u16::to_be_bytes).collect();
        assert_eq!(text(&little).unwrap(), xml);
        assert_eq!(text(&big).unwrap(), xml);
        assert_eq!(text(&[&[0xff, 0xfe], &little[..]].concat()).unwrap(), xml);
        assert_eq!(text(&[&[0xfe, 0xff], &big[..]].concat()).unwrap(), xml);
        let marked = [&[0xef, 0xbb, 0xbf], "<a b='ü'/>".as_bytes()].concat();
        assert_eq!(text(&marked).unwrap(), "<a b='ü'/>");
        assert!(text(&little[..little.len() - 1]).is_err());
    }
}
