//! State of the FMU `DcLink`, and its warnings about limits and voltages, for its FMI calls.

use dclink::{DcLink, Input, Params, Regime, Seconds, State};
use fmu_export::Log;
use serde::{Deserialize, Serialize};

/// The FMU's instance: DC link, state and log.
#[derive(Clone, Serialize, Deserialize)]
pub struct DcLinkFmu {
    pub(crate) link: DcLink,
    pub(crate) state: State,
    pub(crate) log: Log,
    /// State at the last check for warnings in Model Exchange.
    #[serde(skip)]
    pub(crate) seen: Option<State>,
}

impl DcLinkFmu {
    /// Logs warnings for conditions that hold in `after` but not in `before`.
    pub(crate) fn warn(&mut self, u: &Input, before: &State, after: &State, t: f64) {
        let Params { v_min, v_max, .. } = *self.link.params();
        let now = self.link.output(after);
        let (v, i, soc) = (now.v_dc, now.i_battery, now.soc);
        let (load, t) = (u.load(), Seconds(t));
        let discharges = |s: &State| s.mode.ready && s.mode.regime == Regime::Discharging;
        if discharges(after) && !discharges(before) && load > i {
            self.log.warning(
                "",
                format_args!("t = {t} s: the pack gives no more than {i:.4} A at soc = {soc:.4}, the drives draw {load:.4} A: v_dc falls"),
            );
        }
        if now.undervoltage && before.v_c >= v_min {
            self.log.warning(
                "",
                format_args!(
                    "t = {t} s: undervoltage, v_dc = {v:.2} V must be at least v_min = {v_min} V; the pack gives {i:.4} A at soc = {soc:.4}, \
                     the drives draw {load:.4} A"
                ),
            );
        }
        if v > v_max && before.v_c <= v_max {
            self.log.warning(
                "",
                format_args!(
                    "t = {t} s: overvoltage, v_dc = {v:.2} V must be at most v_max = {v_max} V; the drives give back {:.4} A, the pack takes \
                     {:.4} A and the brake resistor {:.0} W",
                    -load, -i, now.P_brake
                ),
            );
        }
    }
}
