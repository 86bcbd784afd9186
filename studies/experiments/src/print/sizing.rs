//! Loads of motors and actuators compared with their ratings (`hdrm-fmu sizing`), as text and CSV.

use std::io;

use cosim::io::cells::cell;

use crate::analyses::sizing::Sizing;

/// A table with a column for each axis, then the sensitivity to the payload.
pub fn text(sizing: &Sizing, title: &str) -> String {
    let mut text = format!("{title}\n{:<44}", "over the motion: value (rating)");
    for axis in &sizing.axes {
        text += &format!("{:>24}", axis.actuator);
    }
    text += "\n";
    let rows: Vec<_> = sizing.axes.iter().map(|a| a.rows()).collect();
    for n in 0..rows.first().map_or(0, |r| r.len()) {
        text += &format!("{:<44}", format!("{}, {}", rows[0][n].0, rows[0][n].1));
        for row in &rows {
            let rating = row[n].3.map_or(String::new(), |r| format!(" ({r:.1})"));
            text += &format!("{:>24}", format!("{:.2}{rating}", row[n].2));
        }
        text += "\n";
    }
    if sizing.axes.iter().any(|a| !a.is_own_heat) {
        text +=
            "temperatures by typical heat capacities and resistances: the actuators tell of none\n";
    }
    if !sizing.payload.is_empty() {
        text += "sensitivity to the payload at the tip, change per kilogram (value)\n";
        text += "                         power rms, W/kg           force rms, N/kg              energy, J/kg          efficiency, %/kg\n";
        for s in &sizing.payload {
            let cell =
                |slope: f64, value: f64| format!("{:>26}", format!("{slope:.4} ({value:.2})"));
            let (d, m) = (&s.per_kg, &s.metrics);
            text += &format!("{:<14}", s.actuator);
            text += &(cell(d.power, m.power) + &cell(d.force, m.force) + &cell(d.energy, m.energy));
            text += &(cell(100.0 * d.efficiency, 100.0 * m.efficiency) + "\n");
        }
    }
    text
}

/// A row for each quantity of each axis of each case.
pub fn write_csv(cases: &[(String, Sizing)], to: &mut impl io::Write) -> io::Result<()> {
    writeln!(to, "trajectory,actuator,quantity,unit,value,rating")?;
    for (case, sizing) in cases {
        for axis in &sizing.axes {
            for (name, unit, value, rating) in axis.rows() {
                let rating = rating.map_or(String::new(), |r| r.to_string());
                let (case, actuator, name) = (cell(case), cell(&axis.actuator), cell(name));
                writeln!(to, "{case},{actuator},{name},{unit},{value},{rating}")?;
            }
        }
        for s in &sizing.payload {
            let d = &s.per_kg;
            for (name, unit, value) in [
                ("power rms by payload", "W/kg", d.power),
                ("force rms by payload", "N/kg", d.force),
                ("energy by payload", "J/kg", d.energy),
                ("efficiency by payload", "1/kg", d.efficiency),
            ] {
                writeln!(to, "{case},{},\"{name}\",{unit},{value},", s.actuator)?;
            }
        }
    }
    Ok(())
}
