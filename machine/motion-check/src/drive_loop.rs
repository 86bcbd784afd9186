//! Linearizes the sampled loop of voltage law, drives and booms about a pose at rest, exactly: the
//! plant by its matrix exponential over a step, the law as it is evaluated. [`crate::gain_rule`]
//! takes from it how fast the tip's feedback may be.
//!
//! The law accelerates the motors with the load: `J/lead·ẍ_r`, in which `ẍ_r = −Λ ẋ` and `ẋ_r =
//! −Λ x`. A motor with a reflected inertia `J (2πN/ρ)²` far above the boom's follows `ẋ_n = −Λ x`
//! whatever the boom does, and with a boom of the frequency ω and the damping ζ on its screw that
//! loop, `s (s² + 2ζω s + ω²) + Λ (2ζω s + ω²) = 0`, is stable for Λ < 2ζω only.

use emla::maps;
use hdrm::{Hdrm, HdrmError, Options, State};
use machine_file::{Controller, Emla, Machine};
use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Matrix3, RowSVector, SMatrix, SVector, Schur};

/// Communication step for which the gains are made, s.
const STEP: f64 = 1e-3;
/// Modes slower than this, 1/s, are integrals, which have no damping ratio of interest.
const SLOWEST: f64 = 5.0;
/// Relative precision of the eigenvalues, and most iterations for them.
const PRECISION: f64 = 1e-13;
const ITERATIONS: usize = 10_000;
/// Slew, lift and tilt.
const AXES: usize = 3;

// States, of each axis: joint angle and rate, nut position and speed, current; of the controller
// the filtered required current, the integral of the voltage, the disturbance observer.
const ANGLE: usize = 0;
const RATE: usize = AXES;
const NUT: usize = 2 * AXES;
const NUT_SPEED: usize = 3 * AXES;
const CURRENT: usize = 4 * AXES;
const FILTERED: usize = 5 * AXES;
const INTEGRAL: usize = 6 * AXES;
const OBSERVER: usize = 7 * AXES;
const STATES: usize = 8 * AXES;

type Row = RowSVector<f64, STATES>;
type Square = SMatrix<f64, STATES, STATES>;

/// Booms and drives at a pose.
pub(crate) struct DriveLoop {
    /// Inertia about the first three joints, kg·m², and its inverse.
    inertia: Matrix3<f64>,
    inverse: Matrix3<f64>,
    /// dx/dζ, m/rad.
    prime: [f64; AXES],
    viscous: [f64; AXES],
    drives: [Emla; AXES],
    /// Force on each rod as a row of the states.
    force: [Row; AXES],
}

/// The least damped mode of a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Damping ratio; negative where the mode grows.
    pub damping: f64,
    /// Frequency, Hz.
    pub hertz: f64,
}

impl DriveLoop {
    /// The loop of `machine` at the joint angles `zeta`, rad. `None` if its inertia is singular.
    pub(crate) fn new(machine: &Machine, zeta: [f64; 6]) -> Result<Option<Self>, HdrmError> {
        let plant = Hdrm::new(machine, &Options::from_machine(machine))?;
        let rest = State {
            zeta,
            ..State::default()
        };
        let (M, _) = plant.equations_of_motion(&rest);
        let inertia = Matrix3::from(M.fixed_view::<AXES, AXES>(0, 0));
        let Some(inverse) = inertia.try_inverse() else {
            return Ok(None);
        };
        let strokes = plant.tree().configuration(&zeta).strokes;
        let drives = machine.emla.in_order().map(|p| *p);
        let prime = strokes.map(|stroke| stroke.prime);
        let stiffness = [0, 1, 2].map(|k| maps::stiffness(&drives[k], strokes[k].x));
        let force = std::array::from_fn(|k| {
            let p = &drives[k];
            let mut row = Row::zeros();
            row[ANGLE + k] = -stiffness[k] * prime[k];
            row[RATE + k] = -(p.C_b + p.C_act) * prime[k];
            row[NUT + k] = stiffness[k];
            row[NUT_SPEED + k] = p.C_b;
            row
        });
        Ok(Some(Self {
            inertia,
            inverse,
            prime,
            viscous: [0, 1, 2].map(|k| machine.joint_viscous[k]),
            drives,
            force,
        }))
    }

    /// The least damped mode under these gains; a damping of −1 where the modes are not found.
    pub(crate) fn least_damped(&self, gains: &Controller) -> Mode {
        let mut least = Mode {
            damping: 1.0,
            hertz: 0.0,
        };
        let mut sampled = self.sampled(gains);
        let is_finite = sampled.iter().all(|value| value.is_finite());
        // Metres and amperes differ by orders of magnitude.
        balance_parlett_reinsch(&mut sampled);
        let schur = is_finite.then(|| Schur::try_new(sampled, PRECISION, ITERATIONS));
        let Some(schur) = schur.flatten() else {
            return Mode {
                damping: -1.0,
                ..least
            };
        };
        for z in schur.complex_eigenvalues().iter() {
            let rate = libm::log(libm::hypot(z.re, z.im)) / STEP;
            let size = libm::hypot(rate, libm::atan2(z.im, z.re) / STEP);
            if size > SLOWEST && -rate / size < least.damping {
                least = Mode {
                    damping: -rate / size,
                    hertz: size / std::f64::consts::TAU,
                };
            }
        }
        least
    }

    /// The matrix of a step: the plant under held voltages, and the law's voltages.
    fn sampled(&self, gains: &Controller) -> Square {
        let mut held = SMatrix::<f64, { STATES + AXES }, { STATES + AXES }>::zeros();
        held.fixed_view_mut::<STATES, STATES>(0, 0)
            .copy_from(&(self.plant() * STEP));
        for (k, p) in self.drives.iter().enumerate() {
            held[(CURRENT + k, STATES + k)] = STEP / p.L_q;
        }
        let held = held.exp();
        let mut next = Square::from(held.fixed_view::<STATES, STATES>(0, 0));
        for k in 0..AXES {
            let (voltage, states) = self.law(k, gains);
            let input: SVector<f64, STATES> = held.fixed_view::<STATES, 1>(0, STATES + k).into();
            next += input * voltage;
            for (state, row) in states {
                next.row_mut(state + k).copy_from(&row);
            }
        }
        next
    }

    /// Rates of the plant's states.
    fn plant(&self) -> Square {
        let mut A = Square::zeros();
        let mut add = |state: usize, row: Row| {
            let mut to = A.row_mut(state);
            to += row;
        };
        for (k, p) in self.drives.iter().enumerate() {
            add(ANGLE + k, unit(RATE + k));
            for l in 0..AXES {
                let on_joint = self.force[l] * self.prime[l] - unit(RATE + l) * self.viscous[l];
                add(RATE + k, on_joint * self.inverse[(k, l)]);
            }
            let travel = maps::travel_per_radian(p);
            let J = maps::inertia(p, 1.0);
            let torque = unit(CURRENT + k) * per_ampere(p) - self.load(k);
            add(NUT + k, unit(NUT_SPEED + k));
            add(NUT_SPEED + k, torque * (travel / J));
            let emf = unit(NUT_SPEED + k) * (flux(p) / travel);
            add(
                CURRENT + k,
                (unit(CURRENT + k) * p.R_s + emf) * (-1.0 / p.L_q),
            );
        }
        A
    }

    /// Torque of load and viscous friction on motor `k`, N·m.
    fn load(&self, k: usize) -> Row {
        let p = &self.drives[k];
        let travel = maps::travel_per_radian(p);
        let nut = self.force[k] + unit(RATE + k) * (p.C_act * self.prime[k]);
        nut * travel + unit(NUT_SPEED + k) * (drag(p) / travel)
    }

    /// The voltage of drive `k`, and the next values of its law's states.
    fn law(&self, k: usize, gains: &Controller) -> (Row, [(usize, Row); 3]) {
        let Controller {
            Lambda_position: L,
            kappa_KA,
            kappa_share,
            di_qr_filter_time: T,
            ..
        } = *gains;
        let (p, prime) = (&self.drives[k], self.prime[k]);
        let travel = maps::travel_per_radian(p);
        let J = maps::inertia(p, 1.0);
        let (rate, growth) = (
            unit(ANGLE + k) * (-L * prime),
            unit(RATE + k) * (-L * prime),
        );
        let mut on_joint = unit(ANGLE + k) * (-L * self.viscous[k]);
        for l in 0..AXES {
            let M = self.inertia[(k, l)];
            let kappa = kappa_KA * libm::sqrt(kappa_share[k] * kappa_share[l]);
            on_joint -= unit(ANGLE + l) * (M * kappa * L) + unit(RATE + l) * (M * (L + kappa));
        }
        let observed = unit(OBSERVER + k) - unit(NUT_SPEED + k) * (J / travel);
        let required = on_joint * (travel / prime)
            + growth * (J / travel)
            + rate * (drag(p) / travel + p.C_act * travel)
            + observed * gains.omega_d;
        let i_qr = required / per_ampere(p);
        let ampere = gains.K_f * maps::beta_1(p, 0.0);
        let error = (i_qr - unit(CURRENT + k)) * ampere + (rate - unit(NUT_SPEED + k)) * gains.K_v;
        let voltage = unit(CURRENT + k) * p.R_s
            + (i_qr - unit(FILTERED + k)) * (p.L_q / T)
            + unit(NUT_SPEED + k) * (flux(p) / travel)
            + error
            + unit(INTEGRAL + k);
        let reached = -libm::expm1(-STEP / T);
        let filtered = unit(FILTERED + k) * (1.0 - reached) + i_qr * reached;
        let integral = unit(INTEGRAL + k) + error * (STEP * gains.omega_i);
        let reached = -libm::expm1(-STEP * gains.omega_d);
        let share = if gains.omega_d > 0.0 {
            reached / gains.omega_d
        } else {
            0.0
        };
        let felt = unit(CURRENT + k) * per_ampere(p)
            - self.force[k] * travel
            - unit(NUT_SPEED + k) * (drag(p) / travel + p.C_act * travel);
        let observer = unit(OBSERVER + k) * (1.0 - reached)
            + unit(NUT_SPEED + k) * (reached * J / travel)
            + felt * share;
        (
            voltage,
            [
                (FILTERED, filtered),
                (INTEGRAL, integral),
                (OBSERVER, observer),
            ],
        )
    }

    /// Inertia of a motor as its boom feels it over that of the boom, of the axis where it is
    /// largest.
    pub(crate) fn heaviest_motor(&self) -> f64 {
        let share = |k: usize| {
            let p = &self.drives[k];
            let (travel, prime) = (maps::travel_per_radian(p), self.prime[k]);
            maps::inertia(p, 1.0) * (prime / travel).powi(2) / self.inertia[(k, k)]
        };
        (0..AXES).map(share).fold(0.0, f64::max)
    }
}

/// The row that reads a state.
fn unit(state: usize) -> Row {
    let mut row = Row::zeros();
    row[state] = 1.0;
    row
}

/// Torque per quadrature current, N·m/A.
fn per_ampere(p: &Emla) -> f64 {
    1.5 * flux(p)
}

/// Voltage per mechanical speed, V·s/rad.
fn flux(p: &Emla) -> f64 {
    f64::from(p.p) * p.lambda_m
}

/// Viscous friction of motor and screw at the motor, N·m·s/rad.
fn drag(p: &Emla) -> f64 {
    p.C_m + p.C_s / (p.N_gear * p.N_gear)
}
