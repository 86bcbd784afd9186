//! Compiles the logger that FMUs of FMI 2.0 are given: stable Rust cannot define a variadic
//! function.

fn main() {
    println!("cargo::rerun-if-changed=src/slave/logger.c");
    #[cfg(feature = "native")]
    cc::Build::new()
        .file("src/slave/logger.c")
        .compile("cosim_logger");
}
