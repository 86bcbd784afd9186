//! Puts a run of the machine together: system and world, machine file, path, start values; what is
//! bound twice is refused. Every command begins here, with [`MachineArgs::setup`].

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use clap::Args;
use cosim::cli::{RunArgs, SystemArgs, find};
use cosim::master::Schedule;
use cosim::{Experiment, System, Verdict, start_value};
use machine_file::{Machine, Source};
use motion_check::gain_rule;

use super::{loads, machine_choice};
use crate::machines::path_margins;
use crate::setup::start_values::{on_path, over};
use crate::worlds::{BENDING_STEP, BENDING_SYSTEM, STRICT_SYSTEM, SYSTEM, World, parameters_of};

/// The packed machine.
pub const MACHINE: &str = "Manipulator.ssp";

/// The parameter of controller and actuators that says how many steps late their outputs act.
const DELAY: &str = "delay";
/// A machine whose adaptation is faster than by the rule by this swings on soft mountings: that is
/// the margin in `gamma` that the rule's gains have on the reference machine.
const MARGIN: f64 = 2.0;

/// Inputs that the shipped systems leave unconnected on purpose, by the model that has them: their
/// start values stand for a machine without supply, brakes, weather, load or operator.
const OPTIONAL: [(&str, &[&str]); 5] = [
    ("Emla", ACTUATOR),
    ("Rig", ACTUATOR),
    ("Hdrm", &["wrench_env", "base", "load"]),
    (
        "Controller",
        &["x", "v_dc", "T_winding", "reference", "base", "rate"],
    ),
    ("DcLink", &["T_ambient"]),
];
const ACTUATOR: &[&str] = &["v_dc", "enable", "brake", "T_ambient", "F_ext"];

/// The machine and how it is run.
#[derive(Args)]
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
    /// iso9283-rectangle, six-joints; without a stop time, to its end
    #[arg(long, value_name = "FILE")]
    waypoints: Option<String>,
}

/// A machine that is ready to run.
pub struct RunSetup {
    /// The system.
    pub system: System,
    /// How it is run, and from which start values.
    pub base: Experiment,
    /// What the system may have forgotten.
    pub verdict: Verdict,
}

/// Which machine the arguments are to run.
#[derive(Clone)]
pub struct SetupBuilder<'a> {
    args: &'a MachineArgs,
    world: World,
    packed: Option<PathBuf>,
    has_path: bool,
}

impl MachineArgs {
    /// The machine that the arguments name, on their path.
    pub fn setup(&self) -> SetupBuilder<'_> {
        SetupBuilder {
            args: self,
            world: World::Ideal,
            packed: None,
            has_path: true,
        }
    }

    /// The path that is given by its name, and the experiment that follows it.
    pub fn on_path(&self, setup: &RunSetup) -> Result<Option<(String, Experiment)>> {
        let Some(path) = &self.waypoints else {
            return Ok(None);
        };
        let settings = on_path(&setup.system, path)?;
        let experiment = over(&setup.system, &setup.base, settings)?;
        Ok(Some((path.clone(), experiment)))
    }

    /// The path that the tip follows, where one is given.
    pub fn waypoints(&self) -> Option<&str> {
        self.waypoints.as_deref()
    }

    /// The parameter set of the real world that belongs to the machine.
    pub fn parameters(&self) -> Result<&'static str> {
        let source = self.file.as_deref().map(Source::named).transpose()?;
        Ok(parameters_of(source.and_then(|source| source.shipped())))
    }

    /// Whether a bad verdict ends the program with a code of its own.
    pub fn check(&self) -> bool {
        self.run.check
    }
}

impl SetupBuilder<'_> {
    /// As the machine of this world; by default its packed system.
    pub fn world(self, world: World) -> Self {
        Self { world, ..self }
    }

    /// Another packed system, with the FMUs from the same place, and without the path.
    pub fn packed(self, path: &Path) -> Self {
        Self {
            packed: Some(path.into()),
            has_path: false,
            ..self
        }
    }

    /// Whatever path is given, without following it.
    pub fn without_path(self) -> Self {
        Self {
            has_path: false,
            ..self
        }
    }

    /// The system, with the machine that was asked for, and with wires for the loads of the path.
    ///
    /// # Errors
    /// A file that is missing or wrong.
    pub fn system(&self) -> Result<System> {
        let MachineArgs {
            system,
            file,
            waypoints,
            ..
        } = self.args;
        let mut arguments = system.clone();
        if let Some(path) = &self.packed {
            arguments.system = Some(path.clone());
            arguments.variant = None;
            arguments.parameters.clear();
        }
        let mut system = arguments.load(|| find(self.world_system()))?;
        if let Some(machine) = file {
            machine_choice::bind(&mut system, machine)
                .with_context(|| format!("--machine {machine}"))?;
        }
        if let (Some(path), None) = (waypoints, &self.packed)
            && loads::are_on(&path_margins::read(path)?)
        {
            loads::connect(&mut system)?;
        }
        if self.world.is_as_built() {
            system.apply_set(Path::new(self.args.parameters()?))?;
            // What is asked for comes after what the world takes by itself.
            for set in &arguments.parameters {
                system.apply_set(set)?;
            }
        }
        Ok(system)
    }

    fn world_system(&self) -> &'static str {
        match self.world {
            World::Ideal => MACHINE,
            World::Real | World::StrictRigid => SYSTEM,
            World::Bending => BENDING_SYSTEM,
            World::Strict => STRICT_SYSTEM,
        }
    }

    /// The system, ready to run.
    ///
    /// # Errors
    /// Arguments that do not fit the system, or a value that is bound twice.
    pub fn build(&self) -> Result<RunSetup> {
        let MachineArgs { run, file, .. } = self.args;
        let system = self.system()?;
        let mut base = run.experiment(&system)?;
        if let Some(machine) = file {
            let twice = (base.settings.iter())
                .map(|s| system.name(s.port))
                .find(|name| name.ends_with(".machine_file"));
            ensure!(
                twice.is_none(),
                "`{}` is set (--set), but --machine {machine} binds it too: give one of both",
                twice.unwrap_or_default()
            );
        }
        let mut verdict = forgotten(run, &system, &base)?;
        if let Some(text) = adapts_too_fast(&system, &base)? {
            verdict.note(text);
        }
        tell_delay(&system, &mut base)?;
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
            let step = &mut setup.base.stepping.step;
            *step = step.min(BENDING_STEP);
        }
        Ok(setup)
    }
}

impl RunSetup {
    /// System, experiment, and what the system may have forgotten.
    pub fn into_parts(self) -> (System, Experiment, Verdict) {
        (self.system, self.base, self.verdict)
    }

    /// Another packed system that lies beside this one.
    pub fn beside(&self, name: &str) -> PathBuf {
        self.system.path.with_file_name(name)
    }
}

/// Whether a controller of actuators as built adapts faster than its machine lets it.
fn adapts_too_fast(system: &System, base: &Experiment) -> Result<Option<String>> {
    let mut models = system.fmus.iter().map(|fmu| &fmu.description.model);
    let ports = ["gamma", "machine_file"].map(|name| system.port(&format!("controller.{name}")));
    let [Ok(gamma), Ok(file)] = ports else {
        return Ok(None);
    };
    if !models.any(|model| model == "Rig") {
        return Ok(None);
    }
    let gamma = start_value(system, &base.settings, gamma)?;
    let file = machine_choice::MachineFile::at(system, &base.settings, file)?;
    too_fast(&file.machine, gamma)
}

/// What is wrong with the adaptation gain `gamma`, J, on a machine; nothing where it has a margin.
///
/// # Errors
/// A mechanism that does not work.
pub fn too_fast(machine: &Machine, gamma: f64) -> Result<Option<String>> {
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

/// Tells all components that have a parameter `delay` that with the schedule `standard` their
/// outputs act one step late. All of them: a controller that predicts over the step needs actuators
/// that do too. What the structure or a parameter set says of a component's delay stays.
pub fn tell_delay(system: &System, base: &mut Experiment) -> Result<()> {
    if base.stepping.schedule != Schedule::Standard {
        return Ok(());
    }
    for (component, element) in system.structure.components.iter().enumerate() {
        let is_bound = element.parameters.iter().any(|p| p.name == DELAY);
        let Ok(delay) = system.port_of(component, DELAY) else {
            continue;
        };
        if !is_bound && !base.settings.iter().any(|s| s.port == delay) {
            base.settings.push(system.setting(&system.name(delay), 1)?);
        }
    }
    Ok(())
}

/// What a system may have forgotten under these arguments; not what the shipped systems leave
/// unconnected on purpose, as long as all components of a model are alike in it.
///
/// # Errors
/// With `--strict`, anything forgotten.
pub fn forgotten(run: &RunArgs, system: &System, experiment: &Experiment) -> Result<Verdict> {
    let mut gaps = system.find_gaps(&experiment.settings)?;
    let all = gaps.unmentioned_inputs.clone();
    let components = || system.structure.components.iter().zip(&system.fmus);
    gaps.unmentioned_inputs.retain(|name| {
        let Some((component, input)) = name.split_once('.') else {
            return true;
        };
        let found = components().find(|(c, _)| c.name == component);
        let model = found.map(|(_, fmu)| fmu.description.model.as_str());
        let is_optional = OPTIONAL
            .iter()
            .any(|(of, inputs)| model == Some(*of) && inputs.contains(&input));
        let alike = components().filter(|(_, fmu)| Some(&*fmu.description.model) == model);
        let mut names = alike.map(|(c, _)| format!("{}.{input}", c.name));
        !(is_optional && names.all(|name| all.contains(&name)))
    });
    gaps.judge(system, experiment.stepping.schedule, run.strict)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The longer boom with 500 kg asks for slower adaptation than the reference machine's gains
    /// have; a reference machine with another name does not.
    #[test]
    fn a_machine_that_asks_for_other_gains_is_told() {
        let mut machine = Machine::reference();
        assert_eq!(too_fast(&machine, 250.0).expect("works"), None);
        machine.geometry.r_B_B4[0] = 2.1;
        machine.bodies.PL.mass = 500.0;
        let text = too_fast(&machine, 250.0).expect("works").expect("a cause");
        assert!(
            text.contains("lowest mode") && text.contains("machine gains"),
            "{text}"
        );
        assert_eq!(too_fast(&machine, 900.0).expect("works"), None);
    }
}
