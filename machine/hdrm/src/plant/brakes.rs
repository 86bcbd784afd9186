//! When the brakes of the wrist act, for `step` and the FMU's events: a commanded brake acts after
//! its closing time, a released one opens at once.

use crate::plant::Hdrm;
use crate::plant::input::Input;
use crate::plant::state::State;

/// Rounding of sums of steps, s.
pub(crate) const SLACK: f64 = 1e-9;

impl Hdrm {
    /// Whether no brake of the wrist is commanded or acts.
    pub(crate) fn is_unbraked(state: &State, input: &Input) -> bool {
        input.wrist_brake == [false; 3] && state.wrist.iter().all(|d| !d.holds && d.braked == 0.0)
    }

    /// The state after each brake was commanded as in `input` for a further `h` s: those whose
    /// closing time has passed act, released ones are open.
    #[must_use]
    pub fn after_braking(&self, mut state: State, input: &Input, h: [f64; 3]) -> State {
        for (i, drive) in state.wrist.iter_mut().enumerate() {
            if !input.wrist_brake[i] {
                (drive.holds, drive.braked) = (false, 0.0);
            } else if !drive.holds {
                drive.braked += h[i];
                if self.brake.awaited(drive) <= SLACK {
                    (drive.holds, drive.braked) = (true, 0.0);
                    if self.wrist.is_none() {
                        drive.angle = state.zeta[3 + i];
                    }
                }
            }
        }
        state
    }

    /// Time until each brake that is commanded acts, s; None where nothing is awaited.
    #[must_use]
    pub fn awaited_brakes(&self, state: &State, input: &Input) -> [Option<f64>; 3] {
        std::array::from_fn(|i| {
            let is_awaited = input.wrist_brake[i] && !state.wrist[i].holds;
            is_awaited.then(|| self.brake.awaited(&state.wrist[i]))
        })
    }
}
