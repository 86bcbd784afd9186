//! Files as a caller sees them: before, while and after they are written.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use output_file::{OutputFile, TemporaryFolder, claim, note_read, write};

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder)
        .unwrap()
        .map(|file| file.unwrap().file_name());
    let mut names: Vec<_> = names.map(|name| name.into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_file_gets_its_name_when_it_is_complete() {
    let folder = folder("complete");
    let path = folder.join("a.csv");
    fs::write(&path, "old").unwrap();
    let mut dropped = OutputFile::create(&path).unwrap();
    writeln!(dropped, "new").unwrap();
    drop(dropped);
    assert_eq!(
        (fs::read_to_string(&path).unwrap(), names(&folder).len()),
        ("old".into(), 1)
    );
    // Two at a time do not mix; names of any length are possible.
    let [mut first, mut second] = [(); 2].map(|()| OutputFile::create(&path).unwrap());
    second.write_all(b"second").unwrap();
    first.write_all(b"first").unwrap();
    first.commit().unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "first");
    second.commit().unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "second");
    let long = folder.join("ü".repeat(125));
    write(&long, "x").unwrap();
    assert_eq!(names(&folder).len(), 2);
}

#[test]
fn what_cannot_be_written_is_named() {
    let folder = folder("refused");
    let text = |path: &Path| OutputFile::create(path).err().unwrap().to_string();
    let missing = folder.join("no/a.csv");
    assert!(text(&missing).contains(&format!("`{}` cannot be written", missing.display())));
    assert!(text(&folder).contains("directory"));
    let absent = claim(&missing).unwrap_err().to_string();
    assert!(absent.contains("there is no folder"), "{absent}");
}

/// Whichever comes first, and by whatever name.
#[test]
fn a_file_that_is_read_is_not_written() {
    let folder = folder("read");
    let [input, hard] = ["in.csv", "hard.csv"].map(|name| folder.join(name));
    fs::write(&input, "in").unwrap();
    fs::hard_link(&input, &hard).unwrap();
    note_read(&input).unwrap();
    let dotted = folder.join("../read/in.csv");
    for path in [&input, &hard, &dotted] {
        assert!(
            write(path, "out")
                .unwrap_err()
                .to_string()
                .contains("this run reads it")
        );
        assert!(claim(path).is_err());
    }
    let output = folder.join("out.csv");
    claim(&output).unwrap();
    assert!(claim(&folder.join("./out.csv")).is_err(), "another output");
    write(&output, "out").unwrap();
    assert!(
        note_read(&output)
            .unwrap_err()
            .to_string()
            .contains("would replace it")
    );
    assert_eq!(fs::read_to_string(&input).unwrap(), "in");
}

#[test]
fn a_temporary_folder_is_removed_with_what_is_in_it() {
    let [one, two] = [(); 2].map(|()| TemporaryFolder::new().unwrap());
    fs::write(one.path().join("x"), "x").unwrap();
    let paths = [one.path().to_path_buf(), two.path().to_path_buf()];
    drop(one);
    assert!(!paths[0].exists() && paths[1].exists());
}

#[cfg(unix)]
#[test]
fn links_stay_links_and_permissions_are_kept() {
    use std::os::unix::fs::{PermissionsExt as _, symlink};
    let folder = folder("links");
    let [file, link, ahead] = ["a", "link", "ahead"].map(|name| folder.join(name));
    fs::write(&file, "old").unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o604)).unwrap();
    symlink("a", &link).unwrap();
    symlink("../links/b", &ahead).unwrap();
    write(&link, "new").unwrap();
    write(&ahead, "new").unwrap();
    assert_eq!(names(&folder), ["a", "ahead", "b", "link"]);
    assert!(link.is_symlink() && ahead.is_symlink());
    assert_eq!(
        fs::metadata(&file).unwrap().permissions().mode() & 0o777,
        0o604
    );
    let umask = Command::new("sh")
        .args(["-c", "umask"])
        .output()
        .unwrap()
        .stdout;
    let umask = u32::from_str_radix(String::from_utf8(umask).unwrap().trim(), 8).unwrap();
    let new = fs::metadata(folder.join("b")).unwrap().permissions().mode();
    assert_eq!(new & 0o777, 0o666 & !umask);
    assert_eq!(fs::read_to_string(&file).unwrap(), "new");
}

/// What a program that was killed left is not locked; what looks alike is not touched.
#[test]
fn what_nobody_holds_is_removed() {
    let folder = folder("stale");
    let path = folder.join("a.csv");
    for name in [".a.csv.1-0.part", ".a.csv.swp", ".b.csv.1-0.part"] {
        fs::write(folder.join(name), "left").unwrap();
    }
    let held = OutputFile::create(&path).unwrap();
    write(&path, "new").unwrap();
    assert_eq!(names(&folder).len(), 4);
    held.commit().unwrap();
    assert_eq!(names(&folder), [".a.csv.swp", ".b.csv.1-0.part", "a.csv"]);
}
