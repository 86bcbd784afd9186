//! What the files of SSP say, typed: system structures (`.ssd`), parameter sets (`.ssv`), parameter
//! mappings (`.ssm`) and signal dictionaries (`.ssb`). Texts in, types out: nothing here opens a
//! file, and nothing knows FMUs.
//!
//! Read is SSP 1.0; of SSP 2.0 the types of FMI 3.0. Names of elements are compared without their
//! namespace prefix, elements may stand in every order, and what the standard does not name
//! (geometry, annotations of tools, comments) is passed over. An error names the file, the line and
//! what is wrong there.
//!
//! ```
//! let text = r#"<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" version="1.0" name="S">
//!   <ssd:System name="S"><ssd:Elements><ssd:Component name="motor" source="resources/Motor.fmu"/></ssd:Elements></ssd:System>
//! </ssd:SystemStructureDescription>"#;
//! let structure = system_structure::SystemStructure::parse(text, "S.ssd").unwrap();
//! assert_eq!(structure.system.elements[0].name(), "motor");
//! ```
#![forbid(unsafe_code)]

mod common;
mod connector;
mod description;
mod dictionary;
mod mapping;
mod parameters;

pub use common::{DataType, Transformation};
pub use connector::{Connector, Direction};
pub use description::{
    Annotation, Component, Connection, DefaultExperiment, Element, End, Kind, System,
    SystemStructure,
};
pub use dictionary::{DictionaryReference, SignalDictionary};
pub use mapping::{MappingEntry, ParameterMapping};
pub use parameters::{Binding, Parameter, ParameterSet, SourceBase, Sourced};
