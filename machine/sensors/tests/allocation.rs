//! A sample needs no heap.

use sensors::{Encoder, ForceKind, Params, Sensors, Signals, SpeedKind};

#[test]
fn measure_read_and_advance_do_not_allocate() {
    let mut p = Params::OFF;
    let on = |e: Encoder| Encoder { on: true, ..e };
    p.motor_encoder = on(p.motor_encoder);
    p.joint_encoder = on(p.joint_encoder);
    p.rod_encoder = on(p.rod_encoder);
    p.joint_zero.on = true;
    p.current.on = true;
    p.speed.kind = SpeedKind::Observer;
    p.force.kind = ForceKind::Sensor;
    p.delay = 2;
    let sensors = Sensors::new(p);
    let mut u = Signals::default();
    let mut state = sensors.start(&u);
    let mut sum = 0.0;
    let used = allocation_counter::measure(|| {
        for k in 0..100 {
            u.theta_m = [0.2 * f64::from(k); 3];
            let now = sensors.measure(&state, &u);
            sum += sensors.read(&state, &now).w_m[1] + sensors.held(&state).F[0];
            sensors.advance(&mut state, &now, 1e-3);
        }
    });
    assert_eq!(used.count_total, 0);
    assert!(sum > 0.0);
}
