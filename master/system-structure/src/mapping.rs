//! Parameter mappings (`.ssm`): they rename the parameters of a set for a component, and transform
//! their values. `cosim` also maps the variables of a replaced FMU by them.

use std::collections::HashSet;

use fmi_description::xml::{Element, XmlError};

use crate::transformation::Transformation;

/// A parameter mapping. Parameters that it does not name are not applied.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParameterMapping {
    /// Entries, in the order of the file.
    pub entries: Vec<MappingEntry>,
}

/// A parameter of the set and the variable it is applied to.
#[derive(Clone, Debug, PartialEq)]
pub struct MappingEntry {
    /// Name in the set.
    pub source: String,
    /// Name in the component or system.
    pub target: String,
    /// `suppressUnitConversion`: the value is not converted to the target's unit.
    pub keeps_units: bool,
    /// Transformation of the value.
    pub transformation: Option<Transformation>,
}

impl ParameterMapping {
    /// Read the text of a `.ssm`; `file` is its name for messages.
    pub fn parse(text: &str, file: &str) -> Result<Self, XmlError> {
        Self::read(&Element::parse(text, file, "ParameterMapping")?)
    }

    pub(crate) fn read(node: &Element) -> Result<Self, XmlError> {
        let (mut entries, mut targets) = (Vec::new(), HashSet::new());
        for entry in node.all("MappingEntry") {
            let target = entry.required("target")?;
            if !targets.insert(target.clone()) {
                return Err(entry.error(format!(
                    "two entries of the mapping have the target `{target}`"
                )));
            }
            entries.push(MappingEntry {
                source: entry.required("source")?,
                target,
                keeps_units: entry.flag("suppressUnitConversion")?,
                transformation: Transformation::read(entry)?,
            });
        }
        Ok(Self { entries })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_rename_and_transform() {
        let text = r#"<ssm:ParameterMapping xmlns:ssm="u" version="1.0"><ssm:MappingEntry source="a" target="b">
            <ssc:LinearTransformation factor="2" offset="1"/></ssm:MappingEntry>
            <ssm:MappingEntry source="a" target="c" suppressUnitConversion="true"><ssc:IntegerMappingTransformation>
            <ssc:MapEntry source="1" target="-2"/></ssc:IntegerMappingTransformation></ssm:MappingEntry></ssm:ParameterMapping>"#;
        let mapping = ParameterMapping::parse(text, "m.ssm").unwrap();
        let linear = Transformation::Linear {
            factor: 2.0,
            offset: 1.0,
        };
        assert_eq!(mapping.entries[0].transformation, Some(linear));
        assert_eq!(
            mapping.entries[1].transformation,
            Some(Transformation::Integers(vec![(1, -2)]))
        );
        assert!(mapping.entries[1].keeps_units && !mapping.entries[0].keeps_units);
        let twice = text.replace("target=\"c\"", "target=\"b\"");
        let error = ParameterMapping::parse(&twice, "m.ssm")
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("`m.ssm`, line 3: two entries of the mapping have the target `b`"),
            "{error}"
        );
    }
}
