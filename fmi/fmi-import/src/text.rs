//! Reads C strings of FMUs, for `log`, `raw` and `functions`; on Linux any pointer may be given.

use std::ffi::{CStr, CString};

use crate::standard::Text;

/// Reads a text; None if the pointer leads to no memory that can be read. NULL is an empty text.
///
/// # Safety
/// On Linux any pointer may be given; elsewhere it must be NULL or a C string.
pub unsafe fn read(text: Text) -> Option<CString> {
    if text.is_null() {
        return Some(CString::default());
    }
    #[cfg(all(target_os = "linux", feature = "native"))]
    if let Some(read) = read_by_system(text) {
        return read;
    }
    // SAFETY: forwarded.
    Some(unsafe { CStr::from_ptr(text) }.to_owned())
}

/// Reads a text, or says that the pointer cannot be read.
///
/// # Safety
/// As for [`read`].
pub unsafe fn read_or_explain(text: Text) -> String {
    // SAFETY: forwarded.
    let read = unsafe { read(text) };
    let read = read.map(|text| text.to_string_lossy().into_owned());
    read.unwrap_or_else(|| format!("(no text: {text:p} cannot be read)"))
}

/// Lets the system copy the text, which reports memory that is not there (`Some(None)`). None if
/// the system does not let a process copy from itself.
#[cfg(all(target_os = "linux", feature = "native"))]
fn read_by_system(text: Text) -> Option<Option<CString>> {
    let mut bytes = Vec::new();
    let mut page_part = [0_u8; 256];
    loop {
        let from = text.addr() + bytes.len();
        // No copy crosses the end of a page, since the next page may not be there.
        let length = (256 - from % 256).min(page_part.len());
        let local = libc::iovec {
            iov_base: page_part.as_mut_ptr().cast(),
            iov_len: length,
        };
        let remote = libc::iovec {
            iov_base: text.wrapping_add(bytes.len()).cast_mut().cast(),
            iov_len: length,
        };
        // SAFETY: `local` is large enough; the system checks `remote`.
        let copied = unsafe { libc::process_vm_readv(libc::getpid(), &local, 1, &remote, 1, 0) };
        if usize::try_from(copied) != Ok(length) {
            let error = std::io::Error::last_os_error().raw_os_error();
            return (error == Some(libc::EFAULT)).then_some(None);
        }
        let end = page_part[..length].iter().position(|byte| *byte == 0);
        bytes.extend(&page_part[..end.unwrap_or(length)]);
        if end.is_some() {
            return Some(CString::new(bytes).ok());
        }
    }
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
        }
    }
}
