//! Probes of several instances (in turn, many, in threads) and of a reset, for `supervision`.

use anyhow::{Result, ensure};

use super::probe::probes;
use crate::outcome::Outcome;
use fmi_import::Fmu;
use fmi_import::instance::{Instance, step_size};
use fmi_import::standard::Mode;

const STEPS: usize = 20;
/// Number of instances that exist at a time.
const MANY: usize = 12;

probes! {
    "instances" {
        opened repeat:
            "two instances, one after the other, do the same bit for bit",
            "a result that cannot be repeated cannot be checked";
        opened turns.unless(is_single):
            "an instance does the same while another takes turns with it",
            "coupled systems hold several instances of one FMU, which must not share data";
        opened many.unless(is_single):
            "a dozen instances live at a time and are freed in another order",
            "sweeps and coupled systems do that";
        opened threads.unless(is_single):
            "instances in four threads do what one alone does",
            "importers step the parts of a system in parallel";
        opened reset:
            "after a reset it does what a new instance does, bit for bit",
            "importers repeat simulations so, instead of loading again";
    }
}

/// What a single instance does, to compare others with.
fn alone(fmu: &Fmu) -> Result<Vec<u64>> {
    Instance::started(fmu, "alone")?.run_excited(STEPS, 0)
}

fn same(one: &[u64], other: &[u64], what: &str) -> Result<()> {
    ensure!(one == other, "what can be read differs {what}");
    Ok(())
}

/// Why there cannot be several instances, if the FMU declares that.
fn is_single(fmu: &Fmu) -> Option<&'static str> {
    let only_once = fmu.description.capabilities.only_once;
    only_once.then_some("the FMU says canBeInstantiatedOnlyOncePerProcess")
}

fn repeat(fmu: &Fmu, _: &mut Outcome) -> Result<()> {
    let first = alone(fmu)?;
    same(&first, &alone(fmu)?, "from the first to the second")
}

fn turns(fmu: &Fmu, _: &mut Outcome) -> Result<()> {
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
    same(&expected, &bits, "from what it is without the other")
}

fn many(fmu: &Fmu, _: &mut Outcome) -> Result<()> {
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
        same(
            &expected,
            &instance.run_excited(STEPS, 0)?,
            "from that of one alone",
        )?;
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
        if let Err(reason) =
            result.and_then(|bits| same(&expected, &bits, "from that of one alone"))
        {
            outcome.remark(reason.to_string());
        }
    }
    Ok(())
}

fn reset(fmu: &Fmu, _: &mut Outcome) -> Result<()> {
    let expected = alone(fmu)?;
    let mut instance = Instance::started(fmu, "reset")?;
    instance.run_excited(STEPS, 9)?;
    instance.enter(Mode::Instantiated)?;
    instance.initialize()?;
    same(
        &expected,
        &instance.run_excited(STEPS, 0)?,
        "from that of a new instance",
    )?;
    // From Initialization Mode, and straight after fmi2Instantiate, too.
    instance.enter(Mode::Instantiated)?;
    instance.setup(0.0, Some(1e9 * step_size(fmu)))?;
    instance.enter(Mode::Initialization)?;
    instance.enter(Mode::Instantiated)?;
    instance.initialize()?;
    same(
        &expected,
        &instance.run_excited(STEPS, 0)?,
        "after a reset in Initialization Mode",
    )
}
