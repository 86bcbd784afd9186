//! The stability proof in numbers (`hdrm-fmu stability`), as tables.
#![allow(non_snake_case)] // the paper's symbols

use crate::analyses::stability::{Gains, Power, Run};

fn power(p: &Power, digits: usize) -> String {
    format!("{:.digits$} {:.digits$} {:.digits$}", p.mean, p.rms, p.max)
}

/// The accompanying functions, their bound, and the gain conditions.
pub fn text(runs: &[Run]) -> String {
    let mut text = "accompanying functions over the motion, J: first, largest, last\n".to_owned()
        + "                                                      1/2 s'Ms                   gamma D_F                 sum of nu_a\n";
    let three = |v: &[f64; 3]| format!("{:.3} {:.3} {:.3}", v[0], v[1], v[2]);
    let name = |r: &Run| format!("{}, {} law, {} ms", r.trajectory, r.law, 1e3 * r.step);
    for r in runs {
        let columns = [&r.nu_velocity, &r.nu_adaptation, &r.nu_actuators].map(three);
        let [a, b, c] = columns;
        text += &format!("{:<34}{a:>28}{b:>28}{c:>28}\n", name(r));
    }
    text += "\nbound nu' <= -B: mean, rms, largest, W\n";
    text += "                                                         B          excess nu' + B     time           of it: bodies               actuators        cuts at the rods\n";
    for r in runs {
        let all = [&r.dissipation, &r.excess, &r.bodies, &r.actuators, &r.cuts];
        let [b, excess, bodies, actuators, cuts] = all.map(|p| power(p, 3));
        let share = format!("{:.1} %", 100.0 * r.exceeded);
        text += &format!(
            "{:<34}{b:>24}{excess:>24}{share:>9}{bodies:>24}{actuators:>24}{cuts:>24}\n",
            name(r)
        );
    }
    text += "bodies: sampling, so it shrinks with the step; actuators: sampling, and the velocity feedback on the motor side;\n\
             cuts: friction, inertia and elasticity between current and rod, which the proof leaves out\n";
    text + &runs.first().map_or(String::new(), |r| gains(&r.gains))
}

/// How far the bound is exceeded with each cause added to the machine.
pub fn causes_text(rungs: &[(&'static str, Run)]) -> String {
    let mut text = "\nbound nu' <= -B on the cubic trajectory as the machine is put together; W: mean, rms, largest\n".to_owned()
        + "                                         time                       B          excess nu' + B           of it: bodies               actuators        cuts at the rods\n";
    for (name, r) in rungs {
        text += &format!("{name:<36}{:>7.1} %", 100.0 * r.exceeded);
        for p in [&r.dissipation, &r.excess, &r.bodies, &r.actuators, &r.cuts] {
            text += &format!("{:>24}", power(p, 2));
        }
        text += "\n";
    }
    text + "time: share of it in which the bound is exceeded\n\
            The drives regulate their currents themselves, so the paper's voltage law does not act: B and nu_a are that law's, evaluated\n\
            with the force errors that the current loops leave. Steps of the adaptation that leave its bounds have no proof.\n"
}

fn holds(holds: bool) -> &'static str {
    if holds { "holds" } else { "fails" }
}

/// The gain conditions.
fn gains(gains: &Gains) -> String {
    let Gains { beta_1, beta_2, .. } = gains;
    let mut text = format!(
        "\ngain conditions of the low-level law, at the largest current: beta_1 = {beta_1:.1} N/A, |beta_2| = {beta_2:.1} N/A\n\
         {:<36}{:>14}{:>16}{:>16}  unit\n",
        "", "weight, A/N", "value", "must be at least"
    );
    for c in gains.conditions() {
        text += &format!(
            "{:<36}{:>14.3e}{:>16.3e}{:>16.3e}  {:<4} {}\n",
            c.statement,
            c.weight,
            c.value,
            c.bound,
            c.unit,
            holds(c.holds())
        );
    }
    text + &format!(
        "the weight of the last two is half of epsilon_max = {:.3e} A/N; K_1 = L_q/(beta_1 K_v) = {:.3e} m/N is an equality by construction\n",
        gains.epsilon_max, gains.K_1
    )
}

/// The gain conditions if the weights are energies of the machine instead of fitted; `compliance`
/// is the elastic compliance of the actuator, m/N.
pub fn unfitted_text(gains: &Gains, compliance: f64, L_d: f64) -> String {
    let [second, third] = gains.unfitted(compliance, L_d);
    format!(
        "with weights that are energies of the machine instead of fitted ones, K_1 = 1/K_b = {:.3e} m/N and K_2 = 3/2 L_d = {:.3e} H:\n               \
         the second condition {} (at least {:.3e} H); the third, an equality, is missed by a factor of {:.2}: to meet it, K_v \
         must be that much smaller\n",
        third.value,
        second.value,
        holds(second.holds()),
        second.bound,
        third.value / third.bound
    )
}
