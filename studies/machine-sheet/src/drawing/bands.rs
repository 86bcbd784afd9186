//! On the sheet of `machine draw`: the bands of payload that colour the workspace (`loads`).

use plotters::style::{Color as _, HSLColor, RGBColor};

/// First digits of a band's width.
const STEPS: [f64; 4] = [1.0, 2.0, 2.5, 5.0];
const BANDS: usize = 7;

pub(super) struct Bands {
    /// Lower ends, kg, ascending.
    pub(super) lows: Vec<f64>,
}

impl Bands {
    /// Divides the range from 0 to `greatest`, kg, into at most [`BANDS`] bands of a round width.
    pub(super) fn new(greatest: f64) -> Self {
        let rounds = (0..6).flat_map(|power| STEPS.map(|step| step * 10.0_f64.powi(power)));
        let most = BANDS as f64;
        let step = rounds.into_iter().find(|step| most * step >= greatest);
        let step = step.unwrap_or(greatest / most);
        let lows = (0..BANDS).map(|k| step * k as f64);
        let lows = lows.filter(|low| *low == 0.0 || *low < greatest).collect();
        Self { lows }
    }

    /// Colour of a payload, kg, from red to green; grey for none.
    pub(super) fn color(&self, payload: Option<f64>) -> RGBColor {
        let Some(payload) = payload else {
            return RGBColor(190, 190, 190);
        };
        let band = self.lows.iter().rposition(|low| payload >= *low);
        let last = (self.lows.len() - 1).max(1);
        let part = band.unwrap_or(0) as f64 / last as f64;
        let (r, g, b) = HSLColor(0.02 + 0.36 * part, 0.55, 0.72 - 0.22 * part).rgb();
        RGBColor(r, g, b)
    }
}
