//! The controller names causes where they begin, and once.

use emla::Surrogate;
use machine_file::{Machine, Seconds};
use vdc::{Controller, Input, ReportedWarnings, Settings, Trajectory, Warning};

const H: f64 = 1e-3;

struct Case {
    controller: Controller,
    settings: Settings,
    u: Input,
    told: ReportedWarnings,
}

impl Case {
    fn new() -> Self {
        let machine = Machine::reference();
        let settings = Settings::from_gains(&machine.controller);
        let (position, orientation) = vdc::tip_pose(&machine, &machine.start.zeta).expect("works");
        let u = Input {
            zeta: machine.start.zeta,
            reference_position: position,
            reference_orientation: orientation,
            ..Input::default()
        };
        let (network, path) = (Surrogate::reference(), Trajectory::External);
        let controller = Controller::new(&machine, &network, path, &settings, &u, 0.0);
        Self {
            controller: controller.expect("works"),
            settings,
            u,
            told: ReportedWarnings::default(),
        }
    }

    fn next_warning(&mut self, t: f64, h: f64) -> Option<Warning> {
        let now = self.controller.evaluate(&self.settings, &self.u);
        let now = now.expect("finite");
        (self.controller).next_warning(&now, &self.settings, &mut self.told, t, h)
    }
}

#[test]
fn an_unreachable_reference_is_named_where_it_begins_and_once() {
    let mut case = Case::new();
    let at_hand = case.u.reference_position;
    assert_eq!(case.next_warning(1.0, H), None);
    case.u.reference_position[0] += 20.0;
    let Some(Warning::OutOfReach { t, distance, reach }) = case.next_warning(2.0, H) else {
        panic!("{:?}", case.next_warning(2.0, H));
    };
    assert!(
        t == Seconds(2.0) && distance > 20.0 && (3.0..8.0).contains(&reach),
        "{distance}, {reach}"
    );
    // The jump asks for voltages that no drive gives; after both are told there is silence.
    let mut rest = Vec::new();
    for _ in 0..3 {
        rest.extend(case.next_warning(2.0, H));
    }
    assert!(
        rest.iter().all(|t| matches!(t, Warning::Voltage { .. })),
        "{rest:?}"
    );
    case.u.reference_position = at_hand;
    assert_eq!(case.next_warning(3.0, H), None);
    case.u.reference_position[1] -= 30.0;
    assert!(matches!(
        case.next_warning(4.0, H),
        Some(Warning::OutOfReach { .. })
    ));
}

#[test]
fn a_step_too_long_for_the_current_feedback_is_named() {
    let mut case = Case::new();
    let emla = Machine::reference().emla.lift;
    let longest = emla.L_q / case.settings.gains.K_i;
    assert_eq!(case.next_warning(0.0, 0.99 * longest), None);
    let h = 1.01 * longest;
    let told = Warning::StepTooLong {
        t: Seconds(0.0),
        h: Seconds(h),
        longest,
    };
    assert_eq!(case.next_warning(0.0, h), Some(told));
    assert_eq!(case.next_warning(0.0, h), None, "told once");
    let text = told.to_string();
    assert!(text.contains("L/K_i"), "{text}");
}

#[test]
fn a_voltage_that_no_drive_gives_is_named_by_actuator() {
    let mut case = Case::new();
    case.u.i_d[1] = 1000.0; // K_i asks for -900 V, L_d·lambda_i for -130 V, R_s for 200 V
    let Some(Warning::Voltage {
        actuator,
        required,
        v_max,
        ..
    }) = case.next_warning(0.0, H)
    else {
        panic!("no warning");
    };
    assert!(
        actuator == 2 && required > v_max && v_max == 375.0,
        "{actuator}, {required}"
    );
}

#[test]
fn a_force_beyond_the_limit_is_named_by_actuator() {
    let mut case = Case::new();
    let rated = Machine::reference().ratings.lift.force_max;
    assert_eq!(case.next_warning(0.0, H), None);
    case.settings.force_limit = 0.5;
    let Some(Warning::Force {
        actuator,
        required,
        f_max,
        ..
    }) = case.next_warning(1.0, H)
    else {
        panic!("41 kN are more than 35");
    };
    assert!((required - 41_143.0).abs() < 1.0, "{required} N");
    assert_eq!((actuator, f_max), (2, 0.5 * rated));
    assert_eq!(
        case.next_warning(2.0, H),
        None,
        "told once; the tilt rod has 32 kN"
    );
}

/// The voltage limit is that of the DC link, `v_dc/√3`; without one the nominal machine's.
#[test]
fn a_link_too_low_for_the_command_is_named() {
    let mut case = Case::new();
    case.u.i_q = [0.0, 15.34, 12.0];
    assert_eq!(case.next_warning(1.0, H), None);
    case.u.v_dc = Some(3.0);
    let Some(Warning::Voltage {
        actuator, v_max, ..
    }) = case.next_warning(2.0, H)
    else {
        panic!("3 V do not carry 15 A through 0.2 ohm");
    };
    assert!(
        actuator == 2 && (v_max - 3.0 / 3.0_f64.sqrt()).abs() < 1e-12,
        "{actuator} {v_max}"
    );
}

/// While the command is beyond what the link gives the integrals rest: after a step of current
/// error the next command is the same, with voltage enough it has grown.
#[test]
fn the_integrals_rest_while_the_link_is_too_low() {
    let grown = |v_dc: Option<f64>| {
        let mut case = Case::new();
        case.u.i_q = [0.0, 14.0, 12.0];
        case.u.v_dc = v_dc;
        // Filters settle in 40 steps of 1 ms; what changes then is the integral.
        let mut v_q = [0.0; 2];
        for k in 0..60 {
            let now = case
                .controller
                .evaluate(&case.settings, &case.u)
                .expect("finite");
            v_q[usize::from(k == 59)] = now.output(&[0.0; 3]).v_q[1];
            let t = f64::from(k) * H;
            case.settings.gains.gamma = 1e9;
            case.settings.gains.omega_d = 0.0;
            case.controller
                .step(&now, &case.settings, &case.u, t, H)
                .expect("finite");
        }
        v_q[1] - v_q[0]
    };
    assert!(grown(None).abs() > 1e-3, "{}", grown(None));
    assert!(grown(Some(2.0)).abs() < 1e-5, "{}", grown(Some(2.0)));
}

/// Halfway between start and end of the derating half of i_max is left, beyond the end nothing.
#[test]
fn hot_windings_get_less_current() {
    let mut case = Case::new();
    let required = |case: &Case| {
        let now = case
            .controller
            .evaluate(&case.settings, &case.u)
            .expect("finite");
        now.output(&[0.0; 3]).i_q_required
    };
    let cold = required(&case);
    assert!(cold[1] > 15.0);
    case.settings.derating = Some(vdc::Derating {
        start: 400.0,
        end: 420.0,
    });
    case.u.T_winding = [399.0, 418.0, 421.0];
    let hot = required(&case);
    assert_eq!(hot[0], cold[0]);
    assert!((hot[1] - 10.0).abs() < 1e-9, "a tenth of 100 A: {}", hot[1]);
    assert_eq!(hot[2], 0.0);
}
