//! A long coupled run, for the subcommand `endurance`: the tip follows a smooth motion that never
//! repeats, while memory, simulated time, tip error and estimated masses are watched.
//!
//! The controller's own trajectories end after half a minute, so here the reference comes from
//! outside. It is `p_i(t) = p_i(t_0) + a_i (1 − cos(2π s/T_i))/2`, `s` the time since the settling,
//! with periods whose ratios are irrational: the motion comes close to every corner of the box again
//! and again, and is exact at any time, however late.

use std::f64::consts::{GOLDEN_RATIO, SQRT_2, TAU};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use cosim::run::interrupt;
use cosim::{Experiment, Inputs, Master, Signals, System, Verdict, matching};

use crate::measures::limits::LimitWatch;
use crate::measures::run::Distance;
use crate::setup::machine_choice::MachineFile;
use crate::setup::start_values::vary;

/// Parts of a run, each of which is reported when it ends.
const PARTS: u64 = 10;
/// What resident memory may grow by after the first part, kB: some pages that the allocator keeps.
const GROWTH: i64 = 256;
/// Largest tip error of the last part over that of the second.
const WORSE: f64 = 1.5;

/// The reference motion: a box that the tip moves through.
#[derive(Clone, Copy, Debug)]
pub struct Excursion {
    /// Edges of the box from the start position on, m, world frame.
    edges: [f64; 3],
    /// Periods along the edges, s.
    periods: [f64; 3],
}

impl Excursion {
    /// Through the box with `edges`, m, of which the first has this `period`, s. The golden ratio
    /// is worst approximated by fractions, so the motion never nearly repeats.
    pub fn new(edges: [f64; 3], period: f64) -> Result<Self> {
        ensure!(
            period.is_finite() && period > 0.0 && edges.iter().all(|e| e.is_finite()),
            "a period of {period} s along edges of {edges:?} m: all must be finite and the period > 0"
        );
        let periods = [period, SQRT_2 * period, GOLDEN_RATIO * period];
        Ok(Self { edges, periods })
    }

    /// Displacement (m), velocity (m/s) and acceleration (m/s²), `s` seconds after the motion
    /// began; rest before.
    pub fn at(&self, s: f64) -> [[f64; 3]; 3] {
        let mut motion = [[0.0; 3]; 3];
        if s > 0.0 {
            for (i, (edge, period)) in self.edges.iter().zip(self.periods).enumerate() {
                let (half, w) = (0.5 * edge, TAU / period);
                let (sin, cos) = (w * s).sin_cos();
                motion[0][i] = half * (1.0 - cos);
                motion[1][i] = half * w * sin;
                motion[2][i] = half * w * w * cos;
            }
        }
        motion
    }
}

/// Measurements of a tenth of the run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Part {
    /// Its end, s.
    pub end: f64,
    pub tip: Distance,
    /// Smallest and largest estimated mass of a body over its value at the start.
    pub mass: [f64; 2],
    /// Largest `lyapunov.nu_adaptation`, J.
    pub adaptation: f64,
    /// Resident memory at its end, kB; None where the operating system does not report it.
    pub memory: Option<i64>,
}

impl Part {
    /// Titles of the columns of [`Part::row`].
    pub const TITLES: &str =
        " until [s]    RMSE [mm]     max [mm]  mass from     to [1]  nu_adapt. [J]  memory [kB]\n";

    /// A line of the table.
    pub fn row(&self) -> String {
        format!(
            "{:>10.0} {:>12.4} {:>12.4} {:>10.4} {:>10.4} {:>14.4} {:>12}",
            self.end,
            1e3 * self.tip.rms(),
            1e3 * self.tip.max,
            self.mass[0],
            self.mass[1],
            self.adaptation,
            self.memory.map_or("-".into(), |kb| kb.to_string())
        )
    }
}

/// Result of a run.
#[derive(Clone, Debug)]
pub struct Endurance {
    /// Communication steps.
    steps: u64,
    parts: Vec<Part>,
    /// Largest difference of an instance's own time from `t_0 + k·h` at the end, s.
    drift: f64,
    /// Simulated time at the end, s.
    end: f64,
    /// Bounds on the estimated masses over their start values.
    bounds: [f64; 2],
    /// What exceeded limits and ratings.
    pub limits: Verdict,
    /// Wall-clock time without loading and initialization.
    elapsed: Duration,
}

/// What is set and read at every communication point.
struct Instruments {
    references: Inputs,
    /// Where the tip starts, m.
    start: [f64; 3],
    /// Time for which the controller settles before the motion, s.
    settle: f64,
    /// Tip error, `lyapunov.nu_adaptation`, the estimated masses, then the signals with limits.
    signals: Signals,
    limits: LimitWatch,
    /// Start values of the estimated masses, kg.
    masses: Vec<f64>,
}

impl Instruments {
    fn new(system: &System, experiment: &Experiment, master: &Master) -> Result<Self> {
        let tip = system.port("tip_error_norm")?;
        let number = |variable: &str| {
            let port = system.port_of(tip.component, variable)?;
            master.number(port)
        };
        let mut references = Vec::new();
        for quantity in ["position", "velocity", "acceleration"] {
            let array = format!("reference.{quantity}");
            references.extend(system.elements(tip.component, &array, 3)?);
        }
        let mut start = [0.0; 3];
        for (i, start) in (1..).zip(&mut start) {
            // Where the tip is, whatever the reference says.
            let desired = number(&format!("desired.position[{i}]"))?;
            *start = desired - number(&format!("tip_error[{i}]"))?;
        }
        let masses = format!("{}.mass_hat.*", system.component_of(tip));
        let adaptation = system.port_of(tip.component, "lyapunov.nu_adaptation")?;
        let masses = matching(system, &[masses])?;
        let file = MachineFile::from_plant(system, &experiment.settings)?;
        let limits = LimitWatch::new(system, &|port| master.number(port), file.as_ref())?;
        let ports = [&[tip, adaptation], &masses[..], limits.ports()].concat();
        let mut signals = Signals::new(system, &ports)?;
        let starts = &signals.read(master)?[2..2 + masses.len()];
        Ok(Self {
            references: Inputs::new(system, &references)?,
            start,
            settle: number("settle_time")?,
            masses: starts.to_vec(),
            signals,
            limits,
        })
    }

    /// Gives the controller the reference at the present time; `start` is that of the run, s.
    fn set_reference(
        &mut self,
        master: &mut Master,
        excursion: &Excursion,
        start: f64,
    ) -> Result<()> {
        let [mut x, v, a] = excursion.at(master.time() - start - self.settle);
        x.iter_mut().zip(self.start).for_each(|(x, p)| *x += p);
        self.references.set(master, [x, v, a].as_flattened())?;
        master.pass()
    }

    /// Adds the signals at the present time to a part.
    fn read(&mut self, master: &Master, part: &mut Part) -> Result<()> {
        let values = self.signals.read(master)?;
        part.tip.add(values[0]);
        part.adaptation = part.adaptation.max(values[1]);
        let (masses, watched) = values[2..].split_at(self.masses.len());
        self.limits.add(master.time(), watched);
        for (mass, start) in masses.iter().zip(&self.masses) {
            let ratio = mass / start;
            part.mass = [part.mass[0].min(ratio), part.mass[1].max(ratio)];
        }
        Ok(())
    }
}

/// Runs `steps` communication steps under `experiment`, whose stop time does not count; `report`
/// gets every tenth when it ends.
pub fn run(
    system: &System,
    experiment: &Experiment,
    excursion: &Excursion,
    steps: u64,
    mut report: impl FnMut(&Part) -> Result<()>,
) -> Result<Endurance> {
    ensure!(steps >= PARTS, "{steps} steps; at least {PARTS} are needed");
    let experiment = vary(system, experiment, &[("trajectory", &"external")])?;
    let mut master = experiment.start(system)?;
    let start = master.time();
    let mut instruments = Instruments::new(system, &experiment, &master)?;
    // `lower·P_0 < P < upper·P_0` for the inverse pseudo-inertias means `m_0/upper < m < m_0/lower`
    // for the masses.
    let inverse = |name| anyhow::Ok(1.0 / master.number(system.port(name)?)?);
    let bounds = [inverse("inverse_bounds[2]")?, inverse("inverse_bounds[1]")?];
    let (clock, mut parts) = (Instant::now(), Vec::new());
    for part in 0..PARTS {
        let (from, to) = (steps * part / PARTS, steps * (part + 1) / PARTS);
        let mut tenth = Part {
            mass: [f64::INFINITY, 0.0],
            ..Part::default()
        };
        for _ in from..to {
            instruments.set_reference(&mut master, excursion, start)?;
            interrupt::check()?;
            master.step()?;
            instruments.read(&master, &mut tenth)?;
        }
        tenth.end = master.time();
        tenth.memory = resident_memory()?;
        report(&tenth)?;
        parts.push(tenth);
    }
    let elapsed = clock.elapsed();
    let mut drift = 0.0_f64;
    for instance in master.instances() {
        drift = drift.max((instance.time()? - master.time()).abs());
    }
    let end = master.time();
    master.terminate()?;
    Ok(Endurance {
        steps,
        parts,
        drift,
        end,
        bounds,
        limits: instruments.limits.verdict(|_| false),
        elapsed,
    })
}

impl Endurance {
    /// Growth of memory after the first tenth, kB.
    fn growth(&self) -> Option<i64> {
        let first = self.parts.first()?.memory?;
        Some(self.parts.last()?.memory? - first)
    }

    /// The result as text for people.
    pub fn summary(&self) -> String {
        let growth = self
            .growth()
            .map_or("not told by the system".into(), |kb| format!("{kb} kB"));
        format!(
            "{} steps, {:.0} s simulated in {:.0} s: {:.0} x real time; growth of memory after the first tenth {growth}; \
             drift of time {:e} s; estimated masses allowed from {:.3} to {:.3} of their start values\n",
            self.steps,
            self.end,
            self.elapsed.as_secs_f64(),
            self.end / self.elapsed.as_secs_f64(),
            self.drift,
            self.bounds[0],
            self.bounds[1]
        )
    }

    /// Fails if memory grew, time drifted, an estimated mass left its bounds or tracking degraded.
    pub fn check(&self) -> Result<()> {
        if let Some(growth) = self.growth() {
            ensure!(
                growth <= GROWTH,
                "memory grew by {growth} kB; it must grow by at most {GROWTH} kB"
            );
        }
        ensure!(
            self.drift <= 2.0 * f64::EPSILON * self.end.abs(),
            "time drifted by {} s; it must not drift by more than the rounding of {} s",
            self.drift,
            self.end
        );
        for part in &self.parts {
            let [least, most] = part.mass;
            ensure!(
                least > self.bounds[0] && most < self.bounds[1],
                "until {} s an estimated mass went from {least} to {most} of its start value; it must stay within {:?}",
                part.end,
                self.bounds
            );
        }
        let second = self.parts.get(1).context("ten parts")?.tip.rms();
        let last = self.parts.last().context("ten parts")?.tip.rms();
        ensure!(
            last <= WORSE * second,
            "tip RMSE of the last tenth {last} m must be at most {WORSE} times the {second} m of the second"
        );
        Ok(())
    }
}

/// Resident memory of this process, kB; None where the operating system does not report it as Linux
/// does.
fn resident_memory() -> Result<Option<i64>> {
    let Ok(status) = std::fs::read_to_string("/proc/self/status") else {
        return Ok(None);
    };
    let line = status.lines().find(|l| l.starts_with("VmRSS:"));
    let number = line.and_then(|l| l.split_whitespace().nth(1));
    let number = number.context("VmRSS in /proc/self/status")?;
    Ok(Some(number.parse().context("VmRSS in /proc/self/status")?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(rms: f64, mass: [f64; 2], memory: i64) -> Part {
        let mut tip = Distance::default();
        tip.add(rms);
        Part {
            end: 1.0,
            tip,
            mass,
            adaptation: 0.0,
            memory: Some(memory),
        }
    }

    fn endurance(last: Part, drift: f64) -> Result<()> {
        let mut parts = vec![part(1e-3, [0.9, 1.1], 9000); 9];
        parts.push(last);
        Endurance {
            steps: 10,
            parts,
            drift,
            end: 1e4,
            bounds: [0.2, 5.0],
            limits: Verdict::default(),
            elapsed: Duration::from_secs(1),
        }
        .check()
    }

    /// Central differences: δ²/6 times the next derivative but one, and rounding of a position of
    /// 0.3 m, ε/δ.
    #[test]
    fn rates_are_the_derivatives_of_the_reference() {
        let excursion = Excursion::new([-0.2, 0.3, 0.15], 7.0).unwrap();
        let d = 1e-4;
        for k in 0..500 {
            let s = 0.37 + 1.3 * f64::from(k);
            let [before, now, after] = [excursion.at(s - d), excursion.at(s), excursion.at(s + d)];
            for i in 0..3 {
                for order in 0..2 {
                    let slope = (after[order][i] - before[order][i]) / (2.0 * d);
                    assert!((slope - now[order + 1][i]).abs() < 1e-8, "{s} {i} {order}");
                }
            }
        }
        assert_eq!(excursion.at(0.0), [[0.0; 3]; 3]);
        let [x, v, _] = excursion.at(3.5);
        assert!((x[0] + 0.2).abs() < 1e-15 && v[0].abs() < 1e-15);
        assert!(Excursion::new([0.1; 3], 0.0).is_err());
    }

    #[test]
    fn what_does_not_endure_is_named() {
        let says = |last, drift, word: &str| {
            let text = endurance(last, drift).unwrap_err().to_string();
            assert!(text.contains(word), "{text}");
        };
        let sound = part(1.4e-3, [0.3, 4.9], 9256);
        assert!(endurance(sound, 1e-12).is_ok());
        says(part(1e-3, [0.9, 1.1], 9257), 0.0, "memory");
        says(part(1.6e-3, [0.9, 1.1], 9000), 0.0, "tip RMSE");
        says(part(1e-3, [0.19, 1.1], 9000), 0.0, "estimated mass");
        says(part(1e-3, [0.9, f64::NAN], 9000), 0.0, "estimated mass");
        says(sound, 1e-11, "time drifted");
    }
}
