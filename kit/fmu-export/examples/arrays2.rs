//! FMU for `tests/test_sizes.py`: arrays of each type that both versions of FMI have.

#[macro_use]
mod arrays;

use arrays::Valve;
use fmu_export::prelude::*;

arrays! { real f64 [unit = "m", min = -100.0, max = 100.0,] = 0.5 }
arrays! { integer i32 [min = -100, max = 100,] = 7 }
arrays! { boolean bool [] = true }
arrays! { text String [] = "a" }
arrays! { choice Choice<Valve> [] = Valve::Half }

model! { Arrays2 "Arrays of each type of FMI 2.0" real integer boolean text choice }
