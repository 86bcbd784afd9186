//! Reads a system structure of SSP into the flat system that the master runs ([`Structure`]), and
//! loads its FMUs ([`system`]), for programs, Python and pages.

mod alarm;
pub(crate) mod arrays;
mod bond;
mod flat;
mod flatten;
mod interfaces;
pub mod osp;
pub mod package;
pub(crate) mod renaming;
pub mod system;
pub(crate) mod units;
mod values;
mod ways;

pub use alarm::Alarm;
pub use bond::{Power, PowerBond};
pub use flat::{Component, Connection, FmuUse, Hop, OuterInput, OuterOutput, Parameter, Structure};
pub(crate) use flatten::check_mime_types;
pub use flatten::read;
pub use system_structure::DataType;
pub(crate) use values::parse_set;

#[cfg(test)]
mod tests {
    use anyhow::{Result, bail};

    use super::*;

    /// Read a structure that names no parameter sets or other files with texts.
    fn parse(text: &str) -> Result<Structure> {
        read(text, package::DEFAULT, &mut |source| {
            bail!("the file `{source}` is not at hand")
        })
    }

    const REPOSITORY: &str = include_str!("../../../system/SystemStructure.ssd");

    #[test]
    fn the_repository_system_is_read_whole() {
        let s = parse(REPOSITORY).unwrap();
        let names: Vec<_> = s.components.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["controller", "emla_1", "emla_2", "emla_3", "hdrm"]);
        // 3 actuators × (3 motion + 1 force + 4 measurements + 2 voltages) + 12 joint + 3 rod
        // measurements + 3 torques
        assert_eq!(s.connections.len(), 3 * 10 + 12 + 3 + 3);
        let with_bond: Vec<_> = s.connections.iter().filter(|c| c.bond.is_some()).collect();
        let bonds: Vec<_> = with_bond.iter().map(ToString::to_string).collect();
        assert_eq!(
            bonds,
            [
                "emla_1.F -> hdrm.f[1]",
                "emla_2.F -> hdrm.f[2]",
                "emla_3.F -> hdrm.f[3]"
            ]
        );
        let bond = PowerBond {
            step_mean: "F_mean".into(),
            flow: "x_dot".into(),
            power: Power::Delivered,
        };
        assert!(with_bond.iter().all(|c| c.bond.as_ref() == Some(&bond)));
        assert_eq!((s.start_time, s.stop_time), (0.0, Some(24.25)));
    }

    fn connector(name: &str, kind: &str) -> String {
        format!(r#"<ssd:Connector name="{name}" kind="{kind}"><ssc:Real/></ssd:Connector>"#)
    }

    fn element(name: &str, source: &str, connectors: &[(&str, &str)], more: &str) -> String {
        let connectors: String = connectors.iter().map(|(n, k)| connector(n, k)).collect();
        format!(
            r#"<ssd:Component name="{name}" {source}><ssd:Connectors>{connectors}</ssd:Connectors>{more}</ssd:Component>"#
        )
    }

    fn fmu(name: &str, more: &str) -> String {
        let connectors = [("u", "input"), ("y", "output"), ("k", "parameter")];
        element(name, r#"source="F.fmu""#, &connectors, more)
    }

    fn link(start: &str, end: &str, content: &str) -> String {
        let end_of = |text: &str, which: &str| match text.split_once('.') {
            Some((element, connector)) => {
                format!(r#"{which}Element="{element}" {which}Connector="{connector}""#)
            }
            None => format!(r#"{which}Connector="{text}""#),
        };
        let (start, end) = (end_of(start, "start"), end_of(end, "end"));
        format!("<ssd:Connection {start} {end}>{content}</ssd:Connection>")
    }

    fn system(connectors: &[(&str, &str)], more: &str, elements: &str, links: &str) -> String {
        let connectors: String = connectors.iter().map(|(n, k)| connector(n, k)).collect();
        format!(
            r#"<ssd:Connectors>{connectors}</ssd:Connectors>{more}<ssd:Elements>{elements}</ssd:Elements>
            <ssd:Connections>{links}</ssd:Connections>"#
        )
    }

    fn file(system: &str) -> String {
        format!(
            r#"<ssd:SystemStructureDescription xmlns:ssd="d" xmlns:ssc="c" xmlns:ssv="v" version="1.0" name="s">
            <ssd:System name="s">{system}</ssd:System></ssd:SystemStructureDescription>"#
        )
    }

    fn bound(source: &str) -> String {
        format!(
            r#"<ssd:ParameterBindings><ssd:ParameterBinding {source}/></ssd:ParameterBindings>"#
        )
    }

    fn set(name: &str, value: &str) -> String {
        format!(
            r#"<ssv:ParameterSet version="1.0" name="x"><ssv:Parameters><ssv:Parameter name="{name}"><ssv:Real value="{value}"/>
            </ssv:Parameter></ssv:Parameters></ssv:ParameterSet>"#
        )
    }

    fn values(c: &Component) -> Vec<String> {
        let all = c.parameters.iter();
        all.map(|p| format!("{}={}", p.name, p.value)).collect()
    }

    fn connections(s: &Structure) -> Vec<String> {
        s.connections.iter().map(ToString::to_string).collect()
    }

    const TWICE: &str = r#"<ssc:LinearTransformation factor="2"/>"#;

    /// a.y goes through the input of a nested system, and of one in that, to two components; each
    /// connection may transform it.
    #[test]
    fn nested_systems_are_resolved_to_paths() {
        let innermost = format!(
            r#"<ssd:System name="deep">{}</ssd:System>"#,
            system(
                &[("v", "input")],
                "",
                &fmu("c", ""),
                &link("v", "c.u", TWICE)
            )
        );
        let links = link("w", "b.u", "") + &link("w", "deep.v", TWICE) + &link("b.y", "z", "");
        let inner = system(
            &[("w", "input"), ("z", "output")],
            "",
            &(fmu("b", "") + &innermost),
            &links,
        );
        let inner = format!(r#"<ssd:System name="in">{inner}</ssd:System>"#);
        // The ends of a connection stand in either order.
        let links = link("in.w", "a.y", "") + &link("in.z", "a.u", "");
        let s = parse(&file(&system(&[], "", &(inner + &fmu("a", "")), &links))).unwrap();
        let names: Vec<_> = s.components.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["in.b", "in.deep.c", "a"]);
        assert_eq!(
            connections(&s),
            ["a.y -> in.deep.c.u", "a.y -> in.b.u", "in.b.y -> a.u"]
        );
        let hops = &s.connections[0].way;
        let doubled = hops
            .iter()
            .filter(|hop| hop.transformation.is_some())
            .count();
        assert_eq!((hops.len(), doubled), (3, 2));
        assert_eq!(s.split("in.deep.c.k"), Some((1, "k")));
    }

    #[test]
    fn connectors_of_the_outer_system_are_its_inputs_and_outputs() {
        let links = link("x", "a.u", TWICE) + &link("x", "b.u", "") + &link("b.y", "out", "");
        let outer = [("x", "input"), ("out", "output"), ("idle", "input")];
        let text = file(&system(&outer, "", &(fmu("a", "") + &fmu("b", "")), &links));
        let s = parse(&text).unwrap();
        assert!(s.connections.is_empty());
        let ends: Vec<_> = s.inputs[0]
            .ends
            .iter()
            .map(|(end, way)| (end.0.as_str(), way.len()))
            .collect();
        assert_eq!(
            (s.inputs.len(), s.inputs[0].name.as_str(), ends),
            (1, "x", vec![("a", 1), ("b", 1)])
        );
        assert_eq!(s.outputs[0].start, ("b".into(), "y".into()));
    }

    #[test]
    fn signals_of_a_dictionary_connect_across_systems() {
        let bus = |name: &str, connectors: &str| {
            format!(
                r#"<ssd:SignalDictionaryReference name="{name}" dictionary="Bus"><ssd:Connectors>{connectors}</ssd:Connectors>
                </ssd:SignalDictionaryReference>"#
            )
        };
        let signal = connector("f", "inout");
        let inner = system(
            &[],
            "",
            &(fmu("b", "") + &bus("here", &signal)),
            &link("here.f", "b.u", ""),
        );
        let inner = format!(r#"<ssd:System name="in">{inner}</ssd:System>"#);
        let elements = inner + &fmu("a", "") + &bus("there", &signal);
        let dictionary = r#"<ssd:SignalDictionaries><ssd:SignalDictionary name="Bus"><ssb:SignalDictionary version="1.0">
            <ssb:DictionaryEntry name="f"><ssc:Real/></ssb:DictionaryEntry></ssb:SignalDictionary></ssd:SignalDictionary>
            </ssd:SignalDictionaries>"#;
        let text = file(&system(
            &[],
            dictionary,
            &elements,
            &link("a.y", "there.f", ""),
        ));
        assert_eq!(connections(&parse(&text).unwrap()), ["a.y -> in.b.u"]);
        let lost = parse(&text.replace("name=\"Bus\"", "name=\"Other\"")).unwrap_err();
        assert!(
            format!("{lost:#}").contains("refers to the signal dictionary `Bus`"),
            "{lost:#}"
        );
    }

    /// Values of the outer element are applied last, so they count; within an element the later
    /// binding counts. Names of a set may be prefixed and mapped.
    #[test]
    fn the_outer_binding_counts() {
        let bindings = r#"<ssd:ParameterBindings><ssd:ParameterBinding source="k1"/><ssd:ParameterBinding source="k2"/></ssd:ParameterBindings>"#;
        let inner = system(
            &[("p", "parameter")],
            &bound(r#"source="a.k3""#),
            &fmu("a", bindings),
            &link("p", "a.k", TWICE),
        );
        let inner = format!(r#"<ssd:System name="in">{inner}</ssd:System>"#);
        let mapped = r#"<ssd:ParameterBindings><ssd:ParameterBinding prefix="in." source="a.k4"/>
            <ssd:ParameterBinding source="in.p"/><ssd:ParameterBinding source="old"><ssd:ParameterMapping><ssm:ParameterMapping version="1.0">
            <ssm:MappingEntry source="old" target="in.a.k"><ssc:LinearTransformation factor="10"/></ssm:MappingEntry>
            </ssm:ParameterMapping></ssd:ParameterMapping></ssd:ParameterBinding><ssd:ParameterBinding source="nowhere"/></ssd:ParameterBindings>"#;
        let text = file(&system(&[], mapped, &inner, ""));
        let s = read(&text, "s.ssd", &mut |source| {
            Ok(match source {
                "k1" => set("k", "1"),
                "k2" => set("k", "2"),
                "a.k3" => set("a.k", "3"),
                "a.k4" => set("a.k", "4"),
                "in.p" => set("in.p", "5"),
                "old" => set("old", "6"),
                other => set(other, "7"),
            })
        })
        .unwrap();
        assert_eq!(
            values(&s.components[0]),
            ["k=1", "k=2", "k=3", "k=4", "k=5", "k=6"]
        );
        let ways: Vec<_> = s.components[0]
            .parameters
            .iter()
            .map(|p| p.way.len())
            .collect();
        assert_eq!(
            ways,
            [0, 0, 0, 0, 1, 1],
            "the connection from p, and the mapping"
        );
        assert_eq!(s.unmatched, ["`nowhere` (parameter set `nowhere`)"]);
        let missing = parse(&text).unwrap_err();
        assert!(
            format!("{missing:#}").contains("component `in.a`: parameter set"),
            "{missing:#}"
        );
    }

    #[test]
    fn structures_and_packages_in_other_files_are_systems() {
        let inner = [("w", "input"), ("z", "output")];
        let part = |kind: &str, name: &str| {
            element(
                name,
                &format!(r#"source="parts/{name}" type="application/x-ssp-{kind}""#),
                &inner,
                "",
            )
        };
        let links = link("p.ssp.z", "d.w", "").replace("p.ssp.z", "p.z");
        let links = links.replace(
            "startElement=\"p\" startConnector=\"ssp.z\"",
            "startElement=\"p\" startConnector=\"z\"",
        );
        let elements = part("definition", "d") + &part("package", "p");
        let links = links + &link("d.z", "p.w", "");
        let nested = file(&system(
            &inner,
            "",
            &fmu("a", ""),
            &(link("w", "a.u", "") + &link("a.y", "z", "")),
        ));
        let mut asked = Vec::new();
        let s = read(
            &file(&system(&[], "", &elements, &links)),
            "s.ssd",
            &mut |source| {
                asked.push(source.to_string());
                Ok(nested.clone())
            },
        )
        .unwrap();
        assert_eq!(asked, ["parts/d", "parts/p/SystemStructure.ssd"]);
        let sources: Vec<_> = s.components.iter().map(|c| c.source.as_str()).collect();
        assert_eq!(sources, ["parts/F.fmu", "parts/p/F.fmu"]);
        assert_eq!(connections(&s), ["p.a.y -> d.a.u", "d.a.y -> p.a.u"]);
        let endless = file(&system(&[], "", &part("definition", "d"), ""));
        let error = read(&endless, "s.ssd", &mut |_| Ok(endless.clone())).unwrap_err();
        assert!(
            format!("{error:#}").contains("nested deeper than 16"),
            "{error:#}"
        );
    }

    /// Files that each name the next one ten times.
    #[test]
    fn a_system_that_multiplies_itself_is_refused() {
        let file_of = |next: u32| {
            let kind = r#"type="application/x-ssp-definition""#;
            let one = |k| {
                element(
                    &format!("e{k}"),
                    &format!(r#"source="{next}.ssd" {kind}"#),
                    &[],
                    "",
                )
            };
            file(&system(&[], "", &(0..10).map(one).collect::<String>(), ""))
        };
        let error = read(&file_of(1), "s.ssd", &mut |source| {
            let number: u32 = source.trim_end_matches(".ssd").parse()?;
            Ok(match number {
                12 => file(&system(&[], "", "", "")),
                _ => file_of(number + 1),
            })
        });
        let error = format!("{:#}", error.unwrap_err());
        let expected =
            "the system has more than 10000 elements, connectors, connections and values";
        assert!(error.contains(expected), "{error}");
    }

    #[test]
    fn wrong_connections_are_named_with_their_line() {
        let text = |links: &str| {
            file(&system(
                &[("x", "input")],
                "",
                &(fmu("a", "") + &fmu("b", "")),
                links,
            ))
        };
        for (links, expected) in [
            (
                link("a.y", "c.u", ""),
                "`SystemStructure.ssd`, line 3: a connection names the component `c`",
            ),
            (
                link("a.q", "b.u", ""),
                "component `a` declares no connector `q`",
            ),
            (
                link("b.u", "a.u", ""),
                "connector `b.u` is declared as input",
            ),
            (
                link("b.y", "a.y", ""),
                "connector `a.y` is declared as output",
            ),
            (link("a.y", "x", ""), "connector `x` is declared as input"),
            (
                link("a.y", "b.u", "") + &link("b.y", "b.u", ""),
                "input b.u is driven twice, by a.y and by b.y",
            ),
            (
                link("a.y", "b.u", "<ssc:BooleanMappingTransformation/>"),
                "a BooleanMappingTransformation is for Boolean connectors; these are Real",
            ),
        ] {
            let error = format!("{:#}", parse(&text(&links)).unwrap_err());
            assert!(error.contains(expected), "{error}");
        }
    }
}
