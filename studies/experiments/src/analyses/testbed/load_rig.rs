//! Rigs that load actuators as built, nose to nose, and their force control: `replay` uses them.
#![allow(non_snake_case)] // the paper's symbols

use anyhow::Result;
use cosim::{Inputs, Master, Setting, Signals, System};
use emla::maps;
use machine_file::{Emla, Machine};
use surrogate::measurement::drive_control::{DriveControl, MotorReference, torque_per_ampere};

use super::axis::{inputs, ports};
use super::profile::Profile;

/// Components of the loading rigs, in the order of the axes.
const LOADS: [&str; 2] = ["load_lift", "load_tilt"];
/// Shortest time constant with which a loading rig's force follows, s: its speed control is hardly
/// faster.
const FASTEST: f64 = 0.01;

/// Stroke of a loading rig whose actuator is at `x`: nose to nose both screws together are one
/// screw long.
fn mirrored(p: &Emla, x: f64) -> f64 {
    p.L_s - x
}

/// Start values of both loading rigs.
pub(super) fn start(system: &System, profiles: &[Profile; 2]) -> Result<Vec<Setting>> {
    let (p, mut settings) = (Machine::reference().emla.lift, Vec::new());
    for (load, profile) in LOADS.into_iter().zip(profiles) {
        for (variable, value) in [
            ("x", mirrored(&p, profile.x[0])),
            ("x_dot", -profile.x_dot[0]),
            ("F_hold", profile.F[0]),
        ] {
            settings.push(system.setting(&format!("{load}.{variable}"), value)?);
        }
    }
    Ok(settings)
}

/// Both loading rigs.
pub(super) struct LoadRigs {
    rods: Inputs,
    voltages: Inputs,
    readings: Signals,
    drives: [Option<LoadDrive>; 2],
    /// The rigs as their control knows them.
    p: Emla,
    /// Time constant with which their force follows, s.
    lag: f64,
}

impl LoadRigs {
    pub(super) fn new(system: &System, lag: f64) -> Result<Self> {
        let names = |variables: &[&str]| -> Vec<String> {
            let all = |load| variables.iter().map(move |v| format!("{load}.{v}"));
            LOADS.into_iter().flat_map(all).collect()
        };
        Ok(Self {
            rods: inputs(system, &names(&["x", "x_dot"]))?,
            voltages: inputs(system, &names(&["v_d", "v_q"]))?,
            readings: Signals::new(system, &ports(system, &names(&["F", "i_d", "i_q", "w_m"]))?)?,
            drives: [None, None],
            p: Machine::reference().emla.lift,
            lag: lag.max(FASTEST),
        })
    }

    /// Moves the rigs with the rods, lets their control act for the next `h` s, and returns their
    /// forces on the rods.
    pub(super) fn press(
        &mut self,
        master: &Master,
        rod: [[f64; 3]; 2],
        wanted: [[f64; 4]; 2],
        h: f64,
    ) -> Result<[f64; 2]> {
        let mirrored = rod.map(|[x, x_dot, _]| [mirrored(&self.p, x), -x_dot]);
        self.rods.set(master, mirrored.as_flattened())?;
        let mut signals = [[0.0; 4]; 2];
        signals
            .as_flattened_mut()
            .copy_from_slice(self.readings.read(master)?);
        let mut v = [[0.0; 2]; 2];
        for axis in 0..2 {
            let [F, i_d, i_q, w_m] = signals[axis];
            let [x, x_dot] = mirrored[axis];
            let read = [F, i_d, i_q, w_m, x, x_dot];
            let [_, _, x_ddot, F] = wanted[axis];
            let (p, drive) = (&self.p, &mut self.drives[axis]);
            let drive = drive.get_or_insert_with(|| LoadDrive::holding(p, read));
            v[axis] = drive.command(p, [F, -x_ddot], read, self.lag, h);
        }
        self.voltages.set(master, v.as_flattened())?;
        Ok(signals.map(|[F, ..]| F))
    }
}

/// Signals that the control of a loading rig reads: force, N, currents i_d and i_q, A, motor speed,
/// rad/s, stroke, m, and its rate, m/s.
type Readings = [f64; 6];

/// Force control of a loading rig, over the control of its drive.
struct LoadDrive(DriveControl);

impl LoadDrive {
    /// A drive that holds the present state.
    fn holding(p: &Emla, [F, i_d, i_q, ..]: Readings) -> Self {
        let tau = torque_per_ampere(p) * i_q - maps::travel_per_radian(p) * F;
        Self(DriveControl::new(p, tau, [i_d, i_q]))
    }

    /// Voltages for the force `F_r` while the nut accelerates by `x_ddot`. The spring between nut and
    /// rod turns speed into force, so the commanded speed is the one with which the force follows
    /// with the time constant `lag`; the load of the drive is known beforehand:
    /// ```text
    /// K (ẋ_n − ẋ) = (F_r − F)/lag,   w = ẋ_n/ρ,   τ_load = ρ F_r
    /// ```
    fn command(
        &mut self,
        p: &Emla,
        [F_r, x_ddot]: [f64; 2],
        [F, i_d, i_q, w_m, x, x_dot]: Readings,
        lag: f64,
        h: f64,
    ) -> [f64; 2] {
        let travel = maps::travel_per_radian(p);
        let mount = rig::Extras::AS_BUILT.compliance.mount;
        let K = 1.0 / (1.0 / maps::stiffness(p, x) + 1.0 / mount);
        let x_dot = x_dot + (F_r - F) / (K * lag);
        let wanted = MotorReference {
            w: x_dot / travel,
            w_dot: x_ddot / travel,
            tau: travel * F_r,
        };
        self.0.command(p, wanted, [i_d, i_q], w_m, h)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rig::{Drive, Extras, Input, Rig};

    /// The force of a loading rig on a rod that stands follows a step as the law that its speed is
    /// commanded by: two thirds after the time constant, all of it in the end. It falls short by
    /// what its speed control, eight times as fast, and dry friction take: a tenth of the step at
    /// first, 2 % in the end.
    #[test]
    fn a_loading_rig_follows_its_force_with_the_lag() {
        let p = Machine::reference().emla.lift;
        let rig = Rig::new(p, Extras::AS_BUILT, Drive::Motion).expect("the reference machine");
        let (low, high, lag, h) = (20e3, 30e3, 0.05, 1e-4);
        let T = rig.extras().temperature.reference;
        let mut u = Input {
            v_dc: Some(650.0),
            T_ambient: T,
            x: 0.4,
            F_hold: low,
            ..Input::default()
        };
        let mut s = rig.start(&u, [T; 2]).expect("a start");
        let mut drive = None;
        let mut force = |time: f64, wanted: f64| {
            let mut F = 0.0;
            for k in 0..(time / h).round() as u32 {
                let y = rig.output(&s, &u);
                F = y.F;
                let read = [F, y.i_d, y.i_q, y.w_m, u.x, 0.0];
                let drive = drive.get_or_insert_with(|| LoadDrive::holding(&p, read));
                [u.v_d, u.v_q] = drive.command(&p, [wanted, 0.0], read, lag, h);
                s = rig.step(&s, &u, f64::from(k) * h, h).expect("a step");
            }
            F
        };
        let part = |F: f64| (F - low) / (high - low);
        assert!(part(force(0.1, low)).abs() < 0.02);
        let first = part(force(lag, high));
        assert!((first - 0.632).abs() < 0.1, "{first}");
        let last = part(force(10.0 * lag, high));
        assert!((last - 1.0).abs() < 0.02, "{last}");
    }
}
