//! Loads that a path picks up: a controller that is told takes them into its model, at the level of
//! the machine.

use emla::Surrogate;
use hdrm::{Body, Hdrm, Load, Options};
use machine_file::Machine;
use tip_path::PathFile;
use vdc::{Controller, Input, Level, Mode, Output, Settings, Trajectory};

const MASS: f64 = 250.0;
const PL: usize = Body::PL as usize;

/// Outputs before and after the path, from its start to beyond its end, picks up the load.
fn run(is_told: bool, level: Level) -> [Output; 2] {
    let mut machine = Machine::reference();
    machine.controller.settle_time = 0.0;
    let file = PathFile::parse(
        r#"{"relative": true, "limits": {"speed": 0.1, "acceleration": 0.2, "jerk": 1.0}, "waypoints": [
            {"position": [0, 0, 0]},
            {"position": [0, 0.01, 0], "dwell": 1.0, "load": {"mass": 250, "com": [0.1, 0, 0]}},
            {"position": [0, 0, 0]}]}"#,
    )
    .expect("valid");
    let settings = Settings {
        mode: Mode::Modular,
        level,
        load_known: is_told,
        ..Settings::from_gains(&machine.controller)
    };
    let u = Input {
        zeta: machine.start.zeta,
        ..Input::default()
    };
    let network = Surrogate::reference();
    let path = Trajectory::Path {
        file: &file,
        is_checked: false,
    };
    let mut controller =
        Controller::new(&machine, &network, path, &settings, &u, 0.0).expect("works");
    let h = 0.01;
    let mut at = |k: u32| {
        let now = controller.evaluate(&settings, &u).expect("finite");
        let t = f64::from(k) * h;
        controller.step(&now, &settings, &u, t, h).expect("finite");
        now.output(&u.F)
    };
    let first = at(0);
    let last = (1..500).map(&mut at).last().expect("steps");
    [first, last]
}

/// With the load at rest in the hand the lift rod is asked for more by its weight; the machine
/// believes in its mass.
#[test]
fn a_controller_that_is_told_takes_the_load_into_its_model() {
    let [before, after] = run(true, Level::Machine);
    assert_eq!((before.load.mass, after.load.mass), (0.0, MASS));
    let heavier = after.mass_hat[PL] - before.mass_hat[PL];
    assert!((heavier - MASS).abs() < 1e-9, "{heavier} kg");
    let more = after.f_required[1] - before.f_required[1];
    assert!(more > MASS * 9.81, "{more} N: the boom is a lever");
    // At the end of the path the machine stands where it should: what is asked of the rods holds
    // the plant with this load.
    let machine = Machine::reference();
    let plant = Hdrm::new(&machine, &Options::from_machine(&machine)).expect("valid");
    let load = Load {
        mass: MASS,
        com: [0.1, 0.0, 0.0],
        ..*plant.load()
    };
    let loaded = plant.with_load(&load).expect("valid");
    let (f, _) = loaded.holding(&machine.start.zeta);
    for (asked, f) in after.f_required.iter().zip(f) {
        let error = (asked - f).abs();
        assert!(error < 1e-6, "{f} N, off by {error:e}");
    }
}

#[test]
fn others_do_not() {
    for (is_told, level) in [(false, Level::Machine), (true, Level::Actuator)] {
        let [before, after] = run(is_told, level);
        assert_eq!(after.load.mass, MASS);
        assert_eq!(after.mass_hat, before.mass_hat);
    }
    let [_, told] = run(true, Level::Machine);
    let [_, untold] = run(false, Level::Machine);
    assert!(untold.f_required[1] < 0.95 * told.f_required[1]);
}
