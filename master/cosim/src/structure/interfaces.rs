//! How each component uses its FMU, as the structure or the options `--interface` and `--isolate` say:
//! by which interface, and whether in a process of its own. For systems that load their FMUs.

use anyhow::{Context, Result, bail, ensure};
use fmi_description::Interface;
use fmi_import::Limits;

use super::{FmuUse, Structure};
use crate::run::signals::matches_pattern;

impl Structure {
    /// Notes the options, which override the structure.
    pub(crate) fn choose(&mut self, options: &FmuUse) -> Result<()> {
        for text in &options.interfaces {
            let chosen = self.choose_interface(text);
            chosen.with_context(|| format!("--interface {text}"))?;
        }
        for text in &options.isolated {
            let pattern = if text == "all" { "*" } else { text };
            let chosen = self.matching(pattern);
            let mut chosen = chosen.with_context(|| format!("--isolate {text}"))?;
            self.isolated.append(&mut chosen);
        }
        self.limits = options.limits;
        let Limits { time, memory } = self.limits;
        for (is_given, option) in [
            (time.is_some(), "--call-timeout"),
            (memory.is_some(), "--memory-limit"),
        ] {
            ensure!(
                !is_given || !self.isolated.is_empty(),
                "{option} is for components in processes of their own; there is none (--isolate)"
            );
        }
        Ok(())
    }

    fn choose_interface(&mut self, text: &str) -> Result<()> {
        let (pattern, word) = match text.rsplit_once('=') {
            Some((pattern, word)) => (Some(pattern), word),
            None => (None, text),
        };
        let interface = match word {
            "me" => Interface::ModelExchange,
            "cs" => Interface::CoSimulation,
            _ => bail!("`{word}` must be me (Model Exchange) or cs (Co-Simulation)"),
        };
        let count = self.components.len();
        ensure!(
            pattern.is_some() || count == 1,
            "there are {count} components: say COMPONENT={word}"
        );
        let chosen = self.matching(pattern.unwrap_or("*"))?.into_iter();
        self.interfaces.extend(chosen.map(|name| (name, interface)));
        Ok(())
    }

    /// The names of components that match a pattern, of which there must be one.
    fn matching(&self, pattern: &str) -> Result<Vec<String>> {
        let names = self.components.iter().map(|c| &c.name);
        let chosen = names.filter(|name| matches_pattern(pattern, name));
        let chosen: Vec<String> = chosen.cloned().collect();
        ensure!(
            !chosen.is_empty(),
            "the system has no component of this name; it has {}",
            self.component_names()
        );
        Ok(chosen)
    }

    /// The interface that is chosen for a component.
    pub(crate) fn interface(&self, component: &str) -> Option<Interface> {
        let mut all = self.interfaces.iter().rev();
        all.find(|(name, _)| name == component)
            .map(|(_, interface)| *interface)
    }

    /// The limits of the process of a component; None if it has no process of its own, as in a page,
    /// where modules are isolated anyway.
    pub(crate) fn isolation(&self, component: &str) -> Option<Limits> {
        let is_isolated = self.isolated.iter().any(|name| name == component);
        (is_isolated && cfg!(feature = "native")).then_some(self.limits)
    }
}
