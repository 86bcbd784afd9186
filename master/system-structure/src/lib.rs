//! Parses the XML files of the SSP standard into Rust types: system structures (`.ssd`), parameter
//! sets (`.ssv`), parameter mappings (`.ssm`) and signal dictionaries (`.ssb`). The co-simulation
//! master `cosim` uses it. The functions take texts: nothing here opens a file or knows FMUs.
//!
//! SSP 1.0 is read, and the FMI 3.0 types of SSP 2.0. Namespace prefixes are ignored, elements may
//! come in any order, and unknown content (geometry, annotations of other tools, comments) is
//! skipped. An error names the file, the line and the fault.
//!
//! ```
//! let text = r#"<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" version="1.0" name="S">
//!   <ssd:System name="S"><ssd:Elements><ssd:Component name="motor" source="resources/Motor.fmu"/></ssd:Elements></ssd:System>
//! </ssd:SystemStructureDescription>"#;
//! let structure = system_structure::SystemStructure::parse(text, "S.ssd").unwrap();
//! assert_eq!(structure.system.elements[0].name(), "motor");
//! ```
#![forbid(unsafe_code)]

mod connector;
mod description;
mod dictionary;
mod mapping;
pub mod osp;
mod parameters;
mod transformation;

pub use connector::{Connector, DataType, Direction};
pub use description::{
    Annotation, Component, Connection, DefaultExperiment, Element, End, Implementation, Kind,
    System, SystemStructure,
};
pub use dictionary::{DictionaryReference, SignalDictionary};
pub use mapping::{MappingEntry, ParameterMapping};
pub use parameters::{Binding, Parameter, ParameterSet, Sourced};
pub use transformation::Transformation;
