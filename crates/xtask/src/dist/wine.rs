//! Windows programs on Linux: Wine, with a Windows of its own below the target directory.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;
use cargo_fmu::process::execute;
use cargo_fmu::target::Tools;

/// Where Debian puts the program that its package `wine` starts.
const DEBIAN: &str = "/usr/lib/wine/wine64";

/// Its source, for Wine alone: Windows has the library.
const BCRYPT_PRIMITIVES: &str = include_str!("bcryptprimitives.c");

/// Wine as it is installed.
pub struct Wine {
    program: PathBuf,
    prefix: PathBuf,
}

impl Wine {
    /// Found on this machine; `folder` is where its Windows lies.
    pub fn find(folder: &Path) -> Option<Self> {
        let tools = Tools::default();
        let installed = ["wine64", "wine"].iter().find_map(|name| tools.find(name));
        let debian = PathBuf::from(DEBIAN);
        let program = installed.or_else(|| debian.is_file().then_some(debian))?;
        let prefix = folder.join("wine");
        Some(Self { program, prefix })
    }

    /// Make its Windows, with the one library of Windows 10 that Wine 8 lacks and Rust programs
    /// need.
    pub fn prepare(&self) -> Result<()> {
        let system = self.prefix.join("drive_c/windows/system32");
        if !system.is_dir() {
            println!("making a Windows in {}", self.prefix.display());
            execute(self.command(Path::new("wineboot")).arg("--init"))?;
        }
        let library = system.join("bcryptprimitives.dll");
        if library.is_file() {
            return Ok(());
        }
        let source = self.prefix.join("bcryptprimitives.c");
        fs::write(&source, BCRYPT_PRIMITIVES)?;
        let mut compiler = Command::new("x86_64-w64-mingw32-gcc");
        compiler.args(["-shared", "-O1", "-s"]).arg(&source);
        execute(compiler.arg("-ladvapi32").arg("-o").arg(&library))
    }

    /// A Windows program, whose paths are those of this machine.
    pub fn command(&self, program: &Path) -> Command {
        let mut command = Command::new(&self.program);
        command.arg(program).env("WINEPREFIX", &self.prefix);
        // No messages of its own, and no questions about add-ons.
        command.env("WINEDEBUG", "-all");
        command.env("WINEDLLOVERRIDES", "mscoree,mshtml=");
        command
    }
}
