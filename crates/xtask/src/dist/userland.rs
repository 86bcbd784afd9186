//! The oldest Debian whose packages are still handed out, in a folder: programs for old systems are
//! run in it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use cargo_fmu::process::{execute, output};
use cargo_fmu::target::Tools;

/// Debian 11 of 2021. Those before it have left the servers.
const RELEASE: &str = "bullseye";

/// Whom a program trusts that reaches the network.
pub const CERTIFICATES: &str = "etc/ssl/certs/ca-certificates.crt";

/// The system's folder is `$0`, the command that runs in it `$@`.
const INSIDE: &str = r#"mount -t proc proc "$0/proc" && exec chroot "$0" "$@""#;

/// An unpacked system.
pub struct Userland {
    root: PathBuf,
    /// Its release and the version of its C library.
    pub name: String,
}

impl Userland {
    /// Unpacked below `folder`, unless it is there.
    pub fn provide(folder: &Path) -> Result<Self> {
        Self::unpacked(folder, RELEASE, &[])
    }

    /// As [`Userland::provide`], with its Python, and with what pip needs to reach the network as
    /// this system does.
    pub fn with_python(folder: &Path) -> Result<Self> {
        let name = format!("{RELEASE}-python");
        let userland = Self::unpacked(folder, &name, &["python3-venv"])?;
        for file in ["etc/resolv.conf", "etc/hosts", CERTIFICATES] {
            let from = Path::new("/").join(file);
            let to = userland.root.join(file);
            fs::create_dir_all(to.parent().unwrap_or(&userland.root))?;
            fs::copy(&from, &to).with_context(|| from.display().to_string())?;
        }
        Ok(userland)
    }

    /// Unpacked as `name` below `folder`, unless it is there, with packages beside those that every
    /// Debian has.
    fn unpacked(folder: &Path, name: &str, packages: &[&str]) -> Result<Self> {
        let root = folder.join(name);
        if !root.is_dir() {
            let debootstrap = Tools::default().find("debootstrap");
            let debootstrap = debootstrap.context("debootstrap: `apt-get install debootstrap`")?;
            let user = output(Command::new("id").arg("-u"))?;
            ensure!(
                user.trim() == "0",
                "debootstrap and chroot need the user root"
            );
            println!("unpacking Debian {RELEASE} into {}", root.display());
            let new = folder.join(format!("{name}.new"));
            if new.exists() {
                fs::remove_dir_all(&new)?;
            }
            let mut command = Command::new(debootstrap);
            // Unpacked is enough: no package has to be set up.
            command.args(["--foreign", "--variant=minbase"]);
            if !packages.is_empty() {
                command.arg(format!("--include={}", packages.join(",")));
            }
            command.arg(RELEASE);
            command.arg(&new);
            let log = fs::File::create(folder.join("debootstrap.log"))?;
            execute(command.stdout(log)).with_context(|| {
                format!(
                    "Debian {RELEASE} could not be unpacked; {} says why",
                    folder.join("debootstrap.log").display()
                )
            })?;
            if !packages.is_empty() {
                // debootstrap has fetched them, but unpacks what every Debian has.
                for package in super::folder::files(&new.join("var/cache/apt/archives"))? {
                    execute(Command::new("dpkg-deb").arg("-x").arg(package).arg(&new))?;
                }
            }
            // In a container debootstrap leaves a link here, which would lead to itself.
            let processes = new.join("proc");
            if processes.is_symlink() {
                fs::remove_file(&processes)?;
                fs::create_dir(&processes)?;
            }
            fs::rename(&new, &root)?;
        }
        let userland = Self {
            root,
            name: RELEASE.to_string(),
        };
        let version = output(userland.command("ldd").arg("--version"))?;
        let version = version
            .lines()
            .next()
            .unwrap_or_default()
            .rsplit(' ')
            .next();
        let name = format!("Debian {RELEASE}, glibc {}", version.unwrap_or_default());
        Ok(Self { name, ..userland })
    }

    /// Put files into its folder `/dist`.
    pub fn copy(&self, files: &Path) -> Result<()> {
        let inside = self.root.join("dist");
        if inside.exists() {
            fs::remove_dir_all(&inside)?;
        }
        for path in super::folder::files(files)? {
            let to = inside.join(path.strip_prefix(files)?);
            fs::create_dir_all(to.parent().unwrap_or(&inside))?;
            fs::copy(&path, &to).with_context(|| to.display().to_string())?;
        }
        Ok(())
    }

    /// A program that runs in it. What shows processes is mounted for this command alone, so that
    /// nothing stays mounted after it.
    pub fn command(&self, program: &str) -> Command {
        let mut command = Command::new("unshare");
        command.args(["--mount", "sh", "-c", INSIDE]);
        command.arg(&self.root).arg(program);
        command
    }

    /// A file in it, by its path from the system's root.
    pub fn file(&self, path: &str) -> PathBuf {
        self.root.join(path)
    }
}
