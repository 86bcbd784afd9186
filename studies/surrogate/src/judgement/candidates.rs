//! What `surrogate compare` prints: the errors of physics, refitted physics, look-up map, networks
//! and hybrid on the same held-out profiles, and how often the bounds of the networks hold.

use std::fmt::Write as _;

use anyhow::Result;
use emla::{Surrogate, maps};
use machine_file::Emla;
use rayon::prelude::*;

use crate::judgement::conformal::{Coverage, SHARE, points};
use crate::judgement::free_run::{DrivenProfile, Errors, QUANTITIES, drive, overall, ratio};
use crate::measurement::campaign::{SECONDS, held_out_profiles, rows, training_campaign};
use crate::measurement::profile::Kind;
use crate::prediction::identification::Identification;
use crate::prediction::lookup::LookUp;
use crate::prediction::model::Model;

/// Seed of the held-out profiles on which the models are compared. Those of seed 1 were seen when
/// the campaign's size was chosen.
const COMPARISON_SEED: u64 = 4;
/// Seed of the profiles that calibrate a network's bound.
pub const CALIBRATION_SEED: u64 = 2;
/// Seed of the profiles on which the bound's coverage is measured.
const COVERAGE_SEED: u64 = 3;
const HYBRID: f64 = 0.9;
/// Index of the refitted physics among the models.
const REFITTED: usize = 1;

/// The models to compare.
pub struct Candidates {
    /// The parameters that were fitted to the campaign.
    pub identification: Identification,
    models: Vec<(&'static str, Model)>,
}

impl Candidates {
    /// Fits the models to the campaign of `seed`, on which `network` was trained; the shipped
    /// network is among them.
    pub fn new(p: &Emla, network: &Surrogate, seed: u64) -> Result<Self> {
        let campaign = training_campaign(p, seed)?;
        let identification = Identification::new(p, &campaign);
        let electrical = identification.electrical;
        let (rows, _) = rows(&electrical, &campaign);
        let rows = rows.iter().map(|row| [row.tau_e, row.w_m, row.f_ext]);
        let rows: Vec<[f64; 3]> = rows.collect();
        let map = LookUp::new(maps::travel_per_radian(p), &rows);
        let blended = |network: &Surrogate, alpha| Model::new(electrical, network.clone(), alpha);
        Ok(Self {
            models: vec![
                ("physics as it is", Model::physics(*p)),
                ("physics refitted", Model::physics(identification.refitted)),
                ("look-up map", Model::look_up(electrical, map)),
                ("network", blended(network, 1.0)),
                ("hybrid, alpha = 0.9", blended(network, HYBRID)),
                ("shipped network", blended(&Surrogate::reference(), 1.0)),
            ],
            identification,
        })
    }

    /// The tables of errors on `count` held-out profiles of `seconds`.
    pub fn judge(&self, p: &Emla, count: u32, seconds: f64) -> Result<String> {
        let driven = drive(p, &held_out_profiles(count, seconds, COMPARISON_SEED))?;
        let errors = |knows_temperature: bool| -> Vec<Vec<Errors>> {
            let errors = |(_, model): &(_, Model)| {
                let driven = driven.par_iter();
                let errors = driven.map(|d| Errors::new(model, d, knows_temperature));
                errors.collect()
            };
            self.models.iter().map(errors).collect()
        };
        let [known, unknown] = [errors(true), errors(false)];
        let mut text = format!(
            "{count} held-out profiles of {seconds} s; root mean square errors in free-running simulation [95 % interval, bootstrap over profiles]\n"
        );
        self.table(&mut text, "known at the start", &known);
        self.table(&mut text, "taken for the data sheet's", &unknown);
        text += "energy: error of the energy from the DC side over the power at the nut either way, integrated\n\n";
        self.by_kind(&mut text, &driven, &known);
        Ok(text)
    }

    fn table(&self, text: &mut String, temperature: &str, errors: &[Vec<Errors>]) {
        let mut add_line = |cells: &[String]| {
            let cells: String = cells.iter().map(|cell| format!("{cell:>26}")).collect();
            *text += &format!("{}\n", cells.trim_end());
        };
        let mut head = vec![format!("{:<26}", format!("temperature {temperature}"))];
        head.extend(QUANTITIES.map(|(name, _)| name.into()));
        head.push("current over refitted's".into());
        add_line(&head);
        for (k, (name, _)) in self.models.iter().enumerate() {
            let mut cells = vec![format!("{name:<26}")];
            for (quantity, (_, factor)) in QUANTITIES.iter().enumerate() {
                cells.push(cell(overall(&errors[k], quantity).map(|e| factor * e)));
            }
            cells.push(cell(ratio(&errors[k], &errors[REFITTED], 0)));
            add_line(&cells);
        }
    }

    fn by_kind(&self, text: &mut String, driven: &[DrivenProfile], errors: &[Vec<Errors>]) {
        *text += &format!("{:<26}", "current, A, by kind");
        for kind in Kind::ALL {
            *text += &format!("{:>22}", format!("{kind:?}").to_lowercase());
        }
        for (k, (name, _)) in self.models.iter().enumerate() {
            *text += &format!("\n{name:<26}");
            for kind in Kind::ALL {
                let pairs = driven.iter().zip(&errors[k]);
                let of_kind = pairs.filter(|(d, _)| d.profile.kind == kind);
                let of_kind: Vec<Errors> = of_kind.map(|(_, e)| *e).collect();
                *text += &format!("{:>22}", cell(overall(&of_kind, 0)));
            }
        }
        *text += "\n";
    }
}

fn cell([value, low, high]: [f64; 3]) -> String {
    let digits = if value >= 100.0 {
        0
    } else if value >= 10.0 {
        1
    } else {
        3
    };
    format!("{value:.digits$} [{low:.digits$}, {high:.digits$}]")
}

/// The table of how often the networks' bounds hold on `count` profiles that they were not
/// calibrated on.
pub fn coverage(p: &Emla, networks: &[(&str, &Surrogate)], count: u32) -> Result<String> {
    let driven = drive(p, &held_out_profiles(count, SECONDS, COVERAGE_SEED))?;
    let mut text = format!(
        "{:.0} % interval of the efficiency, pointwise: one window of each of {count} profiles that it was not calibrated on\n",
        1e2 * SHARE
    );
    for (name, network) in networks {
        let Some(bound) = network.efficiency_bound() else {
            writeln!(text, "{name}: its file has no efficiency_bound")?;
            continue;
        };
        let coverage = Coverage::new(&bound, &points(*p, network, &driven)?, COVERAGE_SEED);
        let [low, high] = coverage.interval().map(|share| 1e2 * share);
        let [windows, whole] = coverage.shares.map(|share| 1e2 * share);
        let share = 1e2 * coverage.inside as f64 / coverage.profiles as f64;
        writeln!(
            text,
            "{name}: {share:.1} % of {} inside [{low:.1}, {high:.1}]; of all windows {windows:.1} %; all windows of a profile in {whole:.0} %; \
             half the width {:.1} % on average, {:.1} % at 100 W, {:.1} % at 3 kW",
            coverage.profiles,
            1e2 * coverage.half,
            1e2 * bound.half_width(100.0, 0.0),
            1e2 * bound.half_width(3e3, 0.0),
        )?;
    }
    Ok(text)
}
