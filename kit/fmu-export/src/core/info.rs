//! Name, experiment, files and abilities of a model: authors set, `core` and `c_api` read them.

use super::log::{Categories, MOST_CATEGORIES};
use super::setters::setters;
use fmi_units::Unit;

/// Model-wide facts for `modelDescription.xml` and the packer.
///
/// Built as a constant: `Info::new("Oscillator", "…").version(env!("CARGO_PKG_VERSION"))`.
#[derive(Clone, Copy, Debug)]
pub struct Info {
    pub(crate) model: &'static str,
    pub(crate) name_after: Option<fn() -> Option<&'static str>>,
    pub(crate) description: &'static str,
    pub(crate) version: &'static str,
    pub(crate) author: &'static str,
    pub(crate) copyright: &'static str,
    pub(crate) license: &'static str,
    pub(crate) experiment: Experiment,
    pub(crate) documentation: &'static [File],
    pub(crate) icon: &'static [u8],
    pub(crate) resources: &'static [File],
    pub(crate) made_resources: &'static [MadeFile],
    pub(crate) units: &'static [Unit],
    pub(crate) log_categories: Categories,
    pub(crate) input_derivatives: bool,
    pub(crate) output_derivatives: bool,
    pub(crate) directional_derivatives: bool,
    pub(crate) early_return: bool,
    pub(crate) tolerance: Option<f64>,
    pub(crate) terminals: &'static [Terminal],
}

impl Info {
    /// `model` is modelName and modelIdentifier: a C identifier that names the library in the FMU.
    pub const fn new(model: &'static str, description: &'static str) -> Self {
        Self {
            model,
            name_after: None,
            description,
            version: "",
            author: "",
            copyright: "",
            license: "",
            experiment: Experiment {
                start: 0.0,
                stop: 1.0,
                step: 1e-3,
            },
            documentation: &[],
            icon: &[],
            resources: &[],
            made_resources: &[],
            units: &[],
            log_categories: &[],
            input_derivatives: false,
            output_derivatives: false,
            directional_derivatives: false,
            early_return: false,
            tolerance: None,
            terminals: &[],
        }
    }

    /// The model's own name: that after which it is named, if there is one.
    pub(crate) fn own_name(&self) -> Option<&'static str> {
        self.name_after.and_then(|name| name())
    }

    setters! {
        /// Where this returns a name, modelName is that of the model, `_` and that name: for a library
        /// that is altered after it was built.
        named_after(name: fn() -> Option<&'static str>) name_after = Some(name);

        /// Version of the model, usually `env!("CARGO_PKG_VERSION")`. Saved states are tied to it.
        version(version: &'static str) version = version;

        /// Author as written into the model description.
        author(author: &'static str) author = author;

        /// Copyright line as written into the model description.
        copyright(copyright: &'static str) copyright = copyright;

        /// Licence as written into the model description.
        license(license: &'static str) license = license;

        /// Default experiment: start, stop and communication step, all s.
        experiment(start: f64, stop: f64, step: f64) experiment = Experiment { start, stop, step };

        /// Files for the FMU's `documentation/` folder, one of them `index.html`.
        documentation(files: &'static [File]) documentation = files;

        /// The icon (`model.png`), usually `include_bytes!("../model.png")`.
        icon(png: &'static [u8]) icon = png;

        /// Files for the FMU's `resources/` folder.
        resources(files: &'static [File]) resources = files;

        /// More files for the `resources/` folder, whose content is generated.
        made_resources(files: &'static [MadeFile]) made_resources = files;

        /// Units beyond (or instead of) those that [`Unit::find`] reads.
        units(units: &'static [Unit]) units = units;
    }

    /// The model's own log categories ([`Log`](crate::Log)), at most 28: name and description.
    pub const fn log_categories(
        mut self,
        categories: &'static [(&'static str, &'static str)],
    ) -> Self {
        assert!(
            categories.len() <= MOST_CATEGORIES,
            "a model has at most 28 categories of messages"
        );
        self.log_categories = categories;
        self
    }

    setters! {
        /// Declare that [`Model::step`](crate::Model::step) evaluates the inputs within the step.
        /// Without it, input derivatives are accepted and have no effect.
        with_input_derivatives() input_derivatives = true;

        /// Declare that [`Model::output_derivative`](crate::Model) is implemented.
        with_output_derivatives() output_derivatives = true;

        /// Declare that [`Model::directional_derivative`](crate::Model) is implemented.
        with_directional_derivatives() directional_derivatives = true;

        /// Declare that [`Model::step`](crate::Model::step) may stop before the end of a step
        /// ([`StepEnd::reached`](crate::StepEnd::reached)).
        with_early_return() early_return = true;

        /// Declare that a solver chooses its steps by a tolerance: the importer's, or this default.
        with_tolerance(tolerance: f64) tolerance = Some(tolerance);

        /// Groups of variables to connect together, for FMI 3.0.
        terminals(terminals: &'static [Terminal]) terminals = terminals;
    }
}

/// Default experiment, s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Experiment {
    pub(crate) start: f64,
    pub(crate) stop: f64,
    pub(crate) step: f64,
}

/// A file that is embedded in the library and written into the FMU by the packer.
#[derive(Clone, Copy, Debug)]
pub struct File {
    /// Path inside the folder it belongs to, with `/`, e.g. `index.html`.
    pub path: &'static str,
    /// Its content, usually `include_bytes!(…)`.
    pub bytes: &'static [u8],
}

/// A file whose content is generated when the FMU is packed.
#[derive(Clone, Copy, Debug)]
pub struct MadeFile {
    /// As in [`File`].
    pub path: &'static str,
    /// Makes its content.
    pub make: fn() -> Vec<u8>,
}

/// A group of variables to connect together, which FMI 3.0 describes in `terminalsAndIcons.xml`.
///
/// ```
/// # use fmu_export::Terminal;
/// const ROD: Terminal = Terminal::new("rod", "org.example.bond", "rod that moves a load", &[("x", "x"), ("x_dot", "x_dot"), ("F", "F")]);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Terminal {
    pub(crate) name: &'static str,
    pub(crate) kind: &'static str,
    pub(crate) description: &'static str,
    pub(crate) matching_rule: &'static str,
    pub(crate) members: &'static [(&'static str, &'static str)],
    /// The FMU simulates the bus of the terminal.
    #[cfg(feature = "can")]
    pub(crate) is_of_bus: bool,
}

impl Terminal {
    /// `kind` is a name with a reversed domain, the same at both ends of a connection; `members`
    /// are (name, variable). A vector is one member; if its elements have different units, each is
    /// one (`w[1]`). Members with the same name are connected.
    pub const fn new(
        name: &'static str,
        kind: &'static str,
        description: &'static str,
        members: &'static [(&'static str, &'static str)],
    ) -> Self {
        Self {
            name,
            kind,
            description,
            matching_rule: "plug",
            members,
            #[cfg(feature = "can")]
            is_of_bus: false,
        }
    }

    /// A bus: members with the same name are connected, others may be missing.
    pub const fn bus(mut self) -> Self {
        self.matching_rule = "bus";
        self
    }

    /// A connection to a CAN network by FMI-LS-BUS ([`can`](crate::can)): its members are the
    /// variables `name.Rx_Data`, `Rx_Clock`, `Tx_Data` and `Tx_Clock`, and `name.BusNotifications`
    /// if there is one. The FMU has the manifest of the layered standard then.
    #[cfg(feature = "can")]
    pub const fn can(name: &'static str, description: &'static str) -> Self {
        let mut terminal = Self::new(name, CAN_KIND, description, &[]);
        terminal.matching_rule = "org.fmi-ls-bus.transceiver";
        terminal
    }

    /// The FMU simulates the bus of this terminal, and is no node of it: `isBusSimulationFMU`.
    #[cfg(feature = "can")]
    pub const fn of_bus_simulation(mut self) -> Self {
        self.is_of_bus = true;
        self
    }

    #[cfg(feature = "can")]
    pub(crate) fn is_can(&self) -> bool {
        self.kind == CAN_KIND
    }
}

/// `terminalKind` of a network.
#[cfg(feature = "can")]
const CAN_KIND: &str = "org.fmi-ls-bus.network-terminal";
