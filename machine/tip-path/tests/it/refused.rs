//! Each way in which a path can be wrong, and what a person is told.

use machine_file::Machine;
use motion_check::{DemandModel, Kinematics, Motion, Payload, Quantity};
use tip_path::{PathFile, TipPath, check};

/// What is said of a path, or None where all is well.
fn said(text: &str, machine: &Machine) -> Option<String> {
    let file = match PathFile::built_in(text).unwrap_or_else(|| PathFile::parse(text)) {
        Ok(file) => file,
        Err(error) => return Some(error.to_string()),
    };
    let kinematics = Kinematics::new(machine).expect("works");
    let start = kinematics.pose(&machine.start.zeta);
    let path = match TipPath::new(&file, start) {
        Ok(path) => path,
        Err(error) => return Some(error.to_string()),
    };
    let checked = check(&file, &path, machine, &machine.start.zeta, |_, _| ()).expect("works");
    checked.refusal()
}

/// A path of waypoints relative to the start.
fn waypoints(list: &str) -> String {
    format!(r#"{{"relative": true, "waypoints": [{list}]}}"#)
}

#[test]
fn wrong_files_are_refused_with_place_name_value_and_rule() {
    let machine = Machine::reference();
    let two = r#"{"position": [0, 0, 0]}, {"position": [-0.2, 0, 0]}"#;
    assert_eq!(said(&waypoints(two), &machine), None);
    for (text, expected) in [
        (
            waypoints(r#"{"position": [0, 0, 0]}"#),
            "a path has 1 waypoint(s), it must have at least two",
        ),
        (
            waypoints(
                r#"{"position": [0, 0, 0]}, {"position": [0.1, 0, 0]}, {"position": [0.1, 0, 0]}"#,
            ),
            "waypoints 2 and 3 are the same; to rest there, give waypoint 2 a `dwell`",
        ),
        (
            waypoints(r#"{"position": [0, 0, 0], "dwel": 1}, {"position": [0.1, 0, 0]}"#),
            "waypoint 1: `dwel` is unknown, did you mean `dwell`?",
        ),
        (
            format!(r#"{{"waypoint": [{two}]}}"#),
            "the file: `waypoint` is unknown, did you mean `waypoints`?",
        ),
        (
            format!(r#"{{"limits": {{"sped": 1}}, "waypoints": [{two}]}}"#),
            "limits: `sped` is unknown, did you mean `speed`?",
        ),
        (
            format!(r#"{{"limits": {{"jerk": 0}}, "waypoints": [{two}]}}"#),
            "limits: `jerk` = 0 must be finite and > 0",
        ),
        (
            waypoints(
                r#"{"position": [0, 0, 0]}, {"position": [0.1, 0, 0], "orientation": [1, 0, 0, 0.2]}"#,
            ),
            "waypoint 2: `orientation` = [1, 0, 0, 0.2] must be a quaternion w, x, y, z of length 1; its length is 1.0198",
        ),
        (
            waypoints(r#"{"position": [0, 0]}, {"position": [0.1, 0, 0]}"#),
            "waypoint 1: `position` = [0,0] must be a list of 3 numbers",
        ),
        (
            waypoints(r#"{"position": [0, 0, null]}, {"position": [0.1, 0, 0]}"#),
            "waypoint 1: `position` = [0,0,null] must be a list of 3 numbers",
        ),
        (
            waypoints(
                r#"{"position": [0, 0, 0], "time": 3}, {"position": [-0.1, 0, 0], "time": 2}"#,
            ),
            "waypoint 2: `time` = 2 must be finite and not before the waypoints before it, 3 s",
        ),
        (
            waypoints(r#"{"position": [0, 0, 0]}, {"position": [-0.5, 0, 0], "time": 1}"#),
            "waypoint 2: `time` = 1 s is too early: the tip leaves the waypoint before at 0.000 s and needs 5.700 s",
        ),
        (
            waypoints(r#"{"position": [0, 0, 0]}, {"position": [-0.1, 0, 0], "speed": -1}"#),
            "waypoint 2: `speed` = -1 must be finite and > 0",
        ),
        (
            waypoints(r#"{"position": [0, 0, 0]}, {"position": [-0.1, 0, 0], "blend": 0.1}"#),
            "waypoint 2: `blend` = 0.1 must be 0, because the path ends there",
        ),
        (
            waypoints(
                r#"{"position": [0, 0, 0]}, {"position": [-0.1, 0, 0], "load": {"mass": -3}}"#,
            ),
            "waypoint 2: `load.mass` = -3 must be finite and ≥ 0",
        ),
        ("[1, 2]".into(), "the file must be an object, not [1,2]"),
        (
            r#"{"waypoints": 3}"#.into(),
            "the file: `waypoints` = 3 must be a list",
        ),
        (
            r#"{"waypoints": null}"#.into(),
            "the file: `waypoints` = null must be a list",
        ),
        (waypoints("3"), "waypoint 1 must be an object, not 3"),
        (
            waypoints("[[0, 0, 0]], [[0, 0, 1]]"),
            "waypoint 1 must be an object, not [[0,0,0]]",
        ),
        (
            waypoints(r#"{"position": [0, 0, 0]}, {"dwell": 1}"#),
            "waypoint 2: `position` = left out must be given",
        ),
        (
            waypoints(r#"{"position": [0, 0, 0]}, {"position": [0, 0, 1], "dwell": null}"#),
            "waypoint 2: `dwell` = null must be a number",
        ),
        (
            waypoints(r#"{"position": [0, 0, 0]}, {"position": [0, 0, 1], "speed": null}"#),
            "waypoint 2: `speed` = null must be a number",
        ),
        (
            waypoints(r#"{"position": [0, 0, 0], "load": {"mass": "x"}}"#),
            "waypoint 1: `load.mass` = \"x\" must be a number",
        ),
        (
            waypoints(r#"{"position": [0, 0, 0], "load": {"com": [0, 0, 0]}}"#),
            "waypoint 1: `load.mass` = left out must be given",
        ),
        (
            waypoints(r#"{"position": [0, 0, 0], "load": {"mass": 1, "com": [0, 0]}}"#),
            "waypoint 1: `load.com` = [0,0] must be a list of 3 numbers",
        ),
        (
            waypoints(r#"{"position": [0, 0, 0], "load": {"mass": 1, "comm": [0, 0, 0]}}"#),
            "waypoint 1, load: `comm` is unknown, did you mean `com`?",
        ),
        (
            waypoints(r#"{"position": [0, 0, 0], "b`lend": 1}"#),
            "waypoint 1: `b`lend` is unknown, did you mean `blend`?",
        ),
        (
            format!(r#"{{"relative": null, "waypoints": [{two}]}}"#),
            "the file: `relative` = null must be true or false",
        ),
        (
            format!(r#"{{"limits": [1, 1, 1, 1, 1, 1], "waypoints": [{two}]}}"#),
            "the file: `limits` = [1,1,1,1,1,1] must be an object",
        ),
        (
            format!(r#"{{"limits": {{"jerk": "x"}}, "waypoints": [{two}]}}"#),
            "limits: `jerk` = \"x\" must be a number",
        ),
        (
            r#"{"samples": [[0, 1, 2, 3], [1, 2, 3, null]]}"#.into(),
            "sample 2: `samples` = [1,2,3,null] must be [t, x, y, z] or [t, x, y, z, qw, qx, qy, qz], all numbers",
        ),
        (
            "{\"waypoints\": [".into(),
            "path JSON: EOF while parsing a list at line 1 column 15",
        ),
        (
            "{}".into(),
            "a path must have either `waypoints` or `samples`",
        ),
        (
            "x,y,z\n3.1,NaN,0\n3.0,1,0\n".into(),
            "waypoint 1: `position` = NaN must be finite",
        ),
        (
            "x,y,z\n3.1,up,0\n3.0,1,0\n".into(),
            "waypoint 1: `y` = up must be a number",
        ),
        (
            "x;y;z\n1;2;3\n".into(),
            "path CSV: its columns are separated by semicolons (`;`)",
        ),
        (
            "x,y,z,dwel\n3.1,1,0,1\n3.0,1,0,1\n".into(),
            "the header: `dwel` is unknown, did you mean `dwell`?",
        ),
        (
            "x,y\n3.1,1\n3.0,1\n".into(),
            "the header must have columns x, y and z; `z` is missing",
        ),
        (
            "t,x,y,z\n0,3,1,0\n1,3,1,0.1\n0.5,3,1,0\n".into(),
            "sample 3: `t` = 0.5 must be later than that of the sample before, 1 s",
        ),
        (
            "t,x,y,z\n0,3,1,0\n".into(),
            "a path has 1 sample(s), it must have at least two",
        ),
        (
            "t,x,y,z,qw,qx,qy,qz\n0,3,1,0,1,0,0,0\n1,3,1,0.1,2,0,0,0\n".into(),
            "sample 2: `orientation` = [2, 0, 0, 0] must be a quaternion w, x, y, z of length 1; its length is 2.0000",
        ),
        (
            "iso9283-cube:0".into(),
            "iso9283-cube: `cycles` = 0 must be a whole number of cycles from 1 to 1000",
        ),
    ] {
        let found = said(&text, &machine).unwrap_or_else(|| panic!("{text} must be refused"));
        assert!(
            found.contains(expected),
            "{text}\n{found}\nmust contain\n{expected}"
        );
    }
}

/// What the machine cannot do: the waypoint, the limit, the value and by how much.
#[test]
fn what_the_machine_cannot_do_is_refused() {
    let reference = Machine::reference();
    let with = |change: fn(&mut Machine)| {
        let mut machine = reference.clone();
        change(&mut machine);
        machine
    };
    let back = r#"{"position": [0, 0, 0]}, {"position": [-0.4, 0, 0]}"#;
    for (list, machine, expected) in [
        (
            r#"{"position": [0, 0, 0]}, {"position": [2.5, 0, 0]}"#,
            reference.clone(),
            "waypoint 2 is 5.509 m from the lift joint, out of reach: it must be within 4.450 m, 1.059 m nearer",
        ),
        (
            r#"{"position": [0, 0, 0]}, {"position": [0.88, 0, 0]}"#,
            reference.clone(),
            "between waypoints 1 and 2, t = ",
        ),
        (
            r#"{"position": [0, 0, 0]}, {"position": [0.88, 0, 0]}"#,
            reference.clone(),
            "joint 3 (tilt) = ",
        ),
        (
            back,
            with(|machine| {
                let capability = DemandModel::new(machine, &Payload::from_machine(machine));
                let start = Motion::rest(machine.start.zeta);
                let x = capability.expect("valid").demand(&start).x;
                machine.limits.stroke_3 = [x[2] - 0.02, 0.47];
            }),
            "stroke of tilt = ",
        ),
        (
            r#"{"position": [0, 0, 0]}, {"position": [-0.4, 0, 0], "speed": 0.5}"#,
            with(|machine| machine.ratings.tilt.rod_speed_max = 0.03),
            "rod speed of tilt = ",
        ),
        (
            back,
            with(|machine| machine.ratings.lift.force_max = 41e3),
            "force of lift = ",
        ),
        (
            back,
            with(|machine| machine.emla.lift.i_max = 15.0),
            "current of lift = ",
        ),
        (
            back,
            with(|machine| machine.emla.lift.v_max = 20.0),
            "voltage of lift = ",
        ),
        (
            back,
            with(|machine| machine.ratings.lift.motor_speed_rpm = 300.0),
            "motor speed of lift = ",
        ),
        (
            back,
            with(|machine| machine.limits.tau_wrist_max[1] = 120.0),
            "wrist torque 2 = ",
        ),
        (
            back,
            with(|machine| machine.ratings.lift.motor_torque = 10.0),
            "motor torque of lift: root mean square ",
        ),
    ] {
        let found = said(&waypoints(list), &machine);
        let found = found.unwrap_or_else(|| panic!("{list} must be refused for {expected}"));
        assert!(
            found.starts_with("the machine cannot do this path: "),
            "{found}"
        );
        assert!(
            found.contains(expected) && found.contains("must be"),
            "{found}\nmust contain\n{expected}"
        );
        assert!(
            found.contains(" beyond") || found.contains(" nearer"),
            "{found}"
        );
    }
}

/// A load that is picked up counts from there on.
#[test]
fn a_load_beyond_the_limits_is_refused_where_it_is_picked_up() {
    let machine = Machine::reference();
    let of = |mass: f64| {
        let list = format!(
            r#"{{"position": [0, 0, 0]}}, {{"position": [-0.2, 0, 0], "load": {{"mass": {mass}}}}}, {{"position": [0, 0, 0]}}"#
        );
        said(&waypoints(&list), &machine)
    };
    assert_eq!(of(50.0), None);
    let found = of(900.0).expect("too heavy");
    assert!(
        found.contains("between waypoints 2 and 3, t = 2.70 s: force of"),
        "{found}"
    );
}

/// The margins that an observer is told are those of the table.
#[test]
fn the_least_margins_are_those_along_the_path() {
    let machine = Machine::reference();
    let file = PathFile::built_in("iso9283-rectangle:1")
        .expect("known")
        .expect("valid");
    let kinematics = Kinematics::new(&machine).expect("works");
    let path = TipPath::new(&file, kinematics.pose(&machine.start.zeta)).expect("timed");
    let mut least = [f64::INFINITY; Quantity::COUNT];
    let mut last = -1.0;
    let checked = check(&file, &path, &machine, &machine.start.zeta, |t, margins| {
        for (least, margin) in least.iter_mut().zip(margins) {
            *least = least.min(margin.part());
        }
        last = t;
    });
    let checked = checked.expect("works");
    assert_eq!(checked.refusal(), None);
    assert_eq!(last, path.duration());
    for (k, (_, margin)) in checked.least.iter().enumerate() {
        assert_eq!(margin.part(), least[k], "{}", margin.quantity);
    }
}

/// The test paths with the standard's cycles and the path of all six joints suit the reference
/// machine.
#[test]
fn the_reference_machine_can_do_the_built_in_paths() {
    let machine = Machine::reference();
    for (name, seconds) in tip_path::BUILT_IN
        .into_iter()
        .zip([600.0, 100.0, 10.0, 50.0])
    {
        assert_eq!(said(name, &machine), None, "{name}");
        let file = PathFile::built_in(name).expect("known").expect("valid");
        let start = Kinematics::new(&machine)
            .expect("works")
            .pose(&machine.start.zeta);
        let path = TipPath::new(&file, start).expect("timed");
        assert!(path.duration() > seconds, "{}", path.duration());
    }
}

/// Moves of a few milliseconds between two checked points: 0.3 mm in 4 ms from rest to rest, along
/// waypoints, and a sample that is 0.3 mm off for 2 ms. By hand: with the jerk j the acceleration reaches (d j²/2)^(1/3) =
/// 150 m/s².
#[test]
fn moves_between_two_checked_points_are_checked() {
    let machine = Machine::reference();
    let limits = r#""limits": {"speed": 9, "acceleration": 1e3, "jerk": 150000}"#;
    let short = format!(
        r#"{{"relative": true, {limits}, "waypoints": [{{"position": [0, 0, 0.0003], "dwell": 1}},
        {{"position": [0, 0, 0.0004], "speed": 0.001}}]}}"#
    );
    let refused = said(&short, &machine).expect("refused");
    assert!(refused.contains("force of slew"), "{refused}");
    let slow = short.replace("150000", "1");
    assert_eq!(said(&slow, &machine), None, "the same move, slowly");
    let samples = |off: f64| {
        let at = |t: f64, z: f64| format!("[{t}, 0, 0, {z}]");
        let list =
            [0.0, 0.5, 0.502, 0.504, 0.506, 1.0].map(|t| at(t, if t == 0.504 { off } else { 0.0 }));
        format!(r#"{{"relative": true, "samples": [{}]}}"#, list.join(", "))
    };
    assert_eq!(said(&samples(0.0), &machine), None);
    let refused = said(&samples(0.0003), &machine).expect("refused");
    assert!(refused.contains("force of slew"), "{refused}");
}
