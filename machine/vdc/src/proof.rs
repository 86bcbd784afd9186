//! Computes the quantities of the paper's stability proof as outputs: accompanying functions,
//! dissipation, stability conditions. `controller` calls it in every evaluation.

use crate::conditions::Conditions;
use crate::evaluation::Evaluation;
use crate::nominal::Nominal;
use crate::settings::Settings;
use crate::signals::Input;
use crate::state::State;

pub(crate) fn fill(
    now: &mut Evaluation,
    nominal: &Nominal,
    State { bodies, drives, .. }: &State,
    settings: &Settings,
    input: &Input,
) {
    let (gains, output) = (&settings.gains, &mut now.output);
    if let Some(machine) = &now.machine {
        output.nu_velocity = settings.true_inertia_scale * machine.energy;
        output.dissipation = machine.dissipation;
        for (k, estimate) in bodies.estimates.iter().enumerate() {
            let truth = bodies.nominal[k] * settings.true_inertia_scale;
            output.mass_hat[k] = estimate.inertia().m;
            output.nu_adaptation += gains.gamma * estimate.divergence(&truth);
        }
    }
    let actuators = nominal.parameters();
    let each = actuators.map(|p| Conditions::new(p, gains));
    let weakest = Conditions::weakest(each);
    if weakest.hold() {
        output.conditions = weakest; // otherwise undefined, and 0
    }
    for i in 0..3 {
        let (p, conditions) = (actuators[i], &each[i]);
        let i_d_error = drives[i].i_dr - input.i_d[i];
        let force_error = now.commands[i].force_error;
        output.force_error[i] = force_error;
        output.nu_actuator[i] = conditions.accompanying(force_error, i_d_error);
        output.dissipation_actuator[i] = conditions.dissipation(p, gains, force_error, i_d_error);
    }
}
