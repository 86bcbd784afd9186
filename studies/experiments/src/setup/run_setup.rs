//! The command-line arguments that all experiments share, and the system and experiment made from
//! them: world, machine file, path, start values. A value that is bound twice is refused. Every
//! command that runs a system, `report` too, begins with [`MachineArgs::setup`].

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail, ensure};
use clap::Args;
use cosim::cli::{RunArgs, SystemArgs, find};
use cosim::master::Schedule;
use cosim::schedule::Between;
use cosim::{Experiment, Port, System, Verdict, start_value};
use machine_file::{Machine, Source};
use motion_check::gain_rule;

use super::loads;
use super::machine_choice::{self, GainChoice};
use crate::machines::path_margins;
use crate::setup::start_values::{add_settings, path_settings};
use crate::worlds::{BENDING_STEP, World, parameter_set_of, without_worlds};

/// Parameter of controller and actuators: how many steps late their outputs act.
const DELAY: &str = "delay";
/// Margin in `gamma` that the rule's gains have on the reference machine: with adaptation faster
/// than the rule's by this factor, a machine may oscillate on soft mountings.
const MARGIN: f64 = 2.0;

/// Inputs that the shipped systems leave unconnected on purpose, by model: their start values stand
/// for a machine without supply, brakes, weather, load or operator.
const OPTIONAL: [(&str, &[&str]); 5] = [
    ("Emla", ACTUATOR),
    ("Rig", ACTUATOR),
    ("Hdrm", &["wrench_env", "base", "load", "wrist"]),
    ("Controller", CONTROLLER),
    ("DcLink", &["T_ambient"]),
];
const CONTROLLER: &[&str] = &[
    "x",
    "v_dc",
    "T_winding",
    "reference",
    "base",
    "rate",
    "tripped",
    "theta_m",
    "reset",
    "supply",
];
const ACTUATOR: &[&str] = &["v_dc", "enable", "brake", "T_ambient", "F_ext"];

/// Arguments that choose the machine and how it is run.
#[derive(Args, Default)]
pub struct MachineArgs {
    #[command(flatten)]
    system: SystemArgs,
    /// Machine file, or name of a shipped machine, for all FMUs: the `machine_file` of every
    /// component that has one
    #[arg(long = "machine", value_name = "FILE|NAME")]
    file: Option<String>,
    #[command(flatten)]
    run: RunArgs,
    /// Path that the tip follows: a JSON or CSV file of waypoints or samples, or iso9283-cube,
    /// iso9283-rectangle, six-joints; without a stop time the run ends with the path
    #[arg(long, value_name = "FILE")]
    pub waypoints: Option<String>,
}

/// A system that is ready to run.
pub struct RunSetup {
    /// The system.
    pub system: System,
    /// How it is run, and its start values.
    pub base: Experiment,
    /// Inputs without a value, and gains that do not fit the machine.
    pub verdict: Verdict,
}

/// Which system the arguments are applied to.
#[derive(Clone)]
pub struct SetupBuilder<'a> {
    args: &'a MachineArgs,
    world: World,
    /// Whether the command asks for that world.
    is_asked: bool,
    packed: Option<PathBuf>,
    has_path: bool,
}

impl MachineArgs {
    /// A machine file, or a shipped machine, and nothing else.
    pub fn of(machine: &str) -> Self {
        Self {
            file: Some(machine.into()),
            ..Self::default()
        }
    }

    /// On a structure of a packed system.
    pub fn in_structure(mut self, system: &Path, name: &str) -> Self {
        self.system.system = Some(system.into());
        self.system.variant = Some(name.into());
        self
    }

    /// The machine that the arguments name, in the ideal world, on their path.
    pub fn setup(&self) -> SetupBuilder<'_> {
        SetupBuilder {
            args: self,
            world: World::Ideal,
            is_asked: false,
            packed: None,
            has_path: true,
        }
    }

    /// The name of the path, if one is given, and the experiment that follows it.
    pub fn on_path(&self, setup: &RunSetup) -> Result<Option<(String, Experiment)>> {
        let Some(path) = &self.waypoints else {
            return Ok(None);
        };
        let settings = path_settings(&setup.system, path)?;
        let experiment = add_settings(&setup.system, &setup.base, settings)?;
        Ok(Some((path.clone(), experiment)))
    }

    /// The real world's parameter set for the machine.
    pub fn parameters(&self) -> Result<&'static str> {
        let source = self.file.as_deref().map(Source::named).transpose()?;
        Ok(parameter_set_of(source.and_then(|source| source.shipped())))
    }

    /// Refuses options of how a run is made, for commands that make none.
    pub fn refuse_stepping(&self) -> Result<()> {
        let (run, system) = (&self.run, &self.system);
        let options = [
            (run.stop_time.is_some(), "--stop-time"),
            (run.input_derivatives, "--input-derivatives"),
            (run.between != Between::default(), "--between"),
            (run.threads.is_some(), "--threads"),
            (!system.rates.is_empty(), "--rate"),
            (!system.interfaces.is_empty(), "--interface"),
            (!system.solvers.is_empty(), "--solver"),
            (!system.feedthrough.is_empty(), "--feedthrough"),
            (system.solve_loops, "--solve-loops"),
        ];
        system.refuse_running(&options, true)
    }

    /// Whether a bad verdict ends the program with exit code 2 (`--check`).
    pub fn check(&self) -> bool {
        self.run.check
    }
}

impl SetupBuilder<'_> {
    /// In this world.
    pub fn world(self, world: World) -> Self {
        Self {
            world,
            is_asked: true,
            ..self
        }
    }

    /// Another packed system, with FMUs from the same folder, and without the path.
    pub fn packed(mut self, path: &Path) -> Self {
        self.packed = Some(path.into());
        self.without_path()
    }

    /// Without following the path that is given.
    pub fn without_path(mut self) -> Self {
        self.has_path = false;
        self
    }

    /// The system with its machine file and, if the path has loads, the connections for them.
    pub fn system(&self) -> Result<System> {
        Ok(self.system_and_gains()?.0)
    }

    /// The system, and a sentence on the gains that the rule gives for its machine file.
    fn system_and_gains(&self) -> Result<(System, Option<String>)> {
        let mut arguments = self.args.system.clone();
        if let Some(path) = &self.packed {
            arguments.system = Some(path.clone());
            arguments.variant = None;
            arguments.parameters.clear();
        }
        if let (Some(path), true) = (&arguments.system, self.is_asked) {
            self.world.refuse_other(path)?;
        }
        let start_values = &self.args.run.settings;
        let mut system = arguments.load(start_values, || find(self.world.system()))?;
        if let Some(machine) = &self.args.file {
            machine_choice::bind(&mut system, machine)
                .with_context(|| format!("--machine {machine}"))?;
        }
        if let (Some(path), None) = (&self.args.waypoints, &self.packed)
            && loads::has_loads(&path_margins::read(path)?)
        {
            loads::connect(&mut system)?;
        }
        if self.world.is_as_built() {
            system.apply_set(Path::new(self.args.parameters()?))?;
            // The user's sets come after those of the world, to override them.
            for set in &arguments.parameters {
                system.apply_set(set)?;
            }
        }
        let Some(machine) = &self.args.file else {
            return Ok((system, None));
        };
        // Those that do not fit the system are told where the experiment is made of them.
        let settings = start_values
            .iter()
            .filter_map(|text| system.parse_settings(text).ok());
        let choice = GainChoice {
            machine,
            sets: &without_worlds(&arguments.parameters),
            settings: &Vec::from_iter(settings.flatten()),
        };
        let gains = choice.bind(&mut system);
        let gains = gains.with_context(|| format!("--machine {machine}"))?;
        let sentence = |gains| format!("gains by the rule for {machine}: {gains}");
        Ok((system, gains.map(sentence)))
    }

    /// The system, ready to run. Fails if arguments do not fit the system or bind a value twice.
    pub fn build(&self) -> Result<RunSetup> {
        let MachineArgs { run, file, .. } = self.args;
        let (system, gains) = self.system_and_gains()?;
        let mut base = run.experiment(&system)?;
        if let Some(machine) = file {
            let twice = (base.settings.iter())
                .map(|s| system.name(s.port))
                .find(|name| name.ends_with(".machine_file"));
            if let Some(name) = twice {
                bail!(
                    "`{name}` is set (--set), but --machine {machine} binds it too: give one of both"
                );
            }
        }
        let (schedule, given) = (base.stepping.schedule, base.given(&system)?);
        let mut verdict = check_mentions(run, &system, schedule, &given)?;
        let warning = controller_warning(&system, &base)?;
        gains
            .into_iter()
            .chain(warning)
            .for_each(|text| verdict.note(text));
        set_delays(&system, &mut base)?;
        let mut setup = RunSetup {
            system,
            base,
            verdict,
        };
        if self.has_path
            && let Some((_, experiment)) = self.args.on_path(&setup)?
        {
            setup.base = experiment;
        }
        if self.world.bends() {
            ensure!(
                run.step.is_none_or(|step| step <= BENDING_STEP),
                "--step {}: a structure that bends needs steps of at most {BENDING_STEP} s",
                setup.base.stepping.step
            );
            let step = &mut setup.base.stepping.step;
            *step = step.min(BENDING_STEP);
        }
        Ok(setup)
    }
}

impl RunSetup {
    /// System, experiment and verdict so far.
    pub fn into_parts(self) -> (System, Experiment, Verdict) {
        (self.system, self.base, self.verdict)
    }

    /// Path of another packed system in the same folder.
    pub fn sibling_path(&self, name: &str) -> PathBuf {
        self.system.path.with_file_name(name)
    }
}

/// A warning if the controller of a system with actuators as built (`Rig`) adapts too fast.
fn controller_warning(system: &System, base: &Experiment) -> Result<Option<String>> {
    let mut models = system.fmus.iter().map(|fmu| &fmu.description.identifier);
    let ports = ["gamma", "machine_file"].map(|name| system.port(&format!("controller.{name}")));
    let [Ok(gamma), Ok(file)] = ports else {
        return Ok(None);
    };
    if !models.any(|model| model == "Rig") {
        return Ok(None);
    }
    let gamma = start_value(system, &base.settings, gamma)?;
    let file = machine_choice::MachineFile::from_parameter(system, &base.settings, file)?;
    adaptation_warning(&file.machine, gamma)
}

/// A warning if the adaptation gain `gamma`, J, is too small for a machine.
pub fn adaptation_warning(machine: &Machine, gamma: f64) -> Result<Option<String>> {
    let ruled = gain_rule::gamma(machine)?;
    if gamma * MARGIN > ruled {
        return Ok(None);
    }
    let hertz = gain_rule::bounds(machine)?.mode / std::f64::consts::TAU;
    Ok(Some(format!(
        "gamma = {gamma} J adapts faster than the lowest mode of this machine allows, {hertz:.1} Hz on actuators as built, so it may swing: the rule gives \
         gamma = {ruled} J; `hdrm-fmu machine gains FILE --output gains.ssv` writes all gains, `--parameters gains.ssv` takes them"
    )))
}

/// Sets `delay` to one step in all components that have it if the schedule is `standard`, under
/// which their outputs act one step late. It must be all of them: a controller that predicts over
/// the step needs actuators that do too. A delay that the structure or a set gives is kept.
pub fn set_delays(system: &System, base: &mut Experiment) -> Result<()> {
    if base.stepping.schedule != Schedule::Standard {
        return Ok(());
    }
    for (component, element) in system.structure.components.iter().enumerate() {
        let is_bound = element.parameters.iter().any(|p| p.name == DELAY);
        if let Ok(delay) = system.port_of(component, DELAY)
            && !is_bound
            && !base.settings.iter().any(|s| s.port == delay)
        {
            base.settings.push(system.setting(&system.name(delay), 1)?);
        }
    }
    Ok(())
}

/// Reports what the system leaves out, such as inputs without a value; not the inputs that the
/// shipped systems leave unconnected on purpose, as long as all components of a model agree.
/// With `--strict`, anything reported is an error.
///
/// The run itself gives values to the variables `given`.
pub fn check_mentions(
    run: &RunArgs,
    system: &System,
    schedule: Schedule,
    given: &BTreeSet<Port>,
) -> Result<Verdict> {
    let mut gaps = system.find_gaps(given)?;
    let all = gaps.unmentioned_inputs.clone();
    let components = || system.structure.components.iter().zip(&system.fmus);
    gaps.unmentioned_inputs.retain(|name| {
        let Some((component, input)) = name.split_once('.') else {
            return true;
        };
        let found = components().find(|(c, _)| c.name == component);
        let model = found.map(|(_, fmu)| fmu.description.identifier.as_str());
        let is_optional = OPTIONAL
            .iter()
            .any(|(name, inputs)| model == Some(*name) && inputs.contains(&input));
        let alike = components().filter(|(_, fmu)| Some(&*fmu.description.identifier) == model);
        let mut names = alike.map(|(c, _)| format!("{}.{input}", c.name));
        !(is_optional && names.all(|name| all.contains(&name)))
    });
    gaps.judge(system, schedule, run.strict)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The longer boom with 500 kg asks for slower adaptation than the reference machine's gains
    /// have; a reference machine with another name does not.
    #[test]
    fn a_machine_that_asks_for_other_gains_is_told() {
        let mut machine = Machine::reference();
        assert_eq!(adaptation_warning(&machine, 250.0).expect("works"), None);
        machine.geometry.r_B_B4[0] = 2.1;
        machine.bodies.PL.mass = 500.0;
        let text = adaptation_warning(&machine, 250.0)
            .expect("works")
            .expect("a cause");
        assert!(
            text.contains("lowest mode") && text.contains("machine gains"),
            "{text}"
        );
        assert_eq!(adaptation_warning(&machine, 900.0).expect("works"), None);
    }
}
