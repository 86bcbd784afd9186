//! Probes of several instances (in turn, many, in threads) and of a reset, for `supervision`.

use anyhow::Result;

use super::probe::probes;
use crate::outcome::Outcome;
use fmi_import::Fmu;
use fmi_import::instance::{Instance, start_time, step_size};
use fmi_import::standard::Mode;

const STEPS: usize = 20;
/// Number of instances that exist at a time.
const MANY: usize = 12;

probes! {
    "instances" {
        opened repeat:
            "two instances, one after the other, do the same bit for bit",
            "a result that cannot be repeated cannot be checked [FMI 2.0, 2.1.5; FMI 3.0, 2.3.2]";
        opened turns.unless(is_single):
            "an instance does the same while another takes turns with it",
            "coupled systems hold several instances of one FMU, which must not share data [FMI 2.0, 2.1.5; FMI 3.0, 2.3.2]";
        opened many.unless(is_single):
            "a dozen instances live at a time and are freed in another order",
            "sweeps and coupled systems do that [FMI 2.0, 2.1.5; FMI 3.0, 2.3.2]";
        opened threads.unless(is_single):
            "instances in four threads do what one alone does",
            "importers step the parts of a system in parallel";
        opened reset:
            "after a reset it does what a new instance does, bit for bit",
            "importers repeat simulations so, instead of loading again [FMI 2.0, 2.1.6; FMI 3.0, 2.3.1]";
    }
}

/// What a single instance does, to compare others with.
fn alone(fmu: &Fmu) -> Result<Vec<u64>> {
    Instance::started(fmu, "alone")?.run_excited(STEPS, 0)
}

/// Reports that what can be read differs in two runs: as far as solvers may go, which begin anew,
/// that is not robust.
pub fn compare(one: &[u64], other: &[u64], what: &str, outcome: &mut Outcome) {
    let is_near = |(a, b): (&u64, &u64)| {
        let [a, b] = [*a, *b].map(f64::from_bits);
        a == b || (a - b).abs() <= 1e-4 * a.abs().max(b.abs()) + 1e-9 || a.is_nan() && b.is_nan()
    };
    match one.len() == other.len() && one.iter().zip(other).all(is_near) {
        _ if one == other => {}
        true => outcome.remark(format!("what can be read differs {what}, by 1e-4 at most")),
        false => outcome.fail(format!("what can be read differs {what}")),
    }
}

/// Why there cannot be several instances, if the FMU declares that.
fn is_single(fmu: &Fmu) -> Option<&'static str> {
    let only_once = fmu.description.capabilities.only_once;
    only_once.then_some("the FMU says canBeInstantiatedOnlyOncePerProcess")
}

fn repeat(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let first = alone(fmu)?;
    compare(
        &first,
        &alone(fmu)?,
        "from the first to the second",
        outcome,
    );
    Ok(())
}

fn turns(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let expected = alone(fmu)?;
    let mut watched = Instance::started(fmu, "watched")?;
    let mut other = Instance::started(fmu, "other")?;
    let (h, mut bits) = (step_size(fmu), Vec::new());
    for k in 0..STEPS {
        // The other is set between the set and the step of the first, and steps before the first is
        // read.
        watched.excite(k);
        other.excite(k + 5);
        watched.step(h)?;
        other.step(h)?;
        bits.extend(watched.observe()?);
    }
    compare(
        &expected,
        &bits,
        "from what it is without the other",
        outcome,
    );
    Ok(())
}

fn many(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let expected = alone(fmu)?;
    let made: Result<Vec<_>, _> = (0..MANY)
        .map(|k| Instance::started(fmu, &format!("instance {k}")))
        .collect();
    let mut instances = made?;
    // They are freed neither in the order in which they were made nor in reverse.
    while !instances.is_empty() {
        let place = if instances.len() % 2 == 0 {
            0
        } else {
            instances.len() - 1
        };
        let mut instance = instances.swap_remove(place);
        compare(
            &expected,
            &instance.run_excited(STEPS, 0)?,
            "from that of one alone",
            outcome,
        );
    }
    Ok(())
}

fn threads(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let expected = alone(fmu)?;
    let results = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..4).map(|_| scope.spawn(|| alone(fmu))).collect();
        handles
            .into_iter()
            .map(|h| h.join().expect("the thread itself does not panic"))
            .collect::<Vec<_>>()
    });
    for result in results {
        compare(&expected, &result?, "from that of one alone", outcome);
    }
    Ok(())
}

fn reset(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let expected = alone(fmu)?;
    let mut instance = Instance::started(fmu, "reset")?;
    instance.run_excited(STEPS, 9)?;
    instance.enter(Mode::Instantiated)?;
    instance.initialize()?;
    compare(
        &expected,
        &instance.run_excited(STEPS, 0)?,
        "from that of a new instance",
        outcome,
    );
    // From Initialization Mode, and straight after fmi2Instantiate, too.
    instance.enter(Mode::Instantiated)?;
    instance.setup(start_time(fmu), None)?;
    instance.enter(Mode::Initialization)?;
    instance.enter(Mode::Instantiated)?;
    instance.initialize()?;
    compare(
        &expected,
        &instance.run_excited(STEPS, 0)?,
        "after a reset in Initialization Mode",
        outcome,
    );
    Ok(())
}
