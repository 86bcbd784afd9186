//! Writes the reference machine as a Rust expression, so that making an instance reads no JSON. A
//! machine that [`Machine::check`] refuses fails the build.
// What only the library needs; the paper's symbols; lints of what is public.
#![allow(dead_code, non_snake_case, unfulfilled_lint_expectations)]

#[path = "src/actuator.rs"]
mod actuator;
#[path = "src/bodies.rs"]
mod bodies;
#[path = "src/check.rs"]
mod check;
#[path = "src/controller.rs"]
mod controller;
#[path = "src/geometry.rs"]
mod geometry;
#[path = "src/machine.rs"]
mod machine;
#[path = "src/per_axis.rs"]
mod per_axis;

use machine::Machine;
use std::path::Path;
use std::{env, fs};

const FILE: &str = "../../parameters/reference_machine.json";

fn main() {
    println!("cargo::rerun-if-changed={FILE}");
    let text = fs::read_to_string(FILE).expect("the reference machine can be read");
    let machine: Machine = serde_json::from_str(&text).expect("a machine");
    machine.check().expect("a valid machine");
    // `{:?}` of numbers, arrays and structs of them is Rust; of vectors it lacks the macro.
    let source = format!("{machine:?}").replace("vertices: [", "vertices: vec![");
    let folder = env::var("OUT_DIR").expect("cargo gives a folder");
    fs::write(Path::new(&folder).join("reference.rs"), source).expect("it can be written");
}
