//! What a `modelDescription.xml` of FMI 2.0 or 3.0 (co-simulation) says, typed, for importer,
//! master, check, `torture` and `cargo fmu`: identity, capabilities, variables, and the inputs that
//! outputs depend on. What both versions have is one type here. [`Archive`] opens the FMU itself.
//!
//! Other tools' FMUs are read as they are: in any encoding that is usual, with whatever their
//! vendors add. What is wrong by the standard but harmless becomes a [`Remark`].
//!
//! References to sections are to the specifications of FMI 2.0.4 and 3.0.1. Attributes that are
//! left out have the value that the specification gives them there, and what a variable leaves to
//! its declared type is filled in. An array of FMI 3.0 is one variable; [`Description::by_element`]
//! has a variable for each of its elements, as FMI 2.0 would.
//!
//! ```
//! let text = r#"<fmiModelDescription fmiVersion="2.0" modelName="Lag" guid="{1}">
//!   <CoSimulation modelIdentifier="Lag"/>
//!   <ModelVariables><ScalarVariable name="u" valueReference="0" causality="input"><Real unit="m" start="1"/></ScalarVariable></ModelVariables>
//!   <ModelStructure/>
//! </fmiModelDescription>"#;
//! let description = fmi_description::Description::parse(text).unwrap();
//! let u = description.variable("u").unwrap();
//! assert_eq!((u.unit.as_deref(), u.start_number()), (Some("m"), Some(1.0)));
//! ```
#![forbid(unsafe_code)]

mod archive;
mod dependencies;
mod description;
mod elements;
mod encoding;
pub mod entries;
mod error;
mod file;
mod fmi2;
mod fmi3;
pub mod limits;
mod parse;
pub mod platform;
mod remark;
mod unit;
mod variable;
pub mod xml;

pub use archive::{Archive, ArchiveError, library_among, unportable};
pub use description::{Capabilities, DefaultExperiment, Description, Interface, Unknown, Version};
pub use encoding::{EncodingError, text};
pub use entries::Entries;
pub use error::DescriptionError;
pub use remark::Remark;
pub use unit::Unit;
pub use variable::{
    Access, Causality, ClockInterval, ClockTiming, Initial, Item, Kind, Variability, Variable,
};
