//! Which faults there are, for `faults`: of every sensor at its source and of every wire to and
//! from the controller, each with every effect, at three times, on three paths, with two payloads.

use std::f64::consts::TAU;
use std::fmt;

use anyhow::{Context, Result};
use cosim::exchange::faults::{Effect, Fault as WireFault, Faults};
use cosim::{Experiment, Port, Setting, System};
use machine_file::Machine;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::Serialize;
use tip_path::SIX_JOINTS;

use crate::measures::run::motion_end;
use crate::setup::machine_choice::MachineFile;
use crate::setup::start_values::{BY_RATES, add_settings, trajectory_settings};

/// The paths, of which two are none: [`RATES`], and rest.
pub const PATHS: [&str; 4] = ["triangular", SIX_JOINTS, BY_RATES, AT_REST];
/// Commanded rates of zero; not among what is tried by default.
pub const AT_REST: &str = "rest";
/// Payloads, kg.
pub const PAYLOADS: [f64; 2] = [0.0, 300.0];
/// Times of the faults, as shares of the time from the first second to the end of the motion.
pub const SHARES: [f64; 3] = [0.25, 0.5, 0.75];
/// Commanded joint rates, rad/s, and the duration of such a run, s.
const RATES: [f64; 6] = [0.06, 0.04, -0.05, 0.1, 0.08, -0.1];
const RATES_END: f64 = 10.0;
/// Rest after the path, s.
const REST: f64 = 1.0;
/// Seed of dropped samples.
const SEED: u64 = 1;
/// Inputs that nothing reads in a system with encoders and drives that regulate their currents:
/// true speeds of sensors that differentiate, and voltages.
const UNREAD: [&str; 5] = ["zeta_dot", "w_m", "x_dot", "v_d", "v_q"];

/// What a fault does.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    Freeze,
    Bias,
    Gain,
    Drop,
    Zero,
    Limit,
    Off,
    On,
}

/// A fault of a wire.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fault {
    /// Input to which the wire leads.
    pub wire: String,
    pub kind: Kind,
    /// Bias, or the value at the limit, in the unit of the wire.
    pub value: Option<f64>,
}

/// When a fault strikes: path, payload and one of [`SHARES`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    pub path: &'static str,
    pub payload: f64,
    pub share: f64,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Freeze => "freeze",
            Self::Bias => "bias",
            Self::Gain => "gain",
            Self::Drop => "drop",
            Self::Zero => "zero",
            Self::Limit => "limit",
            Self::Off => "off",
            Self::On => "on",
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.wire, self.kind.name())?;
        self.value.map_or(Ok(()), |value| write!(f, " {value:.4}"))
    }
}

impl Fault {
    pub fn new(wire: impl Into<String>, kind: Kind, value: Option<f64>) -> Self {
        Self {
            wire: wire.into(),
            kind,
            value,
        }
    }

    /// As the master takes it, from the time `from`, s.
    pub fn on_wire(&self, system: &System, from: f64) -> Result<Faults> {
        let value = self.value.unwrap_or_default();
        let effect = match self.kind {
            Kind::Freeze => Effect::Freeze,
            Kind::Bias => Effect::Bias(value),
            Kind::Gain => Effect::Gain(value),
            Kind::Drop => Effect::Drop(value),
            Kind::Limit => Effect::Override(value),
            Kind::Zero | Kind::Off => Effect::Override(0.0),
            Kind::On => Effect::Override(1.0),
        };
        let port = system.port(&self.wire)?;
        let list = vec![on_wire(port, effect, from)];
        Ok(Faults { list, seed: SEED })
    }
}

/// A fault of the wire to `port` from the time `from`, s, on.
pub fn on_wire(port: Port, effect: Effect, from: f64) -> WireFault {
    WireFault {
        port,
        effect,
        from,
        until: f64::INFINITY,
        is_event: false,
    }
}

impl Instant {
    /// Sorts instants by run, then by time.
    pub fn order(&self) -> (usize, u64, u64) {
        let path = PATHS.iter().position(|path| *path == self.path);
        let milli = |value: f64| (1e3 * value) as u64;
        (path.unwrap_or(0), milli(self.payload), milli(self.share))
    }

    /// The run without a fault, to a second after its path.
    pub fn experiment(
        &self,
        (system, base): (&System, &Experiment),
        common: &[Setting],
    ) -> Result<Experiment> {
        let mut settings = common.to_vec();
        settings.push(system.setting("hdrm.payload.mass", self.payload)?);
        let has_no_path = [BY_RATES, AT_REST].contains(&self.path);
        let trajectory = if has_no_path { BY_RATES } else { self.path };
        settings.extend(trajectory_settings(system, trajectory)?);
        if self.path == BY_RATES {
            for (k, rate) in (1..).zip(RATES) {
                settings.push(system.setting(&format!("rate.joint[{k}]"), rate)?);
            }
        }
        let mut experiment = add_settings(system, base, settings)?;
        experiment.stop = Some(if has_no_path {
            RATES_END
        } else {
            let end = motion_end(system, &experiment.start(system)?);
            end.with_context(|| format!("path {} has no end", self.path))? + REST
        });
        Ok(experiment)
    }

    /// The time of the fault in a run that ends at `end`, s, to a tenth of a second.
    pub fn time(&self, end: f64) -> f64 {
        let time = 1.0 + self.share * (end - REST - 1.0);
        (10.0 * time).round() / 10.0
    }
}

/// All faults of `system`; biases, losses and drops are `size` times whole ones.
pub fn faults(system: &System, base: &Experiment, size: f64) -> Result<Vec<Fault>> {
    let machine = MachineFile::from_manipulator(system, &base.settings)?.machine;
    let controller = system.port("desired.position[1]")?.component;
    let sensors = system.port("zeta_measured[1]").map(|port| port.component);
    let mut found = Vec::new();
    for link in system
        .wiring()?
        .links
        .iter()
        .filter(|link| !link.is_initial)
    {
        let is_source = sensors.as_ref().is_ok_and(|s| *s == link.to.component);
        let ends = [link.from.component, link.to.component];
        let (name, quantity, k) = named(system, link.to);
        let is_read = !UNREAD.contains(&&*quantity) || ends[1] == controller;
        if !(is_source || ends.contains(&controller)) || !is_read {
            continue;
        }
        if system.variable(link.to).kind.name() == "Boolean" {
            let kinds = [Kind::Off, Kind::On];
            found.extend(kinds.map(|kind| Fault::new(&name, kind, None)));
            continue;
        }
        let mut add = |kind, value| found.push(Fault::new(&name, kind, value));
        let sizes = sizes(&machine, &quantity, k);
        if let Some([bias, _]) = sizes {
            add(Kind::Bias, Some(size * bias));
        }
        add(Kind::Gain, Some(1.0 - 0.5 * size));
        add(Kind::Drop, Some(0.5 * size));
        if size < 1.0 {
            continue;
        }
        if let Some([_, limit]) = sizes {
            add(Kind::Limit, Some(limit));
        }
        add(Kind::Freeze, None);
        add(Kind::Zero, None);
    }
    Ok(found)
}

/// Name of an input, its quantity and which axis or joint it is of, counted from 0.
fn named(system: &System, port: Port) -> (String, String, usize) {
    let name = system.name(port);
    let digits = |text: &str| text.trim_end_matches(']').parse::<usize>();
    let variable = &system.variable(port).name;
    let (quantity, k) = match variable.split_once('[') {
        Some((quantity, k)) => (quantity, digits(k)),
        None => (
            &**variable,
            digits(system.component_of(port).rsplit('_').next().unwrap_or("")),
        ),
    };
    (
        name.clone(),
        quantity.into(),
        k.unwrap_or(1).saturating_sub(1),
    )
}

/// A whole bias of a quantity, and its value at the limit: 1° of an angle, a tenth of the rated
/// force, speed or torque, 10 A. None for other quantities.
fn sizes(machine: &Machine, quantity: &str, k: usize) -> Option<[f64; 2]> {
    let axis = k.min(2);
    let rating = machine.ratings.in_order()[axis];
    let drive = machine.emla.in_order()[axis];
    let travel = drive.rho / (TAU * drive.N_gear);
    let [_, stroke] = machine.limits.strokes()[axis];
    let degree = TAU / 360.0;
    Some(match quantity {
        "zeta" => [degree, machine.limits.zeta()[k][1]],
        "theta_m" => [degree, stroke / travel],
        "zeta_dot" => [0.1, 1.0],
        "x" => [0.01 * stroke, stroke],
        "x_dot" => [0.1 * rating.rod_speed_max, rating.rod_speed_max],
        "w_m" => [0.1, 1.0].map(|part| part * rating.rod_speed_max / travel),
        "F" => [0.1 * rating.force_max, rating.force_max],
        "i_d" | "i_q" | "i_q_required" => [10.0, drive.i_max],
        "tau_wrist" => [0.1, 1.0].map(|part| part * machine.limits.tau_wrist_max[axis]),
        "v_dc" => [0.1, 1.0].map(|part| part * drive.link_voltage()),
        _ => return None,
    })
}

/// `count` of the cases, drawn without repetition by `seed`, in their order; all if there are no
/// more.
pub fn sample<T>(cases: Vec<T>, count: usize, seed: u64) -> Vec<T> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut left = cases.len();
    let mut wanted = count;
    let mut is_drawn = |_: &T| {
        // Each set of `count` is as likely as any other.
        let is_drawn = (random.next_u64() % left as u64) < wanted as u64;
        left -= 1;
        wanted -= usize::from(is_drawn);
        is_drawn
    };
    cases.into_iter().filter(|case| is_drawn(case)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_has_as_many_as_asked_and_each_case_is_as_likely() {
        let mut counts = [0; 10];
        for seed in 0..3000 {
            let drawn = sample((0..10).collect(), 3, seed);
            assert!(drawn.len() == 3 && drawn.is_sorted());
            drawn.into_iter().for_each(|k: usize| counts[k] += 1);
        }
        // Binomial: 900 each with a deviation of 25; five times that.
        assert!(counts.iter().all(|n| (775..1025).contains(n)), "{counts:?}");
        assert_eq!(sample(vec![1, 2], 5, 1), [1, 2]);
    }

    #[test]
    fn whole_faults_have_the_sizes_of_the_machine() {
        let machine = Machine::reference();
        let found = |quantity, k| sizes(&machine, quantity, k).expect("known");
        assert_eq!(
            found("F", 1)[0],
            0.1 * machine.ratings.in_order()[1].force_max
        );
        assert!((found("zeta", 4)[0] - 0.017_453_292_519_943).abs() < 1e-15);
        assert_eq!(found("i_q_required", 2)[0], 10.0);
        assert_eq!(found("tau_wrist", 2)[1], machine.limits.tau_wrist_max[2]);
        assert!(sizes(&machine, "enable", 0).is_none());
    }
}
