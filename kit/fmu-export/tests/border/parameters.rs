//! Parameters set one by one, and a text that sets all of them: what is in force, in whichever
//! order they were set.
//!
//! The probe's `file` "n" sets level = n, gain = 0.5, rate = 7.5, 8.5, law = 1.

use crate::client::*;
use crate::probe::vr;
use fmu_export::ffi::*;

/// Start values, as an importer writes back what it has read from the model description.
fn write_back_all(fmu: &Fmu) {
    let reals = [vr::GAIN, vr::RATE[0], vr::RATE[1]];
    assert_eq!(fmu.set(&reals, &[3.0, 0.0, 0.25]), Status::Ok);
    assert_eq!(fmu.set_integer(vr::LAW, 1), Status::Ok);
    assert_eq!(fmu.set_integer(vr::LEVEL, 4), Status::Ok);
    assert_eq!(fmu.set_boolean(vr::ENABLED, 1), Status::Ok);
}

fn in_force(fmu: &Fmu) -> ([f64; 3], i32) {
    assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
    let reals = fmu.get([vr::GAIN, vr::RATE[0], vr::RATE[1]]);
    (reals, fmu.get_integer(vr::LEVEL))
}

#[test]
fn start_values_written_back_leave_the_file_in_force() {
    for (before, after) in [(true, false), (false, true), (true, true)] {
        let fmu = Fmu::instantiated();
        if before {
            write_back_all(&fmu);
        }
        assert_eq!(fmu.set_string(vr::FILE, c"5"), Status::Ok);
        if after {
            write_back_all(&fmu);
        }
        for (name, start, value) in [
            ("gain", "3", "0.5"),
            ("rate[1]", "0", "7.5"),
            ("rate[2]", "0.25", "8.5"),
            ("level", "4", "5"),
        ] {
            let text = format!(
                "`{name}` was set to its start value {start}; the value {value} from `file` = \"5\" is kept"
            );
            let said = fmu.messages().into_iter().find(|m| m.text == text);
            assert_eq!(
                said.map(|m| (m.status, m.category)),
                Some((Status::Warning, "logStatusWarning".to_owned())),
                "{text}"
            );
        }
        assert_eq!(in_force(&fmu), ([0.5, 7.5, 8.5], 5));
        fmu.start();
        assert_eq!(fmu.get([vr::X[1]]), [8.5]);
    }
}

/// Other values win over the file, and a start value takes them back.
#[test]
fn other_values_win_over_the_file() {
    let fmu = Fmu::instantiated();
    assert_eq!(fmu.set(&[vr::GAIN, vr::RATE[0]], &[4.0, 1.5]), Status::Ok);
    assert_eq!(fmu.set_string(vr::FILE, c"5"), Status::Ok);
    assert_eq!(fmu.set(&[vr::RATE[1]], &[2.5]), Status::Ok);
    assert_eq!(fmu.set(&[vr::GAIN], &[3.0]), Status::Ok);
    assert_eq!(in_force(&fmu), ([0.5, 1.5, 2.5], 5));
    fmu.start();
    // Once it runs, a start value is a value like any other.
    assert_eq!(fmu.set(&[vr::GAIN], &[3.0]), Status::Ok);
    assert_eq!(fmu.get([vr::GAIN]), [3.0]);
}

/// Without a file a start value is what is in force; and a start text takes the file back.
#[test]
fn without_a_file_start_values_are_in_force() {
    let fmu = Fmu::instantiated();
    assert_eq!(fmu.set(&[vr::GAIN, vr::RATE[0]], &[4.0, 1.5]), Status::Ok);
    assert_eq!(fmu.set(&[vr::GAIN], &[3.0]), Status::Ok);
    assert_eq!(fmu.set_string(vr::FILE, c"5"), Status::Ok);
    assert_eq!(fmu.set_string(vr::FILE, c"4"), Status::Ok);
    assert_eq!(in_force(&fmu), ([3.0, 1.5, 0.25], 4));
    assert_eq!(fmu.get_string(vr::FILE), "4");
}

/// What a file sets must be in the bounds that hold for everyone; level is from -3 to 7.
#[test]
fn a_file_cannot_pass_the_bounds() {
    let fmu = Fmu::instantiated();
    assert_eq!(fmu.set_string(vr::FILE, c"5"), Status::Ok);
    let before = fmu.snapshot();
    assert_eq!(fmu.set_string(vr::FILE, c"8"), Status::Discard);
    assert_eq!(
        fmu.last().text,
        "fmi2SetString: `file` = \"8\": `level` = 8 must be from -3 to 7"
    );
    assert_eq!(fmu.snapshot(), before);
}
