//! Checks a path against a machine's limits, for `hdrm-fmu path` and the report: smallest margin of
//! each quantity, all margins along the path. `run_setup` reads path files with it.

use std::fmt::Write as _;

use anyhow::{Context, Result};
use machine_file::Machine;
use motion_check::{Kinematics, Quantity};
use serde_json::{Value, json};
use tip_path::{PathCheck, PathFile, Points, TipPath, check};

/// A path and its margins on a machine.
pub struct PathMargins {
    /// Name of the path.
    pub name: String,
    file: PathFile,
    path: TipPath,
    /// Result of the check.
    pub checked: PathCheck,
    /// Times at which it was checked, s.
    pub times: Vec<f64>,
    /// Share of the range that is left, in the order of [`Quantity::all`], for each time.
    pub parts: Vec<[f64; Quantity::COUNT]>,
}

/// Reads a path file, or a built-in path by its name.
pub fn read(name: &str) -> Result<PathFile> {
    if let Some(file) = PathFile::built_in(name) {
        return file.with_context(|| format!("path `{name}`"));
    }
    output_file::note_read(name.as_ref())?;
    let text = std::fs::read_to_string(name).with_context(|| {
        let built_in = tip_path::BUILT_IN.join(" and ");
        format!("file `{name}`; the built-in paths are {built_in}")
    })?;
    PathFile::parse(&text).with_context(|| format!("file `{name}`"))
}

impl PathMargins {
    /// Follows the path called `name` from the machine's start pose; margins may be exceeded.
    pub fn new(name: &str, machine: &Machine) -> Result<Self> {
        let file = read(name)?;
        let zeta = &machine.start.zeta;
        let start = Kinematics::new(machine)?.pose(zeta);
        let path = TipPath::new(&file, start).with_context(|| format!("path `{name}`"))?;
        let (mut times, mut parts) = (Vec::new(), Vec::new());
        let checked = check(&file, &path, machine, zeta, |t, margins| {
            times.push(t);
            parts.push(margins.map(|margin| margin.part()));
        })?;
        Ok(Self {
            name: name.into(),
            file,
            path,
            checked,
            times,
            parts,
        })
    }

    /// One line: number of points, duration, length and largest speed.
    pub fn description(&self) -> String {
        let (count, what) = match &self.file.points {
            Points::Waypoints(list) => (list.len(), "waypoints"),
            Points::Samples(list) => (list.len(), "samples"),
        };
        let duration = self.path.duration();
        let step = 1e-3_f64.max(duration / 1e5);
        let steps = (duration / step).ceil().max(1.0) as u32;
        let at = |k: u32| self.path.at(duration * f64::from(k) / f64::from(steps));
        let (mut length, mut speed) = (0.0, 0.0_f64);
        for k in 0..steps {
            length += (at(k + 1).pose.position - at(k).pose.position).norm();
            speed = speed.max(at(k).velocity.fixed_rows::<3>(0).norm());
        }
        format!(
            "path {}: {count} {what}, {duration:.3} s, {length:.3} m, up to {speed:.3} m/s\n",
            self.name
        )
    }

    /// Arrival and departure of each waypoint, and the loads.
    pub fn stops(&self) -> String {
        let mut text = String::new();
        if !self.path.stops().is_empty() {
            text += "waypoint        x, m      y, m      z, m   from, s       to, s  corner, mm  load, kg\n";
        }
        let Points::Waypoints(waypoints) = &self.file.points else {
            return text;
        };
        for (stop, waypoint) in self.path.stops().iter().zip(waypoints) {
            let p = self.path.at(stop.arrives).pose.position;
            let blend = 1e3 * waypoint.blend;
            let load = waypoint
                .load
                .map_or("".into(), |load| format!("{:.1}", load.mass));
            let _ = writeln!(
                text,
                "{:<10}{:>10.4}{:>10.4}{:>10.4}{:>10.3}{:>12.3}{blend:>12.0}{load:>10}",
                stop.waypoint, p.x, p.y, p.z, stop.arrives, stop.leaves
            );
        }
        text
    }

    /// Smallest margin of each quantity with its value, limits, time and place.
    pub fn table(&self) -> String {
        let mut text = "quantity                       value                 allowed   left, %      t, s  where\n"
            .to_owned();
        for (t, margin) in &self.checked.least {
            let (unit, per_si) = margin.quantity.unit();
            let [min, max] = margin.range.map(|end| end * per_si);
            let _ = writeln!(
                text,
                "{:<24}{:>12.2}{:>24}{:>10.1}{t:>10.2}  {}",
                margin.quantity.to_string(),
                margin.value * per_si,
                format!("{min:.1} to {max:.1} {unit}"),
                100.0 * margin.part(),
                self.path.place(*t)
            );
        }
        let [slew, lift, tilt] = self.checked.torque_rms;
        let _ = writeln!(
            text,
            "motor torque, root mean square: slew {slew:.2}, lift {lift:.2}, tilt {tilt:.2} N.m"
        );
        text
    }

    /// The numbers of [`Self::table`] for programs.
    pub fn json(&self) -> Value {
        let least = self.checked.least.iter().map(|(t, margin)| {
            json!({
                "quantity": margin.quantity.to_string(),
                "value": margin.value,
                "range": margin.range,
                "part": margin.part(),
                "t": t,
                "place": self.path.place(*t).to_string(),
            })
        });
        let findings = self.checked.findings.iter().map(ToString::to_string);
        json!({
            "path": self.name,
            "duration": self.path.duration(),
            "margins": least.collect::<Vec<_>>(),
            "motor_torque_rms": self.checked.torque_rms,
            "findings": findings.collect::<Vec<_>>(),
        })
    }
}
