//! A machine on one sheet, as crane makers print it: side view with named points and dimensions, workspace, load chart.

use std::path::Path;

use anyhow::Result;
use hdrm::Tree;
use machine::Machine;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::load_chart::{LoadChart, Place};
use super::side_view::SideView;
use crate::report::chart::{Area, Drawn, Picture, wheel, write};

/// Size of the sheet, of a view, of the title, pixels.
const SHEET: (u32, u32) = (1640, 1240);
const TITLE: u32 = 56;
const SPLIT: (u32, u32) = (820, 700);
const FONT: (&str, i32) = ("sans-serif", 15);
const SMALL: (&str, i32) = ("sans-serif", 13);
const HEAD: (&str, i32) = ("sans-serif", 20);
/// First digits of the payload from one colour to the next.
const STEPS: [f64; 3] = [1.0, 2.0, 5.0];
/// Bands of payload in the chart.
const BANDS: usize = 7;
/// Classes of reach for the lower curves.
const CLASSES: usize = 60;

type Chart<'a, B> = ChartContext<'a, B, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// What is drawn.
pub struct Sheet {
    name: String,
    machine: Machine,
    view: SideView,
    chart: LoadChart,
    /// Lower ends of the bands, kg, rising.
    bands: Vec<f64>,
}

impl Sheet {
    /// Of a machine that people know as `name`.
    ///
    /// # Errors
    /// A mechanism that does not close.
    pub fn new(name: &str, machine: Machine, chart: LoadChart) -> Result<Self> {
        let tree = Tree::new(&machine)?;
        let view = SideView::new(&tree, &machine.start.zeta);
        let greatest = chart.places().filter_map(|p| p.payload).fold(0.0, f64::max);
        Ok(Self {
            name: name.into(),
            view,
            bands: bands(greatest),
            machine,
            chart,
        })
    }

    /// Write it as SVG or PNG, as the file is called.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, file: &Path) -> Result<()> {
        write(self, file, SHEET)
    }

    /// Colour of a payload.
    fn color(&self, payload: Option<f64>) -> RGBColor {
        let Some(payload) = payload else {
            return RGBColor(190, 190, 190);
        };
        let band = self
            .bands
            .iter()
            .rposition(|low| payload >= *low)
            .unwrap_or(0);
        #[expect(clippy::cast_precision_loss, reason = "a few bands")]
        let part = band as f64 / (BANDS - 1) as f64;
        let (r, g, b) = HSLColor(0.02 + 0.36 * part, 0.55, 0.72 - 0.22 * part).rgb();
        RGBColor(r, g, b)
    }
}

/// Multiples of a round payload that part the range up to `greatest` into at most [`BANDS`], from 0 on.
fn bands(greatest: f64) -> Vec<f64> {
    let rounds = (0..6).flat_map(|power| STEPS.map(|step| step * 10.0_f64.powi(power)));
    let most = BANDS as f64;
    let step = rounds.into_iter().find(|step| most * step >= greatest);
    let step = step.unwrap_or(greatest / most);
    let bands = (0..BANDS).map(|k| step * k as f64);
    bands.filter(|low| *low == 0.0 || *low < greatest).collect()
}

impl Picture for Sheet {
    fn draw<B: DrawingBackend>(&self, area: &Area<'_, B>) -> Drawn<B> {
        area.fill(&WHITE)?;
        let (title, rest) = area.split_vertically(TITLE);
        let start = self.machine.start.zeta.map(f64::to_degrees);
        title.draw(&Text::new(self.name.clone(), (24, 8), HEAD.into_font()))?;
        let stated = format!(
            "start pose: lift {:.0}°, tilt {:.0}°, tool {:.0}° over the horizontal; lengths in mm; actuators rated for {}",
            start[1],
            start[2],
            self.chart.tool.to_degrees(),
            self.rated()
        );
        title.draw(&Text::new(stated, (24, 34), FONT.into_font()))?;
        let (upper, lower) = rest.split_vertically(SPLIT.1);
        let (side, loads) = upper.split_horizontally(SPLIT.0);
        let (legend, reach) = lower.split_horizontally(SPLIT.0);
        self.side(&side)?;
        self.loads(&loads)?;
        self.legend(&legend)?;
        self.over_reach(&reach)
    }
}

impl Sheet {
    fn rated(&self) -> String {
        let ratings = self.machine.ratings.in_order();
        let each = machine::AXES.into_iter().zip(ratings);
        let each = each.map(|(axis, r)| format!("{:.0} kN ({axis})", r.force_max / 1e3));
        Vec::from_iter(each).join(", ")
    }

    /// Equal scales for both axes around everything in `places`.
    fn frame<'a, B: DrawingBackend>(
        area: &Area<'a, B>,
        caption: &str,
        places: impl Iterator<Item = [f64; 2]> + Clone,
    ) -> std::result::Result<Chart<'a, B>, DrawingAreaErrorKind<B::ErrorType>> {
        let range = |k: usize| {
            let values = places.clone().map(|p| p[k]);
            let low = values.clone().fold(0.0, f64::min);
            (low, values.fold(low, f64::max))
        };
        let (width, height) = area.dim_in_pixel();
        let [inner_x, inner_y] = [f64::from(width) - 90.0, f64::from(height) - 100.0];
        let [(x0, x1), (y0, y1)] = [range(0), range(1)];
        let metres = (1.1 * (x1 - x0) / inner_x).max(1.1 * (y1 - y0) / inner_y);
        let around = |(low, high): (f64, f64), pixels: f64| {
            let middle = 0.5 * (low + high);
            let half = 0.5 * metres * pixels;
            middle - half..middle + half
        };
        let mut chart = ChartBuilder::on(area)
            .caption(caption, FONT)
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(60)
            .build_cartesian_2d(around((x0, x1), inner_x), around((y0, y1), inner_y))?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.1))
            .x_desc("distance from the slew axis, m")
            .y_desc("height over the base, m")
            .label_style(SMALL)
            .axis_desc_style(FONT)
            .draw()?;
        Ok(chart)
    }

    fn side<B: DrawingBackend>(&self, area: &Area<'_, B>) -> Drawn<B> {
        let places = self.view.points.iter().map(|point| point.place);
        let mut chart = Self::frame(area, "Side view at the start pose", places)?;
        let at = |name: &str| self.view.at(name);
        let (boom, link, rod) = (
            RGBColor(200, 140, 20),
            RGBColor(120, 120, 130),
            RGBColor(60, 110, 170),
        );
        let lines: [(&[&str], RGBColor, u32); 6] = [
            (&["T1", "O"], RGBColor(90, 90, 90), 9),
            (&["O", "B"], boom, 7),
            (&["O", "P"], boom, 4),
            (&["B", "A4"], boom, 7),
            (&["A", "D", "C"], link, 3),
            (&["A4", "C4", "D4", "T4"], RGBColor(90, 90, 90), 4),
        ];
        for (names, color, width) in lines {
            let points = names.iter().map(|name| at(name)).map(|[x, y]| (x, y));
            chart.draw_series(LineSeries::new(points, color.stroke_width(width)))?;
        }
        for (pivot, on) in [("A", "B"), ("E", "B"), ("C", "B"), ("F", "O")] {
            dashed(&mut chart, at(pivot), at(on), link)?;
        }
        for (foot, pin, inner) in [("F", "P", self.view.rods[0]), ("E", "D", self.view.rods[1])] {
            let (foot, pin) = (at(foot), at(pin));
            let line = |a: [f64; 2], b: [f64; 2]| [(a[0], a[1]), (b[0], b[1])];
            chart.draw_series(LineSeries::new(line(inner, pin), rod.stroke_width(3)))?;
            chart.draw_series(LineSeries::new(
                line(foot, middle(inner, pin)),
                rod.stroke_width(8),
            ))?;
        }
        let mut labels = Labels::default();
        for point in &self.view.points {
            let (x, y) = (point.place[0], point.place[1]);
            chart.draw_series([Circle::new((x, y), 4, WHITE.filled())])?;
            chart.draw_series([Circle::new((x, y), 4, BLACK.stroke_width(1))])?;
        }
        for point in &self.view.points {
            labels.add(
                &chart,
                point.place,
                point.name,
                &RGBColor(150, 0, 0),
                HEAD.1,
            )?;
        }
        let told = |(from, to, _): &([f64; 2], [f64; 2], _)| distance(*from, *to) > 1e-3;
        for (from, to, name) in self.dimensions().into_iter().filter(told) {
            let text = format!("{name} {:.0}", 1e3 * distance(from, to));
            labels.add(
                &chart,
                middle(from, to),
                &text,
                &RGBColor(20, 60, 130),
                SMALL.1,
            )?;
        }
        Ok(())
    }

    /// Ends and names of the lengths that the side view tells.
    fn dimensions(&self) -> Vec<([f64; 2], [f64; 2], &'static str)> {
        [
            ("T1", "O", "T1–O"),
            ("O", "P", "L1_2"),
            ("O", "F", "L2_2"),
            ("F", "P", "x_2 + x0_2"),
            ("O", "B", "O–B"),
            ("B", "A", "B–A"),
            ("B", "E", "B–E"),
            ("B", "C", "B–C"),
            ("A", "D", "d4"),
            ("C", "D", "d5"),
            ("E", "D", "x_3 + x0_3"),
            ("B", "A4", "B–A4"),
            ("A4", "C4", "A4–C4"),
            ("C4", "D4", "C4–D4"),
            ("D4", "T4", "D4–T4"),
        ]
        .map(|(from, to, name)| (self.view.at(from), self.view.at(to), name))
        .into()
    }

    fn loads<B: DrawingBackend>(&self, area: &Area<'_, B>) -> Drawn<B> {
        let places = || self.chart.places().map(|p| [p.reach, p.height]);
        let all = places().chain([[0.0, 0.0]]).collect::<Vec<_>>();
        let caption = format!(
            "Workspace and greatest payload at rest; dynamic factor {}",
            self.chart.factor
        );
        let mut chart = Self::frame(area, &caption, all.into_iter())?;
        for rows in self.chart.rows.windows(2) {
            for (low, high) in rows[0].windows(2).zip(rows[1].windows(2)) {
                let [Some(a), Some(b), Some(c), Some(d)] = [low[0], low[1], high[1], high[0]]
                else {
                    continue;
                };
                let corners = [a, b, c, d].map(|p| (p.reach, p.height));
                let payloads = [a, b, c, d].map(|p| p.payload);
                let least = payloads.into_iter().collect::<Option<Vec<_>>>();
                let least = least.map(|values| values.into_iter().fold(f64::INFINITY, f64::min));
                let color = self.color(least);
                chart.draw_series([Polygon::new(corners, color.filled())])?;
                chart.draw_series([PathElement::new(
                    [corners[0], corners[1], corners[2], corners[3], corners[0]],
                    color.stroke_width(1),
                )])?;
            }
        }
        for [from, to] in [["T1", "O"], ["O", "B"], ["B", "A4"], ["A4", "T4"]] {
            let line = [self.view.at(from), self.view.at(to)].map(|[x, y]| (x, y));
            chart.draw_series(LineSeries::new(line, BLACK.mix(0.5).stroke_width(2)))?;
        }
        for (k, low) in self.bands.iter().enumerate() {
            let text = match self.bands.get(k + 1) {
                Some(high) => format!("{low:.0} to {high:.0} kg"),
                None => format!("{low:.0} kg and more"),
            };
            legend_entry(&mut chart, &text, self.color(Some(*low)))?;
        }
        if self.chart.places().any(|p| p.payload.is_none()) {
            legend_entry(&mut chart, "cannot hold itself", self.color(None))?;
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.3))
            .label_font(SMALL)
            .draw()
    }

    fn legend<B: DrawingBackend>(&self, area: &Area<'_, B>) -> Drawn<B> {
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
            "The payload's centre of mass is that of the machine file. Statics only, whatever the structure bears.".into(),
        ];
        for (text, row) in stated.into_iter().zip(0..) {
            let y = 40 + line * i32::try_from(half).unwrap_or(0) + 16 + line * row;
            area.draw(&Text::new(text, (24, y), FONT.into_font()))?;
        }
        Ok(())
    }

    /// Mass of all bodies but column and payload, kg.
    fn own_weight(&self) -> f64 {
        let bodies = self.machine.bodies.in_order();
        bodies[1..12].iter().map(|body| body.mass).sum()
    }

    /// Payload over reach: the greatest at any height, coloured by what limits it, and the one that holds at every height.
    fn over_reach<B: DrawingBackend>(&self, area: &Area<'_, B>) -> Drawn<B> {
        let classes = self.classes();
        let last = classes.iter().map(|c| c.best.reach).fold(0.0, f64::max);
        let greatest = classes
            .iter()
            .filter_map(|c| c.best.payload)
            .fold(1.0, f64::max);
        let mut chart = ChartBuilder::on(area)
            .caption("Greatest payload over reach", FONT)
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(60)
            .build_cartesian_2d(0.0..1.05 * last, 0.0..1.1 * greatest)?;
        chart
            .configure_mesh()
            .max_light_lines(2)
            .light_line_style(BLACK.mix(0.05))
            .bold_line_style(BLACK.mix(0.12))
            .x_desc("distance of the tip from the slew axis, m")
            .y_desc("payload, kg")
            .label_style(SMALL)
            .axis_desc_style(FONT)
            .draw()?;
        let anywhere = classes.iter().map(|c| (c.best.reach, c.least));
        let gray = RGBColor(110, 110, 110);
        chart
            .draw_series(LineSeries::new(anywhere, gray.stroke_width(2)))?
            .label("at every height that is reached")
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], gray.stroke_width(2)));
        let mut limits: Vec<_> = Vec::new();
        for class in &classes {
            if !limits.contains(&class.best.limit) {
                limits.push(class.best.limit);
            }
        }
        for (k, limit) in limits.iter().enumerate() {
            let color = wheel(k, limits.len());
            let of_limit = classes.iter().filter(|c| c.best.limit == *limit);
            let dots = of_limit.map(|c| {
                Circle::new(
                    (c.best.reach, c.best.payload.unwrap_or(0.0)),
                    4,
                    color.filled(),
                )
            });
            chart
                .draw_series(dots)?
                .label(format!("at the best height, limited by {limit}"))
                .legend(move |(x, y)| Circle::new((x + 9, y), 4, color.filled()));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.3))
            .label_font(SMALL)
            .draw()
    }

    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_sign_loss,
        clippy::cast_possible_truncation,
        reason = "some tens"
    )]
    fn classes(&self) -> Vec<Class> {
        let last = self.chart.places().map(|p| p.reach).fold(0.0, f64::max);
        let mut classes: Vec<Option<Class>> = vec![None; CLASSES + 1];
        for place in self.chart.places() {
            let payload = place.payload.unwrap_or(0.0);
            let k = (CLASSES as f64 * place.reach / last) as usize;
            let class = classes[k].get_or_insert(Class {
                best: *place,
                least: payload,
            });
            class.least = class.least.min(payload);
            if payload > class.best.payload.unwrap_or(0.0) {
                class.best = *place;
            }
        }
        classes.into_iter().flatten().collect()
    }
}

/// Places of about one reach.
#[derive(Clone, Copy)]
struct Class {
    best: Place,
    least: f64,
}

fn legend_entry<B: DrawingBackend>(
    chart: &mut Chart<'_, B>,
    text: &str,
    color: RGBColor,
) -> Drawn<B> {
    chart
        .draw_series(std::iter::empty::<Circle<(f64, f64), i32>>())?
        .label(text)
        .legend(move |(x, y)| Rectangle::new([(x, y - 6), (x + 18, y + 6)], color.filled()));
    Ok(())
}

fn dashed<B: DrawingBackend>(
    chart: &mut Chart<'_, B>,
    a: [f64; 2],
    b: [f64; 2],
    color: RGBColor,
) -> Drawn<B> {
    let line = [(a[0], a[1]), (b[0], b[1])];
    chart.draw_series(DashedLineSeries::new(line, 4, 4, color.stroke_width(1)))?;
    Ok(())
}

fn middle(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Texts that do not cover each other: each goes to the nearest free place beside its point, pixels.
#[derive(Default)]
struct Labels {
    taken: Vec<[i32; 4]>,
}

impl Labels {
    fn add<B: DrawingBackend>(
        &mut self,
        chart: &Chart<'_, B>,
        place: [f64; 2],
        text: &str,
        color: &RGBColor,
        size: i32,
    ) -> Drawn<B> {
        let area = chart.plotting_area();
        let (x, y) = area.map_coordinate(&(place[0], place[1]));
        let letters = i32::try_from(text.chars().count()).unwrap_or(0);
        let (width, height) = (letters * size * 11 / 20 + 4, size);
        let boxed = |dx: i32, dy: i32| {
            let left = if dx < 0 { x + dx - width } else { x + dx };
            [left, y + dy - height / 2, left + width, y + dy + height / 2]
        };
        let near = (0..14).flat_map(|k| {
            let d = 8 + 7 * k;
            [
                (d, -d / 2),
                (d, d / 2),
                (-d, -d / 2),
                (-d, d / 2),
                (3, -d - 4),
                (3, d + 4),
            ]
        });
        let is_free = |b: &[i32; 4]| {
            let apart = |t: &[i32; 4]| b[2] < t[0] || t[2] < b[0] || b[3] < t[1] || t[3] < b[1];
            self.taken.iter().all(apart)
        };
        let found = near.map(|(dx, dy)| boxed(dx, dy)).find(is_free);
        let found = found.unwrap_or_else(|| boxed(8, 0));
        self.taken.push(found);
        let style = ("sans-serif", size).into_font().color(color);
        let style = style.pos(Pos::new(HPos::Left, VPos::Center));
        let [left, top, _, bottom] = found;
        let (base_x, base_y) = area.get_base_pixel();
        let at = (left - base_x, (top + bottom) / 2 - base_y);
        let plain = area.strip_coord_spec();
        let [x0, y0, x1, y1] = found;
        let behind = [(x0 - base_x, y0 - base_y), (x1 - base_x, y1 - base_y)];
        plain.draw(&Rectangle::new(behind, WHITE.mix(0.75).filled()))?;
        plain.draw(&Text::new(text.to_owned(), at, style))
    }
}
