//! Numbers as the memory of an instance has them, all in 64 bits, and as a call of their type passes
//! them.

use fmi_description::Access;

/// An expression by type: of floating-point numbers, or of integers of the type that it is given.
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

/// Write a value of the memory to place `k` of an array of the type of `access`.
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

/// What is at place `k` of an array of the type of `access`, as the memory has it.
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
/// What the memory has, as a number: an integer beyond 2^53 as the nearest.
pub fn number(access: Access, bits: u64) -> f64 {
    match access {
        Access::Real | Access::Float32 => f64::from_bits(bits),
        Access::UInt64 => bits as f64,
        _ => bits.cast_signed() as f64,
    }
}

#[cfg(feature = "master")]
/// A number as the memory has it.
pub fn as_bits(access: Access, value: f64) -> u64 {
    match access {
        Access::Real | Access::Float32 => value.to_bits(),
        Access::UInt64 => value as u64,
        _ => (value as i64).cast_unsigned(),
    }
}
