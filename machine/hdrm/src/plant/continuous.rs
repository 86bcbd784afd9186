//! The equations for Model Exchange, where the importer of the FMU `Hdrm` integrates: derivatives
//! of the state, event indicators, and the state after an event.

use crate::DOF;
use crate::forces::wrist_drive::Slips;
use crate::plant::input::Input;
use crate::plant::state::State;
use crate::plant::{Dynamics, Hdrm};

/// Number of event indicators: end stops, the plane, gears and dry friction of the wrist's drives.
pub const INDICATORS: usize = DOF + 1 + 2 * 3;

/// Indicator of an event that cannot happen.
const NEVER: f64 = 1.0;

impl Hdrm {
    /// The time derivative of the state, per s; `slips` as in [`Hdrm::update_slips`].
    #[must_use]
    pub fn derivative(&self, now: &Dynamics, input: &Input, slips: &Slips) -> State {
        let mut rates = State {
            zeta: now.state.zeta_dot,
            zeta_dot: self.acceleration(now, input).into(),
            contact_loss: self.contact_force(now).dissipation,
            ..State::default()
        };
        if let Some(drive) = &self.wrist {
            for (i, rate) in rates.wrist.iter_mut().enumerate() {
                let torques = [self.wrist_command(input, i), self.brake.torque[i]];
                *rate = drive.rates(i, &now.state.wrist[i], torques, slips[i]);
            }
        } else {
            for (i, rate) in rates.wrist.iter_mut().enumerate() {
                let drive = &now.state.wrist[i];
                if drive.holds {
                    let joint = [now.state.zeta[3 + i], now.state.zeta_dot[3 + i]];
                    rate.angle = self.anchors[i].rate(drive, joint);
                }
            }
        }
        rates
    }

    /// Event indicators; an event is where one changes sign: distances of slew, lift and tilt (m)
    /// and of the wrist (rad) from their nearer end stop, and of the tip from the plane (m); for
    /// each gear of the wrist, how far it exceeds its backlash (rad); for each of its motors, the
    /// reserve of dry friction while it sticks (N·m), or the speed at which it slips (rad/s).
    #[must_use]
    pub fn indicators(&self, now: &Dynamics, input: &Input, slips: &Slips) -> [f64; INDICATORS] {
        let mut z = [NEVER; INDICATORS];
        let State { zeta, wrist, .. } = &now.state;
        for (i, z) in z[..DOF].iter_mut().enumerate() {
            *z = self.stops[i].distance(now.strokes.get(i).map_or(zeta[i], |stroke| stroke.x));
        }
        if let Some(plane) = &self.plane {
            z[DOF] = plane.height(&now.frame.tip_motion(&now.state.zeta_dot).0);
        }
        if let Some(drive) = &self.wrist {
            for i in 0..3 {
                let (state, joint) = (&wrist[i], zeta[3 + i]);
                z[DOF + 1 + i] = drive.beyond_play(state, joint).unwrap_or(NEVER);
                let torques = [self.wrist_command(input, i), self.brake.torque[i]];
                z[DOF + 4 + i] = drive
                    .friction_reserve(i, state, torques, slips[i])
                    .unwrap_or(NEVER);
            }
        }
        z
    }

    /// The state with the torques that the wrist's gears transmit.
    #[must_use]
    pub fn with_gear_torques(&self, mut state: State) -> State {
        if let Some(drive) = &self.wrist {
            for i in 0..3 {
                let joint = [state.zeta[3 + i], state.zeta_dot[3 + i]];
                state.wrist[i].transmitted = drive.transmitted(i, &state.wrist[i], joint);
            }
        }
        state
    }

    /// State and slip directions of the wrist's motors after an event; sticking motors are at rest.
    #[must_use]
    pub fn update_slips(&self, state: State, input: &Input, slips: &Slips) -> (State, Slips) {
        let (mut state, mut slips) = (self.with_gear_torques(state), *slips);
        if let Some(drive) = &self.wrist {
            for (i, slip) in slips.iter_mut().enumerate() {
                let torques = [self.wrist_command(input, i), self.brake.torque[i]];
                *slip = drive.next_slip(i, &mut state.wrist[i], torques, *slip);
            }
        }
        (self.with_gear_torques(state), slips)
    }
}
