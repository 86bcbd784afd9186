//! `<ModelVariables>`.

use super::{Xml, real};
use crate::Model;
use crate::core::layout::Layout;
use crate::core::variable::{Causality, Place, Variable};
use std::io;

pub(super) fn write<M: Model>(xml: &mut Xml, layout: &Layout<M>) -> io::Result<()> {
    let (parameters, input) = M::defaults();
    xml.create_element("ModelVariables")
        .write_inner_content(|xml| {
            for (vr, (i, row)) in layout.iter().enumerate() {
                let start = row.place.start(&parameters, &input, i);
                write_variable(xml, vr, row, i, start)?;
            }
            Ok(())
        })?;
    Ok(())
}

fn write_variable<M: Model>(
    xml: &mut Xml,
    vr: usize,
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
            Causality::Parameter if self.tunable => "tunable",
            Causality::Parameter => "fixed",
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
}

impl<M: Model> Place<M> {
    /// Start value of an input or a parameter; outputs have none.
    fn start(&self, p: &M::Parameters, u: &M::Input, i: usize) -> Option<String> {
        Some(match self {
            Place::RealIn(place) => real(place.get(u, i)),
            Place::IntegerIn(place) => place.get(u, i).to_string(),
            Place::BooleanIn(place) => place.get(u, i).to_string(),
            Place::RealParameter(place) => real(place.get(p, i)),
            Place::IntegerParameter(place) => place.get(p, i).to_string(),
            Place::BooleanParameter(place) => place.get(p, i).to_string(),
            Place::StringParameter(get, _) => get(p).to_owned(),
            Place::RealOut(_) | Place::IntegerOut(_) | Place::BooleanOut(_) => return None,
        })
    }
}
