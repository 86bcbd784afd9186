//! A machine as URDF, for ROS and Pinocchio: a tree, with the loops cut at their pins.

use anyhow::Result;
use hdrm::{BODIES, Body};
use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;

use super::links::{Bar, Joint, Robot, colour, equivalent_box};
use crate::machines::element::Element;

/// Link on which the machine stands, z up.
const BASE: &str = "base";

/// The text of a URDF file.
pub fn urdf(robot: &Robot) -> Result<String> {
    let frame = |name: &str| Element::new("link").with("name", name);
    let links = BODIES.map(|body| link(robot, body));
    let joints = BODIES.map(|body| joint(robot, body));
    let tip = fixed("tip", "D4", &robot.machine.geometry.r_D4_T4);
    let root = Element::new("robot").with("name", &robot.name);
    let root = root
        .holding([frame(BASE)])
        .holding(links)
        .holding([frame("tip")])
        .holding(joints)
        .holding([tip]);
    root.file(&head(robot)?)
}

/// What a tree loses of the machine, with the numbers that close it again.
fn head(robot: &Robot) -> Result<String> {
    let (mut passive, mut start, mut cuts) = (Vec::new(), Vec::new(), String::new());
    for joint in BODIES.into_iter().filter_map(|body| robot.joint(body)) {
        if joint.is_passive || joint.is_slide {
            passive.push(joint.name);
        }
        start.push(format!("{}={}", joint.name, joint.start));
    }
    for cut in robot.cuts() {
        let ((rod, lc), (other, at)) = (cut.rod, cut.other);
        writeln!(cuts, "  x = {lc} of {rod:?} is x = {at} of {other:?}")?;
    }
    let (passive, start) = (passive.join(", "), start.join(" "));
    let g = &robot.machine.geometry;
    let (radius, middle) = (g.r_B, g.x1_mid);
    Ok(format!(
        "
Frames, joints and names are those of Hdrm.fmu; the link `{BASE}` has its z axis up. Joint values are joint angles in rad (zeta_1 to
zeta_6) and strokes in m (rod_2, rod_3); the slew's stroke is {middle} + {radius} zeta_1.

URDF knows trees only. Both closed loops are cut at their pins (points on the x axes of links, m):
{cuts}Lost are: the pins, so {passive} move freely here, while in the machine they follow zeta_2 and zeta_3; the
forces of the rods, which turn zeta_2 and zeta_3 in the machine and move the rods alone here; gravity's value. A tool that
closes loops needs the pins above. The start pose, in which the loops are closed:
  {start}

effort and velocity of zeta_1 to zeta_3 are what rated force and speed of the rods give at every angle of the range; effort 0: no drive.
The machine file bounds no speed of the wrist: pi rad/s stands there. Sizes of visuals are made up.
"
    ))
}

fn link(robot: &Robot, body: Body) -> Element {
    let inertial = &robot.machine.bodies.in_order()[body as usize];
    let i = &inertial.inertia_com;
    let inertia = Element::new("inertia")
        .with("ixx", i.xx)
        .with("ixy", i.xy)
        .with("ixz", i.xz)
        .with("iyy", i.yy)
        .with("iyz", i.yz)
        .with("izz", i.zz);
    let mass = Element::new("mass").with("value", inertial.mass);
    let own = Element::new("inertial").holding([origin(&inertial.com, [0.0; 3]), mass, inertia]);
    let mut drawn: Vec<_> = robot.bars(body).iter().map(cylinder).collect();
    if body == Body::PL {
        let size = Element::new("box").numbers("size", &equivalent_box(inertial));
        drawn.push([origin(&inertial.com, [0.0; 3]), geometry(size)]);
    }
    let visuals = drawn.into_iter().map(|shape| {
        let rgba = Element::new("color").numbers("rgba", &colour(body));
        let name = format!("{body:?}");
        let material = Element::new("material").with("name", name).holding([rgba]);
        Element::new("visual").holding(shape).holding([material])
    });
    (Element::new("link").with("name", format_args!("{body:?}")))
        .holding([own])
        .holding(visuals)
}

fn joint(robot: &Robot, body: Body) -> Element {
    let parent = body.parent().map_or(BASE.into(), |p| format!("{p:?}"));
    let child = format!("{body:?}");
    let Some(joint) = robot.joint(body) else {
        return fixed(&child, &parent, &[0.0; 3]);
    };
    let Joint {
        offset,
        axis,
        damping,
        ..
    } = joint;
    let place = if joint.is_slide {
        origin((joint.origin + axis * offset).as_slice(), [0.0; 3])
    } else {
        // The first joint turns the machine's y axis up.
        let upright = if body == Body::T1 { FRAC_PI_2 } else { 0.0 };
        let turned = axis * offset;
        origin(
            joint.origin.as_slice(),
            [upright + turned.x, turned.y, turned.z],
        )
    };
    let limit = Element::new("limit")
        .with("lower", joint.range[0])
        .with("upper", joint.range[1])
        .with("effort", joint.effort)
        .with("velocity", joint.rate);
    let kind = if joint.is_slide {
        "prismatic"
    } else {
        "revolute"
    };
    between(joint.name, kind, &parent, &child, place).holding([
        Element::new("axis").numbers("xyz", axis.as_slice()),
        limit,
        Element::new("dynamics").with("damping", damping),
    ])
}

/// A link that does not move in its parent.
fn fixed(child: &str, parent: &str, at: &[f64]) -> Element {
    let name = format!("{child}_fixed");
    between(&name, "fixed", parent, child, origin(at, [0.0; 3]))
}

fn between(name: &str, kind: &str, parent: &str, child: &str, place: Element) -> Element {
    let joint = Element::new("joint").with("name", name).with("type", kind);
    joint.holding([
        Element::new("parent").with("link", parent),
        Element::new("child").with("link", child),
        place,
    ])
}

fn origin(xyz: &[f64], rpy: [f64; 3]) -> Element {
    (Element::new("origin").numbers("xyz", xyz)).numbers("rpy", &rpy)
}

fn geometry(shape: Element) -> Element {
    Element::new("geometry").holding([shape])
}

/// Origin and geometry of a bar: a cylinder's axis is z, turned by pitch and yaw.
fn cylinder(bar: &Bar) -> [Element; 2] {
    let along = bar.to - bar.from;
    let length = along.norm();
    let rpy = [0.0, (along.z / length).acos(), along.y.atan2(along.x)];
    let shape = Element::new("cylinder")
        .with("radius", bar.radius)
        .with("length", length);
    let middle = (bar.from + bar.to) * 0.5;
    [origin(middle.as_slice(), rpy), geometry(shape)]
}
