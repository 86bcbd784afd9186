//! Force and rod speed along a profile over time: desired, of the rig, and of the network.

use emla::Surrogate;

use crate::measurement::windows::Window;

/// Two courses over time.
pub struct Panel {
    /// What it shows.
    pub title: &'static str,
    /// Unit of the values.
    pub unit: &'static str,
    /// Names, and points of time, s, and value.
    pub lines: [(&'static str, Vec<(f64, f64)>); 2],
}

/// Force and rod speed along a held-out profile: the rig against what was asked for, the network
/// against the rig.
pub fn responses(surrogate: &Surrogate, work: &[Window]) -> [Panel; 4] {
    let of =
        |value: &dyn Fn(&Window) -> f64| work.iter().map(|w| (w.t, value(w))).collect::<Vec<_>>();
    let network = |w: &Window| surrogate.evaluate(w.row.tau_e, w.row.w_m);
    let force = |title, name, other: &dyn Fn(&Window) -> f64| Panel {
        title,
        unit: "kN",
        lines: [
            ("rig", of(&|w| 1e-3 * w.row.f_ext)),
            (name, of(&|w| 1e-3 * other(w))),
        ],
    };
    let speed = |title, name, other: &dyn Fn(&Window) -> f64| Panel {
        title,
        unit: "mm/s",
        lines: [
            ("rig", of(&|w| 1e3 * w.row.x_dot)),
            (name, of(&|w| 1e3 * other(w))),
        ],
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
