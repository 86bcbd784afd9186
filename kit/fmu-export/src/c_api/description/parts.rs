//! The elements of a model description that `fmi2` and `fmi3` write alike: root, units, types, log
//! categories, default experiment and the common attributes of variables.

use super::element::Element;
use crate::c_api::log::CATEGORIES;
use crate::core::causality::Causality;
use crate::core::enumeration::Enumeration;
use crate::core::info::Info;
use crate::core::layout::Layout;
use crate::core::model::Variable;
use crate::core::storage::{Kind, Storage, Values, each};
use crate::core::value::Value;
use crate::{Model, TypeDefinition};
use fmi_units::{BASE, DisplayUnit, Unit};

/// The root element with the model's name, version, author and licence.
pub(super) fn root(info: &Info, version: &str, hash: (&'static str, String)) -> Element {
    let optional = [
        ("description", info.description),
        ("author", info.author),
        ("version", info.version),
        ("copyright", info.copyright),
        ("license", info.license),
    ];
    let own = info.own_name().map(|own| format!("{}_{own}", info.model));
    let name = own.as_deref().unwrap_or(info.model);
    let generator = concat!("fmu-export ", env!("CARGO_PKG_VERSION"));
    Element::new("fmiModelDescription")
        .with([("fmiVersion", version), ("modelName", name)])
        .with([hash])
        .with(optional.into_iter().filter(|(_, text)| !text.is_empty()))
        .with([
            ("generationTool", generator),
            ("variableNamingConvention", "structured"),
        ])
}

/// `true` or `false`.
pub(crate) fn flag(yes: bool) -> &'static str {
    if yes { "true" } else { "false" }
}

/// The definition of an element's unit: that of the row, else of the model, else what its name says.
pub(crate) fn unit<M: Model>(row: &Variable<M>, i: usize) -> Option<Unit> {
    let name = row.unit_of(i)?;
    let mut own = row.own_unit.into_iter().chain(M::INFO.units);
    let own = own.find(|unit| unit.name == name);
    own.copied().or_else(|| Unit::find(name))
}

/// The units in use with their display units, those of rows last, in the order of first use.
pub(super) fn units_in_use<M: Model>(layout: &Layout<M>) -> Vec<(Unit, Vec<DisplayUnit>)> {
    let mut used: Vec<(Unit, Vec<_>)> = Vec::new();
    for (elements, row) in layout.rows() {
        let different = elements.len().min(row.each_unit.len()).max(1);
        for unit in (0..different).filter_map(|i| unit::<M>(row, i)) {
            if !used.iter().any(|(known, _)| known.name == unit.name) {
                used.push((unit, unit.display.to_vec()));
            }
            let of_type = row.declared_type.and_then(|of| of.display_unit);
            let shown = row.display_unit.into_iter().chain(of_type);
            for shown in shown.filter_map(|name| unit.shown_in(name)) {
                let entry = used.iter_mut().find(|(known, _)| known.name == unit.name);
                let Some((_, display)) = entry else { continue };
                if display.iter().all(|known| known.name != shown.name) {
                    display.push(shown);
                }
            }
        }
    }
    used
}

pub(super) fn units<M: Model>(layout: &Layout<M>) -> Option<Element> {
    let units = units_in_use(layout).into_iter().map(|(unit, display)| {
        let exponents = BASE.into_iter().zip(unit.exponents);
        let base = exponents.filter(|(_, exponent)| *exponent != 0);
        let base = Element::new("BaseUnit")
            .with(base.map(|(name, exponent)| (name, exponent.to_string())))
            .with(scale(unit.factor, unit.offset));
        let display = display.iter().map(|shown| {
            Element::new("DisplayUnit")
                .with([
                    ("name", shown.name.to_owned()),
                    ("factor", real(shown.factor)),
                ])
                .with(scale(1.0, shown.offset))
        });
        let unit = Element::new("Unit").with([("name", unit.name)]);
        unit.holding([base]).holding(display)
    });
    Element::new("UnitDefinitions").holding(units).if_any()
}

/// The attributes `factor` and `offset`, unless they have their defaults 1 and 0.
fn scale(factor: f64, offset: f64) -> impl Iterator<Item = (&'static str, String)> {
    let factor = (factor != 1.0).then(|| ("factor", real(factor)));
    let offset = (offset != 0.0).then(|| ("offset", real(offset)));
    factor.into_iter().chain(offset)
}

/// The enumerations in use, in the order of first use.
pub(crate) fn enumerations<M: Model>(layout: &Layout<M>) -> Vec<Enumeration> {
    let mut used: Vec<Enumeration> = Vec::new();
    for (_, row) in layout.rows() {
        if let Some(enumeration) = row.enumeration
            && !used.iter().any(|known| known.name == enumeration.name)
        {
            used.push(enumeration);
        }
    }
    used
}

/// The types of Reals in use, in the order of first use.
pub(super) fn declared_types<M: Model>(layout: &Layout<M>) -> Vec<&'static TypeDefinition> {
    let mut used: Vec<&TypeDefinition> = Vec::new();
    for declared in layout.rows().filter_map(|(_, row)| row.declared_type) {
        if !used.iter().any(|known| known.name == declared.name) {
            used.push(declared);
        }
    }
    used
}

/// The definitions of enumerations and of types of Reals: `outer` elements that hold the content, or
/// hold an `inner` element with it.
pub(super) fn types<M: Model>(
    layout: &Layout<M>,
    [enumeration, real_type]: [(&'static str, Option<&'static str>); 2],
) -> Option<Element> {
    let enumerations = enumerations(layout).into_iter().map(|of| {
        let items = (1..).zip(of.items);
        let items = items.map(|(value, (name, description))| {
            let value = i32::to_string(&value);
            Element::new("Item").with([
                ("name", *name),
                ("value", &value),
                ("description", description),
            ])
        });
        defined(
            enumeration,
            of.name,
            of.description,
            Vec::new(),
            items.collect(),
        )
    });
    let reals = declared_types(layout).into_iter().map(|of| {
        let bound = |x: f64| x.is_finite().then(|| real(x));
        let attributes = [
            (
                "quantity",
                Some(of.quantity.to_owned()).filter(|q| !q.is_empty()),
            ),
            ("unit", of.unit.map(str::to_owned)),
            ("displayUnit", of.display_unit.map(str::to_owned)),
            (
                "relativeQuantity",
                of.relative.then(|| flag(true).to_owned()),
            ),
            ("min", bound(of.min)),
            ("max", bound(of.max)),
            ("nominal", of.nominal.map(real)),
        ];
        let attributes = attributes
            .into_iter()
            .filter_map(|(name, value)| Some((name, value?)));
        let attributes = attributes.collect();
        defined(real_type, of.name, of.description, attributes, Vec::new())
    });
    Element::new("TypeDefinitions")
        .holding(enumerations)
        .holding(reals)
        .if_any()
}

/// The definition of a type, whose inner element has more attributes and children.
fn defined(
    (outer, inner): (&'static str, Option<&'static str>),
    name: &str,
    description: &str,
    attributes: Vec<(&'static str, String)>,
    children: Vec<Element>,
) -> Element {
    let outer = Element::new(outer).with([("name", name), ("description", description)]);
    let fill = |element: Element| element.with(attributes).holding(children);
    match inner {
        None => fill(outer),
        Some(inner) => outer.holding([fill(Element::new(inner))]),
    }
}

pub(super) fn categories<M: Model>() -> Element {
    let each = CATEGORIES.map(|(name, _, description)| (name, description));
    let each = each.iter().chain(M::INFO.log_categories);
    Element::new("LogCategories").holding(each.map(|(name, description)| {
        Element::new("Category").with([("name", *name), ("description", *description)])
    }))
}

pub(super) fn experiment<M: Model>() -> Element {
    let e = M::INFO.experiment;
    let numbers = [
        ("startTime", Some(e.start)),
        ("stopTime", Some(e.stop)),
        ("tolerance", M::INFO.tolerance),
        ("stepSize", Some(e.step)),
    ];
    let said = |(name, number): (_, Option<f64>)| Some((name, real(number?)));
    Element::new("DefaultExperiment").with(numbers.into_iter().filter_map(said))
}

/// The element of a variable, with the attributes that both versions write first.
pub(crate) fn variable<M: Model>(
    element: &'static str,
    name: String,
    number: u32,
    row: &Variable<M>,
) -> Element {
    let (causality, _) = row.causality_and_initial();
    Element::new(element)
        .with([("name", name), ("valueReference", number.to_string())])
        .with([
            ("description", row.description),
            ("causality", causality),
            ("variability", row.variability()),
        ])
}

/// A list of numbers as the value of an attribute.
pub(crate) fn listed(numbers: impl IntoIterator<Item = impl ToString>) -> String {
    let numbers = numbers.into_iter().map(|number| number.to_string());
    Vec::from_iter(numbers).join(" ")
}

/// The shortest decimal that reads back as the same number.
pub(crate) fn real(x: f64) -> String {
    format!("{x:?}")
}

/// The attributes of a variable's type: unit, bounds and nominal value of element `i`.
pub(crate) fn type_attributes<M: Model>(
    row: &Variable<M>,
    i: usize,
) -> Vec<(&'static str, String)> {
    let mut attributes = Vec::new();
    let mut add = |name, value: Option<String>| attributes.extend(value.map(|value| (name, value)));
    let kind = row.storage.kind();
    let bound = |x: f64| {
        x.is_finite().then(|| match kind {
            Kind::Real => real(x),
            Kind::Float32 => (x as f32).to_xml(),
            _ => x.to_string(),
        })
    };
    let declared = row
        .enumeration
        .map(|e| e.name)
        .or(row.declared_type.map(|t| t.name));
    add("declaredType", declared.map(str::to_owned));
    add("unit", row.unit_of(i).map(str::to_owned));
    add("displayUnit", row.display_unit.map(str::to_owned));
    add("min", bound(row.min));
    if kind == Kind::Binary {
        add(
            "mimeType",
            Some(row.mime_type.to_owned()).filter(|text| !text.is_empty()),
        );
        add("maxSize", bound(row.max));
        return attributes;
    }
    add("max", bound(row.max));
    add("nominal", row.nominal.map(real));
    attributes
}

impl<M: Model> Variable<M> {
    pub(crate) fn variability(&self) -> &'static str {
        match self.causality {
            Causality::Constant => "constant",
            Causality::Parameter | Causality::CalculatedParameter if self.tunable => "tunable",
            Causality::Parameter | Causality::CalculatedParameter => "fixed",
            _ if self.storage.is_real() && !self.discrete => "continuous",
            _ => "discrete",
        }
    }

    /// The attributes `causality` and `initial`; inputs have no `initial`.
    pub(crate) fn causality_and_initial(&self) -> (&'static str, Option<&'static str>) {
        match self.causality {
            Causality::Constant => ("local", Some("exact")),
            _ if self.is_alias => ("local", Some("calculated")),
            Causality::Input => ("input", None),
            Causality::Output => ("output", Some("calculated")),
            Causality::Local => ("local", Some("calculated")),
            Causality::Parameter if self.structural => ("structuralParameter", Some("exact")),
            Causality::Parameter => ("parameter", Some("exact")),
            Causality::CalculatedParameter => ("calculatedParameter", Some("calculated")),
        }
    }

    /// The start values of an input, a parameter or a constant; computed variables have none.
    pub(crate) fn start_values<'a>(
        &self,
        p: &'a M::Parameters,
        u: &'a M::Input,
        y: &'a M::Output,
    ) -> Option<Values<'a>> {
        let is_constant = self.causality == Causality::Constant;
        let values = self.storage.values(p, u, y);
        values.filter(|_| is_constant || !self.storage.is_computed())
    }

    /// The start value of element `i` as text.
    pub(crate) fn start(
        &self,
        p: &M::Parameters,
        u: &M::Input,
        y: &M::Output,
        i: usize,
    ) -> Option<String> {
        match &self.storage {
            Storage::Text(get, _) => Some(get(p).to_owned()),
            _ => Some(each!(Values, self.start_values(p, u, y)?, |values| values
                [i]
                .to_xml())),
        }
    }
}
