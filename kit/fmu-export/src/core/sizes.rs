//! Rows in a `Vec` (length: a number or a structural parameter), for `core`, `c_api` and `check`.
//!
//! The `Vec`s are resized wherever start values are made or a size is set, so that a model always
//! finds vectors of the declared length.

use super::length::{LONGEST, Length, MOST_COUNTED, Resize};
use super::model::{Model, Variable};
use super::storage::{Accessor, Storage};

/// Start values of parameters and inputs.
pub(crate) type StartValues<M> = (<M as Model>::Parameters, <M as Model>::Input);

impl<M: Model> Variable<M> {
    /// A row in a `Vec`: the length of each dimension, stored row by row, and a function that gives
    /// the `Vec` its length and start values. [`Model::defaults`] may leave it empty.
    ///
    /// ```ignore
    /// V::inputs("heat", "heat of each cell", |u| &u.heat, |u| &mut u.heat)
    ///     .vector(&[Length::Parameter("n")], Resize::Input(|u, n| u.heat = vec![0.0; n]))
    /// ```
    pub const fn vector(
        mut self,
        shape: &'static [Length],
        resize: Resize<M::Parameters, M::Input, M::Output>,
    ) -> Self {
        self.shape = shape;
        self.resize = Some(resize);
        self
    }

    /// The declared number of elements in each dimension; 0 for an unknown parameter.
    pub(crate) fn dimensions(&self, p: &M::Parameters) -> impl Iterator<Item = usize> {
        self.lengths().iter().map(move |length| match *length {
            Length::Fixed(n) => n,
            Length::Parameter(name) => size::<M>(name).map_or(0, |(_, field)| {
                usize::try_from(field.get(p, 0)).unwrap_or(0)
            }),
        })
    }

    /// The number of elements.
    pub(crate) fn len(&self, p: &M::Parameters, u: &M::Input, y: &M::Output) -> usize {
        match self.shape {
            [] => self.storage.len(p, u, y),
            _ => (self.dimensions(p)).fold(1, usize::saturating_mul),
        }
    }

    /// Checks the row's dimensions, and a structural parameter's attributes.
    pub(crate) fn check_lengths(&self) -> Result<(), String> {
        if self.structural {
            let is_i32 = matches!(
                self.storage,
                Storage::IntegerParameter(Accessor::Scalar(..))
            );
            let has_bounds = self.min >= 1.0 && self.max <= LONGEST as f64;
            if !is_i32 || self.tunable || self.enumeration.is_some() || !has_bounds {
                return Err(format!(
                    "a structural parameter is an Integer that is not tunable, with min at least 1 and max at most {LONGEST}"
                ));
            }
        }
        let is_long = self.resize.is_some() || self.each_unit.len() > MOST_COUNTED;
        if is_long && (self.scalar || !self.each_unit.is_empty()) {
            return Err("is a long row, which must be a vector with one unit".to_owned());
        }
        let mut most = 1.0;
        for length in self.shape {
            most *= match *length {
                Length::Fixed(n) => n as f64,
                Length::Parameter(name) => match size::<M>(name) {
                    Some((row, _)) => row.max,
                    None => {
                        return Err(format!(
                            "length `{name}` must be a structural parameter of the table"
                        ));
                    }
                },
            };
        }
        if most > LONGEST as f64 {
            return Err(format!(
                "may have {most} elements; it must have at most {LONGEST}"
            ));
        }
        Ok(())
    }
}

/// A row that is a size, and its accessor.
type Size<M> = (
    &'static Variable<M>,
    &'static Accessor<<M as Model>::Parameters, i32>,
);

/// The size with this name.
pub(crate) fn size<M: Model>(name: &str) -> Option<Size<M>> {
    sizes::<M>().find(|(row, _)| row.name == name)
}

/// All rows that are sizes.
pub(crate) fn sizes<M: Model>() -> impl Iterator<Item = Size<M>> {
    (M::variables().iter().filter(|row| row.structural)).filter_map(|row| match &row.storage {
        Storage::IntegerParameter(field) => Some((row, field)),
        _ => None,
    })
}

/// Gives every `Vec` the length that the parameters say, with start values; those whose length was
/// the same with the parameters before keep their values.
pub(crate) fn resize_vectors<M: Model>(
    p: &mut M::Parameters,
    u: &mut M::Input,
    y: &mut M::Output,
    before: Option<&M::Parameters>,
) {
    for row in M::variables() {
        let Some(resize) = row.resize else { continue };
        let is_same = |before| row.dimensions(before).eq(row.dimensions(p));
        if before.is_some_and(is_same) {
            continue;
        }
        let n = row.dimensions(p).product();
        match resize {
            Resize::Parameter(resize) => resize(p, n),
            Resize::Input(resize) => resize(u, n),
            Resize::Output(resize) => resize(y, n),
        }
    }
}

/// Parameters and inputs with every `Vec` resized to the sizes in the parameters.
#[doc(hidden)]
pub fn fit_start_values<M: Model>((mut p, mut u): StartValues<M>) -> StartValues<M> {
    resize_vectors::<M>(&mut p, &mut u, &mut M::Output::default(), None);
    (p, u)
}

/// Default outputs with every `Vec` resized to the sizes in the parameters.
pub(crate) fn output<M: Model>(p: &M::Parameters) -> M::Output {
    let mut y = M::Output::default();
    for row in M::variables() {
        if let Some(Resize::Output(resize)) = row.resize {
            resize(&mut y, row.dimensions(p).product());
        }
    }
    y
}

/// The start values of a model with these sizes, such as `n=200 m=3`.
pub(crate) fn start<M: Model>(given: &str) -> Result<StartValues<M>, String> {
    let (mut p, u) = M::defaults();
    for word in given.split_whitespace() {
        let (name, value) = word.split_once('=').unwrap_or((word, ""));
        let Some((row, field)) = size::<M>(name) else {
            let known: Vec<_> = sizes::<M>().map(|(row, _)| row.name).collect();
            let (model, known) = (M::INFO.model, known.join(", "));
            return Err(format!(
                "size `{word}`: `{name}` must be a structural parameter of `{model}`, which has: {known}"
            ));
        };
        let value = value.parse::<i32>().ok();
        let Some(value) = value.filter(|n| (row.min..=row.max).contains(&f64::from(*n))) else {
            let (min, max) = (row.min, row.max);
            return Err(format!(
                "size `{word}`: `{name}` must be a whole number from {min} to {max}"
            ));
        };
        *field.get_mut(&mut p, 0) = value;
    }
    Ok(fit_start_values::<M>((p, u)))
}
