//! The machine file that an FMU runs with: `--machine` and Python bind one to all FMUs ([`bind`]);
//! commands, analyses, measures and report read that of a component ([`MachineFile`]).

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use cosim::structure::{Component, DataType, Parameter};
use cosim::{Port, Setting, System};
use machine_file::{AXES, Emla, Machine, Source, preset};
use motion_check::gain_rule::{self, Actuators, RuledGain};
use percent_encoding::percent_decode_str;
use surrogate::measurement::data::sha256;

use crate::machines::strokes::beyond_strokes;

/// Parameter of the FMUs that depend on the machine's dimensions, actuators or gains.
pub(super) const MACHINE_FILE: &str = "machine_file";

/// Origin of the values that are bound here.
pub const ORIGIN: &str = "--machine";

/// Parameter of actuators and controller: weight of the network.
const ALPHA: &str = "alpha";

/// Model of the actuators as built.
const RIG: &str = "Rig";

/// Parameter of an actuator that says which of the machine's it is: slew, lift or tilt.
const AXIS: &str = "axis";

/// The machine file that an FMU runs with.
pub struct MachineFile {
    /// Name of the file.
    pub name: String,
    /// SHA-256 of its text and of those that it extends.
    pub sha256: String,
    /// What it says.
    pub machine: Machine,
}

/// Binds `machine`, a file or the name of a shipped machine, to the parameter `machine_file` of
/// every component that has it, in place of what the system binds. Also binds each actuator's
/// `axis`: the one that its name ends in, such as `emla_lift`, else the next in order.
///
/// Fails with everything that is wrong with the machine, or if the manipulator takes no file.
pub fn bind(system: &mut System, machine: &str) -> Result<()> {
    let unfit = beyond_strokes(&Source::named(machine)?.machine)?;
    ensure!(unfit.is_empty(), "{}", unfit.join("; "));
    // Another maker's plant may get its dimensions from elsewhere; a testbed has no manipulator.
    if let Ok(plant) = system.port("f_hold[1]") {
        let file = system.port_of(plant.component, MACHINE_FILE);
        file.context("this manipulator takes no machine file")?;
    }
    let mut actuators = 0;
    for (component, fmu) in system.structure.components.iter_mut().zip(&system.fmus) {
        let name = component.name.clone();
        let mut bind = |name: &str, value: String, data_type| {
            component.bind(name, value, data_type, ORIGIN);
        };
        if fmu.description.index(MACHINE_FILE).is_some() {
            bind(MACHINE_FILE, machine.into(), DataType::String);
        }
        if fmu.description.index(AXIS).is_some() {
            actuators += 1;
            let named = AXES.iter().position(|axis| name.ends_with(axis));
            let axis = named.map_or(actuators, |k| k + 1);
            bind(AXIS, axis.to_string(), DataType::Integer);
        }
    }
    Ok(())
}

/// What a run takes with a machine besides its file.
#[derive(Default)]
pub struct Ruled {
    /// Gains of the controller by the rule.
    pub gains: Vec<RuledGain>,
    /// `alpha` of actuators and controller: 0 where an actuator is not the one that the network was
    /// trained on, else none.
    pub alpha: Option<f64>,
}

/// What a run takes with a machine that has these actuators, for a user who gives `own` values to
/// some gains. The shipped machines have gains of their own in the ideal world: nothing.
pub fn ruled(
    machine: &Machine,
    actuators: Actuators,
    own: &[(&'static str, f64)],
) -> Result<Ruled> {
    let mut shipped = machine_file::PRESETS.iter();
    let is_shipped = shipped.any(|(name, _)| Machine::preset(name).as_ref() == Some(machine));
    if actuators == Actuators::Known && is_shipped {
        return Ok(Ruled::default());
    }
    let known = Machine::reference().emla.lift;
    let is_trained = machine.emla.in_order().map(|p| is_same_actuator(p, &known));
    Ok(Ruled {
        gains: gain_rule::gains_for(machine, actuators, own)?,
        alpha: (is_trained != [true; 3]).then_some(0.0),
    })
}

/// The gains by the rule for a machine.
pub struct GainChoice<'a> {
    /// Machine file, or name of a shipped machine.
    pub machine: &'a str,
    /// Parameter sets that the user gives: their gains count.
    pub sets: &'a [PathBuf],
    /// Start values that the user gives: they count too.
    pub settings: &'a [Setting],
}

impl GainChoice<'_> {
    /// Binds what the rule gives ([`ruled`]) to controller and actuators. Values that the user gives
    /// stay, and the rule's fit them: with a `Lambda_position` of the user's no machine is refused.
    /// Returns a list of what was bound, in words.
    ///
    /// With drives that regulate their currents themselves the gains are those for actuators as
    /// built. Without, but with such actuators, the voltage law's are those of the ideal world.
    pub fn bind(&self, system: &mut System) -> Result<Option<String>> {
        let machine = read(self.machine)?;
        let Ok(controller) = system.port("desired.position[1]") else {
            return Ok(None);
        };
        let controller = controller.component;
        let is_as_built = system
            .fmus
            .iter()
            .any(|fmu| fmu.description.identifier == RIG);
        let loops = bound_to(&system.structure.components[controller], "current_loop");
        let has_current_loops = loops.is_some_and(|p| ["true", "1"].contains(&p.value.as_str()));
        let own = gain_rule::IDEAL.into_iter().filter_map(|name| {
            let value = self.said(system, controller, name)?.parse().ok()?;
            Some((name, value))
        });
        let own: Vec<(_, f64)> = own.collect();
        let actuators = match (is_as_built, has_current_loops) {
            (false, _) => Actuators::Known,
            (true, true) => Actuators::AsBuilt,
            (true, false) => Actuators::AsBuiltOnVoltages,
        };
        let Ruled { mut gains, alpha } = ruled(&machine, actuators, &own)?;
        gains.retain(|gain| {
            system.fmus[controller]
                .description
                .index(gain.name)
                .is_some()
        });
        let mut told = Vec::new();
        for gain in gains {
            if self.bind_value(system, controller, gain.name, gain.value) {
                told.push(format!("{} = {}", gain.name, gain.value));
            }
        }
        if let Some(alpha) = alpha {
            let blended = system
                .fmus
                .iter()
                .map(|fmu| fmu.description.index(ALPHA).is_some());
            let blended: Vec<_> = blended.collect();
            let mut has_changed = false;
            for component in (0..blended.len()).filter(|k| blended[*k]) {
                has_changed |= self.bind_value(system, component, ALPHA, alpha);
            }
            if has_changed {
                told.push("alpha = 0, because the network was trained on another actuator".into());
            }
        }
        Ok((!told.is_empty()).then(|| told.join(", ")))
    }

    /// The value that the user gives to a variable.
    fn said<'b>(&'b self, system: &'b System, component: usize, name: &str) -> Option<&'b str> {
        let port = system.port_of(component, name).ok()?;
        let set = self.settings.iter().rev().find(|set| set.port == port);
        let bound = bound_to(&system.structure.components[component], name);
        let is_user = |origin: &str| {
            let mut sets = self.sets.iter().map(|set| set.to_string_lossy());
            sets.any(|set| origin.contains(&*set))
        };
        let bound = bound.filter(|bound| is_user(&bound.origin));
        set.map(|set| &*set.value)
            .or(bound.map(|bound| &*bound.value))
    }

    /// Binds a value unless the user gives one; returns whether that changes the value.
    fn bind_value(&self, system: &mut System, component: usize, name: &str, value: f64) -> bool {
        if self.said(system, component, name).is_some() {
            return false;
        }
        let fmu = &system.fmus[component];
        let component = &mut system.structure.components[component];
        let own = bound_to(component, name);
        let start = || {
            let index = fmu.description.index(name)?;
            fmu.description.variables[index].start.first().cloned()
        };
        let before = own.map(|own| own.value.clone()).or_else(start);
        let before = before.and_then(|text| text.parse::<f64>().ok());
        if before == Some(value) {
            return false;
        }
        component.bind(name, value.to_string(), DataType::Real, ORIGIN);
        true
    }
}

/// The value of the parameter that counts, of those bound to a component: the last one.
pub(super) fn bound_to<'a>(component: &'a Component, name: &str) -> Option<&'a Parameter> {
    component.parameters.iter().rev().find(|p| p.name == name)
}

/// Whether the network of the reference actuator holds for `p`: the same but for the drive's
/// limits, losses of the inverter, brake and heat.
fn is_same_actuator(p: &Emla, known: &Emla) -> bool {
    let known = Emla {
        i_max: p.i_max,
        v_max: p.v_max,
        core: p.core,
        inverter: p.inverter,
        brake: p.brake,
        heat: p.heat,
        temperature: p.temperature,
        ..*known
    };
    *p == known
}

impl MachineFile {
    /// The file of the manipulator: named by `settings`, by a parameter set or by the system, else
    /// the one among the FMU's resources, else the reference machine.
    pub fn from_manipulator(system: &System, settings: &[Setting]) -> Result<Self> {
        Self::from_parameter(system, settings, system.port("hdrm.machine_file")?)
    }

    /// Name of the machine, without the file's ending; `None` for the reference machine.
    pub fn own_name(&self) -> Option<&str> {
        let name = self.name.strip_suffix(".json").unwrap_or(&self.name);
        (self.machine != Machine::reference()).then_some(name)
    }

    /// As [`MachineFile::from_manipulator`], but `None` if the manipulator takes no file.
    pub fn from_plant(system: &System, settings: &[Setting]) -> Result<Option<Self>> {
        let port = system.port("hdrm.machine_file").ok();
        port.map(|port| Self::from_parameter(system, settings, port))
            .transpose()
    }

    /// As [`MachineFile::from_manipulator`], for the component that has the parameter `file`.
    pub fn from_parameter(system: &System, settings: &[Setting], file: Port) -> Result<Self> {
        let component = &system.structure.components[file.component];
        let name = &system.variable(file).name;
        let bound = bound_to(component, name);
        let set = settings.iter().rev().find(|s| s.port == file);
        let set = set.map(|s| &s.value).or(bound.map(|p| &p.value));
        let set = set.filter(|name| !name.is_empty());
        let resources = system.fmus[file.component]
            .resources()
            .trim_start_matches("file://");
        let resources = PathBuf::from(percent_decode_str(resources).decode_utf8()?.as_ref());
        let mut file = match set {
            Some(value) => PathBuf::from(value),
            None => resources.join("reference_machine.json"),
        };
        if file.is_relative() && !file.exists() {
            file = resources.join(file);
        }
        let shipped = set.and_then(|name| preset(name));
        let text = if let Some(text) = shipped {
            text.into()
        } else if set.is_none() && !file.exists() {
            machine_file::REFERENCE_JSON.into()
        } else {
            output_file::note_read(&file)?;
            std::fs::read_to_string(&file).with_context(|| file.display().to_string())?
        };
        let read = Source::read(&text, shipped.is_none().then_some(&*file));
        let Source { machine, texts } = read.with_context(|| file.display().to_string())?;
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        Ok(Self {
            name: name.into_owned(),
            sha256: sha256(texts.concat().as_bytes()),
            machine,
        })
    }
}

/// Reads a machine file, or the shipped machine of this name.
pub fn read(name: &str) -> Result<Machine> {
    output_file::note_read(name.as_ref())?;
    let source = Source::named(name).with_context(|| name.to_owned())?;
    Ok(source.machine)
}
