//! Cost of a sample of all sensors: `cargo bench -p sensors`.

#[path = "../../../tools/benches/measure.rs"]
mod measure;

use sensors::{ForceKind, Params, Sensors, Signals, SpeedKind};
use std::hint::black_box;

fn main() {
    let bench = measure::Bench::from_arguments();
    let mut on = Params::OFF;
    on.motor_encoder.on = true;
    on.joint_encoder.on = true;
    on.rod_encoder.on = true;
    on.joint_zero.on = true;
    on.current.on = true;
    on.speed.kind = SpeedKind::Observer;
    on.force.kind = ForceKind::Sensor;
    for (kind, p) in [("everything off", Params::OFF), ("everything on", on)] {
        let sensors = Sensors::new(p);
        let u = Signals::default();
        let mut s = sensors.start(&u);
        bench.call(&format!("sample of all sensors, {kind}"), || {
            let now = sensors.measure(&s, black_box(&u));
            sensors.advance(&mut s, &now, 1e-3);
            black_box(sensors.held(&s));
        });
    }
}
