//! Value references.

use crate::{
    InputPolynomial, Model,
    variable::{Place, Write},
};

/// The `order`-th derivative of the Taylor polynomial of all Real inputs, `s` seconds into the step.
pub(crate) fn taylor<M: Model>(u: &InputPolynomial<M::Input>, s: f64, order: usize) -> M::Input {
    let mut result = if order == 0 {
        u.value
    } else {
        M::Input::default()
    };
    for row in M::variables() {
        let Place::RealIn(place) = &row.place else {
            continue;
        };
        for i in 0..place.len(&u.value) {
            let mut sum = 0.0;
            for k in (order..=u.order).rev() {
                let c = if k == 0 {
                    place.get(&u.value, i)
                } else {
                    place.get(&u.derivatives[k - 1], i)
                };
                sum = c + sum * s / (k - order + 1) as f64;
            }
            *place.get_mut(&mut result, i) = sum;
        }
    }
    result
}

impl<S, T: Copy> Write<S, T> {
    pub(crate) fn len(&self, s: &S) -> usize {
        match self {
            Write::Scalar(..) => 1,
            Write::Vector(get, _) => get(s).len(),
        }
    }

    #[inline]
    pub(crate) fn get(&self, s: &S, i: usize) -> T {
        match self {
            Write::Scalar(get, _) => *get(s),
            Write::Vector(get, _) => get(s)[i],
        }
    }

    #[inline]
    pub(crate) fn get_mut<'a>(&self, s: &'a mut S, i: usize) -> &'a mut T {
        match self {
            Write::Scalar(_, get_mut) => get_mut(s),
            Write::Vector(_, get_mut) => &mut get_mut(s)[i],
        }
    }
}
