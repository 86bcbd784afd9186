//! A machine as MJCF, for MuJoCo: both loops closed by `connect` constraints, one actuator for each
//! force and torque of `Hdrm`, the start pose as keyframe.

use anyhow::Result;
use hdrm::Body;
use std::f64::consts::FRAC_PI_2;

use super::links::{Robot, colour, equivalent_box};
use crate::machines::element::Element;

/// Step, s, up to which MuJoCo's explicit integration holds the pins.
const TIMESTEP: f64 = 2.5e-4;

const HEAD: &str = "
The machine's frames, joints and names are those of Hdrm.fmu; the first frame turns its y axis up. Joint values are joint angles in rad
(zeta_1 to zeta_6) and strokes in m (rod_2, rod_3); the slew's stroke is x1_mid and the tendon x_1. Inputs: f_1 to f_3 in N, positive when
pushing, limited to the rated force, and tau_wrist_1 to tau_wrist_3 in N.m. The keyframe `start` is the start pose with the forces that hold it.
The pins of the loops are soft in MuJoCo, as solref and solimp say. Sizes of geoms are made up; nothing collides.
";

/// The text of an MJCF file.
pub fn mjcf(robot: &Robot) -> Result<String> {
    let machine = robot.machine;
    let mut qpos = Vec::new();
    let bodies: Vec<_> = (robot
        .children(None)
        .map(|child| body(robot, child, &mut qpos)))
    .collect();
    let upright = Element::new("frame").numbers("euler", &[FRAC_PI_2, 0.0, 0.0]);
    let light = Element::new("light").numbers("pos", &[0.0, -5.0, 8.0]);
    let floor = Element::new("geom")
        .with("type", "plane")
        .numbers("size", &[10.0, 10.0, 0.1])
        .numbers("rgba", &[0.8, 0.82, 0.84, 1.0]);
    let world = [light, floor, upright.holding(bodies)];

    let pins = robot.cuts().map(|cut| {
        let ((rod, lc), (other, _)) = (cut.rod, cut.other);
        Element::new("connect")
            .with("body1", format_args!("{rod:?}"))
            .with("body2", format_args!("{other:?}"))
            .numbers("anchor", &[lc, 0.0, 0.0])
    });
    let slew = Element::new("joint")
        .with("joint", "zeta_1")
        .with("coef", machine.geometry.r_B);
    let [min, max] = machine.limits.stroke_1.map(|x| x - machine.geometry.x1_mid);
    let rack = Element::new("fixed")
        .with("name", "x_1")
        .numbers("range", &[min, max])
        .holding([slew]);
    let motor = |name: String, on: &'static str, of: String, most: f64| {
        Element::new("motor")
            .with("name", name)
            .with(on, of)
            .numbers("ctrlrange", &[-most, most])
    };
    let ratings = machine.ratings.in_order();
    let rods = (1..=3).zip(ratings).map(|(i, ratings)| {
        let (on, of) = if i == 1 {
            ("tendon", "x_1".into())
        } else {
            ("joint", format!("rod_{i}"))
        };
        motor(format!("f_{i}"), on, of, ratings.force_max)
    });
    let wrist = (1..=3).zip(machine.limits.tau_wrist_max).map(|(i, most)| {
        motor(
            format!("tau_wrist_{i}"),
            "joint",
            format!("zeta_{}", i + 3),
            most,
        )
    });
    let (f, tau) = robot.plant.holding(&machine.start.zeta);
    let key = Element::new("key")
        .with("name", "start")
        .numbers("qpos", &qpos)
        .numbers("ctrl", &[f, tau].concat());
    let middle = Element::new("numeric")
        .with("name", "x1_mid")
        .with("data", machine.geometry.x1_mid);

    let compiler = Element::new("compiler")
        .with("angle", "radian")
        .with("balanceinertia", false);
    let option = Element::new("option")
        .numbers("gravity", &[0.0, 0.0, -machine.gravity])
        .with("timestep", TIMESTEP)
        .with("jacobian", "dense")
        .with("iterations", 50)
        .with("tolerance", "1e-12")
        .holding([Element::new("flag").with("energy", "enable")]);
    let defaults = [
        Element::new("geom")
            .with("contype", 0)
            .with("conaffinity", 0),
        Element::new("equality")
            .numbers("solref", &[2.0 * TIMESTEP, 1.0])
            .numbers("solimp", &[0.9999, 0.9999, 0.001, 0.5, 2.0]),
    ];
    let root = Element::new("mujoco").with("model", &robot.name).holding([
        compiler,
        option,
        Element::new("default").holding(defaults),
        Element::new("custom").holding([middle]),
        Element::new("worldbody").holding(world),
        Element::new("equality").holding(pins),
        Element::new("tendon").holding([rack]),
        Element::new("actuator").holding(rods.chain(wrist)),
        Element::new("keyframe").holding([key]),
    ]);
    root.file(HEAD)
}

/// A body with all that hangs on it; `qpos` collects the joints' start values in MuJoCo's order.
fn body(robot: &Robot, of: Body, qpos: &mut Vec<f64>) -> Element {
    let mut element = Element::new("body").with("name", format_args!("{of:?}"));
    if let Some(joint) = robot.joint(of) {
        let at = joint.offset + joint.start;
        let axis = joint.axis.as_slice();
        let mut own = Element::new("joint")
            .with("name", joint.name)
            .numbers("axis", axis);
        if joint.is_slide {
            element = element.numbers("pos", (joint.origin + joint.axis * at).as_slice());
            own = own.with("type", "slide");
        } else {
            let turn = [axis, &[at]].concat();
            element = element
                .numbers("pos", joint.origin.as_slice())
                .numbers("axisangle", &turn);
        }
        own = own.with("ref", joint.start);
        if !joint.is_passive {
            own = own.numbers("range", &joint.range);
        }
        element = element.holding([own.with("damping", joint.damping)]);
        qpos.push(joint.start);
    }
    let inertial = &robot.machine.bodies.in_order()[of as usize];
    let i = &inertial.inertia_com;
    element = element.holding([Element::new("inertial")
        .numbers("pos", &inertial.com)
        .with("mass", inertial.mass)
        .numbers("fullinertia", &[i.xx, i.yy, i.zz, i.xy, i.xz, i.yz])]);
    let bars = robot.bars(of).into_iter().map(|bar| {
        let ends = [bar.from.as_slice(), bar.to.as_slice()].concat();
        Element::new("geom")
            .with("type", "capsule")
            .with("size", bar.radius)
            .numbers("fromto", &ends)
            .numbers("rgba", &colour(of))
    });
    element = element.holding(bars);
    if of == Body::PL {
        element = element.holding([Element::new("geom")
            .with("type", "box")
            .numbers("pos", &inertial.com)
            .numbers("size", &equivalent_box(inertial).map(|edge| 0.5 * edge))
            .numbers("rgba", &colour(of))]);
    }
    if of == Body::D4 {
        let tip = robot.machine.geometry.r_D4_T4;
        element = element.holding([Element::new("site")
            .with("name", "tip")
            .numbers("pos", &tip)]);
    }
    let children = robot
        .children(Some(of))
        .map(|child| body(robot, child, qpos));
    element.holding(children)
}
