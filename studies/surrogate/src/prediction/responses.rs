//! Force and rod speed along a held-out profile over time, desired, of the rig and of the network,
//! for the report and the pictures of `surrogate compare`.

use emla::Surrogate;

use crate::measurement::windows::Window;

/// Two lines over time.
pub struct Panel {
    /// Title of the panel.
    pub title: &'static str,
    /// Unit of the values.
    pub unit: &'static str,
    /// Names, and points of time, s, and value.
    pub lines: [(&'static str, Vec<(f64, f64)>); 2],
}

/// Compares the rig with the desired motion and load, and the network with the rig.
pub fn responses(surrogate: &Surrogate, work: &[Window]) -> [Panel; 4] {
    let line = |factor: f64, value: &dyn Fn(&Window) -> f64| {
        let points = work.iter().map(|w| (w.t, factor * value(w)));
        points.collect::<Vec<_>>()
    };
    let network = |w: &Window| surrogate.evaluate(w.row.tau_e, w.row.w_m);
    let panel = |title, unit, rig, other| Panel {
        title,
        unit,
        lines: [("rig", rig), other],
    };
    let force = |title, name, other: &dyn Fn(&Window) -> f64| {
        let rig = line(1e-3, &|w| w.row.f_ext);
        panel(title, "kN", rig, (name, line(1e-3, other)))
    };
    let speed = |title, name, other: &dyn Fn(&Window) -> f64| {
        let rig = line(1e3, &|w| w.row.x_dot);
        panel(title, "mm/s", rig, (name, line(1e3, other)))
    };
    [
        force("Force: desired and rig", "desired", &|w| w.desired[1]),
        speed("Rod speed: desired and rig", "desired", &|w| w.desired[0]),
        force("Force: network and rig", "network", &|w| network(w).F),
        speed("Rod speed: network and rig", "network", &|w| {
            network(w).x_dot
        }),
    ]
}
