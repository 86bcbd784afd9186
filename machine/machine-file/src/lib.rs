//! Reads, checks and writes a machine's parameters as JSON (the machine file), and embeds the
//! shipped machines, for models of plant, actuators and controller, their FMUs, studies and Python.
//!
//! A [`Machine`] that [`Machine::from_json`] returns is finite, complete and within its physical
//! ranges, so the models need not check again. SI units throughout. Frames and symbols follow the
//! paper; field names are the JSON keys, so that error message, file and equation show the same
//! symbol. Besides, the crate has the inputs and brake states that both actuator models share.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // fields carry the paper's symbols and are the JSON keys

mod actuator;
mod angles;
mod bodies;
mod check;
mod controller;
mod dq;
mod drive_state;
mod fields;
mod geometry;
mod input;
mod inscription;
mod json;
mod machine;
mod per_axis;
mod shape;
mod source;

pub use actuator::{Brake, CoreLosses, Emla, Heat, InverterLosses, Ratings, Temperature};
pub use bodies::{Bodies, Body, InertiaTensor, Limits, Start};
pub use check::{Finding, MachineError};
pub use controller::{Controller, CubeAxes, CubicPath, Trajectories, TriangularPath};
pub use dq::Dq;
pub use drive_state::{BrakeState, DEAD_LINK, is_tripped, link_current, trip_message};
pub use fields::EmlaFields;
pub use geometry::Geometry;
pub use input::{ActuatorInput, Drive};
pub use inscription::{Inscribed, Inscription, inscribe};
pub use machine::Machine;
pub use model_rules::Seconds;
pub use per_axis::{AXES, PerAxis};
pub use shape::nearest;
pub use source::{PRESETS, Source, extension_of, preset};

/// The reference machine's JSON, as shipped in `parameters/`.
pub const REFERENCE_JSON: &str = include_str!("../../../parameters/reference_machine.json");

/// The reference machine with an actuator sized for each axis: `parameters/sized_machine.json`.
pub const SIZED_JSON: &str = include_str!("../../../parameters/sized_machine.json");

/// A HIAB XS031 loader crane on a research platform, with electric actuators:
/// `parameters/hiab_xs031.json`.
pub const HIAB_XS031_JSON: &str = include_str!("../../../parameters/hiab_xs031.json");

/// The JSON Schema of [`Machine`], for editors (tested): `parameters/machine.schema.json`.
pub const SCHEMA_JSON: &str = include_str!("../../../parameters/machine.schema.json");

impl Machine {
    /// The reference machine, compiled from [`REFERENCE_JSON`] without parsing at run time.
    pub fn reference() -> Self {
        include!(concat!(env!("OUT_DIR"), "/reference.rs"))
    }
}

#[cfg(test)]
#[path = "../tests/unit/schema.rs"]
mod schema;

#[cfg(test)]
mod tests {
    use super::*;

    /// What is compiled in has the bits of the file: numbers are written with as many digits as
    /// tell them apart.
    #[test]
    fn the_reference_machine_is_the_file() {
        let machine = Machine::reference();
        let read = Machine::from_json(REFERENCE_JSON).expect("valid");
        assert_eq!(machine, read);
        assert_eq!(
            format!("{machine:?}"),
            format!("{read:?}"),
            "signs of zeros"
        );
        assert_eq!(machine.geometry.r_B, 0.35);
        assert_eq!(machine.emla.lift.p, 4);
    }

    /// Slew, lift and tilt differ, and nothing else does.
    #[test]
    fn the_sized_machine_has_other_actuators_only() {
        let reference = Machine::reference();
        let sized = Machine::from_json(SIZED_JSON).expect("valid");
        assert!(!sized.emla.is_common() && !sized.ratings.is_common());
        let same = Machine {
            emla: reference.emla,
            ratings: reference.ratings,
            ..sized
        };
        assert_eq!(same, reference);
    }

    #[test]
    fn a_machine_survives_its_json() {
        let machine = Machine::reference();
        let json = serde_json::to_string(&machine).expect("serialisable");
        assert_eq!(Machine::from_json(&json).expect("valid"), machine);
    }

    /// Changes one field of the reference JSON and returns the error text.
    fn refused(pointer: &str, value: serde_json::Value) -> String {
        let mut json: serde_json::Value = serde_json::from_str(REFERENCE_JSON).expect("JSON");
        *json.pointer_mut(pointer).expect("field exists") = value;
        Machine::from_json(&json.to_string())
            .expect_err("must be refused")
            .to_string()
    }

    /// One section for each axis: read, checked and written by its name; a file of one section
    /// stays one of one section.
    #[test]
    fn each_axis_may_have_an_actuator_of_its_own() {
        let mut json: serde_json::Value = serde_json::from_str(REFERENCE_JSON).expect("JSON");
        let common = json["emla"].clone();
        let mut small = common.clone();
        small["R_s"] = 0.7.into();
        json["emla"] = serde_json::json!({"tilt": common, "slew": small, "lift": common});
        let machine = Machine::from_json(&json.to_string()).expect("valid");
        assert_eq!((machine.emla.slew.R_s, machine.emla.tilt.R_s), (0.7, 0.2));
        assert!(machine.ratings.is_common());
        let written = serde_json::to_string(&machine).expect("serialisable");
        assert_eq!(Machine::from_json(&written).expect("valid"), machine);
        let reference = serde_json::to_value(Machine::reference()).expect("serialisable");
        assert_eq!(reference["emla"]["R_s"], 0.2);
        let refused = |json: &serde_json::Value| {
            let error = Machine::from_json(&json.to_string()).expect_err("refused");
            error.to_string()
        };
        json["emla"]["slew"]["R_s"] = (-1).into();
        assert_eq!(
            refused(&json),
            "`emla.slew.R_s` = -1 must be finite and > 0"
        );
        json["emla"]["slew"].take();
        assert_eq!(refused(&json), "`emla.slew` = null must be an object");
        json["emla"].as_object_mut().expect("object").remove("slew");
        assert_eq!(refused(&json), "`emla.slew` is missing");
        json["emla"]["slew"] = common.clone();
        json["emla"]["wrist"] = common;
        assert_eq!(
            refused(&json),
            "`emla.wrist` must be inside `slew`, `lift` or `tilt`, which this section has"
        );
    }

    #[test]
    fn errors_name_field_value_and_rule() {
        let text = refused("/emla/R_s", (-0.3).into());
        assert_eq!(text, "`emla.R_s` = -0.3 must be finite and > 0");
        let text = refused("/bodies/A3/mass", 0.0.into());
        assert_eq!(text, "`bodies.A3.mass` = 0 must be finite and > 0");
        let text = refused("/bodies/D4/inertia_com/xx", 30.0.into());
        assert!(text.contains("bodies.D4.inertia_com"), "{text}");
        assert!(text.contains("triangle inequality"), "{text}");
        let text = refused("/limits/stroke_2", serde_json::json!([0.5, 0.1]));
        assert!(text.contains("limits.stroke_2"), "{text}");
        let text = refused("/controller/gamma", 0.0.into());
        assert!(text.contains("controller.gamma"), "{text}");
        let text = refused("/trajectories/triangular/edge_time", 0.0.into());
        assert!(text.contains("trajectories.triangular.edge_time"), "{text}");
        let text = refused("/start/zeta", serde_json::json!([0, 3.0, -1.4, 0, -0.9, 0]));
        assert!(text.contains("start.zeta[2]"), "{text}");
    }

    #[test]
    fn edges_of_ranges_are_refused() {
        for (pointer, value) in [
            ("/controller/inverse_bounds", serde_json::json!([0.0, 4.0])),
            ("/controller/inverse_bounds", serde_json::json!([1.0, 4.0])),
            ("/controller/inverse_bounds", serde_json::json!([0.5, 1.0])),
            ("/emla/inverter/r_0", (-0.01).into()),
            ("/limits/stroke_2", serde_json::json!([0.25, 0.25])),
            (
                "/trajectories/cubic/vertices",
                serde_json::json!([[0, 0, 0]]),
            ),
        ] {
            let field = pointer[1..].replace('/', ".");
            assert!(refused(pointer, value).contains(&field), "{field}");
        }
    }

    #[test]
    fn gains_that_older_files_lack_have_their_values() {
        let mut json: serde_json::Value = serde_json::from_str(REFERENCE_JSON).expect("JSON");
        let gains = json["controller"].as_object_mut().expect("gains");
        for name in ["lambda_i", "Lambda_rod"] {
            gains.remove(name);
        }
        let gains = Machine::from_json(&json.to_string())
            .expect("valid")
            .controller;
        assert_eq!((gains.lambda_i, gains.Lambda_rod), (50.0, 20.0));
    }

    /// Oracle: by hand, with axes of which no two are alike.
    #[test]
    fn vertices_of_the_cube_lie_along_its_axes() {
        let path = CubicPath {
            edge: 0.5,
            axes: CubeAxes {
                first: [1.0, 2.0, 3.0],
                second: [5.0, 7.0, 11.0],
                third: [13.0, 17.0, 19.0],
            },
            vertices: vec![[2.0, 3.0, 4.0]],
            ..Machine::reference().trajectories.cubic
        };
        assert_eq!(path.world_vertices(), [[34.5, 46.5, 57.5]]);
    }

    #[test]
    fn unknown_and_missing_fields_are_refused_by_name() {
        let unknown = REFERENCE_JSON.replacen("\"gravity\"", "\"gravitas\"", 1);
        let text = Machine::from_json(&unknown).unwrap_err().to_string();
        assert_eq!(
            text,
            "`gravitas` is an unknown field; did you mean `gravity`?; `gravity` is missing"
        );
        let lines = Machine::from_json("{}").unwrap_err().lines();
        assert_eq!(lines.len(), 10, "{lines:?}");
        assert_eq!(lines[0], "`bodies` is missing");
    }

    /// Loss sections are optional: a file without them describes an ideal inverter and core.
    #[test]
    fn loss_sections_may_be_left_out() {
        let mut json: serde_json::Value = serde_json::from_str(REFERENCE_JSON).expect("JSON");
        let emla = json["emla"].as_object_mut().expect("object");
        emla.remove("core");
        emla.remove("inverter");
        let machine = Machine::from_json(&json.to_string()).expect("valid");
        assert_eq!(machine.emla.lift.core, None);
        assert_eq!(machine.emla.lift.inverter, None);
    }
}
