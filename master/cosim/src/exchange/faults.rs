//! Values that are altered on their way to an input: noise and other faults of wires, and what a
//! scenario does. Off unless asked for. Equal seeds give equal runs.

use anyhow::{Context, Result, bail, ensure};
use fmi_description::{Causality, Kind};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use crate::io::numbers;
use crate::schedule::{Stepping, steps_in};
use crate::structure::system::System;
use crate::wiring::{Port, Wiring};
use fmi_import::value::is_non_numeric;

/// What becomes of a value; numbers are in the unit of the variable.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub enum Effect {
    /// This is added.
    Bias(f64),
    /// It is multiplied by this.
    Gain(f64),
    /// This takes its place.
    Override(f64),
    /// It goes from where it is to this value, linearly over a time, s, and stays there.
    Ramp(f64, f64),
    /// It stays as it is when this begins.
    Freeze,
    /// At each communication point it is lost with this probability; the one before then stays.
    Drop(f64),
    /// It arrives later by this time, s, a multiple of the communication step.
    Delay(f64),
    /// A Gaussian number of this standard deviation is added, drawn anew at each communication
    /// point.
    Noise(f64),
}

/// What a user writes for the effects of a wire.
const WORDS: &str = "bias:NUMBER, gain:NUMBER, override:VALUE, freeze, drop:PROBABILITY, delay:SECONDS or noise:DEVIATION";

/// One thing that is done to a variable's values for some time.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Fault {
    /// An input; or an output, of which all connections then carry the altered value.
    pub port: Port,
    /// What is done.
    pub effect: Effect,
    /// From this communication point on, s.
    pub from: f64,
    /// Until before this communication point, s.
    pub until: f64,
    /// It is one of a scenario: also inputs without a connection are altered.
    pub is_event: bool,
}

/// All that is altered in a run; what is done to one variable follows in this order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faults {
    /// The faults.
    pub list: Vec<Fault>,
    /// Seed of the generator.
    pub seed: u64,
}

/// The variable named `name`, or the elements of the array of this name.
pub fn elements(system: &System, name: &str) -> Result<Vec<Port>> {
    let found = system.port(name);
    let mut firsts = ["[1]", "[1,1]"].iter();
    let first = firsts.find_map(|index| system.port(&format!("{name}{index}")).ok());
    let (Err(_), Some(first)) = (&found, first) else {
        return Ok(vec![found?]);
    };
    let variables = &system.fmus[first.component].description.variables;
    let array = |k: usize| variables[k].name.rsplit_once('[').map(|(array, _)| array);
    let own = (0..variables.len()).filter(|k| array(*k) == array(first.variable));
    Ok(own.map(|variable| Port { variable, ..first }).collect())
}

impl Faults {
    /// Add what is done to a variable, or to the elements of an array, written
    /// `component.variable=effect:number@from..until`; the times, s, may be left out.
    pub fn add(&mut self, system: &System, text: &str) -> Result<()> {
        let parts = text.split_once('=');
        let (name, what) =
            parts.with_context(|| format!("it must be WIRE=EFFECT, and EFFECT {WORDS}"))?;
        let (what, times) = what.rsplit_once('@').unwrap_or((what, ""));
        let (from, until) = times.split_once("..").unwrap_or((times, ""));
        let time = |text: &str, without: f64| {
            let time = text.trim().parse().ok().filter(|t: &f64| t.is_finite());
            let time = time.or(text.trim().is_empty().then_some(without));
            time.with_context(|| format!("`{text}` is no time in s; times are written @1.5..2"))
        };
        let (from, until) = (time(from, f64::NEG_INFINITY)?, time(until, f64::INFINITY)?);
        ensure!(
            from < until,
            "it begins at {from} s and must end later than that, not at {until} s"
        );
        let (word, value) = what.split_once(':').unwrap_or((what, ""));
        for port in elements(system, name.trim())? {
            let effect = effect(system, port, word.trim(), value.trim())?;
            self.list.push(Fault {
                port,
                effect,
                from,
                until,
                is_event: false,
            });
        }
        Ok(())
    }

    /// What is altered, a line for each, for the verdict; `fed` are inputs that an input file
    /// gives.
    ///
    /// # Errors
    /// Nothing gives a value that would be altered.
    pub fn described(&self, system: &System, wiring: &Wiring, fed: &[Port]) -> Result<Vec<String>> {
        let mut lines = Vec::new();
        for fault in &self.list {
            let (port, name) = (fault.port, system.name(fault.port));
            let links = wiring.links.iter().filter(|link| !link.is_initial);
            let mut wires = links.filter(|link| link.from == port || link.to == port);
            let is_input = !is_source(system, port);
            let what = match (wires.next(), wires.next()) {
                (Some(wire), _) if is_non_numeric(wiring.access(wire.from)) => {
                    bail!(
                        "the values of `{}` are of 64 bits and do not pass as numbers; they cannot be altered",
                        wiring.name(wire.from)
                    )
                }
                (Some(wire), None) => {
                    let [from, to] = [wire.from, wire.to].map(|end| wiring.name(end));
                    format!("the wire {from} -> {to}")
                }
                (Some(_), Some(_)) => format!("all wires from {name}"),
                (None, _) if is_input && (fault.is_event || fed.contains(&port)) => {
                    format!("the input {name}")
                }
                (None, _) if is_input => {
                    bail!("no connection and no input file gives `{name}` a value to alter")
                }
                (None, _) if fault.is_event => {
                    lines.push(format!(
                        "the scenario alters {name}, which no connection passes on: it has no effect"
                    ));
                    continue;
                }
                (None, _) => bail!("no connection passes on `{name}`"),
            };
            let unit = system.variable(port).unit.as_deref().filter(|u| *u != "1");
            let effect = fault.effect.described(unit.unwrap_or_default());
            let mut line = format!("on {what}: {effect}");
            for (word, time) in [(", from", fault.from), (" until", fault.until)] {
                if time.is_finite() {
                    line += &format!("{word} t = {time} s");
                }
            }
            lines.push(line);
        }
        Ok(lines)
    }
}

/// Whether the values of a variable are altered where they come from; else where they go to.
pub fn is_source(system: &System, port: Port) -> bool {
    use Causality::{Input, Parameter};
    !matches!(system.variable(port).causality, Input | Parameter)
}

/// An effect by its word, on this variable.
pub fn effect(system: &System, port: Port, word: &str, value: &str) -> Result<Effect> {
    let variable = system.variable(port);
    let name = system.name(port);
    ensure!(
        variable.access().is_number(),
        "`{name}` is of type {}; only numbers are altered",
        variable.kind.name()
    );
    let number = |what: &str, fits: fn(f64) -> bool| {
        let number = value.parse().ok().filter(|x: &f64| x.is_finite());
        ensure!(!value.is_empty(), "{word} of `{name}` needs {what}");
        let number = number.filter(|x| fits(*x));
        number.with_context(|| format!("{word} of `{name}`: `{value}` is not {what}"))
    };
    let real = |kinds: &str, what: &str, fits: fn(f64) -> bool| {
        let kind = variable.kind.name();
        ensure!(
            kind == "Real",
            "{word} of `{name}`, which is of type {kind}: this is for {kinds}; of any type are override, freeze, drop and delay"
        );
        number(what, fits)
    };
    Ok(match word {
        "bias" if variable.kind == Kind::Integer => {
            Effect::Bias(number("a whole number", |x| x.fract() == 0.0)?)
        }
        "bias" => Effect::Bias(real("Reals and Integers", "a finite number", |_| true)?),
        "gain" => Effect::Gain(real("Reals", "a finite number", |_| true)?),
        "noise" => {
            let what = "a standard deviation, finite and not negative";
            Effect::Noise(real("Reals", what, |x| x >= 0.0)?)
        }
        "override" => {
            let number = numbers::number(variable, value);
            Effect::Override(number.with_context(|| format!("override of `{name}`"))?)
        }
        "freeze" if value.is_empty() => Effect::Freeze,
        "freeze" => bail!("freeze of `{name}`: it takes no number, but `{value}` is given"),
        "drop" => {
            let fits = |x| (0.0..=1.0).contains(&x);
            Effect::Drop(number("a probability from 0 to 1", fits)?)
        }
        "delay" => Effect::Delay(number("a time in s, greater than 0", |x| x > 0.0)?),
        _ => bail!("`{word}` is nothing that can be done to a value; it must be {WORDS}"),
    })
}

impl Effect {
    fn described(self, unit: &str) -> String {
        let text = match self {
            Self::Bias(x) => format!("bias of {x} {unit}"),
            Self::Gain(x) => format!("gain of {x}"),
            Self::Override(x) => format!("override by {x} {unit}"),
            Self::Ramp(to, over) => format!("ramp to {to} {unit} over {over} s"),
            Self::Freeze => "freeze".into(),
            Self::Drop(x) => format!("values dropped with probability {x}"),
            Self::Delay(x) => format!("delay of {x} s"),
            Self::Noise(x) => format!("noise of standard deviation {x} {unit}"),
        };
        text.trim_end().replace(" , ", ", ")
    }
}

/// The faults of a run that is being made.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Alteration {
    faults: Vec<Active>,
    /// Faults that draw numbers, in the order in which they do.
    draws: Vec<usize>,
    channels: Vec<Channel>,
    generator: ChaCha8Rng,
    stepping: Stepping,
    /// Present communication point, s.
    time: f64,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
struct Active {
    fault: Fault,
    is_on: bool,
    /// Normal number.
    drawn: f64,
    /// The value of this communication point is lost.
    is_lost: bool,
}

/// The values of one wire, or of the mean effort that goes over it.
#[derive(Clone, Debug, Deserialize, Serialize)]
struct Channel {
    states: Vec<State>,
    /// What was given last.
    given: Option<f64>,
    /// What was given at the communication point before.
    before: Option<f64>,
}

/// What one fault remembers of one channel. At one communication point values may pass several
/// times; the last counts.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
struct State {
    fault: usize,
    value: f64,
    has_value: bool,
    /// The value is that of an earlier communication point.
    is_held: bool,
    /// Values of earlier communication points, as many as the delay has steps.
    before: Vec<f64>,
    oldest: usize,
    steps: usize,
}

impl Alteration {
    /// Of `faults`, in a run with these steps.
    ///
    /// # Errors
    /// A delay is no multiple of the communication step.
    pub fn new(system: &System, faults: &Faults, stepping: Stepping) -> Result<Self> {
        let mut active = Vec::new();
        for fault in &faults.list {
            if let Effect::Delay(delay) = fault.effect {
                ensure!(
                    steps_in(delay, stepping.step).is_some(),
                    "the delay of {delay} s of `{}` must be a multiple of the communication step, {} s",
                    system.name(fault.port),
                    stepping.step
                );
            }
            active.push(Active {
                fault: fault.clone(),
                is_on: false,
                drawn: 0.0,
                is_lost: false,
            });
        }
        Ok(Self {
            faults: active,
            draws: Vec::new(),
            channels: Vec::new(),
            generator: ChaCha8Rng::seed_from_u64(faults.seed),
            stepping,
            time: f64::NAN,
        })
    }

    /// A delay, s: it counts communication steps.
    pub fn delay(&self) -> Option<f64> {
        self.faults
            .iter()
            .find_map(|active| match active.fault.effect {
                Effect::Delay(delay) => Some(delay),
                _ => None,
            })
    }

    /// Whether the same is done to the same values.
    pub fn is_like(&self, other: &Self) -> bool {
        let [own, others] = [self, other].map(|of| of.faults.iter().map(|a| &a.fault));
        own.eq(others) && self.channels.len() == other.channels.len()
    }

    /// A channel for values of `port`; none where nothing is done to them.
    pub fn channel(&mut self, port: Port) -> Option<usize> {
        let mut states = Vec::new();
        for (k, Active { fault, .. }) in self.faults.iter().enumerate() {
            if fault.port != port {
                continue;
            }
            let draws = matches!(fault.effect, Effect::Noise(_) | Effect::Drop(_));
            if draws && !self.draws.contains(&k) {
                self.draws.push(k);
            }
            states.push(State::new(k, fault, self.stepping));
        }
        if states.is_empty() {
            return None;
        }
        self.channels.push(Channel {
            states,
            given: None,
            before: None,
        });
        Some(self.channels.len() - 1)
    }

    /// The communication point at `t`, s, begins, unless it has begun.
    pub fn begin(&mut self, t: f64) {
        if t == self.time {
            return;
        }
        self.time = t;
        let early = t + 1e-6 * self.stepping.step;
        for active in &mut self.faults {
            active.is_on = active.fault.from <= early && early < active.fault.until;
        }
        for k in &self.draws {
            let active = &mut self.faults[*k];
            match active.fault.effect {
                Effect::Drop(share) => active.is_lost = uniform(&mut self.generator) < share,
                _ => active.drawn = StandardNormal.sample(&mut self.generator),
            }
        }
        for channel in &mut self.channels {
            channel.before = channel.given;
            for state in &mut channel.states {
                state.advance();
            }
        }
    }

    /// The altered value of a channel.
    pub fn of(&mut self, channel: usize, value: f64) -> f64 {
        let channel = &mut self.channels[channel];
        let before = channel.before;
        let given = channel.states.iter_mut().fold(value, |value, state| {
            state.pass(&self.faults[state.fault], self.time, value, before)
        });
        channel.given = Some(given);
        given
    }

    /// The rate of change of an altered value.
    pub fn of_derivative(&self, channel: usize, rate: f64) -> f64 {
        let states = self.channels[channel].states.iter();
        let active = states.map(|state| &self.faults[state.fault]);
        let mut on = active.filter(|active| active.is_on);
        on.try_fold(rate, |rate, active| match active.fault.effect {
            Effect::Bias(_) | Effect::Noise(_) => Some(rate),
            Effect::Gain(gain) => Some(gain * rate),
            _ => None,
        })
        .unwrap_or(0.0)
    }
}

/// A number from 0 to 1, 1 excluded.
fn uniform(generator: &mut ChaCha8Rng) -> f64 {
    (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

impl State {
    fn new(fault: usize, of: &Fault, stepping: Stepping) -> Self {
        let steps = match of.effect {
            Effect::Delay(delay) => steps_in(delay, stepping.step),
            _ => None,
        };
        let steps = steps.map_or(0, |n| usize::try_from(n).unwrap_or(usize::MAX));
        Self {
            fault,
            before: Vec::with_capacity(steps),
            steps,
            ..Self::default()
        }
    }

    /// The next communication point begins.
    fn advance(&mut self) {
        self.is_held = self.has_value;
        if self.steps == 0 || !self.has_value {
            return;
        }
        if self.before.len() < self.steps {
            self.before.push(self.value);
        } else {
            self.before[self.oldest] = self.value;
            self.oldest = (self.oldest + 1) % self.steps;
        }
    }

    /// The value after this fault; `before` is what was given at the communication point before.
    fn pass(&mut self, active: &Active, time: f64, value: f64, before: Option<f64>) -> f64 {
        let captures = matches!(active.fault.effect, Effect::Freeze | Effect::Ramp(..));
        let keeps = active.is_on && (captures || active.is_lost);
        if !(keeps && self.is_held) {
            self.value = match active.fault.effect {
                Effect::Ramp(..) => before.unwrap_or(value),
                _ => value,
            };
            self.has_value = active.is_on || !captures;
        }
        if !active.is_on {
            return value;
        }
        match active.fault.effect {
            Effect::Bias(bias) => value + bias,
            Effect::Gain(gain) => gain * value,
            Effect::Override(by) => by,
            Effect::Ramp(to, over) => {
                let share = ((time - active.fault.from) / over).clamp(0.0, 1.0);
                match share < 1.0 {
                    true => self.value + share * (to - self.value),
                    false => to,
                }
            }
            Effect::Freeze | Effect::Drop(_) => self.value,
            Effect::Delay(_) => self.before.get(self.oldest).copied().unwrap_or(value),
            Effect::Noise(deviation) => value + deviation * active.drawn,
        }
    }
}
