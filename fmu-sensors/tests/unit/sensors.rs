use super::*;
use fmu_export::Evaluation;

const H: f64 = 1e-3;

/// The FMU as its importer sees it, without the border.
struct Importer {
    parameters: Parameters,
    input: Input,
    fmu: SensorsFmu,
}

impl Importer {
    fn new(change: impl Fn(&mut Parameters)) -> Self {
        let (mut parameters, input) = SensorsFmu::defaults();
        change(&mut parameters);
        let fmu = SensorsFmu::initialize(&parameters, &input, 0.0).expect("valid");
        Self {
            parameters,
            input,
            fmu,
        }
    }

    fn set(&mut self, u: Signals) {
        self.input = Input {
            u,
            sets: self.input.sets.wrapping_add(1),
        };
    }

    fn now(&self) -> Sample {
        Sample::new(&self.fmu, &self.parameters, &self.input).expect("no checks")
    }

    fn read(&self) -> Signals {
        let output = self.fmu.output(&self.parameters, &self.input, &self.now());
        output.expect("finite")
    }

    fn step(&mut self) {
        let (now, u) = (self.now(), InputPolynomial::held(self.input));
        let stepped = self.fmu.step(&self.parameters, &u, &now, 0.0, H);
        stepped.expect("finite");
    }
}

/// Inputs of a machine in motion at time `t`.
fn motion(t: f64) -> Signals {
    let of = |k: usize, size: f64| size * (0.3 + k as f64 + (1.0 + 0.1 * k as f64) * t);
    Signals {
        zeta: std::array::from_fn(|k| of(k, 0.7)),
        zeta_dot: std::array::from_fn(|k| of(k, -0.1)),
        theta_m: std::array::from_fn(|k| of(k, 90.0)),
        w_m: std::array::from_fn(|k| of(k, 9.0)),
        i_d: std::array::from_fn(|k| of(k, -0.5)),
        i_q: std::array::from_fn(|k| of(k, 11.0)),
        F: std::array::from_fn(|k| of(k, 9e3)),
        x: std::array::from_fn(|k| of(k, 0.04)),
        x_dot: std::array::from_fn(|k| of(k, 0.01)),
    }
}

fn passes(y: &Signals, u: &Signals) -> bool {
    let same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
    same(&y.zeta, &u.zeta)
        && same(&y.zeta_dot, &u.zeta_dot)
        && same(&y.theta_m, &u.theta_m)
        && same(&y.w_m, &u.w_m)
        && same(&y.i_d, &u.i_d)
        && same(&y.i_q, &u.i_q)
        && same(&y.F, &u.F)
        && same(&y.x, &u.x)
        && same(&y.x_dot, &u.x_dot)
}

/// Every accessor works, and the declared dependencies are those found by varying the inputs.
#[test]
fn the_table_agrees_with_the_model() {
    assert_eq!(fmu_export::check::<SensorsFmu>(), [""; 0]);
}

/// With every effect off values pass bit for bit, before and after a set, −0 and numbers of any
/// size included.
#[test]
fn everything_off_passes_bit_for_bit() {
    let mut importer = Importer::new(|_| ());
    for k in 0..200 {
        let mut u = motion(f64::from(k) * H);
        u.zeta[0] = -0.0;
        u.F[1] = 1e300;
        u.w_m[2] = -5e-324;
        importer.set(u);
        assert!(passes(&importer.read(), &u));
        importer.step();
        assert!(passes(&importer.read(), &u));
    }
}

/// With a delay of n steps the readings are those of n communication points before, at the start
/// the first ones.
#[test]
fn a_delay_counts_communication_steps() {
    for delay in 0..=4 {
        let mut importer = Importer::new(|p| p.delay = delay);
        importer.fmu = SensorsFmu::initialize(
            &importer.parameters,
            &Input {
                u: motion(0.0),
                sets: 0,
            },
            0.0,
        )
        .expect("valid");
        for k in 0..20 {
            importer.set(motion(f64::from(k) * H));
            let expected = motion(f64::from((k - delay).max(0)) * H);
            assert!(passes(&importer.read(), &expected), "{delay}, {k}");
            importer.step();
        }
    }
}

/// A master that reads all outputs before it sets any input gets each sample one step late, speeds
/// by difference included; whoever sets nothing any more sees the speed come to rest.
#[test]
fn readings_before_a_set_are_those_of_the_last_sample() {
    let on = |p: &mut Parameters| {
        p.speed = SPEED.number(SpeedKind::Difference);
        p.p.speed.filter_time = 0.0;
    };
    let (mut staged, mut standard) = (Importer::new(on), Importer::new(on));
    let mut last = standard.read();
    for k in 0..50 {
        let u = motion(f64::from(k) * H);
        assert_eq!(standard.read(), last, "{k}");
        for importer in [&mut staged, &mut standard] {
            importer.set(u);
        }
        last = staged.read();
        if k > 0 {
            // The quotient loses the digits of an angle of some 300 rad: 300·2⁻⁵²·2/1 ms = 1.3e-10
            // rad/s.
            let w_m = 90.0 * (1.0 + 0.1 * 2.0);
            assert!((last.w_m[2] - w_m).abs() < 2e-10, "{}", last.w_m[2]);
        }
        staged.step();
        standard.step();
    }
    standard.step();
    assert_eq!(standard.read().w_m, [0.0; 3]);
}

/// The same seed gives the same readings, another one others; a saved state goes on as the instance
/// that it was saved from; and asking twice is no new sample.
#[test]
fn noise_belongs_to_seed_and_state() {
    let on = |seed| {
        move |p: &mut Parameters| {
            p.seed = seed;
            p.p.motor_encoder.on = true;
            p.p.current.on = true;
            p.force = FORCE.number(ForceKind::Sensor);
        }
    };
    let run = |importer: &mut Importer, from: u32| -> Vec<Signals> {
        let sample = |k: u32| {
            importer.set(motion(f64::from(k) * H));
            let read = importer.read();
            assert_eq!(read, importer.read());
            importer.step();
            read
        };
        (from..from + 30).map(sample).collect()
    };
    let mut first = Importer::new(on(7));
    let (rows, saved) = (run(&mut first, 0), first.fmu.clone());
    assert_eq!(run(&mut Importer::new(on(7)), 0), rows);
    let other = run(&mut Importer::new(on(8)), 0);
    assert!(rows.iter().zip(&other).all(|(a, b)| a.F != b.F));
    let on_it_goes = run(&mut first, 30);
    first.fmu = saved;
    assert_eq!(run(&mut first, 30), on_it_goes);
}

/// An effect: its name, its switch, the readings that it changes, and by how much at most.
struct Effect {
    name: &'static str,
    on: fn(&mut Parameters),
    of: fn(&Signals) -> Vec<f64>,
    largest: f64,
}

/// Counts are 2π/2¹⁷ = 4.8e-5 and 2π/2¹⁹ = 1.2e-5 rad; seven standard deviations of noise and half
/// a count of rounding.
const EFFECTS: [Effect; 5] = [
    Effect {
        name: "motor encoder",
        on: |p| p.p.motor_encoder.on = true,
        of: |y| y.theta_m.to_vec(),
        largest: 7.5 * 4.8e-5,
    },
    Effect {
        name: "joint encoder",
        on: |p| p.p.joint_encoder.on = true,
        of: |y| y.zeta.to_vec(),
        largest: 0.51 * 1.2e-5,
    },
    Effect {
        name: "joint zero",
        on: |p| p.p.joint_zero.on = true,
        of: |y| y.zeta.to_vec(),
        largest: 0.02 * std::f64::consts::PI / 180.0,
    },
    Effect {
        name: "current",
        on: |p| p.p.current.on = true,
        of: |y| y.i_q.to_vec(),
        largest: 1.0,
    },
    Effect {
        name: "force",
        on: |p| p.force = FORCE.number(ForceKind::Sensor),
        of: |y| y.F.to_vec(),
        largest: 350.0 + 7.0 * 70.0,
    },
];

/// Switching one effect changes no reading of another, and each effect stays within its size.
/// (Zeros act on the same reading as the joint encoder, and currents turn back with the measured
/// motor angle: they are not compared.)
#[test]
fn effects_are_apart_from_each_other() {
    let u = motion(0.2);
    let read = |change: &dyn Fn(&mut Parameters)| {
        let mut importer = Importer::new(change);
        for _ in 0..2 {
            importer.set(u); // the second sample has come after the lag of the force: 2π·1 kHz·1 ms
            importer.step();
        }
        (0..20).for_each(|_| importer.step());
        importer.read()
    };
    let apart = |effect: &&Effect| !["joint zero", "current"].contains(&effect.name);
    let plain = read(&|_| ());
    let all = read(&|p| EFFECTS.iter().filter(apart).for_each(|e| (e.on)(p)));
    for effect in &EFFECTS {
        let alone = (effect.of)(&read(&effect.on));
        let errors = alone.iter().zip((effect.of)(&plain));
        let largest = errors.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let name = effect.name;
        assert!(largest > 0.0, "{name} does nothing");
        assert!(largest <= effect.largest, "{name}: {largest}");
        if apart(&effect) {
            assert_eq!(alone, (effect.of)(&all), "{name}");
        }
    }
}

/// With every effect on an input acts at once on the readings of its own joint or actuator that the
/// table declares, and on no others.
#[test]
fn readings_follow_what_they_declare() {
    type Of<S> = fn(&mut S) -> &mut [f64];
    let inputs: [(&str, Of<Signals>, &[&str]); 9] = [
        ("zeta", |u| &mut u.zeta, &["zeta", "zeta_dot"]),
        ("zeta_dot", |u| &mut u.zeta_dot, &["zeta_dot"]),
        (
            "theta_m",
            |u| &mut u.theta_m,
            &["theta_m", "w_m", "i_d", "i_q", "F"],
        ),
        ("w_m", |u| &mut u.w_m, &["w_m"]),
        ("i_d", |u| &mut u.i_d, &["i_d", "i_q", "F"]),
        ("i_q", |u| &mut u.i_q, &["i_d", "i_q", "F"]),
        ("F", |u| &mut u.F, &["F"]),
        ("x", |u| &mut u.x, &["x", "x_dot"]),
        ("x_dot", |u| &mut u.x_dot, &["x_dot"]),
    ];
    let outputs: [(&str, Of<Signals>); 9] = [
        ("zeta", |y| &mut y.zeta),
        ("zeta_dot", |y| &mut y.zeta_dot),
        ("theta_m", |y| &mut y.theta_m),
        ("w_m", |y| &mut y.w_m),
        ("i_d", |y| &mut y.i_d),
        ("i_q", |y| &mut y.i_q),
        ("F", |y| &mut y.F),
        ("x", |y| &mut y.x),
        ("x_dot", |y| &mut y.x_dot),
    ];
    for (speed, force) in [(1, 1), (2, 2), (3, 3)] {
        let mut importer = Importer::new(|p| {
            (p.speed, p.force) = (speed, force);
            p.p.motor_encoder.on = true;
            p.p.current.on = true;
        });
        importer.set(motion(0.0));
        importer.step();
        importer.set(motion(H));
        let mut before = importer.read();
        for (input, of, declared) in &inputs {
            let mut moved = motion(H);
            of(&mut moved)[1] += 1.0;
            importer.set(moved);
            let mut after = importer.read();
            for (output, of) in &outputs {
                let (before, after) = (of(&mut before), of(&mut after));
                let expected: Vec<usize> = if declared.contains(output) {
                    vec![1]
                } else {
                    vec![]
                };
                let differ = (0..before.len()).filter(|&k| before[k] != after[k]);
                assert!(
                    differ.clone().all(|k| expected.contains(&k)),
                    "{input} on {output}: {:?}",
                    differ.collect::<Vec<_>>()
                );
            }
        }
    }
}
