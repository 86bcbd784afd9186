//! The oldest Debian whose packages are still handed out, in a folder: programs for old systems are run in it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use cargo_fmu::process::{execute, output};
use cargo_fmu::target::Tools;

/// Debian 11 of 2021. Those before it have left the servers.
const RELEASE: &str = "bullseye";

/// An unpacked system.
pub struct Userland {
    root: PathBuf,
    /// Its release and the version of its C library.
    pub name: String,
}

impl Userland {
    /// Unpacked below `folder`, unless it is there.
    pub fn provide(folder: &Path) -> Result<Self> {
        let root = folder.join(RELEASE);
        if !root.is_dir() {
            let debootstrap = Tools::default().find("debootstrap");
            let debootstrap = debootstrap.context("debootstrap: `apt-get install debootstrap`")?;
            let user = output(Command::new("id").arg("-u"))?;
            ensure!(
                user.trim() == "0",
                "debootstrap and chroot need the user root"
            );
            println!("unpacking Debian {RELEASE} into {}", root.display());
            let new = folder.join(format!("{RELEASE}.new"));
            if new.exists() {
                fs::remove_dir_all(&new)?;
            }
            let mut command = Command::new(debootstrap);
            command.args(["--variant=minbase", RELEASE]).arg(&new);
            let log = fs::File::create(folder.join("debootstrap.log"))?;
            execute(command.stdout(log))?;
            fs::rename(&new, &root)?;
        }
        let processes = root.join("proc");
        if !processes.join("self").exists() {
            let mut mount = Command::new("mount");
            execute(mount.args(["-t", "proc", "proc"]).arg(&processes))?;
        }
        let version = output(Command::new("chroot").arg(&root).args(["ldd", "--version"]))?;
        let version = version
            .lines()
            .next()
            .unwrap_or_default()
            .rsplit(' ')
            .next();
        let name = format!("Debian {RELEASE}, glibc {}", version.unwrap_or_default());
        Ok(Self { root, name })
    }

    /// A command in it, which finds a copy of `files` in its folder `/dist`.
    pub fn command(&self, files: &Path, program: &str) -> Result<Command> {
        let inside = self.root.join("dist");
        if inside.exists() {
            fs::remove_dir_all(&inside)?;
        }
        for path in super::files(files)? {
            let to = inside.join(path.strip_prefix(files)?);
            fs::create_dir_all(to.parent().unwrap_or(&inside))?;
            fs::copy(&path, &to).with_context(|| to.display().to_string())?;
        }
        let mut command = Command::new("chroot");
        command
            .arg(&self.root)
            .arg(Path::new("/dist").join(program));
        Ok(command)
    }

    /// A file in it.
    pub fn file(&self, path: &str) -> PathBuf {
        self.root.join(path.trim_start_matches('/'))
    }
}
