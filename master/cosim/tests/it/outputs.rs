//! What a run leaves behind: rows of a run that fails, ends early or is stopped by a signal; files
//! that were there; temporary files and folders. The FMU is `ends.c`, whose output is the time.

use std::fs;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use super::foreign::compiled;
use super::program::cosim;
use super::support::{assert_contains, pack, scratch};

/// `a2.fmu`, `a3.fmu`, `b3.fmu` and `c3.fmu` in a new folder; the digit is the version of FMI.
fn folder(test: &str) -> PathBuf {
    let folder = scratch(test);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let library = compiled(&folder, "ends.so", &["ends.c"], &[]);
    let two = r#"<fmiModelDescription fmiVersion="2.0" modelName="ends" guid="g"><CoSimulation modelIdentifier="ends"
        canHandleVariableCommunicationStepSize="true"/><ModelVariables>
        <ScalarVariable name="y" valueReference="0" causality="output"><Real/></ScalarVariable>
        <ScalarVariable name="kind" valueReference="1" causality="parameter" variability="fixed"><Real start="0"/></ScalarVariable>
        <ScalarVariable name="u" valueReference="2" causality="input"><Real start="0"/></ScalarVariable>
        <ScalarVariable name="z" valueReference="3" causality="output"><Real/></ScalarVariable></ModelVariables><ModelStructure><Outputs>
        <Unknown index="1" dependencies=""/><Unknown index="4" dependencies="3"/></Outputs></ModelStructure></fmiModelDescription>"#;
    let three = r#"<fmiModelDescription fmiVersion="3.0" modelName="ends" instantiationToken="g"><CoSimulation modelIdentifier="ends"
        canHandleVariableCommunicationStepSize="true"/><ModelVariables><Float64 name="y" valueReference="0" causality="output"/>
        <Float64 name="kind" valueReference="1" causality="parameter" variability="fixed" start="0"/>
        <Float64 name="u" valueReference="2" causality="input" start="0"/><Float64 name="z" valueReference="3" causality="output"/>
        </ModelVariables><ModelStructure><Output valueReference="0" dependencies=""/><Output valueReference="3" dependencies="2"/>
        </ModelStructure></fmiModelDescription>"#;
    pack(&folder.join("a2.fmu"), two, "linux64", &[&library]);
    for name in ["a3.fmu", "b3.fmu", "c3.fmu"] {
        pack(&folder.join(name), three, "x86_64-linux", &[&library]);
    }
    folder
}

/// Runs FMUs in a folder to 1 s in steps of 0.1 s; exit code, and what is printed.
fn run(folder: &Path, fmus: &[&str], more: &[&str]) -> (i32, String) {
    let files = fmus
        .iter()
        .map(|fmu| folder.join(fmu).display().to_string());
    let files: Vec<String> = files.collect();
    let mut arguments = vec!["run", "--quiet", "--step", "0.1", "--stop-time", "1"];
    arguments.extend(files.iter().map(String::as_str));
    arguments.extend(more);
    let (code, output, error) = cosim(&arguments);
    (code, output + &error)
}

fn last_row(file: &Path) -> Vec<f64> {
    let text = fs::read_to_string(file).unwrap();
    let row = text.lines().last().unwrap().split(',');
    row.map(|cell| cell.parse().unwrap()).collect()
}

#[track_caller]
fn assert_row(file: &Path, expected: &[f64]) {
    let row = last_row(file);
    let is_near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
    assert!(
        row.len() == expected.len() && row.iter().zip(expected).all(is_near),
        "{row:?}"
    );
}

/// A run that ends or fails keeps its rows up to there, and the last is that of the last whole step,
/// also where `--interval` leaves out others. What one FMU alone has reached within a step counts.
#[test]
fn the_last_row_is_where_the_run_has_come_to() {
    let folder = folder("outputs-last");
    let csv = folder.join("x.csv");
    let file = csv.to_str().unwrap();
    for (fmu, kind, code, end) in [
        ("a3", 0, 0, 1.0),
        ("a3", 1, 0, 0.5),
        ("a3", 2, 0, 0.45),
        ("a3", 3, 1, 0.4),
        ("a2", 1, 0, 0.5),
        ("a2", 2, 0, 0.45),
        ("a2", 3, 1, 0.4),
    ] {
        for interval in [&[][..], &["--interval", "0.2"]] {
            fs::write(&csv, "old").unwrap();
            let kind = format!("{fmu}.kind={kind}");
            let options = [
                &["--set", &kind, "--csv", file, "--signals", "*.y"],
                interval,
            ];
            let (done, text) = run(&folder, &[&format!("{fmu}.fmu")], &options.concat());
            assert_eq!(done, code, "{text}");
            assert_row(&csv, &[end, end]);
            let said = format!("the rows up to t = 0.4 s are in `{file}`");
            assert_eq!(text.contains(&said), code == 1, "{text}");
        }
    }
    // The stop time is no multiple of the interval, nor of the step.
    let more = ["--csv", file, "--interval", "0.4", "--stop-time", "0.75"];
    let a3 = folder.join("a3.fmu").display().to_string();
    let arguments = [&["run", "--quiet", "--step", "0.1", &a3], &more[..]].concat();
    assert_eq!(cosim(&arguments).0, 0);
    assert_row(&csv, &[0.75, 0.75, 0.0]);
}

/// All components make the step after which one asks to end the simulation, and values are passed:
/// the other's `z` is the time that it was given, one step late with the schedule `standard`.
#[test]
fn all_components_make_the_step_after_which_one_ends_the_simulation() {
    let folder = folder("outputs-all");
    let csv = folder.join("x.csv");
    let file = csv.to_str().unwrap();
    for (schedule, z) in [("standard", 0.4), ("jacobi", 0.5), ("gauss-seidel", 0.5)] {
        for (threads, ending) in [("1", "a3"), ("2", "a3"), ("1", "b3"), ("2", "b3")] {
            let kind = format!("{ending}.kind=1");
            let more = [
                "--set",
                &kind,
                "--csv",
                file,
                "--signals",
                "*.y,b3.z",
                "--schedule",
            ];
            let more = [
                &more[..],
                &[schedule, "--threads", threads, "--connect", "a3.y=b3.u"],
            ];
            let (code, text) = run(&folder, &["a3.fmu", "b3.fmu"], &more.concat());
            assert_eq!(code, 0, "{text}");
            assert_contains(&text, &["asks to end the simulation at t = 0.5 s"]);
            assert_row(&csv, &[0.5, 0.5, 0.5, z]);
        }
    }
}

/// If several ask in the same step, the first in the order of the system is named, in whichever
/// thread it is: with two, b3 is in the second one.
#[test]
fn the_first_that_asks_to_end_the_simulation_is_named() {
    let folder = folder("outputs-first");
    let fmus = ["a3.fmu", "b3.fmu", "c3.fmu"];
    for schedule in ["standard", "jacobi"] {
        for threads in ["1", "2", "3"] {
            let more = [
                "--set",
                "b3.kind=1",
                "--set",
                "c3.kind=1",
                "--threads",
                threads,
            ];
            let (code, text) = run(
                &folder,
                &fmus,
                &[&more[..], &["--schedule", schedule]].concat(),
            );
            assert_eq!(code, 0, "{text}");
            assert_contains(&text, &["b3 (FMU `"]);
            assert!(!text.contains("c3 (FMU `"), "{schedule} {threads}: {text}");
        }
    }
}

/// Nothing that the run reads is written, whatever it is named by, and no file twice.
#[test]
fn an_output_replaces_neither_an_input_nor_another_output() {
    let folder = folder("outputs-onto");
    let at = |name: &str| folder.join(name).display().to_string();
    symlink(at("a3.fmu"), at("link.fmu")).unwrap();
    fs::hard_link(at("a3.fmu"), at("hard.fmu")).unwrap();
    fs::write(at("in.csv"), "time,a3.u\n0,1\n1,2\n").unwrap();
    fs::write(at("in.units.csv"), "signal,unit\ntime,s\n").unwrap();
    fs::write(at("s.json"), r#"{"events": [{"time": 0.3, "model": "a3", "variable": "u", "action": "bias", "value": 1}], "end": 1}"#).unwrap();
    let inputs = ["--input", &at("in.csv"), "--scenario", &at("s.json")];
    let before = ["a3.fmu", "in.csv", "in.units.csv", "s.json"].map(|f| fs::read(at(f)).unwrap());
    for output in [
        "a3.fmu",
        "link.fmu",
        "hard.fmu",
        "in.csv",
        "in",
        "in.units.csv",
        "s.json",
    ] {
        for options in [vec!["--csv"], vec!["--snapshot"]] {
            let path = at(output);
            let value = if options[0] == "--csv" {
                path
            } else {
                format!("0.5={path}")
            };
            if options[0] != "--csv" && output == "in" {
                continue; // only a CSV file has a file of units
            }
            let (code, text) = run(
                &folder,
                &["a3.fmu"],
                &[&inputs, &[options[0], &value][..]].concat(),
            );
            assert_eq!(code, 1, "{output}: {text}");
            assert!(
                text.contains("read") && !text.contains("simulated in"),
                "{text}"
            );
        }
    }
    let after = ["a3.fmu", "in.csv", "in.units.csv", "s.json"].map(|f| fs::read(at(f)).unwrap());
    assert!(before == after);
    for more in [
        [
            "--csv",
            &at("x.csv"),
            "--snapshot",
            &format!("0={}", at("x.csv")),
        ],
        [
            "--csv",
            &at("x.csv"),
            "--snapshot",
            &format!("0={}", at("x.units.csv")),
        ],
        [
            "--snapshot",
            &format!("0={}", at("x")),
            "--snapshot",
            &format!("1={}", at("x")),
        ],
    ] {
        let (code, text) = run(&folder, &["a3.fmu"], &more);
        assert_eq!(code, 1, "{text}");
        assert_contains(&text, &["another output goes to the same file"]);
    }
}

/// Rows go through links, pipes and devices; a full disk, or a file that gets too large, leaves what
/// was there.
#[test]
fn links_pipes_and_devices_are_written_through() {
    let folder = folder("outputs-through");
    let at = |name: &str| folder.join(name);
    fs::write(at("there.csv"), "old").unwrap();
    fs::set_permissions(at("there.csv"), fs::Permissions::from_mode(0o640)).unwrap();
    symlink("there.csv", at("link.csv")).unwrap();
    symlink("later.csv", at("ahead.csv")).unwrap();
    for (name, target) in [("link.csv", "there.csv"), ("ahead.csv", "later.csv")] {
        let (code, text) = run(&folder, &["a3.fmu"], &["--csv", at(name).to_str().unwrap()]);
        assert_eq!(code, 0, "{text}");
        assert!(at(name).is_symlink());
        assert_row(&at(target), &[1.0, 1.0, 0.0]);
    }
    assert_eq!(
        fs::metadata(at("there.csv")).unwrap().permissions().mode() & 0o777,
        0o640
    );
    assert!(
        Command::new("mkfifo")
            .arg(at("pipe"))
            .status()
            .unwrap()
            .success()
    );
    let (pipe, got) = (at("pipe"), at("got.csv"));
    let reader = std::thread::spawn(move || fs::write(got, fs::read(pipe).unwrap()).unwrap());
    assert_eq!(
        run(
            &folder,
            &["a3.fmu"],
            &["--csv", at("pipe").to_str().unwrap()]
        )
        .0,
        0
    );
    reader.join().unwrap();
    assert_row(&at("got.csv"), &[1.0, 1.0, 0.0]);
    let (code, text) = run(&folder, &["a3.fmu"], &["--csv", "/dev/stdout"]);
    assert!(code == 0 && text.starts_with("time,a3.y"), "{text}");
    assert_eq!(run(&folder, &["a3.fmu"], &["--csv", "/dev/null"]).0, 0);
    let (code, text) = run(&folder, &["a3.fmu"], &["--csv", "/dev/full"]);
    assert_eq!(code, 1);
    assert_contains(&text, &["`/dev/full` cannot be written"]);
    // 1000 rows are more than 20 blocks of 512 bytes, the library is not.
    fs::write(at("there.csv"), "old").unwrap();
    let limited = format!(
        "ulimit -f 64; exec {} run --quiet a3.fmu --step 1e-4 --stop-time 1 --csv there.csv",
        env!("CARGO_BIN_EXE_cosim")
    );
    let done = Command::new("sh")
        .args(["-c", &limited])
        .current_dir(&folder)
        .output()
        .unwrap();
    assert_eq!(done.status.code(), Some(1), "{done:?}");
    assert_eq!(fs::read_to_string(at("there.csv")).unwrap(), "old");
    assert_eq!(parts(&folder), 0);
}

/// Number of files in a folder that are not complete.
fn parts(folder: &Path) -> usize {
    let names = fs::read_dir(folder)
        .unwrap()
        .map(|file| file.unwrap().file_name());
    names
        .filter(|name| name.to_string_lossy().ends_with(".part"))
        .count()
}

const SLOW: &str = "a3.kind=4";

/// Starts a run of this kind that takes long, with temporary files in the folder `tmp`, and waits
/// until it has rows to write.
fn started(folder: &Path, kind: &str, stop: &str) -> Child {
    let csv = "x.csv";
    fs::create_dir_all(folder.join("tmp")).unwrap();
    let child = Command::new(env!("CARGO_BIN_EXE_cosim"))
        .args(["run", "--quiet", "a3.fmu", "--step", "0.1", "--set", kind])
        .args(["--stop-time", stop, "--csv", csv])
        .current_dir(folder)
        .env("TMPDIR", folder.join("tmp"))
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let name = format!(".{csv}.{}-", child.id());
    let begun = || {
        let files = fs::read_dir(folder).unwrap();
        files
            .flatten()
            .any(|file| file.file_name().to_string_lossy().starts_with(&name))
    };
    for _ in 0..2000 {
        if begun() {
            break;
        }
        sleep(Duration::from_millis(5));
    }
    sleep(Duration::from_millis(50));
    child
}

fn signal(child: &Child, signal: &str) {
    let done = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status();
    assert!(done.unwrap().success());
}

#[test]
fn a_signal_ends_a_run_with_its_rows() {
    let folder = folder("outputs-signals");
    let csv = folder.join("x.csv");
    for (name, code) in [("-INT", 130), ("-TERM", 143), ("-HUP", 129)] {
        fs::write(&csv, "old").unwrap();
        let child = started(&folder, SLOW, "1e6");
        signal(&child, name);
        let done = child.wait_with_output().unwrap();
        assert_eq!(done.status.code(), Some(code));
        let row = last_row(&csv);
        assert!(row[0] > 0.0 && (row[0] - row[1]).abs() < 1e-9, "{row:?}");
        let text = String::from_utf8(done.stderr).unwrap();
        let time = format!("stopped the run at t = {} s", row[0]);
        assert_contains(&text, &[&time, "the rows up to"]);
        assert_eq!(parts(&folder), 0);
        assert_eq!(fs::read_dir(folder.join("tmp")).unwrap().count(), 0);
    }
    // Within a step that does not end, the second one ends the program.
    let mut child = started(&folder, "a3.kind=5", "1");
    signal(&child, "-TERM");
    sleep(Duration::from_millis(200));
    assert!(child.try_wait().unwrap().is_none());
    signal(&child, "-TERM");
    assert_eq!(child.wait().unwrap().code(), Some(143));
}

/// A killed run leaves what was there; the next start removes its temporary files, but not those of
/// a run that lives. Two runs onto one name: the one that ends last has it.
#[test]
fn what_a_killed_run_left_is_removed_and_two_runs_do_not_mix() {
    let folder = folder("outputs-killed");
    let csv = folder.join("x.csv");
    fs::write(&csv, "old").unwrap();
    let mut killed = started(&folder, SLOW, "1e6");
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert_eq!(fs::read_to_string(&csv).unwrap(), "old");
    assert_eq!(
        (
            parts(&folder),
            fs::read_dir(folder.join("tmp")).unwrap().count()
        ),
        (2, 1)
    );
    let mut long = started(&folder, SLOW, "40");
    assert_eq!(
        (
            parts(&folder),
            fs::read_dir(folder.join("tmp")).unwrap().count()
        ),
        (2, 1)
    );
    let mut short = started(&folder, SLOW, "1");
    short.wait().unwrap();
    assert_row(&csv, &[1.0, 1.0, 0.0]);
    assert!(long.wait().unwrap().success());
    assert_eq!(fs::read_to_string(&csv).unwrap().lines().count(), 402);
    assert_eq!(
        (
            parts(&folder),
            fs::read_dir(folder.join("tmp")).unwrap().count()
        ),
        (0, 0)
    );
}
