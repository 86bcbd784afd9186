//! The motion along a path against differences, by hand, and against its limits.

use machine_file::Machine;
use motion_check::{Kinematics, Pose};
use nalgebra::{UnitQuaternion, Vector3, Vector6};
use tip_path::{PathFile, Place, TipPath};

fn start() -> Pose {
    let machine = Machine::reference();
    Kinematics::new(&machine)
        .expect("works")
        .pose(&machine.start.zeta)
}

fn path(text: &str) -> TipPath {
    let file = PathFile::parse(text).unwrap_or_else(|error| panic!("{error}"));
    TipPath::new(&file, start()).unwrap_or_else(|error| panic!("{error}"))
}

/// Stops, blends, turns, times and a rest.
const CORNERS: &str = r#"{
    "relative": true,
    "limits": {"speed": 0.3, "acceleration": 0.5, "jerk": 2.1},
    "waypoints": [
        {"position": [0, 0, 0], "dwell": 0.3},
        {"position": [-0.4, 0, 0.1], "blend": 0.13},
        {"position": [-0.4, 0.35, 0.1], "blend": 0.07, "orientation": [0.96, 0.28, 0, 0]},
        {"position": [-0.1, 0.35, -0.2], "speed": 0.11, "load": {"mass": 170, "com": [0.1, 0, 0]}},
        {"position": [-0.1, 0.35, -0.2], "orientation": [0.8, 0, 0.6, 0], "dwell": 0.4},
        {"position": [0, 0.1, 0], "time": 24.0, "load": {"mass": 0}}
    ]
}"#;

const SAMPLED: &str = "\
# a curve
t, x, y, z, qw, qx, qy, qz
10, 3.0, 1.0, 0.0, 1, 0, 0, 0
11.5, 2.9, 1.1, 0.1, 0.96, 0.28, 0, 0
12.1, 2.8, 1.0, 0.15, -0.96, 0, 0, -0.28
14, 2.9, 0.9, 0.0, 0.8, 0, -0.6, 0
";

/// Velocity and acceleration, angular ones too, against central differences over δ = 1e-4 s: δ²/6
/// of the third derivative, jerks of at most 20 m/s³ or rad/s³ that jump (then j·δ), and rounding,
/// 1e-15/δ.
#[test]
fn rates_are_the_derivatives_of_the_pose() {
    for text in [CORNERS, SAMPLED] {
        let path = path(text);
        let d = 1e-4;
        let mut turned: f64 = 0.0;
        for k in 1..5000 {
            let t = path.duration() * f64::from(k) / 5000.0;
            let [before, now, after] = [path.at(t - d), path.at(t), path.at(t + d)];
            let v = (after.pose.position - before.pose.position) / (2.0 * d);
            let turn = after.pose.orientation * before.pose.orientation.inverse();
            let w = turn.scaled_axis() / (2.0 * d);
            let rate = Vector6::from_iterator(v.iter().chain(&w).copied());
            let error = (rate - now.velocity).norm();
            assert!(error < 1e-6, "t = {t}: {error:e}");
            let rate = (after.velocity - before.velocity) / (2.0 * d);
            let error = (rate - now.acceleration).norm();
            assert!(error < 4e-3, "t = {t}: {error:e}");
            turned = turned.max(w.norm());
        }
        assert!(turned > 0.1, "{turned}");
        for t in [0.0, path.duration()] {
            let motion = path.at(t);
            assert!(motion.velocity.norm() < 1e-12 && motion.acceleration.norm() < 1e-9);
        }
    }
}

/// No jump anywhere: over δ = 1e-6 s the acceleration changes by the jerk at most, 2.1 m/s³ of the
/// path's limits (here per axis and with rounding) and some 30 m/s³ of the sampled one.
#[test]
fn acceleration_does_not_jump() {
    for (text, jerk) in [(CORNERS, 2.2), (SAMPLED, 30.0)] {
        let path = path(text);
        let d = 1e-6;
        for k in 0..=20_000 {
            let t = path.duration() * f64::from(k) / 20_000.0;
            let change = path.at(t + d).acceleration - path.at(t - d).acceleration;
            let change: Vector3<f64> = change.fixed_rows::<3>(0).into();
            assert!(
                change.norm() < 2.0 * d * jerk + 1e-9,
                "t = {t}: {}",
                change.norm()
            );
        }
    }
}

/// Limits hold also where legs overlap in a corner, and the corner is as wide as the file says.
#[test]
fn a_blended_corner_keeps_the_limits_and_leaves_the_line_where_it_is_told() {
    let path = path(CORNERS);
    let (mut speed, mut acceleration): (f64, f64) = (0.0, 0.0);
    let corner = start().position + Vector3::new(-0.4, 0.0, 0.1);
    let mut nearest = f64::INFINITY;
    let (mut first_off, along) = (None, Vector3::new(-0.4, 0.0, 0.1).normalize());
    for k in 0..=40_000 {
        let t = path.duration() * f64::from(k) / 40_000.0;
        let motion = path.at(t);
        speed = speed.max(motion.velocity.fixed_rows::<3>(0).norm());
        acceleration = acceleration.max(motion.acceleration.fixed_rows::<3>(0).norm());
        let to_corner = corner - motion.pose.position;
        nearest = nearest.min(to_corner.norm());
        let off = to_corner - along * along.dot(&to_corner);
        if first_off.is_none() && off.norm() > 1e-9 {
            first_off = Some(to_corner.norm());
        }
    }
    assert!(speed < 0.3 * 1.0001 && speed > 0.15, "{speed}");
    assert!(
        acceleration < 0.5 * 1.0001 && acceleration > 0.3,
        "{acceleration}"
    );
    let first_off = first_off.expect("turns");
    assert!((first_off - 0.13).abs() < 2e-3, "{first_off}");
    assert!(nearest > 0.01 && nearest < 0.13, "{nearest}");
}

/// Waypoints are reached, at the time that is given where one is, and the load changes at the
/// arrival.
#[test]
fn waypoints_are_reached_when_told_and_loads_change_there() {
    let path = path(CORNERS);
    let stops = path.stops();
    let at = |k: usize| path.at(stops[k].arrives).pose;
    let expected = start().position + Vector3::new(-0.1, 0.35, -0.2);
    assert!((at(3).position - expected).norm() < 1e-12);
    let turned = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(0.8, 0.0, 0.6, 0.0));
    assert!(at(4).orientation.angle_to(&turned) < 1e-7);
    assert!((stops[4].leaves - stops[4].arrives - 0.4).abs() < 1e-12);
    assert!((stops[5].arrives - 24.0).abs() < 1e-12 && path.duration() == stops[5].leaves);
    assert_eq!(path.load(stops[3].arrives - 1e-9), None);
    assert_eq!(
        path.load(stops[3].arrives).map(|l| (l.mass, l.com[0])),
        Some((170.0, 0.1))
    );
    assert_eq!(path.load(24.0).map(|l| l.mass), Some(0.0));
    let path = self::path(
        r#"{"relative": true, "waypoints": [
            {"position": [0, 0, 0], "dwell": 2, "load": {"mass": 90, "com": [0.2, 0, 0], "over": 1.5}},
            {"position": [-0.1, 0, 0], "dwell": 3, "load": {"mass": 30, "com": [0, 0.6, 0], "over": 2}}
        ]}"#,
    );
    // Half of the time has passed, half has come; then the middle of both, by mass.
    assert_eq!(
        path.load(0.75).map(|l| (l.mass, l.com)),
        Some((45.0, [0.2, 0.0, 0.0]))
    );
    let found = path.load(path.stops()[1].arrives + 1.0).expect("carried");
    assert!((found.mass - 60.0).abs() < 1e-9);
    assert!((found.com[0] - 0.15).abs() < 1e-9 && (found.com[1] - 0.15).abs() < 1e-9);
    let path = self::path(CORNERS);
    for (t, place) in [
        (0.1, Place::At(1)),
        (stops[3].arrives - 0.1, Place::Between(3)),
        (stops[4].leaves - 0.1, Place::At(5)),
        (23.9, Place::Between(5)),
        (99.0, Place::At(6)),
    ] {
        assert_eq!(path.place(t), place, "{t}");
    }
}

/// The curve goes through its samples at their times, counted from the end of the approach.
#[test]
fn a_sampled_path_goes_through_its_samples() {
    let path = path(SAMPLED);
    let begins = path.duration() - 4.0;
    assert_eq!(path.place(0.5 * begins), Place::Approach);
    for (t, position) in [
        (0.0, [3.0, 1.0, 0.0]),
        (1.5, [2.9, 1.1, 0.1]),
        (2.1, [2.8, 1.0, 0.15]),
        (4.0, [2.9, 0.9, 0.0]),
    ] {
        let error = path.at(begins + t).pose.position - Vector3::from(position);
        assert!(error.norm() < 1e-12, "{t}: {error}");
    }
    assert_eq!(path.place(begins + 1.7), Place::Samples(2));
}

/// A cubic polynomial between two inner samples of a cubic spline: by hand for four samples at
/// equal times 0, 1, 2, 3 with values 0, 1, 0, 1 the slopes are 3/5 and −3/5·… solved from 4 m_1 +
/// m_2 = 0 and m_1 + 4 m_2 = 0: both zero.
#[test]
fn slopes_are_those_of_the_cubic_spline() {
    let path = path("t,x,y,z\n0,3.0,1,0\n1,3.1,1,0\n2,3.0,1,0\n3,3.1,1,0\n");
    let begins = path.duration() - 3.0;
    for t in [1.0, 2.0] {
        assert!(path.at(begins + t).velocity.norm() < 1e-12);
    }
    // Half way between two samples the cubic with zero slopes is in the middle.
    assert!((path.at(begins + 1.5).pose.position.x - 3.05).abs() < 1e-12);
}

/// The path of all six joints is no test of gravity: the tip accelerates with at least 1.5 m/s² (by
/// differences of its velocity over 1 ms, which the jerk of 30 m/s³ moves by less than 2 %), turns
/// by at least 60° between two waypoints, every joint moves by 12° and more, and slew and lift rod
/// come to 95 % of their rated speed.
#[test]
fn the_path_of_six_joints_accelerates_and_turns() {
    let machine = Machine::reference();
    let file = PathFile::built_in(tip_path::SIX_JOINTS)
        .expect("known")
        .expect("valid");
    let path = TipPath::new(&file, start()).expect("timed");
    let (mut acceleration, mut turn) = (0.0_f64, 0.0_f64);
    let points = (path.duration() / 1e-3) as u32;
    for k in 1..points {
        let [before, now] = [k - 1, k].map(|k| path.at(1e-3 * f64::from(k)));
        let change = (now.velocity - before.velocity).fixed_rows::<3>(0).norm() / 1e-3;
        acceleration = acceleration.max(change);
    }
    for stops in path.stops().windows(2) {
        let [from, to] = [0, 1].map(|k| path.at(stops[k].arrives).pose.orientation);
        turn = turn.max(from.angle_to(&to).to_degrees());
    }
    assert!(acceleration > 1.5, "{acceleration} m/s²");
    assert!(turn > 60.0, "{turn}°");
    let mut reached = [[f64::INFINITY, f64::NEG_INFINITY]; 6];
    let zeta = &machine.start.zeta;
    let checked = tip_path::check(&file, &path, &machine, zeta, |_, margins| {
        for (range, margin) in reached.iter_mut().zip(margins) {
            range[0] = range[0].min(margin.value);
            range[1] = range[1].max(margin.value);
        }
    });
    let checked = checked.expect("works");
    for (joint, [least, most]) in reached.into_iter().enumerate() {
        assert!(
            (most - least).to_degrees() > 12.0,
            "joint {joint}: {least} to {most}"
        );
    }
    for rod in ["rod speed of slew", "rod speed of lift"] {
        let (_, margin) = (checked.least.iter())
            .find(|(_, margin)| margin.quantity.to_string() == rod)
            .expect("checked");
        assert!(margin.value.abs() > 0.95 * 0.07, "{rod}: {}", margin.value);
    }
}

/// Laps are equal in every time of them, to the rounding of times that are summed up: 20 s · 2⁻⁵² times 30
/// stops, at 0.3 m/s.
#[test]
fn laps_repeat_the_motion() {
    for name in ["iso9283-rectangle:5", "iso9283-cube:2", tip_path::TRIANGLE] {
        let file = PathFile::built_in(name).expect("known").expect("valid");
        let path = TipPath::new(&file, start()).expect("timed");
        let laps = path.laps().expect("laps");
        let points = path.stops().len() / laps.count;
        assert!((laps.end() - path.stops().last().expect("stops").arrives).abs() < 1e-12);
        for k in 0..1000 {
            let t = laps.begins + laps.period * (f64::from(k) + 0.5) / 1000.0;
            assert_eq!((laps.number(t), laps.number(t + laps.period)), (1, 2));
            let [first, second] = [t, t + laps.period].map(|t| path.at(t));
            let apart = second.pose.position - first.pose.position;
            assert!(
                apart.norm() < 1e-13,
                "{name}, {points} points, {t} s: {apart}"
            );
        }
        assert_eq!(
            [laps.begins - 1e-9, laps.end()].map(|t| laps.number(t)),
            [0, 0]
        );
    }
}

/// What a file of laps may not have.
#[test]
fn laps_are_checked() {
    let said = |laps: &str, more: &str| {
        let text = format!(
            r#"{{"relative": true, "laps": {laps}, "waypoints": [{{"position": [0, 0, 0]{more}}}, {{"position": [0, 0, 0.1]}}]}}"#
        );
        PathFile::parse(&text)
            .map(|_| ())
            .map_err(|e| e.to_string())
    };
    assert_eq!(said("3", ""), Ok(()));
    for (laps, more, expected) in [
        (
            "0",
            "",
            "the file: `laps` = 0 must be a whole number of laps from 1 to 1000",
        ),
        (
            "2.5",
            "",
            "the file: `laps` = 2.5 must be a whole number of laps from 1 to 1000",
        ),
        (
            "2",
            r#", "time": 3"#,
            "waypoint 1: `time` = 3 must be left out, since the path has `laps`",
        ),
        (
            "2",
            r#", "blend": 0.01"#,
            "waypoint 1: `blend` = 0.01 must be 0, because the laps end there and the tip stops",
        ),
    ] {
        assert_eq!(said(laps, more), Err(expected.into()));
    }
    let samples = r#"{"laps": 2, "samples": [[0, 3, 1, 0], [1, 3, 1.1, 0]]}"#;
    let refused = PathFile::parse(samples).unwrap_err().to_string();
    assert!(refused.contains("`samples` has no `laps`"), "{refused}");
}
