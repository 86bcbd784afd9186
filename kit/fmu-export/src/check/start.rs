//! Tests in `check` what every importer does first: it sets texts, initializes with the start
//! values, gets the outputs and does a step.

use super::model_check::ModelCheck;
use super::point::Point;
use crate::core::layout::Element;
use crate::core::model::zero;
use crate::core::storage::{Storage, each};
use crate::core::value::{Value, allowed};
use crate::{Evaluation, InputPolynomial, Model, ModelError};

/// The text that String parameters are set to.
const WRITTEN: &str = "a text of check";

impl<M: Model> ModelCheck<M> {
    /// Sets each String parameter to a text; a setter that expects a file name refuses it.
    pub(super) fn texts(&mut self) {
        let texts = |p: &M::Parameters| -> Vec<Option<String>> {
            let text = |(_, row): Element<M>| match &row.storage {
                Storage::Text(get, _) => Some(get(p).to_owned()),
                _ => None,
            };
            self.layout.iter().map(text).collect()
        };
        let before = texts(&self.start.0);
        let mut read = Vec::new();
        for (k, (_, row)) in self.layout.iter().enumerate() {
            let mut p = self.start.0.clone();
            if let Storage::Text(_, set) = &row.storage
                && set(&mut p, WRITTEN, None).is_ok()
            {
                read.push((k, texts(&p)));
            }
        }
        for (k, after) in read {
            if after[k].as_deref() != Some(WRITTEN) {
                self.has_two_fields(k);
            }
            for other in (0..after.len()).filter(|&j| j != k && after[j] != before[j]) {
                self.share_a_field(k, other);
            }
        }
    }

    /// Initializes, gets outputs and steps with the start values.
    pub(super) fn start(&mut self) {
        if let Err(problem) = self.started() {
            self.problems.insert(problem);
        }
    }

    fn started(&self) -> Result<(), String> {
        let (Point(p, u), info) = (&self.start, M::INFO);
        let what =
            |what: &'static str| move |e: ModelError| format!("{what} with the start values: {e}");
        let mut model = M::initialize(p, u, info.experiment.start).map_err(what("initialize"))?;
        let now = M::Evaluation::new(&model, p, u).map_err(what("Evaluation::new"))?;
        let y = model.output(p, u, &now).map_err(what("output"))?;
        for (i, row) in self.layout.iter() {
            let name = row.element_name(i);
            let Some(values) = row.storage.output_values(&y) else {
                continue;
            };
            each!(Values, values, |values| {
                let value = &values[i];
                let allowed = match row.enumeration {
                    Some(_) if !value.is_allowed(row) => allowed(row),
                    _ if !value.is_finite() => "finite".to_owned(),
                    _ => continue,
                };
                return Err(format!(
                    "`{name}` = {} with the start values must be {allowed}",
                    value.to_message()
                ));
            })
        }
        if info.output_derivatives {
            let zero = zero::<M>(u);
            (model.output_derivative(p, u, &now, &zero)).map_err(what("output_derivative"))?;
        }
        let (t, h) = (info.experiment.start, info.experiment.step);
        (model.step(p, &InputPolynomial::held(u.clone()), &now, t, h)).map_err(what("step"))?;
        Ok(())
    }
}
