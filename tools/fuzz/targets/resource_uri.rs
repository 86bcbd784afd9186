//! A resource location becomes an absolute path or is refused. The private module's source is
//! included.
#![no_main]

#[path = "../../../kit/fmu-export/src/fmi2/uri.rs"]
#[allow(dead_code)]
mod uri;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(folder) = uri::folder(text) {
        let shown = folder.to_str().expect("made of text");
        let has_drive = shown.as_bytes().get(1) == Some(&b':');
        assert!(shown.starts_with('/') || has_drive, "{text} -> {shown}");
    }
});
