//! Pixels as a PNG file (ISO/IEC 15948): one chunk of data, each row unfiltered.

use std::io::{self, Write as _};

use flate2::Compression;
use flate2::write::ZlibEncoder;

const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
/// After width and height: 8 bits a sample, red, green and blue; deflated, filtered by row, not
/// interlaced.
const KIND: [u8; 5] = [8, 2, 0, 0, 0];
/// Filter of a row: none.
const UNFILTERED: u8 = 0;

/// The file of `pixels`, rows from above, three bytes each.
pub fn encoded(pixels: &[u8], (width, height): (u32, u32)) -> io::Result<Vec<u8>> {
    let mut data = ZlibEncoder::new(Vec::new(), Compression::default());
    for row in pixels.chunks(3 * width as usize) {
        data.write_all(&[UNFILTERED])?;
        data.write_all(row)?;
    }
    let header = [&width.to_be_bytes()[..], &height.to_be_bytes(), &KIND].concat();
    let mut file = SIGNATURE.to_vec();
    chunk(&mut file, *b"IHDR", &header)?;
    chunk(&mut file, *b"IDAT", &data.finish()?)?;
    chunk(&mut file, *b"IEND", &[])?;
    Ok(file)
}

fn chunk(file: &mut Vec<u8>, name: [u8; 4], data: &[u8]) -> io::Result<()> {
    let length = u32::try_from(data.len()).map_err(io::Error::other)?;
    file.extend(length.to_be_bytes());
    let from = file.len();
    file.extend(name);
    file.extend(data);
    let sum = crc32fast::hash(&file[from..]);
    file.extend(sum.to_be_bytes());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Oracle: a file of two pixels, red over blue, that Python made by `zlib` and `struct` after
    /// the standard; its data are inflated here, as compressors differ in what they write.
    #[test]
    fn two_pixels_are_a_file_after_the_standard() {
        let file = encoded(&[255, 0, 0, 0, 0, 255], (1, 2)).unwrap();
        let header = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01\0\0\0\x02\x08\x02\0\0\0\x16\xe3!p";
        assert_eq!(&file[..33], header);
        assert!(file.ends_with(b"\0\0\0\0IEND\xaeB`\x82"));
        let length = u32::from_be_bytes(file[33..37].try_into().unwrap()) as usize;
        assert_eq!(&file[37..41], b"IDAT");
        let mut rows = Vec::new();
        let mut inflated = flate2::read::ZlibDecoder::new(&file[41..41 + length]);
        io::Read::read_to_end(&mut inflated, &mut rows).unwrap();
        assert_eq!(rows, [0, 255, 0, 0, 0, 0, 0, 255]);
        let sum = u32::from_be_bytes(file[41 + length..45 + length].try_into().unwrap());
        assert_eq!(sum, crc32fast::hash(&file[37..41 + length]));
    }
}
