//! The derive macros of `fmu-export`, which re-exports them with its feature `derive` to authors of
//! models: they make the variables of an FMU from structs.
//!
//! `#[derive(Parameters)]`, `#[derive(Input)]`, `#[derive(Output)]` and `#[derive(State)]` make a
//! row of the table of variables from each field: from its name, its doc comment as the
//! description, its type, and the attribute `#[fmu(…)]`.
//!
//! | Field | Variable |
//! |---|---|
//! | `f64`, `i32`, `bool`, `String` | Real, Integer, Boolean, String; in FMI 3.0 Float64, Int32, Boolean, String |
//! | `Choice<E>`, `E` with `#[derive(Enumeration)]` | Enumeration |
//! | `f32`, `i8`, `u8`, `i16`, `u16`, `u32`, `i64`, `u64`, `Binary` | Float32, Int8, … UInt64, Binary: of FMI 3.0 only |
//! | `&'static str` (an output) | String |
//! | `[T; N]`, `T` any of these but `&'static str` | a vector: `x[1]`, `x[2]`, …; at most 64 kB |
//! | `[[T; N]; M]` and so on | a matrix: `x[1,1]`, `x[1,2]`, … |
//! | `Vec<T>` | a vector or matrix with the lengths of `len` |
//! | `[S; 2]`, `S` a struct with the same derive | its variables twice: `motor[1].R`, `motor[2].R` |
//! | a struct with the same derive | its variables, with the field's name before theirs: `motor.R` |
//!
//! | `#[fmu(…)]` on a field | of | means |
//! |---|---|---|
//! | `unit = "N.m"` | `f64`, `f32` | its unit, `"1"` for none; must be there. `unit = MINE` with `const MINE: Unit` for one that is not known |
//! | `display_unit = "kN.m"` | `f64`, `f32` | what tools show |
//! | `start = 2.5` | parameters, inputs, states | start value; must be there for a parameter, except a String or Binary. Of an array one for all elements, or an array. `p.x_0` in a state: of the parameters `p` and inputs `u` |
//! | `min = 0.0`, `max = 1.0` | numbers | bounds; what is set outside is refused |
//! | `nominal = 1e5` | `f64`, `f32` | typical magnitude |
//! | `len = 5000`, `len = p.n`, `len = (2, p.n)` | a `Vec` | its lengths, row by row: numbers, or structural parameters of the model's parameters `p`. `start` is then of the element with the index `i`, from 0 |
//! | `structural` | Integer parameters | a size, with `min` and `max`: a structural parameter in FMI 3.0, a constant in FMI 2.0 |
//! | `name = "R"` | all | name, where it is not the field's |
//! | `at = 17` | all | value reference (of the first element), where it is not the next one |
//! | `tunable` | parameters | may be set between steps |
//! | `constant` | parameters | cannot be set: always `start` |
//! | `discrete` | inputs and outputs, `f64` and `f32` | changes at communication points only |
//! | | states | is not integrated: `event` changes it; may be of any type |
//! | `set = read_file` | a `String` among the parameters | `fn(&mut Self, &str, Option<&Path>) -> Result<(), String>` sets it, and whatever the text means |
//! | `depends_on(u, w[2], v[i], v[i - 1])` | outputs | the inputs that act on it at once; `depends_on()` none. Without it: all. With `model_exchange` states too; where none is named, and not `no_states`: all of them |
//! | `initially_depends_on(u, gain)` | outputs | the inputs and parameters that act on it in Initialization Mode; `parameters` for all of them |
//! | `rate_depends_on(u, x[i])` | states | the inputs and states that act on the derivative, for Model Exchange. Without it: all |
//! | `local` | outputs, states | is a local variable, not meant for wiring |
//! | `calculated` | outputs | is a calculated parameter: a function of the parameters alone |
//! | `skip` | parameters, states | is no variable and not integrated, only saved: of any type with `Clone`, `Default` and serde's traits. It begins as its `start`, else as `Default`; after that a setter changes it among the parameters, `event` in a state |
//!
//! | `#[fmu(…)]` on a state | means |
//! |---|---|
//! | `parameters = P`, `input = U`, `output = Y` | the model's other structs; makes the struct the state of a model, see `Ode` |
//! | `model_exchange` | the FMU supports Model Exchange too; `depends_on` then names states as well as inputs |
//! | `max_step = 1e-4` | longest internal step, s; without it 1 ms, and none with `solver` |
//! | `solver = "adaptive"`, `"stiff"` | what integrates it in Co-Simulation: the method of Dormand and Prince, or Rodas5P for rates that differ by orders of magnitude, whose Jacobian follows `rate_depends_on`. Without it: Runge–Kutta in steps of `max_step` |
//! | `tolerance = 1e-4` | error of an internal step of these, relative to states or their `nominal` values, if the importer gives none; 1e-6 without it |
//! | `experiment(0.0, 5.0, 0.01)` | default experiment: start, stop, communication step, s |
//! | `info = INFO` | names and files (a `const INFO: Info`), instead of the struct's name, doc comment and the package's version |
//!
//! Each derive also implements the other traits that a model's struct needs: `Clone`, serde's
//! traits (except for outputs), and except for parameters a `Default` of zeros; and `Copy` if the
//! struct has no `Vec`, String or Binary. `#[fmu(table_only)]` on the struct omits them.
//!
//! On an enumeration, `#[derive(Enumeration)]` makes the items from the variants, in order and
//! counted from 1: names, doc comments as descriptions, `#[fmu(name = "…")]` for another name.

mod attributes;
mod check;
mod enumeration;
mod errors;
mod field;
mod names;
mod rows;
mod state;
mod structs;
mod values;

use field::Role;
use proc_macro::TokenStream;
use syn::{DeriveInput, Error, parse_macro_input};

/// A struct of parameters. The attributes are described in the documentation of the crate.
#[proc_macro_derive(Parameters, attributes(fmu))]
pub fn parameters(input: TokenStream) -> TokenStream {
    derive(input, |input| structs::derive(input, Role::Parameter))
}

/// A struct of inputs. The attributes are described in the documentation of the crate.
#[proc_macro_derive(Input, attributes(fmu))]
pub fn input(input: TokenStream) -> TokenStream {
    derive(input, |input| structs::derive(input, Role::Input))
}

/// A struct of outputs. The attributes are described in the documentation of the crate.
#[proc_macro_derive(Output, attributes(fmu))]
pub fn output(input: TokenStream) -> TokenStream {
    derive(input, |input| structs::derive(input, Role::Output))
}

/// A struct of states; of a whole model with `#[fmu(parameters = …)]`. The attributes are described
/// in the documentation of the crate.
#[proc_macro_derive(State, attributes(fmu))]
pub fn state(input: TokenStream) -> TokenStream {
    derive(input, |input| structs::derive(input, Role::State))
}

/// An enumeration that can be the type of a variable, as `Choice<E>`.
#[proc_macro_derive(Enumeration, attributes(fmu))]
pub fn enumeration(input: TokenStream) -> TokenStream {
    derive(input, enumeration::derive)
}

fn derive(
    input: TokenStream,
    expand: impl FnOnce(&DeriveInput) -> Result<proc_macro2::TokenStream, Error>,
) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    expand(&input)
        .unwrap_or_else(Error::into_compile_error)
        .into()
}
