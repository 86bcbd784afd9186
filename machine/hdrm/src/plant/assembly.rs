//! Builds the plant from machine file and options, for the FMU, `motion-check` and the studies.

use crate::DOF;
use crate::dynamics::boom_frame::MovingParts;
use crate::dynamics::gravity::Gravity;
use crate::forces::end_stop::{EndStop, JOINT_DISSIPATION, STROKE_DISSIPATION};
use crate::forces::wrist_brake::Anchor;
use crate::forces::wrist_drive::WristState;
use crate::geometry::body::{BODIES, Body};
use crate::geometry::tree::Tree;
use crate::load::Payload;
use crate::plant::error::HdrmError;
use crate::plant::input::Input;
use crate::plant::options::Options;
use crate::plant::state::State;
use crate::plant::{Dynamics, Hdrm};
use machine_file::Machine;
use spatial::Inertia;

impl Hdrm {
    /// The plant of a machine; an error if the mechanism does not work over its joint range, or an
    /// option is out of range.
    pub fn new(machine: &Machine, options: &Options) -> Result<Self, HdrmError> {
        options.check()?;
        let tree = Tree::new(machine)?;
        let payload = Payload::new(machine, options.inertia_scale);
        let bodies = inertias(machine, options, &payload);
        let free = EndStop {
            range: [f64::NEG_INFINITY, f64::INFINITY],
            stiffness: 0.0,
            dissipation: 0.0,
        };
        let mut plant = Self {
            parts: MovingParts::new(&bodies),
            payload,
            load: options.load,
            plane: options.contact.plane()?,
            tree,
            bodies,
            gravity: Gravity::from_vector(options.gravity),
            joint_viscous: options.joint_viscous,
            joint_dry: options.joint_dry,
            wrist: options.wrist.on.then_some(options.wrist),
            brake: options.brake,
            anchors: Anchor::all(&options.brake, &options.wrist),
            friction_is_stiff: false,
            tau_wrist_max: machine.limits.tau_wrist_max,
            stops: [free; DOF],
        };
        let start = plant.dynamics(&State::at_rest(machine.start.zeta));
        plant.friction_is_stiff = plant.has_stiff_friction(&start);
        plant.stops = plant.dimension_stops(machine, &start);
        Ok(plant)
    }

    /// The start state: wrist drives as built hold the pose, and brakes that are applied act.
    pub fn start_state(&self, state: State, input: &Input) -> State {
        let brakes = input.wrist_brake;
        if self.wrist.is_none() && brakes == [false; 3] {
            return state;
        }
        let (_, hold) = self.holding(&state.zeta);
        let start = |i: usize| {
            let zeta = state.zeta[3 + i];
            let mut now = match &self.wrist {
                Some(drive) => drive.at_rest(i, zeta, hold[i]),
                None => WristState::default(),
            };
            now.holds = brakes[i];
            if self.wrist.is_none() && brakes[i] {
                let left = hold[i] - self.wrist_command(input, i);
                now.angle = self.anchors[i].holding(zeta, left);
            }
            now
        };
        State {
            wrist: std::array::from_fn(start),
            ..state
        }
    }

    /// End stops, with stiffnesses for each coordinate's effective mass at `start`. Those of slew,
    /// lift and tilt are where the stroke or the joint range ends, whichever comes first (the tilt
    /// linkage has a dead point just below stroke zero, far beyond its joint range); those of the
    /// wrist at the joint limits.
    fn dimension_stops(&self, machine: &Machine, start: &Dynamics) -> [EndStop; DOF] {
        let limits = machine.limits.zeta();
        let strokes = machine.limits.strokes();
        // x_i depends on zeta_i only, so a pose at all lower limits gives all lower strokes.
        let at_limit = |end: usize| {
            let zeta = limits.map(|range| range[end]);
            self.tree.strokes(zeta[0], &self.tree.solve(&zeta))
        };
        let (low, high) = (at_limit(0), at_limit(1));
        std::array::from_fn(|i| {
            let mobility = start.factor.mobility(i);
            if i < 3 {
                let [min, max] = strokes[i];
                let range = [min.max(low[i].x), max.min(high[i].x)];
                let prime = start.strokes[i].prime;
                let mass = 1.0 / (prime * prime * mobility);
                EndStop::new(range, mass, STROKE_DISSIPATION)
            } else {
                EndStop::new(limits[i], 1.0 / mobility, JOINT_DISSIPATION)
            }
        })
    }
}

/// Inertias about body origins with the options applied.
fn inertias(machine: &Machine, options: &Options, payload: &Payload) -> [Inertia; Body::COUNT] {
    let bodies = machine.bodies.in_order();
    std::array::from_fn(|k| {
        if BODIES[k] == Body::PL {
            return payload.inertia(&options.load);
        }
        let body = bodies[k];
        let I_com = body.inertia_com.rows().into();
        let inertia = Inertia::from_com(body.mass, body.com.into(), I_com);
        inertia * options.inertia_scale
    })
}
