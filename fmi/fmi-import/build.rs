//! Compiles the logger that FMUs of FMI 2.0 are given: stable Rust cannot define a variadic
//! function.

fn main() {
    println!("cargo::rerun-if-changed=src/logger.c");
    #[cfg(feature = "printf")]
    cc::Build::new()
        .file("src/logger.c")
        .compile("fmi_import_logger");
}
