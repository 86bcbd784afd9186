//! What the FMUs `Emla` and `Rig` share besides their variables: enumerations, terminals, resource
//! files, units, and the start values and bounds that their code reads as well.

use fmu_export::{File, Items, PackedFile, Terminal, Unit, read_placed_file};
use machine_file::{Drive, EmlaFields, Inscribed, Inscription, Machine};
use std::path::Path;
use std::sync::OnceLock;

/// Rod position before anyone sets it, m: inside every stroke of the reference machine.
pub const X_START: f64 = 0.3;
/// Largest magnitude of the rod position, m.
pub const X_LARGEST: f64 = 10.0;
/// 20 °C, K.
pub const ROOM_TEMPERATURE: f64 = 293.15;

/// Who moves the rod.
#[rustfmt::skip] // an item a line
pub static DRIVE: Items<Drive, 2> = Items::new("Drive", "who moves the rod", [
    (Drive::Motion, "motion", "a mechanism: the rod follows the inputs x and x_dot, F is the answer"),
    (Drive::Force, "force", "the actuator: the rod is a free mass against the input F_ext"),
]);

/// Indices into the machine's actuators, in their order.
#[rustfmt::skip] // an item a line
pub static AXIS: Items<usize, 3> = Items::new("Axis", "actuator of the machine", [
    (0, "slew", "turns the column"),
    (1, "lift", "lifts the boom"),
    (2, "tilt", "tilts the second boom"),
]);

/// Terminals of FMI 3.0.
#[rustfmt::skip]
pub const TERMINALS: &[Terminal] = &[
    Terminal::new("rod", "io.github.hdrm-fmu.rod", "mechanical bond: the rod moves as told, and pushes with F", &[
        ("x", "x"), ("x_dot", "x_dot"), ("F", "F"), ("F_mean", "F_mean"), ("F_hold", "F_hold"),
    ]),
    Terminal::new("dc", "io.github.hdrm-fmu.dc-link", "electrical bond: the DC link that the drive draws from", &[
        ("v_dc", "v_dc"), ("i_dc", "i_dc"),
    ]),
    Terminal::new("voltages", "io.github.hdrm-fmu.voltages", "voltages that the controller commands", &[
        ("v_d", "v_d"), ("v_q", "v_q"),
    ]),
    Terminal::new("measurements", "io.github.hdrm-fmu.measurements", "what can be measured of the drive", &[
        ("i_d", "i_d"), ("i_q", "i_q"), ("theta_m", "theta_m"), ("w_m", "w_m"), ("F", "F"), ("x", "x_rod"), ("x_dot", "x_rod_dot"),
    ]).bus(),
];

/// The reference machine among [`RESOURCES`].
pub const REFERENCE: PackedFile = PackedFile::new(
    "reference_machine.json",
    machine_file::REFERENCE_JSON.as_bytes(),
);
const SIZED: PackedFile =
    PackedFile::new("sized_machine.json", machine_file::SIZED_JSON.as_bytes());

/// Machine files in the FMU's `resources` folder.
#[rustfmt::skip] // an item a line
pub const RESOURCES: &[File] = &[
    File { path: REFERENCE.path, bytes: machine_file::REFERENCE_JSON.as_bytes() },
    File { path: SIZED.path, bytes: machine_file::SIZED_JSON.as_bytes() },
];

/// Units of the loss coefficients.
pub const UNITS: &[Unit] = &[
    Unit::new("W.s/(rad.Wb2)").kg(-1).m(-2).s(2).A(2).rad(-1),
    Unit::new("W.s2/(rad2.Wb2)").kg(-1).m(-2).s(3).A(2).rad(-2),
    Unit::new("J/(V.A)").s(1),
];

/// Where `hdrm-fmu machine pack` writes a machine into the library.
#[used]
static PLACE: Inscription = Inscription::empty();

/// The machine that is written into the library, if any.
fn inscribed() -> Option<&'static Inscribed> {
    static READ: OnceLock<Option<Inscribed>> = OnceLock::new();
    let read = || Some(PLACE.read()?.expect("a machine that was checked"));
    READ.get_or_init(read).as_ref()
}

/// The library's own machine: the reference machine, or the one that is written into it.
pub fn own_machine() -> Machine {
    inscribed().map_or_else(Machine::reference, |own| own.machine.clone())
}

/// Name of the machine that is written into the library.
pub fn own_name() -> Option<&'static str> {
    inscribed().map(|own| &*own.name)
}

/// The machine of a file, or the shipped machine of that name: where that is among
/// [`RESOURCES`], the one in the folder counts. Without a name the library's own.
pub fn machine(file: &str, resources: Option<&Path>) -> Result<Machine, String> {
    if file.is_empty() {
        return Ok(own_machine());
    }
    let Some(shipped) = Machine::preset(file) else {
        return read_placed_file(file, resources, Machine::from_text);
    };
    let edited = match file {
        // In the place of that file is the machine that is written into the library.
        "reference" if inscribed().is_some() => None,
        "reference" => REFERENCE.if_edited(resources, Machine::from_text)?,
        "sized" => SIZED.if_edited(resources, Machine::from_text)?,
        _ => None,
    };
    Ok(edited.unwrap_or(shipped))
}

/// The section `emla` of the actuator number `axis` (an item of [`AXIS`]) in a machine file, or in
/// the shipped machine of that name.
pub fn read_machine(file: &str, axis: i32, resources: Option<&Path>) -> Result<EmlaFields, String> {
    let machine = machine(file, resources)?;
    let place = AXIS.item(axis).map_err(|error| error.to_string())?;
    Ok(EmlaFields::new(*machine.emla.in_order()[place]))
}
