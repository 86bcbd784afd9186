//! Writes the shipped network as Rust constants, so that making an instance reads no JSON. A
//! network that [`SurrogateFile::check`] refuses fails the build.

#[path = "src/surrogate/file.rs"]
#[allow(dead_code)] // what only the library needs
mod file;

use file::{LayerFile, SurrogateFile, TrainingRecord};
use std::path::Path;
use std::{env, fs};

const FILE: &str = "../../parameters/surrogate.json";

fn main() {
    println!("cargo::rerun-if-changed={FILE}");
    let text = fs::read_to_string(FILE).expect("the shipped network can be read");
    let file: SurrogateFile = serde_json::from_str(&text).expect("a network file");
    file.check().expect("a valid network");
    let folder = env::var("OUT_DIR").expect("cargo gives a folder");
    fs::write(Path::new(&folder).join("shipped.rs"), source(&file)).expect("it can be written");
}

/// `{:?}` of numbers, arrays and structs of them is Rust, and as many digits as tell a number from
/// its neighbours.
fn source(file: &SurrogateFile) -> String {
    let layers: String = (1..).zip(&file.layers).map(layer).collect();
    let TrainingRecord {
        data,
        data_sha256,
        seed,
        epochs,
        best_epoch,
        stop,
        rows,
        mse,
        r_f,
        r_x_dot,
        curve,
    } = &file.training;
    format!(
        "pub(super) static NETWORK: Network = Network {{ {layers} }};\n\
         pub(super) static RANGES: Ranges = {:?};\n\
         pub(super) static BOUND: Option<EfficiencyBound> = {:?};\n\
         pub(super) fn training() -> TrainingRecord {{ TrainingRecord {{\n\
         data: {data:?}.into(), data_sha256: {data_sha256:?}.into(), seed: {seed}, epochs: {epochs}, best_epoch: {best_epoch}, \
         stop: {stop:?}.into(), rows: {rows:?}, mse: {mse:?}, r_f: {r_f:?}, r_x_dot: {r_x_dot:?}, curve: vec!{curve:?}\n\
         }} }}\n",
        file.ranges, file.efficiency_bound
    )
}

/// A layer with its outputs side by side.
fn layer((number, layer): (u32, &LayerFile)) -> String {
    let LayerFile { weights, bias } = layer;
    let of_input = |i: usize| weights.iter().map(|row| row[i]).collect();
    let transposed: Vec<Vec<f64>> = (0..weights[0].len()).map(of_input).collect();
    format!("l{number}: Layer {{ weights: {transposed:?}, bias: {bias:?} }},\n")
}
