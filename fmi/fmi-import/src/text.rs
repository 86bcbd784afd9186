//! Reads C strings of FMUs, for `log`, `raw` and `functions`; on Linux any pointer may be given.

use std::ffi::{CStr, CString};

use crate::standard::Text;

/// The most bytes that a value of a String or Binary variable may have.
pub const MAX_VALUE: usize = 256 << 20;

/// Reads a text; None if the pointer leads to no memory that can be read, or to more than
/// [`MAX_VALUE`] bytes. NULL is an empty text.
///
/// # Safety
/// On Linux any pointer may be given; elsewhere it must be NULL or a C string.
pub unsafe fn read(text: Text) -> Option<CString> {
    // SAFETY: forwarded.
    let bytes = unsafe { read_first(text, MAX_VALUE) }?;
    (bytes.len() < MAX_VALUE).then(|| CString::new(bytes).unwrap_or_default())
}

/// Reads the first [`MAX_TEXT`](crate::messages::MAX_TEXT) bytes of a text, or says that the pointer
/// cannot be read.
///
/// # Safety
/// As for [`read`].
pub unsafe fn read_or_explain(text: Text) -> String {
    // SAFETY: forwarded.
    match unsafe { read_first(text, crate::messages::MAX_TEXT) } {
        Some(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
        None => format!("(no text: {text:p} cannot be read)"),
    }
}

/// Reads the first `limit` bytes of a text; None as for [`read`].
///
/// # Safety
/// As for [`read`].
unsafe fn read_first(text: Text, limit: usize) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    if text.is_null() {
        return Some(bytes);
    }
    let mut part = [0_u8; 4096];
    while bytes.len() < limit {
        let (left, at) = (
            limit - bytes.len(),
            text.wrapping_add(bytes.len()).cast::<u8>(),
        );
        // No copy crosses the end of a page, since the next page may not be there. Most texts are
        // short.
        let page = if bytes.is_empty() { 256 } else { part.len() };
        let part = &mut part[..(page - at.addr() % page).min(left)];
        // SAFETY: forwarded.
        if !unsafe { copy(at, part) }? {
            // SAFETY: forwarded; the system does not let a process copy from itself.
            let rest = unsafe { CStr::from_ptr(at.cast()) }.to_bytes();
            bytes.extend(&rest[..rest.len().min(left)]);
            return Some(bytes);
        }
        let end = part.iter().position(|byte| *byte == 0);
        bytes.extend(&part[..end.unwrap_or(part.len())]);
        if end.is_some() {
            return Some(bytes);
        }
    }
    Some(bytes)
}

/// Reads `size` bytes into a buffer; false if they are not there, or more than [`MAX_VALUE`].
///
/// # Safety
/// On Linux any pointer may be given; elsewhere as many bytes must be readable.
pub unsafe fn read_bytes(at: *const u8, size: usize, bytes: &mut Vec<u8>) -> bool {
    bytes.clear();
    if size == 0 || size > MAX_VALUE {
        return size == 0;
    }
    bytes.resize(size, 0);
    // SAFETY: forwarded.
    match unsafe { copy(at, bytes) } {
        // SAFETY: forwarded.
        Some(false) => bytes.copy_from_slice(unsafe { std::slice::from_raw_parts(at, size) }),
        Some(true) => {}
        None => bytes.clear(),
    }
    !bytes.is_empty()
}

/// Lets the system copy bytes, which reports memory that is not there: then None. False if the
/// system does not let a process copy from itself.
///
/// # Safety
/// None is needed on Linux: the system checks the pointer. Elsewhere nothing is read.
unsafe fn copy(from: *const u8, to: &mut [u8]) -> Option<bool> {
    #[cfg(all(target_os = "linux", feature = "native"))]
    {
        let iov_len = to.len();
        let [local, remote] = [to.as_mut_ptr(), from.cast_mut()].map(|base| libc::iovec {
            iov_base: base.cast(),
            iov_len,
        });
        // SAFETY: `local` is large enough; the system checks `remote`.
        let copied = unsafe { libc::process_vm_readv(libc::getpid(), &local, 1, &remote, 1, 0) };
        if usize::try_from(copied) == Ok(iov_len) {
            return Some(true);
        }
        let error = std::io::Error::last_os_error().raw_os_error();
        // A part was copied: the rest is not there.
        if copied >= 0 || error == Some(libc::EFAULT) {
            return None;
        }
    }
    let _ = (from, to);
    Some(false)
}

/// `logger.c` lets this copy a text into `room` bytes, with a zero at the end; returns how many
/// bytes it has, or -1 if it cannot be read.
#[cfg(feature = "printf")]
#[unsafe(no_mangle)]
unsafe extern "C" fn fmi_import_copy(text: Text, to: *mut u8, room: usize) -> std::ffi::c_long {
    // SAFETY: as for `read`.
    let read = unsafe { read_first(text, room - 1) };
    let bytes = read.as_deref().unwrap_or_default();
    // SAFETY: `to` has `room` bytes.
    unsafe {
        to.copy_from_nonoverlapping(bytes.as_ptr(), bytes.len());
        to.add(bytes.len()).write(0);
    }
    read.as_ref()
        .map_or(-1, |bytes| bytes.len() as std::ffi::c_long)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_any_length_are_read() {
        let long = std::ffi::CString::new("äx".repeat(1000)).unwrap();
        // SAFETY: C strings and NULL.
        let [long_read, empty, none] =
            unsafe { [long.as_ptr(), c"".as_ptr(), std::ptr::null()].map(|text| read(text)) };
        assert_eq!(long_read, Some(long));
        assert_eq!([empty, none], [(); 2].map(|()| Some(CString::default())));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_pointer_that_leads_nowhere_is_told() {
        let nowhere: Text = std::ptr::without_provenance(8);
        // SAFETY: any pointer may be given.
        unsafe {
            assert_eq!(read(nowhere), None);
            assert_eq!(read_or_explain(nowhere), "(no text: 0x8 cannot be read)");
            let (bytes, mut read) = ([1_u8, 2, 3], vec![9]);
            assert!(!read_bytes(nowhere.cast(), 4, &mut read) && read.is_empty());
            assert!(read_bytes(bytes.as_ptr(), 3, &mut read) && read == bytes);
            assert!(!read_bytes(bytes.as_ptr(), MAX_VALUE + 1, &mut read));
            assert!(read_bytes(nowhere.cast(), 0, &mut read) && read.is_empty());
        }
    }
}
