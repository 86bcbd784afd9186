//! On the sheet of `machine draw`: the legend, with the points' meanings and the machine's limits.

use plotters::prelude::*;

use super::sheet::{FONT, HEAD, Sheet};
use charts::{Area, DrawResult};
use experiments::machines::continuous_torque::ContinuousTorque;

impl Sheet {
    pub(super) fn legend<B: DrawingBackend>(&self, area: &Area<'_, B>) -> DrawResult<B> {
        area.draw(&Text::new("Points", (24, 8), HEAD.into_font()))?;
        let half = self.view.points.len().div_ceil(2);
        let [column, line] = [380, 24];
        for (k, point) in self.view.points.iter().enumerate() {
            let row = i32::try_from(k % half).unwrap_or(0);
            let x = 24 + if k < half { 0 } else { column };
            let [px, py] = point.place.map(|v| (1e3 * v).round());
            let text = format!("{}  {} ({px:.0}, {py:.0})", point.name, point.meaning);
            area.draw(&Text::new(text, (x, 40 + line * row), FONT.into_font()))?;
        }
        let limits = &self.machine.limits;
        let range = |i: usize| {
            format!(
                "{:.0}° to {:.0}°",
                limits.zeta_min_deg[i], limits.zeta_max_deg[i]
            )
        };
        let stroke = |[a, b]: [f64; 2]| format!("{:.0} to {:.0}", 1e3 * a, 1e3 * b);
        let stated = [
            format!("strokes: slew {}, lift {}, tilt {}", stroke(limits.stroke_1), stroke(limits.stroke_2), stroke(limits.stroke_3)),
            format!("joints: slew {}, lift {}, tilt {}, wrist {}, {}, {}", range(0), range(1), range(2), range(3), range(4), range(5)),
            format!(
                "wrist torques: {:.0}, {:.0}, {:.0} N·m; own weight of arm and wrist {:.0} kg",
                limits.tau_wrist_max[0], limits.tau_wrist_max[1], limits.tau_wrist_max[2], self.own_weight()
            ),
            self.continuous_torques(),
            "The payload's centre of mass is that of the machine file. Air of 40 °C. Statics only, whatever the structure bears.".into(),
        ];
        for (text, row) in stated.into_iter().zip(0..) {
            let y = 40 + line * i32::try_from(half).unwrap_or(0) + 16 + line * row;
            area.draw(&Text::new(text, (24, y), FONT.into_font()))?;
        }
        Ok(())
    }

    /// Torques that the motors may give continuously at standstill.
    fn continuous_torques(&self) -> String {
        let each = machine_file::AXES
            .into_iter()
            .zip(ContinuousTorque::from_machine(&self.machine));
        let each = each.map(|(axis, l)| format!("{:.1} N·m ({axis}, {})", l.torque, l.by));
        format!("lasting motor torques: {}", Vec::from_iter(each).join(", "))
    }

    /// Mass of all bodies but column and payload, kg.
    fn own_weight(&self) -> f64 {
        let bodies = self.machine.bodies.in_order();
        bodies[1..12].iter().map(|body| body.mass).sum()
    }
}
