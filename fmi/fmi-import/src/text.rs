//! C strings that an FMU hands out, read without trusting that they are there.

use std::ffi::{CStr, CString};

use crate::standard::Text;

/// A text; None where the pointer leads to no memory that can be read. NULL is an empty text.
///
/// # Safety
/// On Linux any pointer may be given; elsewhere it must be NULL or a C string.
pub unsafe fn owned(text: Text) -> Option<CString> {
    if text.is_null() {
        return Some(CString::default());
    }
    #[cfg(all(target_os = "linux", feature = "native"))]
    if let Some(read) = through_the_system(text) {
        return read;
    }
    // SAFETY: forwarded.
    Some(unsafe { CStr::from_ptr(text) }.to_owned())
}

/// The text, or what is told of a pointer that leads nowhere.
///
/// # Safety
/// As for [`read`].
pub unsafe fn shown(text: Text) -> String {
    // SAFETY: forwarded.
    let read = unsafe { owned(text) };
    let read = read.map(|text| text.to_string_lossy().into_owned());
    read.unwrap_or_else(|| format!("(no text: {text:p} cannot be read)"))
}

/// Copied by the system, which tells of memory that is not there; None where it does not let a
/// process copy from itself.
#[cfg(all(target_os = "linux", feature = "native"))]
fn through_the_system(text: Text) -> Option<Option<CString>> {
    let mut bytes = Vec::new();
    let mut room = [0_u8; 256];
    loop {
        let from = text.addr() + bytes.len();
        // No copy crosses a border of pages: what lies behind it may not be there.
        let length = (256 - from % 256).min(room.len());
        let local = libc::iovec {
            iov_base: room.as_mut_ptr().cast(),
            iov_len: length,
        };
        let remote = libc::iovec {
            iov_base: text.wrapping_add(bytes.len()).cast_mut().cast(),
            iov_len: length,
        };
        // SAFETY: room for the bytes; the system checks where they come from.
        let copied = unsafe { libc::process_vm_readv(libc::getpid(), &local, 1, &remote, 1, 0) };
        if usize::try_from(copied) != Ok(length) {
            let error = std::io::Error::last_os_error().raw_os_error();
            return (error == Some(libc::EFAULT)).then_some(None);
        }
        let end = room[..length].iter().position(|byte| *byte == 0);
        bytes.extend(&room[..end.unwrap_or(length)]);
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
            unsafe { [long.as_ptr(), c"".as_ptr(), std::ptr::null()].map(|text| owned(text)) };
        assert_eq!(long_read, Some(long));
        assert_eq!([empty, none], [(); 2].map(|()| Some(CString::default())));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_pointer_that_leads_nowhere_is_told() {
        let nowhere: Text = std::ptr::without_provenance(8);
        // SAFETY: any pointer may be given.
        unsafe {
            assert_eq!(owned(nowhere), None);
            assert_eq!(shown(nowhere), "(no text: 0x8 cannot be read)");
        }
    }
}
