//! Converts numbers between the 64 bits in which this crate keeps them, their C type in an array
//! that a call passes, and `f64`, for the instances of `fmi2` and `fmi3`, and for `values`.

use fmi_description::Access;

/// Chooses an expression by type: for f64, for f32, or for integers of the type `$t`.
macro_rules! by_type {
    ($access:expr, $real:expr, $single:expr, |$t:ident| $integer:expr) => {
        by_type!($access, $real, $single, $t $integer; Int8 i8 UInt8 u8 Int16 i16 UInt16 u16
            Integer i32 UInt32 u32 Int64 i64 UInt64 u64 Boolean u8)
    };
    ($access:expr, $real:expr, $single:expr, $t:ident $integer:expr; $($of:ident $type:ty)*) => {
        match $access {
            Access::Real => $real,
            Access::Float32 => $single,
            $(Access::$of => {
                type $t = $type;
                $integer
            })*
            other => unreachable!("{other:?} is no number"),
        }
    };
}

/// Writes a number to place `k` of an array of the C type of `access`.
pub fn store(access: Access, array: &mut [u64], k: usize, bits: u64) {
    assert!(k < array.len());
    let array = array.as_mut_ptr();
    // SAFETY: `k` is a place of the array, since no type is larger than its elements.
    unsafe {
        by_type!(
            access,
            *array.add(k) = bits,
            *array.cast::<f32>().add(k) = f64::from_bits(bits) as f32,
            |T| *array.cast::<T>().add(k) = bits as T
        );
    }
}

/// Reads the number at place `k` of an array of the C type of `access`.
#[expect(
    clippy::cast_lossless,
    clippy::unnecessary_cast,
    reason = "one expression for all integer types"
)]
pub fn load(access: Access, array: &[u64], k: usize) -> u64 {
    assert!(k < array.len());
    let array = array.as_ptr();
    // SAFETY: `k` is a place of the array, since no type is larger than its elements.
    unsafe {
        by_type!(
            access,
            *array.add(k),
            f64::from(*array.cast::<f32>().add(k)).to_bits(),
            |T| *array.cast::<T>().add(k) as u64
        )
    }
}

#[cfg(feature = "master")]
/// A number as `f64`; integers beyond 2^53 are rounded.
pub fn number(access: Access, bits: u64) -> f64 {
    match access {
        Access::Real | Access::Float32 => f64::from_bits(bits),
        Access::UInt64 => bits as f64,
        _ => bits.cast_signed() as f64,
    }
}

#[cfg(feature = "master")]
/// The 64 bits of a number that is given as `f64`.
pub fn as_bits(access: Access, value: f64) -> u64 {
    match access {
        Access::Real | Access::Float32 => value.to_bits(),
        Access::UInt64 => value as u64,
        _ => (value as i64).cast_unsigned(),
    }
}
