//! Noise on one component's input, and recordings, on the oscillator of two FMUs.

use cosim::master::Schedule;
use cosim::noise::{Noise, Sensor};
use cosim::recording::Recording;
use cosim::run::{self, Experiment};

use super::support::{oscillator, settings, stepping, system};

fn noise(variable: &str, sigma: f64, seed: u64) -> Noise {
    let sensors = vec![Sensor {
        component: "spring".into(),
        variable: variable.into(),
        sigma,
    }];
    Noise { sensors, seed }
}

#[test]
fn noise_reaches_the_input_it_is_meant_for_and_repeats_with_its_seed() {
    let system = system("noise", &oscillator()).unwrap();
    let record = |noise: Noise| {
        let experiment = Experiment {
            stepping: stepping(0.01, Schedule::GaussSeidel),
            stop: Some(0.6),
            settings: settings(&system, &["spring.k=10"])?,
            noise,
            inputs: None,
        };
        let ports = [system.port("spring.F")?, system.port("mass.x")?];
        let mut recording = Recording::new(&system, &ports)?;
        let (master, stop) = (experiment.start(&system)?, experiment.stop(&system)?);
        run::run(&system, master, stop, &|_, _| (), |master| {
            recording.add(master)
        })?;
        let [force, x] = ports.map(|p| recording.column(p).unwrap().to_vec());
        anyhow::Ok((recording.times, force, x))
    };
    let (times, clean, x) = record(Noise::default()).unwrap();
    assert_eq!(
        (times.len(), times[0]),
        (11, 0.5),
        "0.5 s to 0.6 s in steps of 0.01 s"
    );
    let (_, noisy, noisy_x) = record(noise("x", 0.01, 5)).unwrap();
    // The mass moves only by the forces of steps made: at the start it is where it was, the force
    // is not.
    assert_eq!(noisy_x[0], x[0]);
    let difference = (noisy[0] - clean[0]).abs();
    assert!(
        difference > 0.0 && difference < 10.0 * 0.01 * 6.0,
        "k times some deviations: {difference}"
    );
    assert_eq!(record(noise("x", 0.01, 5)).unwrap().1, noisy);
    assert_ne!(record(noise("x", 0.01, 6)).unwrap().1, noisy);
    assert_eq!(record(noise("x", 0.0, 5)).unwrap().1, clean);
    let refused = format!("{:#}", record(noise("y", 0.01, 5)).unwrap_err());
    assert!(
        refused.contains("no connection drives an input spring.y"),
        "{refused}"
    );
}
