//! A variable of a model description as its texts, which may be invalid, with the standard's
//! defaults, for `variables`, `structure`, `terminals`. `fmi_description` refuses what they report.

use fmi_description::Version;
use fmi_description::xml::Element;

/// Tags of the elements with the type of a variable of FMI 2.0.
const KINDS: [&str; 5] = ["Real", "Integer", "Boolean", "String", "Enumeration"];

pub struct Variable<'a> {
    pub name: &'a str,
    /// Value reference, as it is written.
    pub reference: &'a str,
    /// The element that says its type, which in FMI 3.0 is the variable itself.
    pub typed: &'a Element,
    pub causality: &'a str,
    pub variability: &'a str,
    /// `initial` or its default; empty if there is none.
    pub initial: &'a str,
    /// The element of the variable.
    pub element: &'a Element,
    pub declared: Option<DeclaredType<'a>>,
}

pub struct DeclaredType<'a> {
    /// Tag of the variables that may have this type.
    pub kind: &'a str,
    /// The element with its attributes and items.
    pub attributes: &'a Element,
}

impl<'a> Variable<'a> {
    pub fn all(root: &'a Element, version: Version) -> Vec<Self> {
        let read = |element| match version {
            Version::Fmi2 => Self::from_fmi2(root, element),
            Version::Fmi3 => Some(Self::from_fmi3(root, element)),
        };
        root.all_in("ModelVariables").filter_map(read).collect()
    }

    fn from_fmi2(root: &'a Element, element: &'a Element) -> Option<Self> {
        let kind = |e: &'a Element| e.children.iter().find(|c| KINDS.contains(&c.tag.as_str()));
        let typed = kind(element)?;
        let declared = typed.get("declaredType").and_then(|name| {
            let mut types = root.listed("TypeDefinitions", "SimpleType");
            let attributes = kind(types.find(|t| t.get("name") == Some(name))?)?;
            let kind = attributes.tag.as_str();
            Some(DeclaredType { kind, attributes })
        });
        Some(Self::new(element, typed, declared, Version::Fmi2))
    }

    fn from_fmi3(root: &'a Element, element: &'a Element) -> Self {
        let declared = element.get("declaredType").and_then(|name| {
            let mut types = root.all_in("TypeDefinitions");
            let attributes = types.find(|t| t.get("name") == Some(name))?;
            let kind = attributes.tag.as_str().strip_suffix("Type")?;
            Some(DeclaredType { kind, attributes })
        });
        Self::new(element, element, declared, Version::Fmi3)
    }

    fn new(
        element: &'a Element,
        typed: &'a Element,
        declared: Option<DeclaredType<'a>>,
        version: Version,
    ) -> Self {
        let causality = element.get("causality").unwrap_or("local");
        // The default in the schema of FMI 2.0 is continuous, also where it makes no sense.
        // Importers take other types as discrete, and parameters of both versions as fixed.
        let default = if causality.to_lowercase().ends_with("parameter") {
            "fixed"
        } else if is_float(typed) {
            "continuous"
        } else {
            "discrete"
        };
        let variability = element.get("variability").unwrap_or(default);
        Self {
            name: element.get("name").unwrap_or(""),
            reference: element.get("valueReference").unwrap_or("").trim(),
            typed,
            causality,
            variability,
            initial: element.get("initial").unwrap_or(default_initial(
                version,
                causality,
                variability,
            )),
            element,
            declared,
        }
    }

    /// Its name, and those of its aliases.
    pub fn names(&self) -> Vec<&'a str> {
        let aliases = self
            .element
            .all("Alias")
            .filter_map(|alias| alias.get("name"));
        std::iter::once(self.name).chain(aliases).collect()
    }

    /// Whether it belongs to clocks.
    pub fn is_clocked(&self) -> bool {
        self.element.get("clocks").is_some()
    }

    /// An attribute of its type element, else of its declared type.
    pub fn inherited(&self, attribute: &str) -> Option<&'a str> {
        let of_type = || self.declared.as_ref()?.attributes.get(attribute);
        self.typed.get(attribute).or_else(of_type)
    }

    /// The attribute as a number.
    pub fn number(&self, attribute: &str) -> Option<f64> {
        self.inherited(attribute)?.trim().parse().ok()
    }

    pub fn is_float(&self) -> bool {
        is_float(self.typed)
    }

    /// Whether an importer may set it.
    pub fn is_settable(&self) -> bool {
        matches!(self.causality, "input" | "parameter")
    }
}

fn is_float(typed: &Element) -> bool {
    matches!(typed.tag.as_str(), "Real" | "Float32" | "Float64")
}

/// The default of `initial`; empty if there is none.
fn default_initial(version: Version, causality: &str, variability: &str) -> &'static str {
    match (causality, variability) {
        ("parameter" | "structuralParameter", _) | ("output" | "local", "constant") => "exact",
        ("input", _) if version == Version::Fmi3 => "exact",
        ("input" | "independent", _) => "",
        _ => "calculated",
    }
}
