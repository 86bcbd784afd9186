//! How large the content of a file may become: an archive once unpacked, XML as a tree, an array
//! with all its elements. A few bytes could otherwise fill memory or disk. Every reader of FMUs and
//! systems keeps to these limits, which are far from what tools write.

/// Most files in an archive.
pub const FILES: usize = 100_000;
/// Deepest nesting of XML elements; trees are walked by recursion.
pub const DEPTH: usize = 256;
/// Most elements in an XML file.
pub const ELEMENTS: usize = 10_000_000;
/// Most attributes of an XML element.
pub const ATTRIBUTES: usize = 256;
/// Most elements of all arrays of an FMU.
pub const ARRAY_ELEMENTS: usize = 1 << 22;

/// Size to which every archive may unpack, bytes.
const SMALL: u64 = 1 << 29;
/// Size to which no archive may unpack, bytes.
const LARGE: u64 = 1 << 34;
/// Largest ratio of the unpacked size to that of the archive. FMUs have 2 to 20.
const RATIO: u64 = 200;

/// Largest size, bytes, to which an archive of `packed` bytes may unpack with everything in it: 200
/// times as much, but 512 MiB in any case, and never more than 16 GiB.
pub fn unpacked_size(packed: u64) -> u64 {
    packed.saturating_mul(RATIO).clamp(SMALL, LARGE)
}

/// What is wrong with an archive of `packed` bytes that unpacks to `unpacked` bytes, if that is too
/// much.
pub fn excess(packed: u64, unpacked: u64) -> Option<String> {
    let most = unpacked_size(packed);
    (unpacked > most).then(|| {
        format!(
            "{packed} bytes unpack to {unpacked}; at most {most} are allowed for an archive of this size (200 times as many, at least 512 MiB, at most 16 GiB)"
        )
    })
}
