//! A ball that is thrown over a floor: two continuous states that are vectors, a discrete one, an
//! event indicator, a time event.

use fmu_export::prelude::*;

pub const GRAVITY: f64 = 9.75;
/// When the ball is kicked, s.
pub const KICK: f64 = 0.625;

#[derive(Parameters)]
pub struct Parameters {
    /// Part of the speed that a bounce leaves
    #[fmu(unit = "1", start = 0.75, min = 0, max = 1, tunable)]
    restitution: f64,
    /// Air drag over mass
    #[fmu(unit = "1/s", start = 0.5, min = 0)]
    drag: f64,
    /// Speed at the start
    #[fmu(unit = "m/s", start = [3.0, 0.5])]
    throw: [f64; 2],
}

#[derive(Input)]
pub struct Input {
    /// Speed of the wind
    #[fmu(unit = "m/s")]
    wind: [f64; 2],
    /// Speed that the kick adds
    #[fmu(unit = "m/s", discrete)]
    kick: f64,
    /// Whether the model fails: 20 with a panic, 30 with NaN
    #[fmu(min = 0, max = 30)]
    fault: i32,
}

#[derive(Output)]
pub struct Output {
    /// Kinetic and potential energy of 1 kg
    #[fmu(unit = "J", depends_on(position[2], velocity), initially_depends_on(throw))]
    energy: f64,
}

/// A ball over a floor
#[derive(State)]
#[fmu(parameters = Parameters, input = Input, output = Output, model_exchange, max_step = 1e-3, experiment(0, 2, 0.01))]
pub struct Ball {
    /// Where the ball is
    #[fmu(unit = "m", nominal = 2.0, start = [0.0, 1.0], rate_depends_on(velocity[i]))]
    pub position: [f64; 2],
    /// Speed of the ball
    #[fmu(unit = "m/s", start = p.throw, local, rate_depends_on(velocity[i], wind[i], fault))]
    pub velocity: [f64; 2],
    /// How often it has touched the floor
    #[fmu(discrete)]
    pub bounces: i32,
    /// Whether it was kicked
    #[fmu(discrete)]
    pub kicked: bool,
}

impl Ode for Ball {
    fn derivative(&self, p: &Parameters, u: &Input, _t: f64, dx: &mut Self) {
        assert!(u.fault != 20, "asked for");
        dx.position = self.velocity;
        dx.velocity = [0, 1].map(|i| p.drag * (u.wind[i] - self.velocity[i]));
        dx.velocity[1] -= if u.fault == 30 { f64::NAN } else { GRAVITY };
    }

    fn outputs(&self, _p: &Parameters, _u: &Input) -> Output {
        let square = self.velocity.iter().map(|v| v * v).sum::<f64>();
        Output {
            energy: 0.5 * square + GRAVITY * self.position[1],
        }
    }

    const INDICATORS: &'static [Variable<Self>] =
        &[Variable::indicator("floor", "Height above the floor")
            .unit("m")
            .depends_on(&["position[2]"])];

    fn indicators(&self, _p: &Parameters, _u: &Input, _t: f64, z: &mut [f64]) {
        z[0] = self.position[1];
    }

    fn event(&mut self, p: &Parameters, u: &Input, t: f64) -> Event {
        if self.position[1] <= 0.0 && self.velocity[1] < 0.0 {
            self.velocity[1] *= -p.restitution;
            self.bounces += 1;
        }
        if !self.kicked && t < KICK {
            return Event::at(KICK);
        }
        if !self.kicked {
            self.velocity[0] += u.kick;
            self.kicked = true;
        }
        Event::NONE
    }
}

export_fmu!(Ball);
