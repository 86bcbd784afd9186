//! FMUs that end the process, change what is not theirs, or log and print what is no text: the call
//! is named, what was changed is put back, and everything has a limit.
#![cfg(target_os = "linux")]

use std::fs;
use std::process::Command;

use super::foreign::compiled;
use super::support::{assert_contains, pack, scratch};

const FMI2: &str = r#"<fmiModelDescription fmiVersion="2.0" modelName="h" guid="1">
  <CoSimulation modelIdentifier="hostile" canGetAndSetFMUstate="true" canSerializeFMUstate="true"/><ModelVariables>
  <ScalarVariable name="u" valueReference="0" causality="input"><Real start="1"/></ScalarVariable>
  <ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>
  </ModelVariables><ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure></fmiModelDescription>"#;
const FMI3: &str = r#"<fmiModelDescription fmiVersion="3.0" modelName="h" instantiationToken="1">
  <CoSimulation modelIdentifier="hostile"/><ModelVariables>
  <Float64 name="u" valueReference="0" causality="input" start="1"/><Float64 name="y" valueReference="1" causality="output"/>
  MORE</ModelVariables><ModelStructure><Output valueReference="1"/></ModelStructure></fmiModelDescription>"#;

/// The FMU `h.fmu` of both versions, in a folder of the test's own.
pub fn packed(test: &str) -> [String; 2] {
    let folder = scratch(test);
    fs::create_dir_all(&folder).unwrap();
    let library = compiled(
        &folder,
        "hostile.so",
        &["hostile.c"],
        &["-w", "-lm", "-lpthread"],
    );
    let platforms = match cfg!(target_arch = "x86_64") {
        true => ["linux64", "x86_64-linux"],
        false => ["aarch64-linux"; 2],
    };
    let descriptions = [FMI2.to_string(), FMI3.replace("MORE", "")];
    [0, 1].map(|k| {
        let file = folder.join(format!("h{}.fmu", k + 2));
        pack(&file, &descriptions[k], platforms[k], &[&library]);
        file.display().to_string()
    })
}

/// Exit code, standard output and standard error of a run of 1 s, 0.1 s a step.
fn run(fmu: &str, more: &[&str], environment: &[(&str, &str)]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
    command
        .args(["run", fmu, "--quiet", "--step", "0.1", "--stop-time", "1"])
        .args(more);
    let done = command.envs(environment.iter().copied()).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    let code = done.status.code().unwrap_or(-1);
    (code, text(done.stdout), text(done.stderr))
}

/// However an FMU ends the process, and in whatever call: a line names the call, and the exit code is
/// one that nothing else has.
#[test]
fn an_fmu_that_ends_the_process_is_named() {
    let fmus = packed("hostile-ends");
    #[rustfmt::skip]
    let rows = [
        ("segv step", "h: fmiDoStep at t = 0.3 s crashed with a segmentation fault (SIGSEGV)"),
        ("abort step", "h: fmiDoStep at t = 0.3 s called abort (SIGABRT)"),
        ("exit step", "h: fmiDoStep at t = 0.3 s called exit, which ends this process"),
        ("quick_exit step", "h: fmiDoStep at t = 0.3 s called exit, which ends this process"),
        ("bus step", "h: fmiDoStep at t = 0.3 s crashed with a bus error (SIGBUS)"),
        ("stack step", "h: fmiDoStep at t = 0.3 s overflowed its stack (SIGSEGV)"),
        ("thread_exit step", "error: a thread that an FMU has made called exit"),
        ("thread_segv step", "a thread that an FMU has made crashed with a segmentation fault (SIGSEGV); meanwhile h: fmiDoStep at t = 0.3 s"),
        ("exit get", "h: fmiGetReal"),
        ("exit set", "h: fmiSetReal"),
        ("exit load", "FILE`: loading the library called exit"),
        ("segv load", "FILE`: loading the library crashed"),
        ("exit unload", "FILE`: unloading the library called exit"),
        ("segv instantiate", "h: fmiInstantiate crashed"),
        ("exit enter", "h: fmiEnterInitializationMode at t = 0 s called exit"),
        ("abort terminate", "h: fmiTerminate at t = 1 s called abort"),
        ("segv free", "h: fmiFreeInstance at t = 1 s crashed"),
        #[cfg(target_arch = "x86_64")]
        ("fpe step", "h: fmiDoStep at t = 0.3 s crashed with an arithmetic fault (SIGFPE)"),
        #[cfg(target_arch = "x86_64")]
        ("trap step", "h: fmiDoStep at t = 0.3 s crashed with an illegal instruction (SIGILL)"),
    ];
    for (k, fmu) in fmus.iter().enumerate() {
        for (asked, line) in rows {
            let prefix = format!("fmi{}", k + 2);
            let mut line = line
                .replace("fmi", &prefix)
                .replace("FILE", &format!("h{}.fmu", k + 2));
            line = line.replace("h:", &format!("h{}:", k + 2));
            if k == 1 {
                line = line.replace("Real", "Float64");
                line = line.replace("fmi3Instantiate", "fmi3InstantiateCoSimulation");
            }
            let csv = scratch("hostile-ends").join("out.csv");
            let csv = csv.display().to_string();
            let more = ["--set", "u=2", "--signals", "*", "--csv", &csv];
            let (code, _, error) = run(fmu, &more, &[("HOSTILE", asked)]);
            assert_contains(&error, &[&line]);
            assert_eq!(code, 3, "{asked}: {error}");
        }
    }
}

/// The same in a thread of the master's.
#[test]
fn crashes_are_named_in_threads_too() {
    let [fmu, _] = packed("hostile-threads");
    let other = scratch("hostile-threads").join("other.fmu");
    fs::copy(&fmu, &other).unwrap();
    let other = other.display().to_string();
    let schedules = ["standard", "gauss-seidel"].into_iter();
    let asked = ["stack step", "exit step"];
    for (schedule, asked) in schedules.flat_map(|schedule| asked.map(|asked| (schedule, asked))) {
        let more = [other.as_str(), "--threads", "2", "--schedule", schedule];
        let (code, _, error) = run(&fmu, &more, &[("HOSTILE", asked)]);
        assert_eq!(code, 3, "{asked}: {error}");
        assert_contains(&error, &[": fmi2DoStep at t = 0.3 s "]);
    }
}

/// Processes that an FMU forks may end as they like.
#[test]
fn a_forked_process_may_exit() {
    let [fmu, _] = packed("hostile-fork");
    let (code, _, error) = run(&fmu, &["--check"], &[("HOSTILE", "fork step")]);
    assert_eq!(code, 0, "{error}");
    assert!(!error.contains("called exit"), "{error}");
}

/// What belongs to the thread and the process is put back, and that is said once.
#[test]
fn what_an_fmu_changes_is_put_back() {
    #[rustfmt::skip]
    let rows = [
        ("round step", "fmi2DoStep changed the rounding mode; it was put back"),
        ("round load", "loading the library changed the rounding mode; it was put back"),
        ("round get", "fmi2GetReal changed the rounding mode; it was put back"),
        #[cfg(target_arch = "x86_64")]
        ("flush step", "fmi2DoStep changed how numbers near 0 are computed (flush to zero); it was put back"),
        #[cfg(target_arch = "x86_64")]
        ("unmask instantiate", "fmi2Instantiate changed the traps of floating-point exceptions; it was put back"),
        #[cfg(target_arch = "x86_64")]
        ("x87 exit", "fmi2ExitInitializationMode changed the control word of the x87 unit; it was put back"),
        ("chdir instantiate", "it changed the working folder, found after fmi2Instantiate; it was put back"),
        ("chdir load", "it changed the working folder, found after loading the library; it was put back"),
        ("chdir step", "it changed the working folder, found after fmi2Terminate; it was put back"),
        ("locale enter", "it changed the locale, found after fmi2EnterInitializationMode; it was put back"),
        ("ignore exit", "it changed the handlers of signals that end a program, found after fmi2ExitInitializationMode"),
        ("block exit", "it changed the mask of signals, found after fmi2ExitInitializationMode"),
    ];
    let [fmu, _] = packed("hostile-changes");
    let folder = scratch("hostile-changes");
    for (asked, line) in rows {
        let csv = folder.join("out.csv").display().to_string();
        let (code, out, error) = run(&fmu, &["--csv", &csv], &[("HOSTILE", asked)]);
        let all = out + &error;
        assert_eq!(code, 0, "{asked}: {all}");
        assert_contains(&all, &[line]);
        assert_eq!(all.matches("it was put back").count(), 1, "{all}");
    }
    // Closed streams are opened again: what is said afterwards is seen.
    let (code, out, error) = run(&fmu, &[], &[("HOSTILE", "close exit")]);
    assert_eq!(code, 0, "{error}");
    assert_contains(
        &(out + &error),
        &["it changed the standard streams, which it closed"],
    );
}

/// Numbers are those of an FMU that changes nothing.
#[test]
fn the_rounding_mode_of_one_fmu_is_not_that_of_others() {
    let [fmu, _] = packed("hostile-rounding");
    let folder = scratch("hostile-rounding");
    let rows = ["none none", "round get"].map(|asked| {
        let csv = folder.join("out.csv").display().to_string();
        let (code, _, error) = run(&fmu, &["--csv", &csv], &[("HOSTILE", asked)]);
        assert_eq!(code, 0, "{error}");
        fs::read_to_string(csv).unwrap()
    });
    assert_eq!(rows[0], rows[1]);
}

/// Messages of every form: formats with arguments, texts that are no formats, marks of variables,
/// pointers that lead nowhere.
#[test]
fn messages_of_every_form_are_shown() {
    let [fmu, _] = packed("hostile-messages");
    let (code, out, error) = run(&fmu, &[], &[("HOSTILE", "forms exit")]);
    assert_eq!(code, 0, "{error}");
    let parts = [
        "t = 1.5, n = 42, s = text, fmi2True",
        "1099511627776 7 9  3.14|ab  |    7 abc Z % ff",
        "valve at 100%",
        "50% load, 5 % of it, 100% done",
        "u and y, #i7#, #, a # b",
        "an argument with 100%d",
        "cannot be read",
    ];
    assert_contains(&(out + &error), &parts);
    for asked in ["s exit", "n exit", "d exit", "many exit"] {
        let (code, out, error) = run(&fmu, &[], &[("HOSTILE", asked)]);
        assert_eq!(code, 0, "{asked}: {error}");
        let part = if asked == "many exit" {
            "%d%d"
        } else {
            " is none"
        };
        assert_contains(&(out + &error), &[part]);
    }
}

/// Messages from a thread that the FMU has made arrive; a flood of them, long ones and prints are
/// cut, and that is said.
#[test]
fn messages_and_prints_have_limits() {
    for fmu in packed("hostile-limits") {
        let all = |asked: &str| {
            let (code, out, error) = run(&fmu, &[], &[("HOSTILE", asked)]);
            assert_eq!(code, 0, "{asked}: {error}");
            out + &error
        };
        assert_contains(&all("thread_log step"), &["from a thread (7 times)"]);
        let flood = all("flood exit");
        assert_contains(&flood, &["an FMU: further messages, which are not kept ("]);
        let long = all("long exit");
        assert_contains(&long, &["LLL … (the rest is not kept)"]);
        for (asked, prefix) in [
            ("print load", "prints: first line\n"),
            ("print step", "first line\n"),
        ] {
            let printed = all(asked);
            assert_contains(
                &printed,
                &[prefix, "more than 1 MiB is printed; the rest is not shown"],
            );
            assert!(
                [&flood, &long, &printed]
                    .iter()
                    .all(|text| text.len() < 2 << 20)
            );
        }
    }
}

/// States and values of absurd sizes are refused by name.
#[test]
fn sizes_have_limits() {
    let [fmu, _] = packed("hostile-sizes");
    let folder = scratch("hostile-sizes");
    let snapshot = format!("0.5={}", folder.join("state.bin").display());
    for (bytes, expected) in [("8", 0), ("2000000000", 1), ("4611686018427387904", 1)] {
        let (code, _, error) = run(&fmu, &["--snapshot", &snapshot], &[("STATE", bytes)]);
        assert_eq!(code, expected, "{error}");
        if expected == 1 {
            let part = format!("fmi2SerializedFMUstateSize says that its state has {bytes} bytes");
            assert_contains(&error, &[&part, "at most 1073741824 are kept"]);
        }
    }
    let library = folder.join("hostile.so");
    for (kind, call) in [("Binary", "fmi3GetBinary"), ("String", "fmi3GetString")] {
        let variable = format!(r#"<{kind} name="b" valueReference="2" causality="output"/>"#);
        let text = FMI3.replace("MORE", &variable);
        let text = text.replace(
            "</ModelStructure>",
            "<Output valueReference=\"2\"/></ModelStructure>",
        );
        let file = folder.join("values.fmu");
        let platform = if cfg!(target_arch = "x86_64") {
            "x86_64-linux"
        } else {
            "aarch64-linux"
        };
        pack(&file, &text, platform, &[&library]);
        let (file, csv) = (
            file.display().to_string(),
            folder.join("out.csv").display().to_string(),
        );
        let more = ["--signals", "*", "--csv", csv.as_str()];
        assert_eq!(run(&file, &more, &[]).0, 0);
        for bytes in ["100000000", "400000000", "4611686018427387904"] {
            let (code, _, error) = run(&file, &more, &[("BYTES", bytes)]);
            assert_eq!(code, 1, "{bytes}: {error}");
            assert_contains(&error, &["values", call, " of b ", "that"]);
        }
    }
}
