//! Variables of the testbed by their names.

use anyhow::Result;
use cosim::signals::Inputs;
use cosim::system::System;
use cosim::wiring::Port;

pub(super) fn inputs(testbed: &System, names: &[String]) -> Result<Inputs> {
    Inputs::new(testbed, &ports(testbed, names)?)
}

pub(super) fn ports(system: &System, names: &[String]) -> Result<Vec<Port>> {
    names.iter().map(|name| system.port(name)).collect()
}
