//! Event indicators of models within models: [`indicators_of!`](crate::indicators_of), for `Ode`.

use super::{Name, Ode};
use crate::Variable;

/// The event indicators of a model whose state has fields that are models: the type of the model's
/// state, and its fields with their types, in the order in which `fn indicators` writes them.
///
/// ```
/// use fmu_export::prelude::*;
///
/// /// A ball
/// #[derive(State)]
/// #[fmu(input = ())]
/// struct Ball {
///     /// Height
///     #[fmu(unit = "m", start = 1.0)]
///     height: f64,
///     /// Speed
///     #[fmu(unit = "m/s")]
///     speed: f64,
/// }
///
/// impl Ode for Ball {
///     fn derivative(&self, _: &(), _: &(), _t: f64, dx: &mut Self) { (dx.height, dx.speed) = (self.speed, -9.81); }
///     const INDICATORS: &'static [Variable<Self>] = &[Variable::indicator("impact", "Height above the floor").unit("m")];
///     fn indicators(&self, _: &(), _: &(), _t: f64, z: &mut [f64]) { z[0] = self.height; }
///     fn event(&mut self, _: &(), _: &(), _t: f64) -> Event {
///         if self.height <= 0.0 && self.speed < 0.0 { self.speed *= -0.7; }
///         Event::NONE
///     }
/// }
///
/// /// Two balls, one below the other
/// #[derive(State)]
/// #[fmu(input = ())]
/// struct Pair {
///     #[fmu(start = Ball::start(&(), &()))]
///     upper: Ball,
///     #[fmu(start = Ball { height: 0.5, speed: 0.0 })]
///     lower: Ball,
/// }
///
/// impl Ode for Pair {
///     fn derivative(&self, p: &(), u: &(), t: f64, dx: &mut Self) {
///         self.upper.derivative(p, u, t, &mut dx.upper);
///         self.lower.derivative(p, u, t, &mut dx.lower);
///     }
///     const INDICATORS: &'static [Variable<Self>] = indicators_of!(Pair, upper: Ball, lower: Ball);
///     fn indicators(&self, p: &(), u: &(), t: f64, z: &mut [f64]) {
///         self.upper.indicators(p, u, t, &mut z[..1]);
///         self.lower.indicators(p, u, t, &mut z[1..]);
///     }
///     fn event(&mut self, p: &(), u: &(), t: f64) -> Event {
///         self.upper.event(p, u, t).and(self.lower.event(p, u, t))
///     }
/// }
/// # assert_eq!(fmu_export::check::<Pair>(), [""; 0]);
/// ```
#[macro_export]
macro_rules! indicators_of {
    ($model:ty, $($field:ident: $child:ty),+ $(,)?) => {{
        const N: usize = 0 $(+ <$child as $crate::Ode>::INDICATORS.len())+;
        const NAMES: [$crate::derive::Name; N] = {
            let all = ([$crate::derive::Name::EMPTY; N], 0);
            $(let all = $crate::derive::child_names::<$child, N>(all, stringify!($field));)+
            all.0
        };
        const ROWS: [$crate::Variable<$model>; N] = {
            let all = ([$crate::Variable::indicator("", ""); N], 0);
            $(let all = $crate::derive::child_indicators::<$model, $child, N>(all, &NAMES);)+
            all.0
        };
        &ROWS
    }};
}

/// Names of the indicators of the child in this field, after the first `n` names.
pub const fn child_names<C: Ode, const N: usize>(
    (mut names, mut n): ([Name; N], usize),
    field: &str,
) -> ([Name; N], usize) {
    let mut k = 0;
    while k < <C as Ode>::INDICATORS.len() {
        names[n] = Name::EMPTY.join(field).join(<C as Ode>::INDICATORS[k].name);
        (n, k) = (n + 1, k + 1);
    }
    (names, n)
}

/// Rows of the indicators of a child by their names, after the first `n` rows.
pub const fn child_indicators<M: Ode, C: Ode, const N: usize>(
    (mut rows, mut n): ([Variable<M>; N], usize),
    names: &'static [Name; N],
) -> ([Variable<M>; N], usize) {
    let mut k = 0;
    while k < <C as Ode>::INDICATORS.len() {
        let of = &<C as Ode>::INDICATORS[k];
        let row = Variable::indicator(names[n].text(), of.description);
        rows[n] = Variable {
            unit: of.unit,
            own_unit: of.own_unit,
            ..row
        };
        (n, k) = (n + 1, k + 1);
    }
    (rows, n)
}
