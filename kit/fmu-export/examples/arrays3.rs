//! FMU for `tests/test_sizes.py`: arrays of each type that only FMI 3.0 has, and of others.

#[macro_use]
mod arrays;

use arrays::Valve;
use fmu_export::prelude::*;

arrays! { real f64 [unit = "m",] = 0.5 }
arrays! { float32 f32 [unit = "m", min = -99.9, max = 99.9,] = 0.1 }
arrays! { int8 i8 [min = -100, max = 100,] = 7 }
arrays! { uint8 u8 [max = 200,] = 7 }
arrays! { int16 i16 [] = 7 }
arrays! { uint16 u16 [] = 7 }
arrays! { uint32 u32 [] = 4_000_000_000 }
arrays! { int64 i64 [min = -9_007_199_254_740_992.0,] = 9_223_372_036_854_775_807 }
arrays! { uint64 u64 [] = 18_446_744_073_709_551_615 }
arrays! { binary Binary [] = b"\x00\xff" }
arrays! { choice Choice<Valve> [] = Valve::Half }

model! { Arrays3 "Arrays of each type of FMI 3.0" real float32 int8 uint8 int16 uint16 uint32 int64 uint64 binary choice }
