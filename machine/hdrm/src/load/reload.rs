//! Change of the load while the machine moves, for the FMU `Hdrm`. A load set down leaves with the
//! velocity of the end-effector. A load picked up has that velocity too, so that no velocity jumps,
//! or its own velocity; then the momentum of arm and load is conserved (a plastic impact).

use crate::dynamics::boom_frame::MovingParts;
use crate::geometry::body::Body;
use crate::load::Load;
use crate::plant::error::HdrmError;
use crate::plant::input::Input;
use crate::plant::state::State;
use crate::plant::{Dynamics, Hdrm};
use nalgebra::{Vector3, Vector6};
use spatial::{Inertia, Twist, Wrench};

impl Hdrm {
    /// What the end-effector carries.
    pub fn load(&self) -> &Load {
        &self.load
    }

    /// The same plant with another load; an error if a value is out of range.
    pub fn with_load(&self, load: &Load) -> Result<Self, HdrmError> {
        load.check()?;
        let mut plant = self.clone();
        plant.load = *load;
        plant.bodies[Body::PL as usize] = plant.payload.inertia(load);
        plant.parts = MovingParts::new(&plant.bodies);
        Ok(plant)
    }

    /// Plant and state after a change of the load at the instant of `now`. If the mass increases,
    /// the added inertia ΔI has the velocity `own` (m/s in the world, pure translation), or that of
    /// the end-effector. Positions and the momentum of arm and load are unchanged:
    /// ```text
    /// M⁺·zeta_dot⁺ = M⁻·zeta_dot⁻ + Jᵀ·ΔI·V_own
    /// ```
    pub fn change_load(
        &self,
        now: &Dynamics,
        load: &Load,
        own: Option<[f64; 3]>,
        input: &Input,
    ) -> Result<(Self, State), HdrmError> {
        let mut plant = self.with_load(load)?;
        let mut state = now.state;
        let after = plant.dynamics_with(&state, input);
        let [before, loaded] = [self, &plant].map(|p| p.bodies[Body::PL as usize]);
        if let Some(own) = own
            && loaded.m > before.m
        {
            let arriving = Inertia {
                m: loaded.m - before.m,
                h: loaded.h - before.h,
                I: loaded.I - before.I,
            };
            let v = now.frame.world_to_tip(&own.into());
            let at_D4 = arriving.apply(&Twist::new(v, Vector3::zeros()));
            let r = self.payload.r_D4_T4;
            let at_T4 = Wrench::new(at_D4.f, at_D4.m - r.cross(&at_D4.f));
            let momentum: Vector6<f64> =
                now.M * Vector6::from(state.zeta_dot) + now.frame.tip_forces(&at_T4);
            state.zeta_dot = after.factor.solve(&momentum).into();
        }
        plant.friction_is_stiff = plant.has_stiff_friction(&after);
        let [before, after] = [
            self.energies_at(now),
            plant.energies_at(&plant.dynamics_with(&state, input)),
        ];
        state.load_energy += (after.0 + after.1) - (before.0 + before.1);
        Ok((plant, state))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DOF, Options};
    use machine_file::Machine;
    use spatial::Pose;

    const ZETA: [f64; DOF] = [0.31, 0.52, -1.13, 0.41, -0.62, 0.37];
    const ZETA_DOT: [f64; DOF] = [0.11, -0.07, 0.13, 0.3, -0.2, 0.4];
    const OWN: [f64; 3] = [0.7, -0.4, 0.9];

    fn plant() -> Hdrm {
        let machine = Machine::reference();
        Hdrm::new(&machine, &Options::from_machine(&machine)).expect("valid")
    }

    fn moving() -> State {
        State {
            zeta: ZETA,
            zeta_dot: ZETA_DOT,
            ..State::default()
        }
    }

    fn heavier(plant: &Hdrm) -> Load {
        Load {
            mass: 170.0,
            com: [0.2, -0.3, 0.1],
            payload_mass: 331.0,
            ..*plant.load()
        }
    }

    /// Linear momentum of all bodies in the world and angular momentum about the world's origin, by
    /// each body's own twist: differences of the poses over d = 1 ms, which err by d⁴/30 times the
    /// fifth derivative and by ε/d, 1e-12 of the momentum.
    fn momentum(plant: &Hdrm, state: &State) -> Vector6<f64> {
        let d = 1e-3;
        let poses = |s: f64| {
            let zeta = std::array::from_fn(|i| state.zeta[i] + s * d * state.zeta_dot[i]);
            plant.tree().configuration(&zeta).world_poses()
        };
        let (near, far) = ([poses(-1.0), poses(1.0)], [poses(-2.0), poses(2.0)]);
        let now = poses(0.0);
        let mut sum = Vector6::zeros();
        for k in 0..Body::COUNT {
            let R_dot =
                ((near[1][k].R - near[0][k].R) * 8.0 - (far[1][k].R - far[0][k].R)) / (12.0 * d);
            let r_dot =
                ((near[1][k].r - near[0][k].r) * 8.0 - (far[1][k].r - far[0][k].r)) / (12.0 * d);
            let W = now[k].R.tr_mul(&R_dot);
            let twist = Twist::new(now[k].R.tr_mul(&r_dot), Vector3::new(W.m32, W.m13, W.m21));
            let momentum = plant.inertias()[k].apply(&twist);
            sum += now[k].wrench_to_A(&momentum).to_vector();
        }
        sum
    }

    /// A load that comes with the end-effector changes no rate; one with a velocity of its own
    /// conserves the momentum along each joint (1e-9 of its size), found from the load's own
    /// momentum with the tip's Jacobian, which shares no code with the plant's.
    #[test]
    fn picking_up_conserves_momentum() {
        let plant = plant();
        let state = moving();
        let now = plant.dynamics(&state);
        let load = heavier(&plant);
        let none = Input::default();

        let (carrying, same) = plant.change_load(&now, &load, None, &none).expect("valid");
        assert_eq!((same.zeta, same.zeta_dot), (ZETA, ZETA_DOT));
        let (_, pushed) = plant
            .change_load(&now, &load, Some(OWN), &none)
            .expect("valid");

        let configuration = plant.tree().configuration(&ZETA);
        let tip = crate::Tip::new(plant.tree(), &configuration);
        let D4 = configuration.world_poses()[Body::D4 as usize];
        let PL = |p: &Hdrm| p.inertias()[Body::PL as usize];
        let mass = PL(&carrying).m - PL(&plant).m;
        let centre = D4.R * ((PL(&carrying).h - PL(&plant).h) / mass);
        let (p, arm) = (Vector3::from(OWN) * mass, D4.r + centre - tip.position);
        let at_tip = Vector6::from_iterator(p.iter().chain(arm.cross(&p).iter()).copied());
        let arriving = tip.jacobian().transpose() * at_tip;

        let of =
            |plant: &Hdrm, state: &State| plant.dynamics(state).M * Vector6::from(state.zeta_dot);
        let (before, after) = (of(&plant, &state) + arriving, of(&carrying, &pushed));
        let error = (after - before).norm() / before.norm();
        assert!(error < 1e-9, "{error:e}");
        assert!(arriving.norm() > 0.1 * before.norm());

        // The slew axis passes through the world's origin: arm and load keep their angular momentum
        // about it, body by body.
        let L = momentum(&plant, &state)[4] + (D4.r + centre).cross(&p).y;
        let L_after = momentum(&carrying, &pushed)[4];
        assert!((L_after / L - 1.0).abs() < 1e-9, "{L_after} {L}");
    }

    /// What is set down leaves with the end-effector, whatever velocity arriving loads have.
    #[test]
    fn setting_down_changes_no_rate_and_leads_back_to_the_same_plant() {
        let plant = plant();
        let loaded = plant.with_load(&heavier(&plant)).expect("valid");
        let now = loaded.dynamics(&moving());
        let (empty, state) =
            (loaded.change_load(&now, plant.load(), Some(OWN), &Input::default())).expect("valid");
        assert_eq!(state.zeta_dot, ZETA_DOT);
        assert_eq!(empty, plant);
    }

    /// The energy that a change brings: with the end-effector's velocity, that of the load itself
    /// by hand.
    #[test]
    fn the_load_brings_its_own_energy() {
        let plant = plant();
        let state = moving();
        let now = plant.dynamics(&state);
        let load = Load {
            mass: 170.0,
            com: [0.2, -0.3, 0.1],
            ..*plant.load()
        };
        let (_, carrying) =
            (plant.change_load(&now, &load, None, &Input::default())).expect("valid");
        let at = |s: f64| {
            let zeta = std::array::from_fn(|i| ZETA[i] + s * ZETA_DOT[i]);
            let D4 = plant.tree().configuration(&zeta).world_poses()[Body::D4 as usize];
            (D4 * Pose::translation(plant.tree().r_D4_T4 + Vector3::from(load.com))).r
        };
        let d = 1e-5;
        let v = (at(d) - at(-d)) / (2.0 * d);
        let expected = 170.0 * (0.5 * v.norm_squared() + 9.81 * at(0.0).y);
        let error = carrying.load_energy / expected - 1.0;
        assert!(error.abs() < 1e-8, "{error:e}");
    }

    #[test]
    fn masses_that_are_none_are_refused() {
        let plant = plant();
        for mass in [-1.0, f64::NAN, f64::INFINITY] {
            let load = Load {
                mass,
                ..*plant.load()
            };
            let refused = plant.with_load(&load).expect_err("no mass").to_string();
            assert!(refused.contains("load.mass"), "{refused}");
        }
    }

    /// A load that is no heavier brings no momentum: setting the same load again, or setting one
    /// down, changes no rate by a bit.
    #[test]
    fn only_what_comes_brings_momentum() {
        let plant = plant();
        let state = moving();
        let now = plant.dynamics(&state);
        for load in [
            *plant.load(),
            Load {
                payload_mass: 0.0,
                ..*plant.load()
            },
        ] {
            let again = plant.change_load(&now, &load, Some(OWN), &Input::default());
            let (_, after) = again.expect("valid");
            assert_eq!(after.zeta_dot, state.zeta_dot);
        }
        let heavier = heavier(&plant);
        let picked = plant.change_load(&now, &heavier, Some(OWN), &Input::default());
        assert_ne!(picked.expect("valid").1.zeta_dot, state.zeta_dot);
    }
}
