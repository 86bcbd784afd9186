//! Empty. The package exists for its dependencies, whose features it turns on in every build of the
//! workspace; `Cargo.toml` says why.
