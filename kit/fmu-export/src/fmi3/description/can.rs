//! What FMI-LS-BUS adds to the files of an FMU, for `description`: the members of a terminal of a
//! CAN network, and the manifest of the layered standard.

use crate::Model;
use crate::c_api::description::Element;
use crate::can::MIME_TYPE;
use crate::core::info::Terminal;
use crate::core::layout::Layout;

/// Path of the manifest.
pub(super) const MANIFEST: &str = "extra/org.fmi-standard.fmi-ls-bus/fmi-ls-manifest.xml";

const MEMBERS: [&str; 4] = ["Rx_Data", "Rx_Clock", "Tx_Data", "Tx_Clock"];
const NOTIFICATIONS: &str = "BusNotifications";

/// The first mistake in the terminals of networks: each has a received and a sent Binary with their
/// clocks, and each Binary of a network a terminal.
pub(super) fn check<M: Model>(layout: &Layout<M>) -> Result<(), String> {
    for terminal in M::INFO.terminals.iter().filter(|t| t.is_can()) {
        if M::SCHEDULED_EXECUTION {
            return Err(format!(
                "terminal `{}` is one of CAN, and `SCHEDULED_EXECUTION` is set: each partition would replace the frames that the one \
                 before has sent; leave one of the two out",
                terminal.name
            ));
        }
        for member in MEMBERS {
            let name = variable(terminal, member);
            if !layout.blocks().any(|(_, (span, ..))| span.row.name == name) {
                return Err(format!(
                    "terminal `{}`: there is no variable `{name}`; a CanInput, a CanOutput and `can_clocks!` of this name make it",
                    terminal.name
                ));
            }
        }
    }
    for row in M::variables()
        .iter()
        .filter(|row| row.mime_type == MIME_TYPE)
    {
        let mut networks = M::INFO.terminals.iter().filter(|t| t.is_can());
        if !networks.any(|t| MEMBERS.iter().any(|member| variable(t, member) == row.name)) {
            return Err(format!(
                "`{}` belongs to no terminal: name it by `Terminal::can` in `Info::terminals`",
                row.name
            ));
        }
    }
    Ok(())
}

/// The members of a terminal, made by `member` of their names and variables, and the terminal of
/// its configuration; none if it is no network's.
pub(super) fn members<M: Model>(
    terminal: &Terminal,
    member: impl Fn(&str, &str) -> Element,
) -> Vec<Element> {
    if !terminal.is_can() {
        return Vec::new();
    }
    let member = |name| member(name, &variable(terminal, name));
    let mut all = Vec::from(MEMBERS.map(member));
    let notifications = variable(terminal, NOTIFICATIONS);
    if M::variables().iter().any(|row| row.name == notifications) {
        let attributes = [
            ("name", "Configuration"),
            ("matchingRule", "bus"),
            (
                "terminalKind",
                "org.fmi-ls-bus.network-terminal.configuration",
            ),
        ];
        let configuration = Element::new("Terminal").with(attributes);
        all.push(configuration.holding([member(NOTIFICATIONS)]));
    }
    all
}

/// The name of the variable that is this member.
fn variable(terminal: &Terminal, member: &str) -> String {
    format!("{}.{member}", terminal.name)
}

/// The text of the manifest; None if the model has no terminal of a network.
pub(super) fn manifest<M: Model>() -> Result<Option<String>, String> {
    let networks = M::INFO.terminals.iter().filter(|t| t.is_can());
    let Some(is_bus) = networks.map(|t| t.is_of_bus).reduce(|a, b| a || b) else {
        return Ok(None);
    };
    let attributes = [
        ("xmlns:fmi-ls", "http://fmi-standard.org/fmi-ls-manifest"),
        ("fmi-ls:fmi-ls-name", "org.fmi-standard.fmi-ls-bus"),
        ("fmi-ls:fmi-ls-version", "1.0.0"),
        (
            "fmi-ls:fmi-ls-description",
            "Layered Standard for the simulation of bus communication on a Physical Signal Abstraction or Network Abstraction based level.",
        ),
        ("isBusSimulationFMU", if is_bus { "true" } else { "false" }),
    ];
    let root = Element::new("fmiLayeredStandardManifest").with(attributes);
    root.file().map(Some)
}
