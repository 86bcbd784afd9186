//! Macros for the examples `arrays2` and `arrays3`: structs with arrays of one type, of a fixed
//! length and of a length set by a parameter. The model passes inputs to outputs, the vector a step
//! later.

use fmu_export::prelude::*;

/// How a valve stands
#[derive(Clone, Copy, Debug, PartialEq, Enumeration)]
pub(crate) enum Valve {
    /// No flow
    Closed,
    /// Half the flow
    Half,
    /// All flow
    Open,
}

/// `arrays! { name Type [attributes of each field] = start value }`
macro_rules! arrays {
    ($module:ident $type:ident $(<$of:ident>)? [$($said:tt)*] = $($start:tt)*) => {
        pub(crate) mod $module {
            #[allow(unused_imports)]
            use super::*;

            #[derive(Parameters)]
            pub(crate) struct Parameters {
                /// An array
                #[fmu($($said)* start = $($start)*)]
                pub(crate) array: [$type $(<$of>)?; 3],
                /// A matrix
                #[fmu($($said)* start = $($start)*, len = (p.n, 2), tunable)]
                pub(crate) matrix: Vec<$type $(<$of>)?>,
            }

            #[derive(Input)]
            pub(crate) struct Input {
                /// A vector
                #[fmu($($said)* start = $($start)*, len = p.n)]
                pub(crate) vector: Vec<$type $(<$of>)?>,
                /// A matrix
                #[fmu($($said)* start = $($start)*)]
                pub(crate) matrix: [[$type $(<$of>)?; 2]; 2],
            }

            #[derive(Output)]
            pub(crate) struct Output {
                /// The vector as it was in the last step
                #[fmu($($said)* len = p.n, depends_on())]
                pub(crate) last: Vec<$type $(<$of>)?>,
                /// The matrix
                #[fmu($($said)* depends_on($module.matrix), initially_depends_on($module.matrix))]
                pub(crate) now: [[$type $(<$of>)?; 2]; 2],
                /// The matrix of the parameters
                #[fmu($($said)* len = (p.n, 2), depends_on(), initially_depends_on($module.matrix))]
                pub(crate) given: Vec<$type $(<$of>)?>,
            }
        }
    };
}

/// The model of some of them.
macro_rules! model {
    ($model:ident $description:literal $($module:ident)*) => {
        #[derive(Parameters)]
        struct Parameters {
            /// Length of vectors
            #[fmu(structural, start = 3, min = 1, max = 1000)]
            n: i32,
            $($module: [$module::Parameters; 2],)*
        }

        #[derive(Input)]
        struct Input {
            $($module: $module::Input,)*
        }

        #[derive(Output)]
        struct Output {
            $($module: $module::Output,)*
        }

        /// Its state: the inputs of the last step.
        #[derive(Clone, serde::Serialize, serde::Deserialize)]
        struct $model(Input);

        impl Model for $model {
            derived!(Parameters, Input, Output);
            const INFO: Info = Info::new(stringify!($model), $description).experiment(0.0, 1.0, 0.1);

            fn initialize(_: &Parameters, u: &Input, _: f64) -> Result<Self, ModelError> {
                Ok(Self(u.clone()))
            }

            fn output(&self, p: &Parameters, u: &Input, _: &()) -> Result<Output, ModelError> {
                Ok(Output {
                    $($module: $module::Output {
                        last: self.0.$module.vector.clone(),
                        now: u.$module.matrix.clone(),
                        given: p.$module[1].matrix.clone(),
                    },)*
                })
            }

            fn step(&mut self, _: &Parameters, u: &InputPolynomial<Input>, _: &(), _: f64, _: f64) -> Result<StepEnd, ModelError> {
                self.0 = u.value().clone();
                Ok(StepEnd::WHOLE)
            }
        }

        export_fmu!($model);
    };
}
