//! libclang for the bindings that tests compare with: their build script runs bindgen. The
//! system's, else the one of the Python package `libclang`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use cargo_fmu::process::output;

use crate::python::Python;
use crate::workspace::Workspace;

/// Wheel of the `libclang` package on PyPI.
const REQUIREMENT: &str = "libclang==18.1.1\n";

/// The environment variables with which cargo can build everything. They are also left in
/// `.cargo/libclang.toml`, which `.cargo/config.toml` includes, so that plain cargo commands work
/// from then on.
pub fn provide(workspace: &Workspace) -> Result<Vec<(String, String)>> {
    if std::env::var_os("LIBCLANG_PATH").is_some() || on_system() {
        return Ok(Vec::new());
    }
    let python = Python::provide(workspace)?;
    python.install(workspace, "libclang", REQUIREMENT)?;
    let code = "import clang, pathlib; print(pathlib.Path(clang.__file__).parent / 'native')";
    let native = output(workspace.command(python.program()).args(["-c", code]))?;
    let mut variables = vec![("LIBCLANG_PATH".to_string(), native.trim().to_string())];
    if std::env::var_os("BINDGEN_EXTRA_CLANG_ARGS").is_none()
        && let Some(include) = compiler_include(workspace)
    {
        variables.push((
            "BINDGEN_EXTRA_CLANG_ARGS".to_string(),
            format!("-I{include}"),
        ));
    }
    remember(workspace, &variables)?;
    Ok(variables)
}

fn remember(workspace: &Workspace, variables: &[(String, String)]) -> Result<()> {
    let file = workspace.root.join(".cargo/libclang.toml");
    let mut text = String::from("# Written by `cargo xtask`; not committed.\n[env]\n");
    for (name, value) in variables {
        text += &format!("{name} = '{value}'\n");
    }
    if fs::read_to_string(&file).is_ok_and(|present| present == text) {
        return Ok(());
    }
    fs::write(&file, text).with_context(|| file.display().to_string())
}

/// True where bindgen will find a libclang of the system.
fn on_system() -> bool {
    let fixed = [
        "/usr/lib",
        "/usr/lib64",
        "/usr/local/lib",
        "/Library/Developer/CommandLineTools/usr/lib",
        "C:/Program Files/LLVM/bin",
    ];
    let machine = format!("/usr/lib/{}-linux-gnu", std::env::consts::ARCH);
    let llvm = fs::read_dir("/usr/lib")
        .into_iter()
        .flatten()
        .flatten()
        .map(|e| e.path());
    let llvm = llvm
        .filter(|p| {
            p.file_name()
                .is_some_and(|n| n.to_string_lossy().starts_with("llvm"))
        })
        .map(|p| p.join("lib"));
    fixed
        .into_iter()
        .map(PathBuf::from)
        .chain([machine.into()])
        .chain(llvm)
        .any(|dir| holds_libclang(&dir))
}

fn holds_libclang(dir: &Path) -> bool {
    let is_libclang = |name: &str| {
        let stem = name.strip_prefix("lib").unwrap_or(name);
        let rest = stem.strip_prefix("clang").unwrap_or("?");
        // libclang.so.1, libclang-14.so, libclang.dylib, libclang.dll; not libclang-cpp.so
        (rest.starts_with('.')
            || rest.starts_with('-') && rest[1..].starts_with(|c: char| c.is_ascii_digit()))
            && (rest.contains(".so") || rest.ends_with(".dylib") || rest.ends_with(".dll"))
    };
    fs::read_dir(dir)
        .into_iter()
        .flatten()
        .flatten()
        .any(|e| is_libclang(&e.file_name().to_string_lossy()))
}

/// Folder of the C compiler's own headers (`stddef.h`), which the wheel does not bring.
fn compiler_include(workspace: &Workspace) -> Option<String> {
    ["cc", "gcc", "clang"].into_iter().find_map(|compiler| {
        let printed = output(workspace.command(compiler).arg("-print-file-name=include")).ok()?;
        Some(printed.trim().to_string()).filter(|dir| Path::new(dir).join("stddef.h").is_file())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libclang_is_told_from_its_neighbours() {
        let dir = std::env::temp_dir().join(format!("xtask-libclang-{}", std::process::id()));
        for (name, expected) in [
            ("libclang-cpp.so.14", false),
            ("libclangAST.a", false),
            ("libclang-14.so.1", true),
            ("libclang.so", true),
        ] {
            fs::create_dir_all(&dir).unwrap();
            fs::write(dir.join(name), "").unwrap();
            assert_eq!(holds_libclang(&dir), expected, "{name}");
            fs::remove_dir_all(&dir).unwrap();
        }
    }
}
