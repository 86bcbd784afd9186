//! The axes beside their ratings as a verdict, a table and CSV.

use std::f64::consts::TAU;
use std::io::Write;

use cosim::verdict::Verdict;
use machine::Ratings;

use super::{Axis, Sizing};

/// Winding temperature that insulation of class F stands (IEC 60085: 155 °C), K.
pub(crate) const WINDING_LIMIT: f64 = 428.15;

impl Axis {
    /// What is told of it: name, unit, value, rating where there is one.
    fn rows(&self, ratings: &Ratings) -> [(&'static str, &'static str, f64, Option<f64>); 16] {
        let rpm = 60.0 / TAU;
        let t = &self.temperatures;
        [
            (
                "motor torque, rms",
                "N.m",
                self.torque.rms,
                Some(self.continuous),
            ),
            (
                "motor torque, peak",
                "N.m",
                self.torque.peak,
                Some(self.motor.peak(0.0)),
            ),
            ("motor speed, rms", "rpm", rpm * self.speed.rms, None),
            (
                "motor speed, peak",
                "rpm",
                rpm * self.speed.peak,
                Some(ratings.motor_speed_rpm),
            ),
            (
                "motor power, rms",
                "W",
                self.power.rms,
                Some(ratings.motor_power),
            ),
            ("motor power, peak", "W", self.power.peak, None),
            (
                "phase current, rms of the peak value",
                "A",
                self.current.rms,
                None,
            ),
            (
                "phase current, peak",
                "A",
                self.current.peak,
                Some(self.motor.current),
            ),
            ("rod force, rms", "N", self.force.rms, None),
            (
                "rod force, peak",
                "N",
                self.force.peak,
                Some(ratings.force_max),
            ),
            (
                "torque rms of what may last",
                "%",
                100.0 * self.torque.rms / self.continuous.max(1e-9),
                Some(100.0),
            ),
            (
                "rod force peak of the rating",
                "%",
                100.0 * self.force.peak / ratings.force_max,
                Some(100.0),
            ),
            (
                "beyond the peak envelope, of the time",
                "%",
                100.0 * self.beyond_peak,
                Some(0.0),
            ),
            (
                "winding, greatest in an hour",
                "degC",
                t.winding_max - 273.15,
                Some(WINDING_LIMIT - 273.15),
            ),
            ("winding after an hour", "degC", t.winding - 273.15, None),
            ("housing after an hour", "degC", t.housing - 273.15, None),
        ]
    }

    fn judge(&self, ratings: &Ratings, verdict: &mut Verdict) {
        for (name, unit, value, rating) in self.rows(ratings) {
            if let Some(rating) = rating
                && value > rating
            {
                verdict.object(format!(
                    "{}: {name} = {value:.4} {unit}, more than {rating:.4} {unit}",
                    self.actuator
                ));
            }
        }
    }
}

impl Sizing {
    /// What is beyond a rating.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        for axis in &self.axes {
            axis.judge(&axis.ratings, &mut verdict);
        }
        verdict
    }

    /// The axes as a table for people.
    pub fn text(&self, title: &str) -> String {
        let mut text = format!("{title}\n{:<44}", "over the motion: value (rating)");
        text += &self
            .axes
            .iter()
            .map(|a| format!("{:>24}", a.actuator))
            .collect::<String>();
        text += "\n";
        let rows: Vec<_> = self.axes.iter().map(|a| a.rows(&a.ratings)).collect();
        for n in 0..rows.first().map_or(0, |r| r.len()) {
            text += &format!("{:<44}", format!("{}, {}", rows[0][n].0, rows[0][n].1));
            for row in &rows {
                let rating = row[n].3.map_or(String::new(), |r| format!(" ({r:.1})"));
                text += &format!("{:>24}", format!("{:.2}{rating}", row[n].2));
            }
            text += "\n";
        }
        if self.axes.iter().any(|a| !a.is_own_heat) {
            text += "temperatures by typical heat capacities and resistances: the actuators tell of none\n";
        }
        if !self.payload.is_empty() {
            text += "sensitivity to the payload at the tip, change per kilogram (value)\n";
            text += &format!(
                "{:<14}{:>26}{:>26}{:>26}{:>26}\n",
                "", "power rms, W/kg", "force rms, N/kg", "energy, J/kg", "efficiency, %/kg"
            );
            for s in &self.payload {
                let cell =
                    |slope: f64, value: f64| format!("{:>26}", format!("{slope:.4} ({value:.2})"));
                let (d, m) = (&s.per_kg, &s.metrics);
                text += &format!("{:<14}", s.actuator);
                text +=
                    &(cell(d.power, m.power) + &cell(d.force, m.force) + &cell(d.energy, m.energy));
                text += &(cell(100.0 * d.efficiency, 100.0 * m.efficiency) + "\n");
            }
        }
        text
    }
}

/// A row of each quantity of each axis of each case.
pub fn write_csv(cases: &[(String, Sizing)], to: &mut impl Write) -> std::io::Result<()> {
    writeln!(to, "trajectory,actuator,quantity,unit,value,rating")?;
    for (case, sizing) in cases {
        for axis in &sizing.axes {
            for (name, unit, value, rating) in axis.rows(&axis.ratings) {
                let rating = rating.map_or(String::new(), |r| r.to_string());
                writeln!(
                    to,
                    "{case},{},\"{name}\",{unit},{value},{rating}",
                    axis.actuator
                )?;
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
