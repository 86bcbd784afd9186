//! Tables from files: values between by SciPy (golden.py), units, and what is wrong with a file.

use fmu_export::tables::{Between, Column, Curve, Map};

const X: Column = Column::new("x", "1");
const Y: Column = Column::new("y", "1");
const Z: Column = Column::new("z", "1");

const CURVE: &str = "x [1],y [1]\n-1,0.5\n0.25,0.75\n1,3\n3,3\n3.5,2.5\n7,4\n";
/// Places, and values by golden.py.
#[rustfmt::skip]
const ON_CURVE: [(f64, f64); 11] = [
    (-1.0, 0.5), (-0.9, 0.5015669213483146), (0.0, 0.6592808988764045), (0.25, 0.75), (0.8, 2.621153558052434),
    (1.7, 3.0), (3.2, 2.824), (3.5, 2.5), (4.0, 2.5043731778425657), (6.9, 3.875067055393586), (7.0, 4.0),
];
/// As above, in two dimensions.
const ON_MAP: [(f64, f64, f64); 5] = [
    (0.3, -1.7, 2.656514144165236),
    (1.0, 0.0, 2.2213264928855434),
    (2.7, 1.9, -2.820161058434198),
    (4.9, 1.5, 1.0),
    (1.3, 1.2, 1.4823144311167225),
];

fn map(z: impl Fn(usize, usize) -> f64, between: Between) -> Map {
    let mut text = "x [1],y [1],z [1]\n".to_owned();
    for (i, x) in [0.0, 1.0, 2.5, 3.0, 5.0].iter().enumerate() {
        for (j, y) in [-2.0, -1.0, 1.5, 2.0].iter().enumerate() {
            text += &format!("{x},{y},{}\n", z(i, j));
        }
    }
    Map::read(&text, [X, Y, Z], between).unwrap()
}

/// The same cubics in another order of operations: some ε of the largest value.
#[test]
fn monotone_cubics_are_those_of_scipy() {
    let curve = Curve::read(CURVE, [X, Y], Between::Monotone).unwrap();
    for (x, y) in ON_CURVE {
        assert!((curve.at(x) - y).abs() < 4e-15, "{x}: {} {y}", curve.at(x));
    }
    let values = |i: usize, j: usize| {
        let (i, j) = (i as f64, j as f64);
        (1.0 + i) * (1.0 + i).sqrt() * (2.0 - j) + 0.25 * j * j
    };
    let map = map(values, Between::Monotone);
    for (x, y, z) in ON_MAP {
        assert!(
            (map.at(x, y) - z).abs() < 2e-14,
            "{x} {y}: {} {z}",
            map.at(x, y)
        );
    }
}

/// A bilinear function is given back by straight lines, a straight line by cubics too. Beyond the
/// border its values are held.
#[test]
fn straight_lines_are_exact_and_borders_are_held() {
    let plane = |x: f64, y: f64| 0.5 - 0.25 * x + 2.0 * y + 0.75 * x * y;
    let (xs, ys) = ([0.0, 1.0, 2.5, 3.0, 5.0], [-2.0, -1.0, 1.5, 2.0]);
    let map = map(|i, j| plane(xs[i], ys[j]), Between::Linear);
    assert_eq!(map.range(), [[0.0, 5.0], [-2.0, 2.0]]);
    for (x, y) in [
        (0.0, -2.0),
        (0.6, 0.3),
        (2.9, 1.9),
        (4.75, -1.25),
        (5.0, 2.0),
    ] {
        assert!((map.at(x, y) - plane(x, y)).abs() < 4e-15, "{x} {y}");
    }
    assert_eq!(map.at(-1.0, 7.0), map.at(0.0, 2.0));
    assert!(map.at(f64::NAN, 0.0).is_nan());
    for between in [Between::Linear, Between::Monotone] {
        let line = Curve::read("x [1],y [1]\n1,5\n3,-1\n", [X, Y], between).unwrap();
        assert_eq!(
            [0.0, 1.0, 2.0, 2.5, 3.0, 9.0].map(|x| line.at(x)),
            [5.0, 5.0, 2.0, 0.5, -1.0, -1.0]
        );
    }
}

/// Between two places the curve stays between their values.
#[test]
fn cubics_do_not_overshoot() {
    let curve = Curve::read(CURVE, [X, Y], Between::Monotone).unwrap();
    for (ends, [low, high]) in [
        ([-1.0, 0.25], [0.5, 0.75]),
        ([0.25, 1.0], [0.75, 3.0]),
        ([3.0, 3.5], [2.5, 3.0]),
    ] {
        let inside =
            (0..=1000).map(|k| curve.at(ends[0] + (ends[1] - ends[0]) * f64::from(k) / 1000.0));
        assert!(inside.clone().all(|y| (low..=high).contains(&y)));
        let values: Vec<f64> = inside.collect();
        assert!(values.is_sorted() || values.iter().rev().is_sorted());
    }
}

/// What a file shows in another unit comes in that of the model.
#[test]
fn units_of_the_file_are_converted() {
    let columns = [
        Column::new("speed", "rad/s"),
        Column::new("T", "K").within(200.0, 400.0),
    ];
    let text = "# of the test stand\n speed [rpm] , T [degC]\n0,-20\n\n# warm\n30,60\n";
    let curve = Curve::read(text, columns, Between::Linear).unwrap();
    assert_eq!(curve.range()[0], 0.0);
    assert!((curve.range()[1] - std::f64::consts::PI).abs() < 1e-15);
    assert!((curve.at(0.0) - 253.15).abs() < 1e-13 && (curve.at(4.0) - 333.15).abs() < 1e-13);
}

#[test]
fn errors_name_line_variable_value_and_what_is_allowed() {
    let curve = |text: &str| {
        let columns = [Column::new("speed", "rad/s"), Y.within(0.0, 1.0)];
        Curve::read(text, columns, Between::Linear).unwrap_err()
    };
    for (text, error) in [
        ("", "there must be a line with the names of the columns"),
        (
            "speed,y [1]\n",
            "line 1: the column `speed` must be `speed [rad/s]`",
        ),
        (
            "# c\ny [1],speed [rad/s]\n",
            "line 2: the column `y [1]` must be `speed [rad/s]`",
        ),
        (
            "speed [Hz],y [1]\n",
            "line 1: `speed` is in Hz; it must be in rad/s or rpm or deg/s",
        ),
        ("speed [rpm]\n", "line 1: there must be 2 columns, not 1"),
        (
            "speed [rad/s],y [1]\n1,1\n",
            "there must be at least two values of `speed`",
        ),
        (
            "speed [rad/s],y [1]\n1,1,2\n",
            "line 2: there must be 2 columns, not 3",
        ),
        (
            "speed [rad/s],y [1]\n1,1e\n",
            "line 2: `y` = `1e` must be a finite number",
        ),
        (
            "speed [rad/s],y [1]\nnan,1\n",
            "line 2: `speed` = `nan` must be a finite number",
        ),
        (
            "speed [rad/s],y [%]\n\n1,120\n",
            "line 3: `y` = 1.2 1 must be from 0 to 1",
        ),
        (
            "speed [rad/s],y [1]\n1,1\n1,0\n",
            "line 3: `speed` = 1 must be greater than 1 before it",
        ),
    ] {
        assert_eq!(curve(text), error);
    }
    let map = |text: &str| {
        let text = format!("x [1],y [1],z [1]\n{text}");
        Map::read(&text, [X, Y, Z], Between::Linear).unwrap_err()
    };
    for (text, error) in [
        ("0,0,1\n1,0,1\n", "there must be at least two values of `y`"),
        ("0,0,1\n0,1,1\n", "there must be at least two values of `x`"),
        (
            "0,1,1\n0,0,1\n",
            "line 3: `y` = 0 must be greater than 1 before it",
        ),
        (
            "0,0,1\n0,1,1\n1,0,1\n1,2,1\n",
            "line 5: `y` = 2 must be 1, as it is for the first `x`",
        ),
        (
            "0,0,1\n0,1,1\n1,0,1\n",
            "line 4: there must be 2 values of `y` before it, not 1",
        ),
        (
            "0,0,1\n0,1,1\n1,0,1\n2,0,1\n",
            "line 5: there must be 2 values of `y` before it, not 1",
        ),
        (
            "0,0,1\n0,1,1\n1,0,1\n1,1,1\n1,2,1\n",
            "line 6: `y` = 2 must be no more numbers, as it is for the first `x`",
        ),
        (
            "1,0,1\n1,1,1\n0,0,1\n",
            "line 4: `x` = 0 must be greater than 1 before it",
        ),
    ] {
        assert_eq!(map(text), error);
    }
}
