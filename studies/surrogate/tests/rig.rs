//! Data of the rig: what its windows hold, and what a model with the rig's own friction left out
//! says of them.

use emla::Surrogate;
use surrogate::measurement::campaign::{
    RowErrors, compliance, held_out_profiles, measure, rms, training_profiles,
};
use surrogate::measurement::profile::{Kind, Profile};
use surrogate::measurement::rig_run::run;
use surrogate::measurement::windows::windows;
use surrogate::prediction::model::Model;

/// The rig follows its profile: force as asked for, speed but for what load changes bend.
#[test]
fn the_rig_follows_its_profile_both_ways() {
    let profile = Profile {
        kind: Kind::Work,
        seed: 5,
        seconds: 6.0,
        T: 300.0,
    };
    let run = run(&profile, 5).expect("runs");
    let late = &run[500..];
    let error = rms(late.iter().map(|s| s.truth.x_rod_dot - s.desired.x_dot));
    assert!(error < 1e-3, "rod speed {error} m/s");
    let p = machine_file::Machine::reference().emla.lift;
    let windows = windows(&p, &run);
    let forward = windows.iter().filter(|w| w.truth.motion.w_m > 0.0).count();
    assert!(
        forward > 50 && windows.len() - forward > 50,
        "{forward} of {}",
        windows.len()
    );
    assert!(run[5999].truth.T_winding > 300.0);
}

fn seed(profile: &Profile) -> u64 {
    profile.seed
}

/// Sensors leave some 260 N and no bias worth the name; two runs of one profile differ by less. The
/// compliance is that of mounting, pins, screw and bearings, 1/60 N/nm and a quarter more.
#[test]
fn rows_are_as_good_as_their_sensors() {
    let p = machine_file::Machine::reference().emla.lift;
    let profiles = training_profiles(5, 2.0, 3);
    let campaign = measure(&p, &profiles, seed).expect("runs");
    let trust = RowErrors::new(&p, &campaign, &measure(&p, &profiles, seed).expect("runs"));
    assert!((100.0..500.0).contains(&trust.floor), "{trust:?}");
    assert_eq!(
        trust.repeatability, 0.0,
        "the same seeds give the same readings"
    );
    let found = compliance(&p, &campaign);
    assert!((1.7e-8..2.5e-8).contains(&found), "{found} m/N");
}

/// The physics lacks the rig's friction that grows with the load; the shipped network, trained on
/// another simulation with such friction, brings the hybrid nearer. At the same current a model's
/// torque and force are each other's inverse.
#[test]
fn the_network_brings_what_the_physics_lacks() {
    let p = machine_file::Machine::reference().emla.lift;
    let held_out = measure(&p, &held_out_profiles(6, 3.0, 9), seed).expect("runs");
    let error = |alpha: f64| {
        let model = Model::new(p, Surrogate::reference(), alpha);
        assert!((model.force(model.torque(31e3, 77.0), 77.0) - 31e3).abs() < 1e-6);
        rms(held_out
            .iter()
            .flatten()
            .map(|w| model.demand(&w.truth.motion).i_q - w.truth.i_q))
    };
    let (physics, hybrid) = (error(0.0), error(0.9));
    assert!(
        physics > 0.5 && hybrid < physics / 2.5,
        "{physics} A, {hybrid} A"
    );
}
