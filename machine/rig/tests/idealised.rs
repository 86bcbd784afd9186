//! With every extra off it is the idealised actuator, whose code it does not share.
use rig::{Drive, Extras, Input, Rig};

/// Communication step, s: one substep of either. In a step of a millisecond the idealised actuator
/// takes longer ones, whose errors of some 0.1 N (2.6e-6 of the peak here) are no difference of the
/// equations.
const H: f64 = 62.5e-6;

/// All outputs that both have, to 1e-6 of their peaks, in both drive modes, over four seconds of
/// voltages, motions and loads of both signs.
#[test]
fn with_all_extras_off_it_is_the_idealised_actuator() {
    let p = machine_file::Machine::reference().emla.lift;
    for drive in [Drive::Motion, Drive::Force] {
        let rig = Rig::new(p, Extras::AS_BUILT.off(), drive).expect("valid");
        let other = match drive {
            Drive::Motion => emla::Drive::Motion,
            Drive::Force => emla::Drive::Force,
        };
        let emla = emla::Emla::new(p, other).expect("valid");
        // The back-EMF of a rod that swings at 0.8 Hz, and a voltage that pushes and pulls.
        let input = |t: f64| {
            let (w, amplitude, travel) = (5.0, 9e-3, 0.016 / std::f64::consts::TAU / 6.0);
            let swing = amplitude * w * (w * t).sin();
            let ideal = emla::Input {
                v_d: -3.0 + 2.0 * (9.0 * t).sin(),
                v_q: 4.0 * 0.19 / travel * swing + 3.0 * (11.0 * t + 0.4).sin(),
                x: 0.3 + amplitude * (1.0 - (w * t).cos()),
                x_dot: swing,
                F_ext: 20e3 * (3.1 * t).cos(),
                F_hold: 12e3,
                ..emla::Input::default()
            };
            let built = Input {
                v_d: ideal.v_d,
                v_q: ideal.v_q,
                v_dc: Some(650.0),
                T_ambient: 293.15,
                x: ideal.x,
                x_dot: ideal.x_dot,
                F_ext: ideal.F_ext,
                F_hold: ideal.F_hold,
                ..Input::default()
            };
            (built, ideal)
        };
        let (built, ideal) = input(0.0);
        let mut a = rig.start(&built, [293.15; 2]).expect("finite");
        let mut b = emla.start(&ideal).expect("finite");
        let (mut worst, mut peak) = ([0.0_f64; 14], [0.0_f64; 14]);
        for k in 0..64_000 {
            let t = f64::from(k) * H;
            let (built, ideal) = input(t);
            let (y, z) = (rig.output(&a, &built), emla.output(&b, &ideal));
            let pairs = [
                (y.F, z.F),
                (y.F_mean, z.F_mean),
                (y.i_d, z.i_d),
                (y.i_q, z.i_q),
                (y.w_m, z.w_m),
                (y.theta_m, z.theta_m),
                (y.tau_e, z.tau_e),
                (y.P_in, z.P_in),
                (y.P_out, z.P_out),
                (y.P_loss, z.P_loss),
                (y.E_in, z.E_in),
                (y.E_stored, z.E_stored),
                (y.x_rod, z.x_rod),
                (y.P_mech, z.P_mech),
            ];
            for (i, (y, z)) in pairs.into_iter().enumerate() {
                worst[i] = worst[i].max((y - z).abs());
                peak[i] = peak[i].max(z.abs());
            }
            a = rig.step(&a, &built, t, H).expect("finite");
            b = emla.step(&b, |s| ideal.moved(s), t, H).expect("finite");
        }
        for (i, (worst, peak)) in worst.into_iter().zip(peak).enumerate() {
            println!("{drive:?} {i}: {:.2e} of {peak:.4e}", worst / peak);
            assert!(worst <= 1e-6 * peak, "{drive:?} {i}: {worst} of {peak}");
        }
    }
}
