//! Identities of the spatial algebra, with seeded random numbers. Tolerances: some 100 rounded
//! products, 100 ε of their summed size.
#![allow(non_snake_case)]

use nalgebra::{Matrix3, Matrix6, Rotation3, Vector3, Vector6};
use spatial::{Inertia, Pose, PseudoInertia, Twist, Wrench};

const EPS: f64 = 100.0 * f64::EPSILON;

struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| 3.0 * self.next())
    }

    fn twist(&mut self) -> Twist {
        Twist::new(self.vector(), self.vector())
    }

    fn wrench(&mut self) -> Wrench {
        Wrench::new(self.vector(), self.vector())
    }

    fn pose(&mut self) -> Pose {
        Pose {
            R: *Rotation3::new(self.vector()).matrix(),
            r: self.vector(),
        }
    }

    /// A physical body: five random mass points.
    fn inertia(&mut self) -> Inertia {
        (0..5).fold(Inertia::default(), |sum, _| {
            let m = 1.3 + self.next();
            sum + Inertia::from_com(m, self.vector(), Matrix3::zeros())
        })
    }
}

fn each(mut check: impl FnMut(&mut Random)) {
    let mut random = Random(0x1F2E_3D4C_5B6A_7988);
    (0..300).for_each(|_| check(&mut random));
}

fn close(a: Vector6<f64>, b: Vector6<f64>, scale: f64) {
    assert!((a - b).norm() < EPS * scale, "{a} vs {b}");
}

/// ½ Vᵀ M V, J.
fn kinetic_energy(M: &Inertia, V: &Twist) -> f64 {
    0.5 * V.power(&M.apply(V))
}

/// `ᴬU_B` as a 6×6 matrix: `ᴬF = ᴬU_B ᴮF`, `ᴮV = ᴬU_Bᵀ ᴬV`.
fn U(X: &Pose) -> Matrix6<f64> {
    let mut U = Matrix6::zeros();
    U.fixed_view_mut::<3, 3>(0, 0).copy_from(&X.R);
    U.fixed_view_mut::<3, 3>(3, 3).copy_from(&X.R);
    let lower = X.r.cross_matrix() * X.R;
    U.fixed_view_mut::<3, 3>(3, 0).copy_from(&lower);
    U
}

#[test]
fn power_does_not_depend_on_the_frame() {
    each(|random| {
        let (X_AB, V_A, F_B) = (random.pose(), random.twist(), random.wrench());
        let P_A = V_A.power(&X_AB.wrench_to_A(&F_B));
        let P_B = X_AB.twist_to_B(&V_A).power(&F_B);
        assert!((P_A - P_B).abs() < EPS * 200.0, "{P_A} vs {P_B}");
    });
}

#[test]
fn kinetic_energy_does_not_depend_on_the_frame() {
    each(|random| {
        let (X_AB, V_A, I_B) = (random.pose(), random.twist(), random.inertia());
        let T_B = kinetic_energy(&I_B, &X_AB.twist_to_B(&V_A));
        let T_A = kinetic_energy(&X_AB.inertia_to_A(&I_B), &V_A);
        assert!(
            (T_A - T_B).abs() < EPS * (T_A.abs() + 1e3),
            "{T_A} vs {T_B}"
        );
    });
}

#[test]
fn net_wrench_does_not_depend_on_the_frame() {
    each(|random| {
        let (X, V, A, I_B) = (
            random.pose(),
            random.twist(),
            random.twist(),
            random.inertia(),
        );
        let F_B = I_B.net_wrench(&X.twist_to_B(&V), &X.twist_to_B(&A));
        let F_A = X.inertia_to_A(&I_B).net_wrench(&V, &A);
        let there = X.wrench_to_A(&F_B).to_vector();
        close(F_A.to_vector(), there, 10.0 * there.norm() + 1e3);
    });
}

/// The paper's matrix ᴬU_B moves wrenches, its transpose twists; both have their inverses.
#[test]
fn poses_act_as_the_matrix_U() {
    each(|random| {
        let (X, V, F) = (random.pose(), random.twist(), random.wrench());
        let U: Matrix6<f64> = U(&X);
        close(X.wrench_to_A(&F).to_vector(), U * F.to_vector(), 50.0);
        close(X.twist_to_B(&V).to_vector(), U.tr_mul(&V.to_vector()), 50.0);
        close(
            X.twist_to_A(&X.twist_to_B(&V)).to_vector(),
            V.to_vector(),
            100.0,
        );
        close(
            X.inverse().wrench_to_A(&X.wrench_to_A(&F)).to_vector(),
            F.to_vector(),
            100.0,
        );
        close(
            X.inverse().twist_to_A(&V).to_vector(),
            X.twist_to_B(&V).to_vector(),
            100.0,
        );
        let Y = random.pose();
        let chained = X.wrench_to_A(&Y.wrench_to_A(&F)).to_vector();
        close((X * Y).wrench_to_A(&F).to_vector(), chained, 500.0);
    });
}

/// crf(V) = −crm(V)ᵀ, and both are the derivative of a change of frame:
/// crm(V)·T = d/dt of T carried along with V.
#[test]
fn cross_products_are_dual_and_move_with_the_frame() {
    each(|random| {
        let (V, T, F) = (random.twist(), random.twist(), random.wrench());
        let (a, b) = (V.crm(&T).power(&F), T.power(&V.crf(&F)));
        assert!((a + b).abs() < EPS * 500.0, "{a} vs {b}");

        let h = 1e-6;
        let along = |s: f64| Pose {
            R: *Rotation3::new(V.w * s).matrix(),
            r: V.v * s,
        };
        let slope = (along(h).twist_to_A(&T) - along(-h).twist_to_A(&T)) * (0.5 / h);
        let error = (slope - V.crm(&T)).to_vector().norm();
        // Central difference: truncation h²·|w|³|T|, rounding ε/h: 1e-8.
        assert!(error < 1e-7, "{error:e}");
    });
}

/// Newton and Euler about the centre of mass.
#[test]
fn net_wrench_is_newton_and_euler() {
    each(|random| {
        let I_com = {
            let cloud = random.inertia();
            cloud.I
        };
        let (m, c) = (3.7, random.vector());
        let (V, A) = (random.twist(), random.twist());
        let F = Inertia::from_com(m, c, I_com).net_wrench(&V, &A);
        // Classical acceleration of the centre of mass from the spatial one at the origin.
        let a_c = A.v + V.w.cross(&V.v) + A.w.cross(&c) + V.w.cross(&V.w.cross(&c));
        let f = a_c * m;
        let moment = I_com * A.w + V.w.cross(&(I_com * V.w)) + c.cross(&f);
        let scale = f.norm() + moment.norm() + 1e3;
        close(
            F.to_vector(),
            Wrench::new(f, moment).to_vector(),
            10.0 * scale,
        );
    });
}

#[test]
fn matrix_of_inertia_is_its_action() {
    each(|random| {
        let (I, V) = (random.inertia(), random.twist());
        let M = I.to_matrix();
        assert_eq!(M, M.transpose());
        close(I.apply(&V).to_vector(), M * V.to_vector(), 1e3);
    });
}

#[test]
fn pseudo_inertia_returns_the_body() {
    each(|random| {
        let body = random.inertia();
        let L = PseudoInertia::from(&body);
        assert!(L.0.cholesky().is_some(), "a physical body: {}", L.0);
        let back = Inertia::from(&L);
        assert!((back.I - body.I).norm() < EPS * body.I.norm());
        assert_eq!((back.m, back.h), (body.m, body.h));
    });
}

/// Sums, differences, negatives and multiples are those of the columns and matrices, to the bit.
#[test]
fn operators_act_on_every_component() {
    each(|random| {
        let (s, [a, b]) = (random.next(), [random.twist(), random.twist()]);
        let [x, y] = [a.to_vector(), b.to_vector()];
        let (mut sum, mut difference) = (a, a);
        sum += b;
        difference -= b;
        for (found, expected) in [
            (a + b, x + y),
            (sum, x + y),
            (a - b, x - y),
            (difference, x - y),
            (-a, -x),
            (a * s, x * s),
            (Twist::from_vector(&x), x),
        ] {
            assert_eq!(found.to_vector(), expected);
        }
        let [a, b] = [random.wrench(), random.wrench()];
        let [x, y] = [a.to_vector(), b.to_vector()];
        let (mut sum, mut difference) = (a, a);
        sum += b;
        difference -= b;
        for (found, expected) in [
            (a + b, x + y),
            (sum, x + y),
            (a - b, x - y),
            (difference, x - y),
            (-a, -x),
            (a * s, x * s),
            (Wrench::from_vector(&x), x),
        ] {
            assert_eq!(found.to_vector(), expected);
        }
        let [a, b] = [random.inertia(), random.inertia()];
        assert_eq!((a + b).to_matrix(), a.to_matrix() + b.to_matrix());
        assert_eq!((a * s).to_matrix(), a.to_matrix() * s);
    });
}

/// ½ Vᵀ M V with the 6×6 matrix.
#[test]
fn kinetic_energy_is_the_quadratic_form() {
    each(|random| {
        let (M, V) = (random.inertia(), random.twist());
        let v = V.to_vector();
        let scale = M.to_matrix().norm() * v.norm_squared();
        let error = kinetic_energy(&M, &V) - 0.5 * v.dot(&(M.to_matrix() * v));
        assert!(error.abs() < EPS * scale, "{error}");
    });
}

/// Against nalgebra's rotations about the axes.
#[test]
fn turns_are_right_handed_about_their_axes() {
    each(|random| {
        let (angle, r) = (3.0 * random.next(), random.vector());
        let (c, s) = (angle.cos(), angle.sin());
        for (found, axis) in [
            (Pose::turn_x(r, c, s), Vector3::x_axis()),
            (Pose::turn_y(r, c, s), Vector3::y_axis()),
            (Pose::turn_z(r, c, s), Vector3::z_axis()),
        ] {
            let expected = Rotation3::from_axis_angle(&axis, angle);
            assert!((found.R - expected.matrix()).norm() < EPS);
            assert_eq!(found.r, r);
        }
    });
}
