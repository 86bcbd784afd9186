//! The controller names causes where they begin, and once.
#![allow(non_snake_case)]

use emla::Surrogate;
use machine::Machine;
use vdc::{Controller, Input, Level, Mode, Settings, Told, Trajectory, Trouble};

const H: f64 = 1e-3;

struct Case {
    controller: Controller,
    settings: Settings,
    u: Input,
    told: Told,
}

impl Case {
    fn new() -> Self {
        let machine = Machine::reference();
        let settings = Settings {
            mode: Mode::Adaptive,
            integral: false,
            level: Level::Machine,
            gains: machine.controller,
            alpha: 0.0,
            true_inertia_scale: 1.0,
        };
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
            told: Told::default(),
        }
    }

    fn trouble(&mut self, t: f64, h: f64) -> Option<Trouble> {
        let now = self.controller.evaluate(&self.settings, &self.u);
        let now = now.expect("finite");
        (self.controller).trouble(&now, &self.settings, &mut self.told, t, h)
    }
}

#[test]
fn an_unreachable_reference_is_named_where_it_begins_and_once() {
    let mut case = Case::new();
    let at_hand = case.u.reference_position;
    assert_eq!(case.trouble(1.0, H), None);
    case.u.reference_position[0] += 20.0;
    let Some(Trouble::OutOfReach { t, distance, reach }) = case.trouble(2.0, H) else {
        panic!("{:?}", case.trouble(2.0, H));
    };
    assert!(
        t == 2.0 && distance > 20.0 && (3.0..8.0).contains(&reach),
        "{distance}, {reach}"
    );
    // The jump asks for voltages that no drive gives; after both are told there is silence.
    let mut rest = Vec::new();
    for _ in 0..3 {
        rest.extend(case.trouble(2.0, H));
    }
    assert!(
        rest.iter().all(|t| matches!(t, Trouble::Voltage { .. })),
        "{rest:?}"
    );
    case.u.reference_position = at_hand;
    assert_eq!(case.trouble(3.0, H), None);
    case.u.reference_position[1] -= 30.0;
    assert!(matches!(
        case.trouble(4.0, H),
        Some(Trouble::OutOfReach { .. })
    ));
}

#[test]
fn a_step_too_long_for_the_current_feedback_is_named() {
    let mut case = Case::new();
    let emla = Machine::reference().emla;
    let longest = emla.L_q / case.settings.gains.K_i;
    assert_eq!(case.trouble(0.0, 0.99 * longest), None);
    let h = 1.01 * longest;
    assert_eq!(
        case.trouble(0.0, h),
        Some(Trouble::StepTooLong { t: 0.0, h, longest })
    );
    assert_eq!(case.trouble(0.0, h), None, "told once");
    let text = Trouble::StepTooLong { t: 0.0, h, longest }.to_string();
    assert!(text.contains("L/K_i"), "{text}");
}

#[test]
fn a_voltage_that_no_drive_gives_is_named_by_actuator() {
    let mut case = Case::new();
    case.u.i_d[1] = 1000.0; // K_i asks for -900 V, L_d·lambda_i for -130 V, R_s for 200 V
    let Some(Trouble::Voltage {
        actuator,
        asked,
        v_max,
        ..
    }) = case.trouble(0.0, H)
    else {
        panic!("no trouble");
    };
    assert!(
        actuator == 2 && asked > v_max && v_max == 375.0,
        "{actuator}, {asked}"
    );
}
