//! Force and rod speed along a profile over time: desired, of the rig, and of the network.

use emla::Surrogate;

use crate::windows::Window;

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
    let [force, speed] = [of(&|w| 1e-3 * w.row.f_ext), of(&|w| 1e3 * w.row.x_dot)];
    [
        Panel {
            title: "Force: desired and rig",
            unit: "kN",
            lines: [
                ("rig", force.clone()),
                ("desired", of(&|w| 1e-3 * w.desired[1])),
            ],
        },
        Panel {
            title: "Rod speed: desired and rig",
            unit: "mm/s",
            lines: [
                ("rig", speed.clone()),
                ("desired", of(&|w| 1e3 * w.desired[0])),
            ],
        },
        Panel {
            title: "Force: network and rig",
            unit: "kN",
            lines: [("rig", force), ("network", of(&|w| 1e-3 * network(w).F))],
        },
        Panel {
            title: "Rod speed: network and rig",
            unit: "mm/s",
            lines: [("rig", speed), ("network", of(&|w| 1e3 * network(w).x_dot))],
        },
    ]
}
