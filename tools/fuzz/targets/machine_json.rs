//! A machine that is read makes models that are built, or says why not; nothing panics.
#![no_main]

use libfuzzer_sys::fuzz_target;
use machine_file::Machine;

fuzz_target!(|text: &str| {
    let Ok(machine) = Machine::from_json(text) else {
        return;
    };
    let _ = hdrm::Hdrm::new(&machine, &hdrm::Options::from_machine(&machine));
    for actuator in [machine.emla.slew, machine.emla.lift, machine.emla.tilt] {
        let _ = emla::Emla::new(actuator, machine_file::Drive::Motion);
    }
    let _ = vdc::tip_pose(&machine, &machine.start.zeta);
});
