//! Parameter values (SSP 1.0), written inside a system structure or in a file of their own (`.ssv`).

use anyhow::{Context, Result, bail};

use super::xml;

/// Start value of a variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name of the variable; in a set for a whole system `component.variable`.
    pub name: String,
    /// Value.
    pub value: String,
    /// Type in which it is given.
    pub data_type: &'static str,
    /// Unit of a real value.
    pub unit: Option<String>,
    /// Where the value stands, for messages.
    pub origin: String,
}

/// Read the text of the parameter set `file`.
pub fn parse_set(text: &str, file: &str) -> Result<Vec<Parameter>> {
    let origin = format!("parameter set `{file}`");
    let set: xml::Set = xml::read(text, "ParameterSet")
        .with_context(|| format!("{origin}: no readable SSP 1.0 parameter values"))?;
    values(set, "", &origin)
}

/// The values of all bindings of the element `owner`, in file order; `read` gives the text of a file that a binding names.
pub(super) fn bound(
    bindings: xml::Bindings,
    owner: &str,
    read: &mut dyn FnMut(&str) -> Result<String>,
) -> Result<Vec<Parameter>> {
    let mut found = Vec::new();
    for binding in bindings.bindings {
        let prefix = binding.prefix.as_deref().unwrap_or_default();
        if binding.mapping.is_some() {
            bail!("{owner}: parameter mappings are not supported");
        }
        match (binding.values, binding.source) {
            (Some(inline), None) => {
                found.extend(values(inline.set, prefix, "the system structure")?);
            }
            (None, Some(source)) => {
                if binding.source_base.is_some_and(|base| base != "SSD") {
                    bail!(
                        "{owner}: parameter set `{source}`: only sources relative to the system structure are supported"
                    );
                }
                let text = read(&source).with_context(|| format!("{owner}: parameter set"))?;
                let set = parse_set(&text, &source).with_context(|| owner.to_string())?;
                found.extend(set.into_iter().map(|p| Parameter {
                    name: format!("{prefix}{}", p.name),
                    ..p
                }));
            }
            _ => {
                bail!("{owner}: a parameter binding needs either a source or values, and not both")
            }
        }
    }
    Ok(found)
}

fn values(set: xml::Set, prefix: &str, origin: &str) -> Result<Vec<Parameter>> {
    set.parameters
        .parameters
        .into_iter()
        .map(|p| {
            let values = [
                ("Real", p.real),
                ("Integer", p.integer),
                ("Boolean", p.boolean),
                ("String", p.string),
                ("Enumeration", p.enumeration),
            ];
            let mut given = values.into_iter().filter_map(|(t, v)| v.map(|v| (t, v)));
            let (data_type, value) = given
                .next()
                .with_context(|| format!("{origin}: parameter `{}` has no value", p.name))?;
            Ok(Parameter {
                name: format!("{prefix}{}", p.name),
                value: value.value,
                data_type,
                unit: value.unit,
                origin: origin.to_string(),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SET: &str = r#"<ssv:ParameterSet xmlns:ssv="urn:ssv" version="1.0" name="x"><ssv:Parameters>
        <ssv:Parameter name="k"><ssv:Real value="2.5" unit="N/m"/></ssv:Parameter>
        <ssv:Parameter name="n"><ssv:Integer value="3"/></ssv:Parameter>
        <ssv:Parameter name="on"><ssv:Boolean value="true"/></ssv:Parameter>
        <ssv:Parameter name="file"><ssv:String value="a.json"/></ssv:Parameter>
        <ssv:Parameter name="mode"><ssv:Enumeration value="pd"/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet>"#;

    #[test]
    fn a_set_of_every_type_is_read() {
        let set = parse_set(SET, "x.ssv").unwrap();
        let found: Vec<_> = set
            .iter()
            .map(|p| (p.name.as_str(), p.value.as_str(), p.unit.as_deref()))
            .collect();
        assert_eq!(
            found,
            [
                ("k", "2.5", Some("N/m")),
                ("n", "3", None),
                ("on", "true", None),
                ("file", "a.json", None),
                ("mode", "pd", None)
            ]
        );
        assert!(set.iter().all(|p| p.origin == "parameter set `x.ssv`"));
    }

    #[test]
    fn what_is_no_set_is_refused_with_its_name() {
        let empty = SET.replace(r#"<ssv:Integer value="3"/>"#, "");
        for (text, expected) in [
            (empty.as_str(), "parameter `n` has no value"),
            ("<a/>", "no readable"),
            ("time,x\n0,1\n", "no XML"),
        ] {
            let error = format!("{:#}", parse_set(text, "x.ssv").unwrap_err());
            assert!(
                error.contains(expected) && error.contains("x.ssv"),
                "{error}"
            );
        }
    }
}
