//! Nothing: its dependencies are what this package is for (`Cargo.toml` says why).
