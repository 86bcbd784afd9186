//! Macros for tables that models' authors write: [`joined!`](crate::joined) joins lists, and
//! [`row!`](crate::row) makes a row from its name and field.

/// Joins constant slices to one at compile time: lists of names, or rows of a table.
///
/// ```
/// use fmu_export::joined;
///
/// const MOTION: &[&str] = &["x", "x_dot"];
/// const MOTION_AND_CURRENTS: &[&str] = joined!(MOTION, &["i_d[i]", "i_q[i]"]);
/// assert_eq!(MOTION_AND_CURRENTS, ["x", "x_dot", "i_d[i]", "i_q[i]"]);
/// ```
///
/// At least one of the parts must not be empty.
#[macro_export]
macro_rules! joined {
    ($($part:expr),+ $(,)?) => {
        const { &$crate::join::<_, { $crate::total(&[$($part),+]) }>(&[$($part),+]) }
    };
}

/// A row of the table with accessors made from its name, so that the field is written once.
///
/// First comes the type `Variable` of the model; then the name of the row's constructor, then the
/// name of the variable, and the field if it is not that of the name:
///
/// ```
/// # use fmu_export::*; use serde::{Deserialize, Serialize};
/// # #[derive(Clone, Serialize, Deserialize)] struct Motor;
/// # #[derive(Clone, Serialize, Deserialize)] struct Winding { R_s: f64 }
/// # #[derive(Clone, Serialize, Deserialize)] struct Machine { winding: Winding }
/// # #[derive(Clone, Serialize, Deserialize)] struct Parameters { machine: Machine, T_start: [f64; 2] }
/// # #[derive(Clone, Copy, Default, Serialize, Deserialize)] struct Input { u: [f64; 2], load: CountedInput<f64> }
/// # #[derive(Clone, Copy, Default)] struct Output { P_copper: f64, i: [f64; 2] }
/// # impl Model for Motor { type Parameters = Parameters; type Input = Input; type Output = Output; type Evaluation = ();
/// # const INFO: Info = Info::new("Motor", "motor"); fn variables() -> &'static [Variable<Self>] { TABLE }
/// # fn defaults() -> (Parameters, Input) { (Parameters { machine: Machine { winding: Winding { R_s: 1.0 } }, T_start: [293.15, 294.15] }, Input::default()) }
/// # fn initialize(_: &Parameters, _: &Input, _: f64) -> Result<Self, ModelError> { Ok(Motor) }
/// # fn output(&self, _: &Parameters, _: &Input, _: &()) -> Result<Output, ModelError> { Ok(Output::default()) }
/// # fn step(&mut self, _: &Parameters, _: &InputPolynomial<Input>, _: &(), _: f64, _: f64) -> Result<StepEnd, ModelError> { Ok(StepEnd::WHOLE) } }
/// type V = Variable<Motor>;
///
/// const TABLE: &[V] = &[
///     row!(V, inputs u, "voltages").unit("V").range(-1e4..=1e4),      // |u| &u.u
///     row!(V, counted_input load, "torque of the load").unit("N.m"),   // a field `load: CountedInput<f64>`
///     row!(V, outputs i, "currents").unit("A"),
///     row!(V, output loss.copper = P_copper, "copper losses").unit("W"), // |y| &y.P_copper
///     row!(V, parameter winding.R_s in machine, "resistance").unit("Ohm"), // |p| &p.machine.winding.R_s
///     row!(V, parameter T_housing = T_start[1], "temperature").unit("K"),
/// ];
/// # assert_eq!(check::<Motor>(), [""; 0]);
/// # let text = model_description::<Motor>().unwrap();
/// # for name in ["u[2]", "load", "i[1]", "loss.copper", "winding.R_s", "T_housing"] { assert!(text.contains(&format!("name=\"{name}\""))); }
/// # assert!(text.contains("start=\"294.15\""));
/// ```
///
/// `string_parameter`, which takes a function, has no such form.
#[macro_export]
macro_rules! row {
    ($V:ty, $kind:ident $first:ident $(. $part:ident)* in $start:ident $(. $more:ident)* $([$i:expr])*, $description:expr $(,)?) => {
        $crate::row!(@ $kind [$V, $crate::row!(@name $first $(. $part)*), $description] $start $(. $more)* $([$i])* . $first $(. $part)*)
    };
    ($V:ty, $kind:ident $first:ident $(. $part:ident)* = $start:ident $(. $more:ident)* $([$i:expr])*, $description:expr $(,)?) => {
        $crate::row!(@ $kind [$V, $crate::row!(@name $first $(. $part)*), $description] $start $(. $more)* $([$i])*)
    };
    ($V:ty, $kind:ident $first:ident $(. $part:ident)*, $description:expr $(,)?) => {
        $crate::row!(@ $kind [$V, $crate::row!(@name $first $(. $part)*), $description] $first $(. $part)*)
    };

    (@name $first:ident $(. $part:ident)*) => { concat!(stringify!($first) $(, ".", stringify!($part))*) };

    // Rows that can be set have two accessors.
    (@ input $($row:tt)*) => { $crate::row!(@both input $($row)*) };
    (@ inputs $($row:tt)*) => { $crate::row!(@both inputs $($row)*) };
    (@ integer_input $($row:tt)*) => { $crate::row!(@both integer_input $($row)*) };
    (@ integer_inputs $($row:tt)*) => { $crate::row!(@both integer_inputs $($row)*) };
    (@ boolean_input $($row:tt)*) => { $crate::row!(@both boolean_input $($row)*) };
    (@ boolean_inputs $($row:tt)*) => { $crate::row!(@both boolean_inputs $($row)*) };
    (@ parameter $($row:tt)*) => { $crate::row!(@both parameter $($row)*) };
    (@ parameters $($row:tt)*) => { $crate::row!(@both parameters $($row)*) };
    (@ integer_parameter $($row:tt)*) => { $crate::row!(@both integer_parameter $($row)*) };
    (@ integer_parameters $($row:tt)*) => { $crate::row!(@both integer_parameters $($row)*) };
    (@ boolean_parameter $($row:tt)*) => { $crate::row!(@both boolean_parameter $($row)*) };
    (@ boolean_parameters $($row:tt)*) => { $crate::row!(@both boolean_parameters $($row)*) };
    (@ counted_input [$($row:tt)*] $($at:tt)*) => {
        $crate::row!(@both input [$($row)*] $($at)* . value).counted(|s| &mut s.$($at)*.sets)
    };
    (@both $kind:ident [$V:ty, $name:expr, $description:expr] $($at:tt)*) => {
        <$V>::$kind($name, $description, |s| &s.$($at)*, |s| &mut s.$($at)*)
    };
    // Computed rows have one.
    (@ $kind:ident [$V:ty, $name:expr, $description:expr] $($at:tt)*) => {
        <$V>::$kind($name, $description, |s| &s.$($at)*)
    };
}

/// The number of elements of all parts.
pub const fn total<T>(parts: &[&[T]]) -> usize {
    let (mut n, mut k) = (0, 0);
    while k < parts.len() {
        n += parts[k].len();
        k += 1;
    }
    n
}

/// The `N` elements of all parts, in order.
pub const fn join<T: Copy, const N: usize>(parts: &[&[T]]) -> [T; N] {
    let mut k = 0;
    while parts[k].is_empty() {
        k += 1;
    }
    let mut joined = [parts[k][0]; N];
    let mut n = 0;
    while k < parts.len() {
        let mut i = 0;
        while i < parts[k].len() {
            joined[n] = parts[k][i];
            n += 1;
            i += 1;
        }
        k += 1;
    }
    assert!(n == N, "`N` is the number of elements");
    joined
}
