//! Lets the host of a WebAssembly module, which has no file system, place files in the module.

use crate::core::placed_files;
use std::slice;

/// Places a file for all instances of this module, in the place of one that has the same path;
/// 0 if all is well, 1 if path or contents are not UTF-8.
#[unsafe(no_mangle)]
unsafe extern "C" fn fmu_place_file(
    path: *const u8,
    path_size: usize,
    bytes: *const u8,
    size: usize,
) -> i32 {
    let text = |bytes: *const u8, size: usize| match size {
        0 => Ok(String::new()),
        // SAFETY: the host gives as many bytes as it says.
        _ => String::from_utf8(unsafe { slice::from_raw_parts(bytes, size) }.to_vec()),
    };
    let (Ok(path), Ok(text)) = (text(path, path_size), text(bytes, size)) else {
        return 1;
    };
    placed_files::place(path.into(), text);
    0
}
