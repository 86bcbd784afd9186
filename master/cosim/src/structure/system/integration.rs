//! How components of Model Exchange are integrated: by which method (`--solver`), and which of their
//! outputs' means over a step power bonds need, which no such FMU knows.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use fmi_description::Access;
use fmi_import::Choice;
use fmi_import::digits::short;

use super::System;
use crate::run::signals::matches_pattern;

impl System {
    /// The mean efforts of power bonds are those over each communication step.
    pub(super) fn take_means(&mut self) {
        let mut of: BTreeMap<usize, Vec<[usize; 2]>> = BTreeMap::new();
        for connection in &self.structure.connections {
            let (component, effort) = &connection.start;
            let bond = connection.bond.as_ref();
            let Some((k, bond)) = self.structure.component(component).zip(bond) else {
                continue;
            };
            let description = &self.fmus[k].description;
            let is_real = |i: &usize| description.variables[*i].access() == Access::Real;
            let index = |name| description.index(name).filter(is_real);
            let both = index(effort).zip(index(&bond.step_mean));
            let known = of.entry(k).or_default();
            known.extend(both.map(Into::into).filter(|pair| !known.contains(pair)));
        }
        for (k, pairs) in of {
            if let Some(fmu) = self.fmus[k].with_means(&pairs) {
                self.fmus[k] = fmu;
            }
        }
    }

    /// Chooses the method by which components of Model Exchange are integrated: `a=explicit`,
    /// `wheel_*=stiff`, `a=fixed:1e-4`, or without a name for all.
    ///
    /// # Errors
    /// There is no such component or method, or the component cannot use it.
    pub fn choose_solver(&mut self, text: &str) -> Result<()> {
        let (pattern, word) = text.rsplit_once('=').unwrap_or(("*", text));
        let step = word.strip_prefix("fixed:").and_then(|h| h.parse().ok());
        let step = step.filter(|h: &f64| *h > 0.0 && h.is_finite());
        let choice = match (word, step) {
            ("explicit", _) => Some(Choice::Explicit),
            ("stiff", _) => Some(Choice::Stiff),
            (_, step) => step.map(Choice::Fixed),
        };
        let choice = choice.with_context(|| {
            format!("`{word}` must be explicit, stiff, or fixed:STEP with a step greater than 0 s")
        })?;
        let (mut is_known, mut is_any) = (false, false);
        for (component, fmu) in self.structure.components.iter().zip(&mut self.fmus) {
            if matches_pattern(pattern, &component.name) {
                is_known = true;
                let chosen = fmu.with_method(choice);
                if let Some(chosen) = chosen.with_context(|| component.name.clone())? {
                    (*fmu, is_any) = (chosen, true);
                }
            }
        }
        ensure!(is_known, "the system has no component of this name");
        ensure!(
            is_any,
            "only components of Model Exchange are integrated here (--interface {pattern}=me)"
        );
        Ok(())
    }
}

/// The method as `--solver` names it.
pub(crate) fn method_name(choice: Choice) -> String {
    match choice {
        Choice::Automatic => "automatic".into(),
        Choice::Explicit => "explicit".into(),
        Choice::Stiff => "stiff".into(),
        Choice::Fixed(step) => format!("fixed:{}", short(step)),
    }
}
