//! Macro that implements what `Twist` and `Wrench`, pairs of linear and angular part, share.

/// Implements constructors, conversions to and from a column, and sums for a pair of vectors.
macro_rules! pair_of_vectors {
    ($pair:ident: $linear:ident $angular:ident, zero: $zero:literal) => {
        impl $pair {
            #[doc = $zero]
            pub fn zero() -> Self {
                Self::default()
            }

            /// From the linear and the angular part.
            pub const fn new($linear: Vector3<f64>, $angular: Vector3<f64>) -> Self {
                Self { $linear, $angular }
            }

            /// Both parts as one column, the linear one first.
            pub fn to_vector(&self) -> Vector6<f64> {
                let (a, b) = (self.$linear, self.$angular);
                Vector6::new(a.x, a.y, a.z, b.x, b.y, b.z)
            }

            /// The inverse of `to_vector`.
            pub fn from_vector(c: &Vector6<f64>) -> Self {
                Self::new(c.fixed_rows::<3>(0).into(), c.fixed_rows::<3>(3).into())
            }
        }

        impl std::ops::Add for $pair {
            type Output = Self;
            fn add(self, other: Self) -> Self {
                Self::new(self.$linear + other.$linear, self.$angular + other.$angular)
            }
        }

        impl std::ops::AddAssign for $pair {
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        impl std::ops::Sub for $pair {
            type Output = Self;
            fn sub(self, other: Self) -> Self {
                Self::new(self.$linear - other.$linear, self.$angular - other.$angular)
            }
        }

        impl std::ops::SubAssign for $pair {
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }

        impl std::ops::Neg for $pair {
            type Output = Self;
            fn neg(self) -> Self {
                Self::new(-self.$linear, -self.$angular)
            }
        }

        impl std::ops::Mul<f64> for $pair {
            type Output = Self;
            fn mul(self, s: f64) -> Self {
                Self::new(self.$linear * s, self.$angular * s)
            }
        }
    };
}
pub(crate) use pair_of_vectors;
