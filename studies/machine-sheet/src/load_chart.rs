//! The load chart: the greatest payload at rest over the workspace, and what limits it. `machine
//! draw` draws it and writes it as CSV.
#![allow(non_snake_case)] // symbols of the machine file

use anyhow::{Context, Result, ensure};
use hdrm::{Body, DOF};
use machine_file::{AXES, Machine};
use motion_check::{AllowedRanges, Demand, DemandModel, Margin, Motion, Payload, Quantity};
use nalgebra::Vector3;
use std::io::{self, Write};

use experiments::machines::continuous_torque::ContinuousTorque;

/// Number of angles of each of the two boom joints.
const POSES: usize = 81;
/// Loads are linear in the payload: they are computed without any and with this one, kg.
const UNIT: f64 = 1000.0;

/// One pose of the machine.
#[derive(Clone, Copy, Debug)]
pub struct LoadPoint {
    /// Joint angles, rad.
    pub zeta: [f64; DOF],
    /// Distance of the tip from the slew axis, m.
    pub reach: f64,
    /// Height of the tip over the base, m.
    pub height: f64,
    /// Greatest payload, kg; none where the machine cannot hold even itself.
    pub payload: Option<f64>,
    /// What limits the payload.
    pub limit: Quantity,
    /// Greatest payload that may be held continuously, kg: at most `payload`, and what the motors'
    /// continuous torques hold.
    pub lasting: Option<f64>,
    /// The actuator, from 0, whose continuous torque limits `lasting`; none if `limit` does.
    pub lasting_limit: Option<usize>,
}

/// Greatest payloads over lift and tilt angles.
pub struct LoadChart {
    /// A row for each lift angle, over tilt angles; none where strokes, joints or wrist do not
    /// allow the pose.
    pub rows: Vec<Vec<Option<LoadPoint>>>,
    /// Factor on all weights.
    pub factor: f64,
    /// Angle of the tool over the horizontal, rad.
    pub tool: f64,
}

/// A machine with nothing at its tip, and with a payload of [`UNIT`].
struct Loads {
    empty: DemandModel,
    loaded: DemandModel,
    limits: AllowedRanges,
    lasting: [ContinuousTorque; 3],
    factor: f64,
    tip: Vector3<f64>,
}

impl LoadChart {
    /// The chart of `machine` with all weights times `factor`, which allows for dynamic loads. The
    /// tool keeps the angle to the horizontal that it has in the start pose; the payload's centre
    /// of mass is that of the machine file. Fails if the mechanism does not close, or the factor is
    /// not positive.
    pub fn new(machine: &Machine, factor: f64) -> Result<Self> {
        ensure!(
            factor.is_finite() && factor > 0.0,
            "the dynamic factor {factor} must be finite and > 0"
        );
        let loads = Loads::new(machine, factor)?;
        let start = machine.start.zeta;
        let tool = start[1] + start[2] + start[4];
        let ranges = machine.limits.zeta();
        let row = |i: usize| {
            let point = |j: usize| {
                let [lift, tilt] = [angle(ranges[1], i), angle(ranges[2], j)];
                let zeta = [start[0], lift, tilt, start[3], tool - lift - tilt, start[5]];
                loads.point(zeta)
            };
            (0..POSES).map(point).collect()
        };
        Ok(Self {
            rows: (0..POSES).map(row).collect(),
            factor,
            tool,
        })
    }

    /// The points of all allowed poses.
    pub fn points(&self) -> impl Iterator<Item = &LoadPoint> {
        self.rows.iter().flatten().flatten()
    }

    /// The curve on which the greatest payload is this one, kg: pieces [reach, height, reach,
    /// height], m, linear between the poses.
    pub fn curve(&self, payload: f64) -> Vec<[f64; 4]> {
        let mut pieces = Vec::new();
        for rows in self.rows.windows(2) {
            for (a, b) in rows[0].windows(2).zip(rows[1].windows(2)) {
                for corners in [[a[0], a[1], b[0]], [a[1], b[0], b[1]]] {
                    if let [Some(p), Some(q), Some(r)] = corners {
                        pieces.extend(piece([&p, &q, &r], payload));
                    }
                }
            }
        }
        pieces
    }

    /// Writes every place with its joint angles, payload and limit.
    pub fn write_csv(&self, file: &mut impl Write) -> io::Result<()> {
        writeln!(
            file,
            "reach_m,height_m,lift_rad,tilt_rad,wrist_2_rad,payload_kg,limit,lasting_kg,lasting_limit"
        )?;
        for p in self.points() {
            let [_, lift, tilt, _, wrist, _] = p.zeta;
            let payload = p.payload.unwrap_or(0.0);
            let (reach, height, limit) = (p.reach, p.height, p.limit);
            let lasting = p.lasting.unwrap_or(0.0);
            let motor = p.lasting_limit.map_or_else(
                || limit.to_string(),
                |k| format!("lasting torque of {}", AXES[k]),
            );
            writeln!(
                file,
                "{reach},{height},{lift},{tilt},{wrist},{payload},{limit},{lasting},{motor}"
            )?;
        }
        Ok(())
    }
}

/// The line through a triangle of poses on which the greatest payload is this one.
fn piece(corners: [&LoadPoint; 3], payload: f64) -> Option<[f64; 4]> {
    let above = |p: &LoadPoint| p.payload.unwrap_or(-1.0) - payload;
    let mut ends = [(0, 1), (1, 2), (2, 0)].into_iter().filter_map(|(i, k)| {
        let (p, q) = (corners[i], corners[k]);
        let share = above(p) / (above(p) - above(q));
        let crosses = (above(p) < 0.0) != (above(q) < 0.0);
        crosses.then(|| {
            let between = |a: f64, b: f64| a + share * (b - a);
            [between(p.reach, q.reach), between(p.height, q.height)]
        })
    });
    let [[x, y], [u, v]] = [ends.next()?, ends.next()?];
    Some([x, y, u, v])
}

/// The `k`-th of [`POSES`] angles over a range.
fn angle([min, max]: [f64; 2], k: usize) -> f64 {
    min + (max - min) * k as f64 / (POSES - 1) as f64
}

impl Loads {
    fn new(machine: &Machine, factor: f64) -> Result<Self> {
        let com = Payload::from_machine(machine).com;
        let with = |mass| DemandModel::new(machine, &Payload { mass, com });
        Ok(Self {
            empty: with(0.0).context("the mechanism")?,
            loaded: with(UNIT).context("the mechanism")?,
            limits: AllowedRanges::from_machine(machine),
            lasting: ContinuousTorque::from_machine(machine),
            factor,
            tip: Vector3::from(machine.geometry.r_D4_T4),
        })
    }

    /// The point of a pose; none where joints or strokes do not allow it.
    fn point(&self, zeta: [f64; DOF]) -> Option<LoadPoint> {
        let motion = Motion::rest(zeta);
        let [empty, loaded] = [&self.empty, &self.loaded].map(|c| c.demand(&motion));
        let (continuous, motor) = self.continuous_payload(&empty, &loaded);
        let [empty, loaded] = [empty, loaded].map(|demand| self.limits.margins(&demand));
        if empty.iter().any(|m| is_geometric(m) && !m.holds()) {
            return None;
        }
        let (payload, limit) = empty
            .iter()
            .zip(&loaded)
            .filter(|(a, _)| !is_geometric(a))
            .map(|(a, b)| {
                let range = a.range.map(|end| end / self.factor);
                (payload_at_limit([a.value, b.value], range), a.quantity)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        let lasting = continuous.min(payload);
        let poses = self.empty.plant().tree().configuration(&zeta).world_poses();
        let last = poses[Body::D4 as usize];
        let tip = last.r + last.R * self.tip;
        Some(LoadPoint {
            zeta,
            reach: tip.x.hypot(tip.z),
            height: tip.y,
            payload: (payload >= 0.0).then_some(payload),
            limit,
            lasting: (lasting >= 0.0).then_some(lasting),
            lasting_limit: (continuous < payload).then_some(motor),
        })
    }

    /// The payload, kg, at which a motor first reaches its continuous torque, at rest and whatever
    /// the factor, and which motor that is.
    fn continuous_payload(&self, empty: &Demand, loaded: &Demand) -> (f64, usize) {
        let each = (0..3).map(|i| {
            let limit = self.lasting[i].torque;
            let torques = [empty.tau_e[i], loaded.tau_e[i]];
            (payload_at_limit(torques, [-limit, limit]), i)
        });
        let least = each.min_by(|a, b| a.0.total_cmp(&b.0));
        least.expect("three motors")
    }
}

/// Whether a quantity depends on the pose alone, not on the load.
fn is_geometric(margin: &Margin) -> bool {
    matches!(margin.quantity, Quantity::Joint(_) | Quantity::Stroke(_))
}

/// The payload m, kg, at which `a + (b − a)·m/UNIT` leaves the range; negative where `a` is outside
/// already.
fn payload_at_limit([a, b]: [f64; 2], [min, max]: [f64; 2]) -> f64 {
    let slope = (b - a) / UNIT;
    if !(min..=max).contains(&a) {
        return -1.0;
    }
    match slope {
        s if s > 0.0 => (max - a) / s,
        s if s < 0.0 => (min - a) / s,
        _ => f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holds(machine: &Machine, place: &LoadPoint, mass: f64) -> Vec<Quantity> {
        let com = Payload::from_machine(machine).com;
        let capability = DemandModel::new(machine, &Payload { mass, com }).expect("closed");
        let demand = capability.demand(&Motion::rest(place.zeta));
        let margins = AllowedRanges::from_machine(machine).margins(&demand);
        let beyond = margins.iter().filter(|margin| !margin.holds());
        beyond.map(|margin| margin.quantity).collect()
    }

    /// At every place: 0.98 of the payload breaks no limit, 1.05 of it breaks the one that is
    /// named.
    #[test]
    fn the_edge_of_the_chart_is_true() {
        for (name, _) in machine_file::PRESETS {
            let machine = Machine::preset(name).expect("shipped");
            let chart = LoadChart::new(&machine, 1.0).expect("chart");
            let mut seen = 0;
            for place in chart.points().step_by(7) {
                let Some(payload) = place.payload else {
                    assert_ne!(holds(&machine, place, 0.0), []);
                    continue;
                };
                seen += 1;
                assert_eq!(
                    holds(&machine, place, 0.98 * payload),
                    [],
                    "{name} {place:?}"
                );
                let beyond = holds(&machine, place, 1.05 * payload);
                assert!(beyond.contains(&place.limit), "{name} {place:?} {beyond:?}");
            }
            assert!(seen > 100, "{name}: {seen} places");
        }
    }

    /// At the lasting payload the named motor gives its lasting torque, and no other more; where
    /// none is named it is the peak payload.
    #[test]
    fn the_lasting_edge_is_true() {
        let mut machine = Machine::reference();
        machine.ratings.lift.motor_torque = 22.0;
        machine.ratings.tilt.motor_torque = 25.0;
        let com = Payload::from_machine(&machine).com;
        let most = ContinuousTorque::from_machine(&machine);
        let chart = LoadChart::new(&machine, 1.0).expect("chart");
        let mut seen = [0; 4];
        for place in chart.points().step_by(7) {
            let Some(mass) = place.lasting else { continue };
            let Some(k) = place.lasting_limit else {
                assert_eq!(place.lasting, place.payload);
                seen[3] += 1;
                continue;
            };
            seen[k] += 1;
            let capability = DemandModel::new(&machine, &Payload { mass, com }).expect("closed");
            let torques = capability.demand(&Motion::rest(place.zeta)).tau_e;
            assert!((torques[k].abs() / most[k].torque - 1.0).abs() < 1e-9);
            let within = |i: usize| torques[i].abs() <= most[i].torque * (1.0 + 1e-9);
            assert!((0..3).all(within), "{place:?} {torques:?}");
            assert!(mass <= place.payload.unwrap_or(0.0));
        }
        assert!(seen[1] > 20 && seen[2] > 20, "{seen:?}");
    }

    /// Oracle: at rest all weights count with the factor, as with as much more gravity.
    #[test]
    fn a_factor_is_as_much_more_gravity() {
        let mut machine = Machine::reference();
        let with_factor = LoadChart::new(&machine, 1.25).expect("chart");
        machine.gravity *= 1.25;
        let heavier = LoadChart::new(&machine, 1.0).expect("chart");
        for (a, b) in with_factor.points().zip(heavier.points()) {
            let difference = a.payload.unwrap_or(0.0) - b.payload.unwrap_or(0.0);
            assert!(difference.abs() < 1e-6, "{a:?} {b:?}");
        }
        assert!(LoadChart::new(&machine, 0.0).is_err());
    }
}
