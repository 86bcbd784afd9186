//! Which interface of its FMU each component uses, as the structure or the option `--interface` says,
//! for systems that load their FMUs.

use anyhow::{Context, Result, ensure};
use fmi_description::Interface;

use super::Structure;
use crate::run::signals::matches_pattern;

impl Structure {
    /// Chooses interfaces of components: `a=me`, `wheel_*=cs`, or `me` if there is one component.
    pub(crate) fn choose_interfaces(&mut self, given: &[String]) -> Result<()> {
        for text in given {
            self.choose(text)
                .with_context(|| format!("--interface {text}"))?;
        }
        Ok(())
    }

    fn choose(&mut self, text: &str) -> Result<()> {
        let (pattern, word) = match text.rsplit_once('=') {
            Some((pattern, word)) => (Some(pattern), word),
            None => (None, text),
        };
        let interface = match word {
            "me" => Interface::ModelExchange,
            "cs" => Interface::CoSimulation,
            _ => anyhow::bail!("`{word}` must be me (Model Exchange) or cs (Co-Simulation)"),
        };
        let names = self.components.iter().map(|c| &c.name);
        let chosen: Vec<_> = match pattern {
            Some(pattern) => names
                .filter(|name| matches_pattern(pattern, name))
                .collect(),
            None => {
                let count = names.len();
                ensure!(
                    count == 1,
                    "there are {count} components: say COMPONENT={word}"
                );
                names.collect()
            }
        };
        ensure!(
            !chosen.is_empty(),
            "the system has no component of this name"
        );
        let chosen = chosen.into_iter().map(|name| (name.clone(), interface));
        self.interfaces.extend(chosen.collect::<Vec<_>>());
        Ok(())
    }

    /// The interface that is chosen for a component.
    pub(crate) fn interface(&self, component: &str) -> Option<Interface> {
        let mut all = self.interfaces.iter().rev();
        all.find(|(name, _)| name == component)
            .map(|(_, interface)| *interface)
    }
}
