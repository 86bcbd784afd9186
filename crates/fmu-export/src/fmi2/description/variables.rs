//! `<ModelVariables>`.

use super::{Xml, real};
use crate::Model;
use crate::core::layout::Layout;
use crate::core::variable::{Causality, Place, Variable};
use std::io;

pub(super) fn write<M: Model>(xml: &mut Xml, layout: &Layout<M>) -> io::Result<()> {
    let (parameters, input) = M::defaults();
    let output = M::Output::default();
    xml.create_element("ModelVariables")
        .write_inner_content(|xml| {
            for (vr, (i, row)) in layout.numbered() {
                let start = row.start(&parameters, &input, &output, i);
                write_variable(xml, vr, row, i, start)?;
            }
            Ok(())
        })?;
    Ok(())
}

fn write_variable<M: Model>(
    xml: &mut Xml,
    vr: u32,
    row: &Variable<M>,
    i: usize,
    start: Option<String>,
) -> io::Result<()> {
    let (vr, name) = (vr.to_string(), row.element_name(i));
    let (causality, initial) = match row.causality {
        Causality::Input => ("input", None),
        Causality::Output => ("output", Some("calculated")),
        Causality::Local => ("local", Some("calculated")),
        Causality::Parameter => ("parameter", Some("exact")),
        Causality::CalculatedParameter => ("calculatedParameter", Some("calculated")),
        Causality::Constant => ("local", Some("exact")),
    };
    let mut attributes = vec![
        ("name", name.as_str()),
        ("valueReference", &vr),
        ("description", row.description),
        ("causality", causality),
        ("variability", row.variability()),
    ];
    attributes.extend(initial.map(|initial| ("initial", initial)));
    xml.create_element("ScalarVariable")
        .with_attributes(attributes)
        .write_inner_content(|xml| {
            let attributes = type_attributes(row, i, start);
            let attributes = attributes
                .iter()
                .map(|(name, value)| (*name, value.as_str()));
            xml.create_element(row.element_type())
                .with_attributes(attributes)
                .write_empty()?;
            Ok(())
        })?;
    Ok(())
}

fn type_attributes<M: Model>(
    row: &Variable<M>,
    i: usize,
    start: Option<String>,
) -> Vec<(&'static str, String)> {
    let mut attributes = Vec::new();
    let mut add = |name, value: Option<String>| attributes.extend(value.map(|value| (name, value)));
    let is_real = row.place.type_name() == "Real";
    let bound = |x: f64| {
        x.is_finite()
            .then(|| if is_real { real(x) } else { x.to_string() })
    };
    add("declaredType", row.enumeration.map(|e| e.name.to_owned()));
    add("unit", row.unit_of(i).map(str::to_owned));
    add("displayUnit", row.display_unit.map(str::to_owned));
    add("min", bound(row.min));
    add("max", bound(row.max));
    add("nominal", row.nominal.map(real));
    add("start", start);
    attributes
}

impl<M: Model> Variable<M> {
    fn variability(&self) -> &'static str {
        match self.causality {
            Causality::Constant => "constant",
            Causality::Parameter | Causality::CalculatedParameter if self.tunable => "tunable",
            Causality::Parameter | Causality::CalculatedParameter => "fixed",
            _ if self.place.type_name() == "Real" && !self.discrete => "continuous",
            _ => "discrete",
        }
    }

    fn element_type(&self) -> &'static str {
        if self.enumeration.is_some() {
            "Enumeration"
        } else {
            self.place.type_name()
        }
    }

    /// Start value of an input, a parameter or a constant; what is computed has none.
    fn start(&self, p: &M::Parameters, u: &M::Input, y: &M::Output, i: usize) -> Option<String> {
        let is_constant = self.causality == Causality::Constant;
        match &self.place {
            Place::RealIn(place) => Some(real(place.get(u, i))),
            Place::IntegerIn(place) => Some(place.get(u, i).to_string()),
            Place::BooleanIn(place) => Some(place.get(u, i).to_string()),
            Place::RealParameter(place) => Some(real(place.get(p, i))),
            Place::IntegerParameter(place) => Some(place.get(p, i).to_string()),
            Place::BooleanParameter(place) => Some(place.get(p, i).to_string()),
            Place::StringParameter(get, _) => Some(get(p).to_owned()),
            Place::RealOut(place) => is_constant.then(|| real(place.get(y, i))),
            Place::IntegerOut(place) => is_constant.then(|| place.get(y, i).to_string()),
            Place::BooleanOut(place) => is_constant.then(|| place.get(y, i).to_string()),
            Place::StringOut(_) => None,
        }
    }
}
