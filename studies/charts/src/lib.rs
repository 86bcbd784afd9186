//! Figures as PNG and SVG, for the programs `hdrm-fmu-report` and `hdrm-fmu-surrogate`: curves in
//! panels ([`Figure`]), paths in space ([`Path3`]), and any other [`Picture`] ([`save`], `write`).
#![forbid(unsafe_code)]

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow};
use output_file::OutputFile;
use plotters::coord::Shift;
use plotters::coord::ranged1d::ValueFormatter;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

const FONT: (&str, i32) = ("sans-serif", 16);
const TITLE: (&str, i32) = ("sans-serif", 20);
/// Size of a panel, of a title line and of a path in space, pixels.
const PANEL: (u32, u32) = (720, 380);
/// Width of the line before a name in the legend, and of a letter of the name, pixels.
const LEGEND: (u32, u32) = (40, 8);
const TITLE_HEIGHT: u32 = 34;
const SPACE: (u32, u32) = (900, 760);

/// The area that is drawn on, of any backend.
pub type Area<'a, B> = DrawingArea<B, Shift>;
/// Result of drawing.
pub type DrawResult<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

/// A line with its name.
pub struct Curve {
    label: String,
    color: RGBColor,
    points: Vec<(f64, f64)>,
}

/// Axes with curves.
pub struct Panel {
    /// Quantity and unit of the horizontal axis.
    pub x_label: String,
    /// Quantity and unit of the vertical axis.
    pub y_label: String,
    /// Lower end of a logarithmic vertical axis; none: the axis is linear.
    pub floor: Option<f64>,
    /// The curves.
    pub curves: Vec<Curve>,
}

/// Panels under one title.
pub struct Figure {
    /// File name without extension.
    pub name: String,
    /// Title above all panels.
    pub title: String,
    /// The panels, two in a row.
    pub panels: Vec<Panel>,
}

/// Paths in space, y upwards.
pub struct Path3 {
    /// File name without extension.
    pub name: String,
    /// Title above it.
    pub title: String,
    /// Label, colour, points, m.
    pub curves: Vec<(String, RGBColor, Vec<[f64; 3]>)>,
}

/// Something that can be drawn on any backend.
pub trait Picture {
    /// Draws it; fails only if the backend does.
    fn draw<B: DrawingBackend>(&self, area: &Area<'_, B>) -> DrawResult<B>;
}

impl Curve {
    /// A line through `points`; with an empty label it is not in the legend.
    pub fn new(label: &str, color: RGBColor, points: Vec<(f64, f64)>) -> Self {
        Self {
            label: label.into(),
            color,
            points,
        }
    }
}

impl Panel {
    /// Curves over time, s.
    pub fn over_time(y_label: &str, curves: Vec<Curve>) -> Self {
        Self {
            x_label: "time, s".into(),
            y_label: y_label.into(),
            floor: None,
            curves,
        }
    }

    /// The same with a logarithmic axis upwards from `floor`.
    pub fn logarithmic(self, floor: f64) -> Self {
        let floor = Some(floor);
        Self { floor, ..self }
    }

    /// Width of the legend at the right of the axes, pixels.
    fn legend_width(&self) -> u32 {
        let letters = self.curves.iter().map(|c| c.label.chars().count()).max();
        let letters = u32::try_from(letters.unwrap_or(0))
            .unwrap_or(0)
            .clamp(12, 36);
        LEGEND.0 + LEGEND.1 * letters
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<'_, B>) -> DrawResult<B> {
        let points = || self.curves.iter().flat_map(|c| &c.points);
        let (x0, x1) = extent(points().map(|p| p.0));
        let (y0, y1) = extent(points().map(|p| p.1));
        let mut builder = ChartBuilder::on(area);
        builder
            .margin(12)
            .margin_right(self.legend_width())
            .x_label_area_size(44)
            .y_label_area_size(72);
        if let Some(floor) = self.floor {
            let range = (floor..(2.0 * y1).max(10.0 * floor)).log_scale();
            let mut chart = builder.build_cartesian_2d(x0..x1, range)?;
            self.lines(&mut chart, Some(&|y| format!("{y:.0e}")), |y| y.max(floor))
        } else {
            let margin = 0.06 * (y1 - y0).max(1e-12);
            let mut chart = builder.build_cartesian_2d(x0..x1, y0 - margin..y1 + margin)?;
            self.lines(&mut chart, None, |y| y)
        }
    }

    fn lines<'a, B, Y>(
        &self,
        chart: &mut ChartContext<'a, B, Cartesian2d<RangedCoordf64, Y>>,
        y_format: Option<&dyn Fn(&f64) -> String>,
        shown: impl Fn(f64) -> f64,
    ) -> DrawResult<B>
    where
        B: DrawingBackend + 'a,
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let mut mesh = chart.configure_mesh();
        mesh.light_line_style(TRANSPARENT).label_style(FONT);
        mesh.x_desc(&self.x_label).y_desc(&self.y_label);
        mesh.x_label_formatter(&short);
        mesh.y_label_formatter(y_format.unwrap_or(&short));
        mesh.draw()?;
        for curve in &self.curves {
            let color = curve.color;
            let points = curve.points.iter().map(|(x, y)| (*x, shown(*y)));
            chart.draw_series(LineSeries::new(points, color.stroke_width(2)))?;
        }
        Ok(())
    }

    /// Draws the names at the right of the axes, where they cover no curve.
    fn legend<B: DrawingBackend>(&self, area: &Area<'_, B>) -> DrawResult<B> {
        let (width, _) = area.dim_in_pixel();
        let left = i32::try_from(width.saturating_sub(self.legend_width())).unwrap_or(0) + 10;
        let named = self.curves.iter().filter(|c| !c.label.is_empty());
        for (curve, top) in named.zip((26..).step_by(19)) {
            let line = [(left, top), (left + 20, top)];
            area.draw(&PathElement::new(line, curve.color.stroke_width(3)))?;
            area.draw(&Text::new(curve.label.as_str(), (left + 27, top - 9), FONT))?;
        }
        Ok(())
    }
}

impl Picture for Figure {
    fn draw<B: DrawingBackend>(&self, area: &Area<'_, B>) -> DrawResult<B> {
        area.fill(&WHITE)?;
        let area = area.titled(&self.title, TITLE)?;
        let columns = self.panels.len().min(2);
        let parts = area.split_evenly((self.panels.len().div_ceil(2), columns));
        for (panel, part) in self.panels.iter().zip(&parts) {
            panel.draw(part)?;
            panel.legend(part)?;
        }
        Ok(())
    }
}

impl Picture for Path3 {
    fn draw<B: DrawingBackend>(&self, area: &Area<'_, B>) -> DrawResult<B> {
        area.fill(&WHITE)?;
        let axis = |i: usize| {
            let points = self.curves.iter().flat_map(|(_, _, points)| points);
            let (low, high) = extent(points.map(|p| p[i]));
            let middle = 0.5 * (low + high);
            (middle, high - low)
        };
        let axes = [0, 1, 2].map(axis);
        let half = 0.58 * axes.iter().fold(0.02_f64, |m, a| m.max(a.1));
        let range = |i: usize| axes[i].0 - half..axes[i].0 + half;
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, TITLE)
            .margin(16)
            .build_cartesian_3d(range(0), range(1), range(2))?;
        chart.with_projection(|mut view| {
            view.yaw = 0.7;
            view.pitch = 0.35;
            view.scale = 0.85;
            view.into_matrix()
        });
        chart
            .configure_axes()
            .label_style(FONT)
            .light_grid_style(BLACK.mix(0.06))
            .max_light_lines(2)
            .draw()?;
        for (label, color, points) in &self.curves {
            let color = *color;
            let points = points.iter().map(|p| (p[0], p[1], p[2]));
            chart
                .draw_series(LineSeries::new(points, color.stroke_width(2)))?
                .label(label)
                .legend(move |(x, y)| {
                    PathElement::new([(x, y), (x + 22, y)], color.stroke_width(2))
                });
        }
        chart
            .configure_series_labels()
            .label_font(FONT)
            .border_style(BLACK.mix(0.3))
            .draw()
    }
}

impl Figure {
    /// Write `folder/name.png` and `.svg`.
    pub fn save(&self, folder: &Path) -> Result<[PathBuf; 2]> {
        let [columns, rows] = [self.panels.len().min(2), self.panels.len().div_ceil(2)];
        let [width, height] = [columns as u32 * PANEL.0, rows as u32 * PANEL.1];
        let size = (width, height + TITLE_HEIGHT);
        save(self, folder, &self.name, size)
    }
}

impl Path3 {
    /// Write `folder/name.png` and `.svg`.
    pub fn save(&self, folder: &Path) -> Result<[PathBuf; 2]> {
        save(self, folder, &self.name, SPACE)
    }
}

/// Writes `folder/name.png` and `.svg`; makes the folder if it does not exist.
pub fn save(
    picture: &impl Picture,
    folder: &Path,
    name: &str,
    size: (u32, u32),
) -> Result<[PathBuf; 2]> {
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let files = ["png", "svg"].map(|extension| folder.join(format!("{name}.{extension}")));
    for file in &files {
        write(picture, file, size)?;
    }
    Ok(files)
}

/// Writes a picture: as PNG if the file's name ends in `.png`, else as SVG.
pub fn write(picture: &impl Picture, file: &Path, size: (u32, u32)) -> Result<()> {
    // Without system fonts; a second registration changes nothing.
    let font = epaint_default_fonts::UBUNTU_LIGHT;
    register_font(FONT.0, FontStyle::Normal, font)
        .map_err(|_| anyhow!("the built-in font is unreadable"))?;
    let failed = |e: &dyn std::fmt::Display| anyhow!("figure {}: {e}", file.display());
    if file.extension().is_some_and(|extension| extension == "png") {
        let mut pixels = vec![0; 3 * size.0 as usize * size.1 as usize];
        let area = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
        let drawn = picture.draw(&area).and_then(|()| area.present());
        drop(area);
        drawn.map_err(|e| failed(&e))?;
        let mut out = OutputFile::create(file)?;
        let mut encoder = png::Encoder::new(&mut out, size.0, size.1);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_filter(png::Filter::NoFilter); // smaller, of drawings
        let written = (encoder.write_header()).and_then(|mut out| out.write_image_data(&pixels));
        written.map_err(|e| failed(&e))?;
        return Ok(out.commit()?);
    }
    let mut text = String::new();
    let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
    let drawn = picture.draw(&area).and_then(|()| area.present());
    drop(area);
    drawn.map_err(|e| failed(&e))?;
    Ok(output_file::write(file, text)?)
}

/// Colours of slew, lift, tilt and the three joints of the wrist, the same in every figure.
const AXES: [RGBColor; 6] = [
    RGBColor(31, 119, 180),
    RGBColor(225, 110, 10),
    RGBColor(44, 140, 44),
    RGBColor(214, 39, 40),
    RGBColor(148, 103, 189),
    RGBColor(120, 76, 65),
];

/// Colours of curves with these names: that of the axis which a name says, darker and lighter where
/// several belong to one axis, and different ones for all others.
pub fn colors(names: &[&str]) -> Vec<RGBColor> {
    let axes: Vec<_> = names.iter().map(|name| axis(name)).collect();
    let others = axes.iter().filter(|axis| axis.is_none()).count();
    let color = |k: usize| {
        let before = axes[..k].iter().filter(|axis| **axis == axes[k]).count();
        let Some(axis) = axes[k] else {
            return wheel(before, others);
        };
        let shade = [1.0, 0.6, 1.5, 0.35, 2.0][before % 5];
        let shaded = |c: u8| {
            let c = f64::from(c);
            let c = if shade > 1.0 {
                255.0 - (255.0 - c) / shade
            } else {
                c * shade
            };
            c as u8
        };
        let RGBColor(r, g, b) = AXES[axis];
        RGBColor(shaded(r), shaded(g), shaded(b))
    };
    (0..names.len()).map(color).collect()
}

/// The axis that a name says: `slew`, `emla_1`, `[1]` or `joint 1` is the first, `wrist 1` the fourth.
fn axis(name: &str) -> Option<usize> {
    let called = ["slew", "lift", "tilt"];
    if let Some(k) = called.iter().position(|axis| name.contains(axis)) {
        return Some(k);
    }
    let digit = |(_, rest): (&str, &str)| rest.chars().next()?.to_digit(10);
    let marked = name.split_once("emla_").and_then(digit);
    let ending = || {
        name.trim_end_matches([']', ')'])
            .chars()
            .last()?
            .to_digit(10)
    };
    let is_ending = name.ends_with(']') || name.contains("joint") || name.contains("wrist");
    let number = marked.or_else(|| ending().filter(|_| is_ending))? as usize;
    let is_of_wrist = name.contains("wrist") && number <= 3;
    let axis = number.checked_sub(1)? + if is_of_wrist { 3 } else { 0 };
    (axis < AXES.len()).then_some(axis)
}

/// The k-th of `count` different colours.
pub fn wheel(k: usize, count: usize) -> RGBColor {
    let (r, g, b) = HSLColor(k as f64 / count.max(1) as f64, 0.65, 0.42).rgb();
    RGBColor(r, g, b)
}

/// A number beside an axis, without digits that say nothing.
#[allow(clippy::trivially_copy_pass_by_ref)] // as plotters asks
fn short(value: &f64) -> String {
    let rounded = (value * 1e9).round() / 1e9;
    (if rounded == 0.0 { 0.0 } else { rounded }).to_string()
}

/// Smallest and largest value; an interval around a single one.
pub fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let widen = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), widen);
    if low < high {
        (low, high)
    } else {
        (low - 1.0, low + 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_has_one_color() {
        let lift = colors(&["emla_2.F"])[0];
        for name in [
            "rod speed of lift",
            "hdrm.zeta[2]",
            "joint 2 (lift)",
            "emla_2",
        ] {
            assert_eq!(colors(&[name, "a"])[0], lift, "{name}");
        }
        assert_eq!(colors(&["wrist torque 1"]), colors(&["joint 4 (wrist 1)"]));
        let all = colors(&["emla_2.i_d", "emla_2.i_q", "emla_1.i_d", "x", "y"]);
        assert!((1..5).all(|k| !all[..k].contains(&all[k])), "{all:?}");
    }

    #[test]
    fn numbers_are_short() {
        let shown = [0.1 + 0.2, 45000.0, -0.0, 12.5].map(|value| short(&value));
        assert_eq!(shown, ["0.3", "45000", "0", "12.5"]);
    }
}
