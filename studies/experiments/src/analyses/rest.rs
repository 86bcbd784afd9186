//! Whether the machine rests: random poses that it can hold, each pushed and left to itself, for the
//! subcommand `rest`. Five seconds after the push no rod's force may swing, and the supervisor must
//! not have acted.

use anyhow::{Result, bail};
use cosim::run::observer::Observer;
use cosim::run::simulate::{Plan, run_plan};
use cosim::{Experiment, Master, Signals, System, Verdict};
use hdrm::DOF;
use machine_file::Machine;
use motion_check::{AllowedRanges, DemandModel, Motion, Payload};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Uniform};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::measures::swinging::{SWINGS, SwingWatch};
use crate::runs::run_store::RunStore;
use crate::setup::machine_choice::MachineFile;
use crate::setup::start_values::{BY_RATES, Law, add_settings};
use crate::worlds::World;

/// Push, N, when it begins, and how long it lasts, s.
const PUSH: f64 = 300.0;
const PUSH_START: f64 = 3.0;
const PUSH_DURATION: f64 = 0.2;
/// Length of a run, s; its last second counts, which begins 5 s after the push.
const END: f64 = 9.2;
/// Payloads over the nominal one.
pub(crate) const LOADS: [f64; 3] = [0.0, 0.5, 1.0];
/// Share of a joint's range that poses leave free at each end.
const MARGIN: f64 = 0.02;
/// Poses that are drawn for each that is held, at most.
const TRIES: usize = 1000;
/// First number of a supervisor's stage that acts.
const ACTS: f64 = 3.0;

/// What the controller follows while it rests.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Follows {
    /// Commanded rates of zero.
    Rates,
    /// The start of a path.
    Path,
}

/// What a machine at rest did after a push.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct RestRun {
    /// Largest root mean square of a rod's force in the last second, less its moving mean, divided
    /// by the rated force.
    pub(crate) swing: f64,
    /// Whether the supervisor acted.
    pub(crate) acted: bool,
    /// Why the run failed; empty if it did not.
    pub(crate) why: String,
}

impl RestRun {
    pub(crate) fn rests(&self) -> bool {
        self.swing <= SWINGS && !self.acted && self.why.is_empty()
    }
}

/// A case: where and with what the machine rests.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Rest {
    pub(crate) world: World,
    pub(crate) follows: Follows,
    pub(crate) law: String,
    /// Joint angles, rad.
    pub(crate) pose: [f64; DOF],
    /// Payload, kg.
    pub(crate) payload: f64,
    pub(crate) run: RestRun,
}

/// Joint angles, rad, and the number of the push: along +x, +y, +z, −x, −y, −z.
pub(crate) type Pose = ([f64; DOF], usize);

/// `count` random poses, in which the machine holds its nominal payload with no quantity beyond its
/// allowed range, and the direction of the push in each.
pub(crate) fn poses(machine: &Machine, seed: u64, count: usize) -> Result<Vec<Pose>> {
    let ranges = AllowedRanges::from_machine(machine);
    let model = DemandModel::new(machine, &Payload::from_machine(machine))?;
    let even = Uniform::new_inclusive(MARGIN, 1.0 - MARGIN).expect("finite bounds");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let limits = machine.limits.zeta();
    let mut poses = Vec::new();
    for _ in 0..TRIES * count {
        let pose = limits.map(|[low, high]| low + (high - low) * even.sample(&mut random));
        let demand = model.demand(&Motion::rest(pose));
        let mut margins = ranges.margins(&demand).into_iter();
        if margins.all(|margin| margin.holds()) {
            poses.push((pose, poses.len() % 6));
        }
        if poses.len() == count {
            return Ok(poses);
        }
    }
    bail!("this machine holds its payload in too few poses")
}

/// Runs `law` in all `poses` with all [`LOADS`], in parallel; `done` is called after each.
pub(crate) fn run(
    (system, base, world): (&System, &Experiment, World),
    law: &Law,
    follows: Follows,
    poses: &[Pose],
    store: &RunStore,
    done: impl Fn() + Sync,
) -> Result<Vec<Rest>> {
    let file = MachineFile::from_manipulator(system, &base.settings)?;
    let nominal = file.machine.bodies.PL.mass;
    let rated = file.machine.ratings.in_order().map(|r| r.force_max);
    let mut common = law.settings(system)?;
    let mut set = |name: &str, value: &dyn ToString| -> Result<()> {
        common.push(system.setting(name, value.to_string())?);
        Ok(())
    };
    let trajectory = if follows == Follows::Rates {
        BY_RATES
    } else {
        "triangular"
    };
    set("controller.trajectory", &trajectory)?;
    set("controller.settle_time", &(10.0 * END))?;
    set("controller.supervisor", &true)?;
    set("hdrm.push.start", &PUSH_START)?;
    set("hdrm.push.duration", &PUSH_DURATION)?;
    let points: Vec<_> = (poses.iter().enumerate())
        .flat_map(|(k, pose)| LOADS.map(|load| (k, *pose, load * nominal)))
        .collect();
    let one = |(k, (pose, push), payload): (usize, Pose, f64)| {
        let mut settings = common.clone();
        for (j, angle) in (1..).zip(pose) {
            settings.push(system.setting(&format!("hdrm.zeta_start[{j}]"), angle)?);
        }
        let force = if push < 3 { PUSH } else { -PUSH };
        settings.push(system.setting(&format!("hdrm.push.force[{}]", 1 + push % 3), force)?);
        settings.push(system.setting("hdrm.payload.mass", payload)?);
        let mut experiment = add_settings(system, base, settings)?;
        experiment.stop = Some(END);
        let name = format!("{} {} {follows:?} {k} {payload}", world.name(), law.name);
        let run = || RestRun::run(system, &experiment, rated);
        let run = store.load_or_make(&name, system, &experiment, run)?;
        done();
        Ok(Rest {
            world,
            follows,
            law: law.name.clone(),
            pose,
            payload,
            run,
        })
    };
    points.into_par_iter().map(one).collect()
}

impl RestRun {
    /// Runs `experiment`; a run that fails does not rest.
    fn run(system: &System, experiment: &Experiment, rated: [f64; 3]) -> Result<Self> {
        let names = [
            "emla_1.F",
            "emla_2.F",
            "emla_3.F",
            "controller.supervisor.state",
        ];
        let ports = names.map(|name| system.port(name));
        let ports = ports.into_iter().collect::<Result<Vec<_>>>()?;
        let mut watch = Watch {
            signals: Signals::new(system, &ports)?,
            swings: SwingWatch::new(rated),
            acted: false,
        };
        let mut run = || -> Result<()> {
            let master = experiment.start(system)?;
            run_plan(system, master, &Plan::to(END), &|_, _| (), &mut watch)?;
            Ok(())
        };
        let ended = run();
        cosim::run::interrupt::check()?;
        let rods = watch.swings.rods.iter();
        Ok(Self {
            swing: rods.map(|rod| rod.rms).fold(0.0, f64::max),
            acted: watch.acted,
            why: ended
                .err()
                .map_or(String::new(), |error| format!("{error:#}")),
        })
    }
}

struct Watch {
    signals: Signals,
    swings: SwingWatch,
    acted: bool,
}

impl Observer for Watch {
    fn observe(&mut self, master: &Master) -> Result<()> {
        let values = self.signals.read(master)?;
        let (forces, stage) = values.split_at(3);
        self.swings.add(master.time(), forces.iter().copied(), &[]);
        self.acted |= stage[0] >= ACTS;
        Ok(())
    }
}

/// Makes the verdict bad where a machine does not rest; PD laws are only noted, since their shipped
/// dampings are not tuned to every load.
pub(crate) fn judge(rests: &[Rest], verdict: &mut Verdict) {
    for is_pd in [false, true] {
        let of_kind = || {
            rests
                .iter()
                .filter(|rest| rest.law.starts_with("pd") == is_pd)
        };
        let mut restless = of_kind().filter(|rest| !rest.run.rests());
        let Some(Rest {
            world,
            law,
            pose,
            payload,
            run,
            ..
        }) = restless.next()
        else {
            continue;
        };
        let what = match run {
            RestRun { why, .. } if !why.is_empty() => why.clone(),
            RestRun { swing, .. } if *swing > SWINGS => {
                format!("a rod swings by {:.2} % of its rated force", 100.0 * swing)
            }
            _ => "the supervisor acts".into(),
        };
        let text = format!(
            "{} of {} machines do not rest, first {law} in the {} world at {:.2?} rad with {payload} kg: {what}",
            1 + restless.count(),
            of_kind().count(),
            world.name(),
            pose
        );
        if is_pd {
            verdict.note(text);
        } else {
            verdict.object(text);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion_check::Quantity;

    /// Poses are held by the rods, differ from each other, and are the same for a seed.
    #[test]
    fn poses_are_held() {
        let machine = Machine::reference();
        let found = poses(&machine, 1, 20).expect("enough poses");
        let model = DemandModel::new(&machine, &Payload::from_machine(&machine)).expect("valid");
        for (pose, _) in &found {
            let force = model.demand(&Motion::rest(*pose)).value(Quantity::Force(2));
            assert!(
                force.abs() <= machine.ratings.tilt.force_max,
                "{pose:?} {force}"
            );
        }
        assert_eq!(found[..5], poses(&machine, 1, 5).expect("enough poses"));
        assert_ne!(found[0].0, poses(&machine, 2, 1).expect("a pose")[0].0);
    }

    #[test]
    fn what_does_not_rest_spoils_the_verdict_unless_it_is_pd() {
        let rest = |law: &str, swing, acted| Rest {
            world: World::Real,
            follows: Follows::Rates,
            law: law.into(),
            pose: [0.1; DOF],
            payload: 150.0,
            run: RestRun {
                swing,
                acted,
                why: String::new(),
            },
        };
        for (rest, is_bad) in [
            (rest("adaptive", 0.009, false), false),
            (rest("adaptive", 0.011, false), true),
            (rest("adaptive", 0.002, true), true),
            (rest("pd_gravity", 0.2, true), false),
        ] {
            let mut verdict = Verdict::default();
            judge(&[rest], &mut verdict);
            assert_eq!(verdict.is_bad(), is_bad, "{verdict}");
        }
    }
}
