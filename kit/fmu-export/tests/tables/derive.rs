//! A table from derives is the table by hand: the same model description.

use fmu_export::prelude::*;
use fmu_export::{ALL_PARAMETERS, DisplayUnit, model_description};
use serde::{Deserialize, Serialize};
use std::path::Path;

const VISCOSITY: Unit = Unit::new("Pa.s")
    .kg(1)
    .m(-1)
    .s(-1)
    .display(&[DisplayUnit::new("mPa.s", 1e3)]);
const G: f64 = 9.80665;

mod derived {
    use super::*;

    /// Law of the spring
    #[derive(Clone, Copy, Debug, PartialEq, Enumeration)]
    pub enum Law {
        /// force k x
        #[fmu(name = "linear")]
        Linear,
        /// force k x (1 + x²)
        #[fmu(name = "hardening")]
        Hardening,
    }

    #[derive(Parameters)]
    pub struct Winding {
        /// Resistance.
        #[fmu(
            name = "R",
            unit = "Ohm",
            display_unit = "mOhm",
            start = 0.5,
            min = 0,
            nominal = 0.1
        )]
        pub resistance: f64,
        /// Turns
        #[fmu(start = 12, min = 1, max = 100)]
        pub turns: i32,
    }

    #[derive(Parameters)]
    pub struct Motor {
        /// Each phase alike.
        pub winding: Winding,
        /// Moment of inertia
        #[fmu(unit = "kg.m2", start = 0.125, tunable)]
        pub inertia: f64,
        #[fmu(skip)]
        pub calls: u32,
    }

    #[derive(Parameters)]
    pub struct Parameters {
        /// Standard gravity
        #[fmu(unit = "m/s2", start = G, constant)]
        pub g: f64,
        pub motor: Motor,
        #[fmu(name = "second", start = Motor { inertia: 0.25, ..fmu_export::derive::Parameters::start() })]
        pub other: Motor,
        /// Viscosity of the oil,
        /// at the start
        ///
        /// More about it.
        #[fmu(unit = VISCOSITY, display_unit = "mPa.s", start = 0.03)]
        pub viscosity: f64,
        /// Start of x
        #[fmu(unit = "m", start = [1, -2.5])]
        pub x_start: [f64; 2],
        /// Corners
        #[fmu(unit = "1", start = 0.75)]
        pub corners: [f64; 3],
        /// Law of the spring
        #[fmu(start = Law::Hardening)]
        pub law: Choice<Law>,
        /** Whether it is on */
        #[fmu(start = true, at = 100)]
        pub on: bool,
        /// A note
        #[fmu(start = "none")]
        pub note: String,
        /// File to read
        #[fmu(set = read)]
        pub file: String,
    }

    fn read(p: &mut Parameters, text: &str, _folder: Option<&Path>) -> Result<(), String> {
        text.clone_into(&mut p.file);
        Ok(())
    }

    #[derive(Input)]
    pub struct Oil {
        /// Flow of the oil
        #[fmu(unit = "m3/s", discrete)]
        pub r#flow: f64,
    }

    #[derive(Input)]
    pub struct Input {
        /// Forces
        #[fmu(unit = "N", display_unit = "kN", start = [0.5, -0.25], max = 1e6)]
        pub u: [f64; 2],
        pub oil: Oil,
        /// Gear
        #[fmu(start = -1, min = -1, max = 5, not_in_evaluation)]
        pub gear: i32,
        /// Brake
        pub brake: bool,
        /// Law in use
        #[fmu(start = Law::Linear, name = "law_in_use")]
        pub law: Choice<Law>,
    }

    #[derive(Output)]
    pub struct Power {
        /// Losses
        #[fmu(unit = "W", depends_on(), initially_depends_on(motor.winding.R, u[i], parameters))]
        pub loss: f64,
    }

    #[derive(Output)]
    pub struct Output {
        /// Sums
        #[fmu(unit = "N", depends_on(u[i], oil.flow, "u[2]"), initially_depends_on(u))]
        pub y: [f64; 2],
        pub power: Power,
        /// Gear, doubled
        #[fmu(at = 17, name = "doubled_gear")]
        pub gear: i32,
        /// Law in use
        #[fmu(name = "law_found")]
        pub law: Choice<Law>,
        /// Braking
        #[fmu(local, name = "braking")]
        pub brake: bool,
        /// What it does
        pub does: &'static str,
        /// Natural frequency
        #[fmu(unit = "rad/s", calculated, initially_depends_on(motor.inertia))]
        pub w_0: f64,
    }

    #[derive(Clone, Serialize, Deserialize)]
    pub struct Machine;

    impl Model for Machine {
        const INFO: Info = INFO;
        derived!(Parameters, Input, Output);

        fn initialize(_p: &Parameters, _u: &Input, _t: f64) -> Result<Self, ModelError> {
            Ok(Self)
        }

        fn output(&self, p: &Parameters, u: &Input, _now: &()) -> Result<Output, ModelError> {
            Ok(Output {
                y: [u.u[0] + u.oil.flow + u.u[1], u.u[1] + u.oil.flow],
                power: Power {
                    loss: p.motor.winding.resistance,
                },
                gear: u.gear,
                law: u.law,
                brake: u.brake,
                does: if *p.law == Law::Linear {
                    "swings"
                } else {
                    "sticks"
                },
                w_0: 1.0 / p.motor.inertia,
            })
        }

        fn step(
            &mut self,
            _p: &Parameters,
            _u: &InputPolynomial<Input>,
            _now: &(),
            _t: f64,
            _h: f64,
        ) -> Result<StepEnd, ModelError> {
            Ok(StepEnd::WHOLE)
        }
    }
}

mod by_hand {
    use super::*;
    use fmu_export::{Enumeration, Variable};

    const LAW: Enumeration = Enumeration::new(
        "Law",
        "Law of the spring",
        &[("linear", "force k x"), ("hardening", "force k x (1 + x²)")],
    );

    #[derive(Clone, Serialize, Deserialize)]
    pub struct Parameters {
        inertia: [f64; 2],
        resistance: [f64; 2],
        turns: [i32; 2],
        viscosity: f64,
        x_start: [f64; 2],
        corners: [f64; 3],
        law: i32,
        on: bool,
        note: String,
        file: String,
    }

    #[derive(Clone, Copy, Default, Serialize, Deserialize)]
    pub struct Input {
        u: [f64; 2],
        flow: f64,
        gear: i32,
        brake: bool,
        law: i32,
    }

    #[derive(Clone, Copy, Default)]
    pub struct Output {
        y: [f64; 2],
        loss: f64,
        gear: i32,
        law: i32,
        brake: bool,
        w_0: f64,
    }

    #[derive(Clone, Serialize, Deserialize)]
    pub struct Machine;
    type V = Variable<Machine>;

    #[rustfmt::skip]
    const VARIABLES: &[V] = &[
        V::constant("g", "Standard gravity", |_| &G).unit("m/s2"),
        V::parameter("motor.winding.R", "Resistance", |p| &p.resistance[0], |p| &mut p.resistance[0]).unit("Ohm").display_unit("mOhm").min(0.0).nominal(0.1),
        V::integer_parameter("motor.winding.turns", "Turns", |p| &p.turns[0], |p| &mut p.turns[0]).min(1.0).max(100.0),
        V::parameter("motor.inertia", "Moment of inertia", |p| &p.inertia[0], |p| &mut p.inertia[0]).unit("kg.m2").tunable(),
        V::parameter("second.winding.R", "Resistance", |p| &p.resistance[1], |p| &mut p.resistance[1]).unit("Ohm").display_unit("mOhm").min(0.0).nominal(0.1),
        V::integer_parameter("second.winding.turns", "Turns", |p| &p.turns[1], |p| &mut p.turns[1]).min(1.0).max(100.0),
        V::parameter("second.inertia", "Moment of inertia", |p| &p.inertia[1], |p| &mut p.inertia[1]).unit("kg.m2").tunable(),
        V::parameter("viscosity", "Viscosity of the oil, at the start", |p| &p.viscosity, |p| &mut p.viscosity).own_unit(&VISCOSITY).display_unit("mPa.s"),
        V::parameters("x_start", "Start of x", |p| &p.x_start, |p| &mut p.x_start).unit("m"),
        V::parameters("corners", "Corners", |p| &p.corners, |p| &mut p.corners).unit("1"),
        V::integer_parameter("law", "Law of the spring", |p| &p.law, |p| &mut p.law).enumeration(&LAW),
        V::boolean_parameter("on", "Whether it is on", |p| &p.on, |p| &mut p.on).at(100),
        V::string_parameter("note", "A note", |p| &p.note, |_, _, _| Ok(())),
        V::string_parameter("file", "File to read", |p| &p.file, |_, _, _| Ok(())),
        V::inputs("u", "Forces", |u| &u.u, |u| &mut u.u).unit("N").display_unit("kN").max(1e6),
        V::input("oil.flow", "Flow of the oil", |u| &u.flow, |u| &mut u.flow).unit("m3/s").discrete(),
        V::integer_input("gear", "Gear", |u| &u.gear, |u| &mut u.gear).min(-1.0).max(5.0).not_in_evaluation(),
        V::boolean_input("brake", "Brake", |u| &u.brake, |u| &mut u.brake),
        V::integer_input("law_in_use", "Law in use", |u| &u.law, |u| &mut u.law).enumeration(&LAW),
        V::outputs("y", "Sums", |y| &y.y).unit("N").depends_on(&["u[i]", "oil.flow", "u[2]"]).initially_depends_on(&["u"]),
        V::output("power.loss", "Losses", |y| &y.loss).unit("W").depends_on(&[]).initially_depends_on(&["motor.winding.R", "u[i]", ALL_PARAMETERS]),
        V::integer_output("doubled_gear", "Gear, doubled", |y| &y.gear).at(17),
        V::integer_output("law_found", "Law in use", |y| &y.law).enumeration(&LAW),
        V::boolean_local("braking", "Braking", |y| &y.brake),
        V::string_output("does", "What it does", |_| "nothing"),
        V::calculated_parameter("w_0", "Natural frequency", |y| &y.w_0).unit("rad/s").initially_depends_on(&["motor.inertia"]),
    ];

    impl Model for Machine {
        type Parameters = Parameters;
        type Input = Input;
        type Output = Output;
        type Evaluation = ();
        const INFO: Info = INFO;

        fn variables() -> &'static [V] {
            VARIABLES
        }

        fn defaults() -> (Parameters, Input) {
            let p = Parameters {
                inertia: [0.125, 0.25],
                resistance: [0.5; 2],
                turns: [12; 2],
                viscosity: 0.03,
                x_start: [1.0, -2.5],
                corners: [0.75; 3],
                law: 2,
                on: true,
                note: "none".to_owned(),
                file: String::new(),
            };
            let u = Input {
                u: [0.5, -0.25],
                gear: -1,
                law: 1,
                ..Input::default()
            };
            (p, u)
        }

        idle_model!();
    }
}

const INFO: Info = Info::new("Machine", "two tables that are the same");

#[test]
fn a_derived_table_is_the_table_by_hand() {
    let derived = model_description::<derived::Machine>().unwrap();
    let by_hand = model_description::<by_hand::Machine>().unwrap();
    assert_eq!(derived, by_hand);
}
