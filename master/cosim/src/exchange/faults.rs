//! Alters values on their way to inputs, for exchanges and input tables: faults of wires
//! (`--fault`, and in studies) and events of scenarios (`--scenario`). Equal seeds give equal runs.

use std::collections::{HashMap, HashSet, VecDeque};

use anyhow::{Context, Result, bail, ensure};
use fmi_description::{Causality, Kind};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use crate::io::numbers;
use crate::schedule::{Stepping, steps_in};
use crate::structure::system::System;
use crate::wiring::{Link, Port, Wiring};
use fmi_import::digits::short;
use fmi_import::value::is_non_numeric;

/// What is done to a value; numbers are in the unit of the variable.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub enum Effect {
    /// Add this.
    Bias(f64),
    /// Multiply by this.
    Gain(f64),
    /// Replace by this.
    Override(f64),
    /// Go linearly from the present value to this one over a time, s, and stay there.
    Ramp(f64, f64),
    /// Hold the value from the beginning of the fault.
    Freeze,
    /// Lose the value with this probability at each communication point, and hold the one before.
    Drop(f64),
    /// Delay by this time, s, a multiple of the communication step.
    Delay(f64),
    /// Add Gaussian noise of this standard deviation, drawn at each communication point.
    Noise(f64),
}

/// The effects as a user writes them.
const EFFECT_FORMS: &str = "bias:NUMBER, gain:NUMBER, override:VALUE, freeze, drop:PROBABILITY, delay:SECONDS or noise:DEVIATION";

/// An effect on the values of a variable for some time.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Fault {
    /// An input; or an output, of which all connections carry the altered value.
    pub port: Port,
    /// Effect.
    pub effect: Effect,
    /// From this communication point on, s.
    pub from: f64,
    /// Until before this communication point, s.
    pub until: f64,
    /// It is an event of a scenario, which also alters inputs without a connection.
    pub is_event: bool,
}

impl Fault {
    /// Whether it draws random numbers.
    fn draws(&self) -> bool {
        matches!(self.effect, Effect::Noise(_) | Effect::Drop(_))
    }
}

/// All faults of a run. Those of one variable apply in this order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faults {
    /// The faults.
    pub list: Vec<Fault>,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Faults {
    /// Add a fault of a variable, or of the elements of an array, written
    /// `component.variable=effect:number@from..until`; the times, s, are optional.
    pub fn add(&mut self, system: &System, text: &str) -> Result<()> {
        let parts = system.split_name(text);
        let (name, what) =
            parts.with_context(|| format!("it must be WIRE=EFFECT, and EFFECT {EFFECT_FORMS}"))?;
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
            "it begins at {from} s and must end later than that, not at {until} s",
            from = short(from),
            until = short(until)
        );
        let (word, value) = what.split_once(':').unwrap_or((what, ""));
        for port in system.ports(name)? {
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

    /// Whether a fault draws random numbers.
    pub fn is_random(&self) -> bool {
        self.list.iter().any(Fault::draws)
    }

    /// One line per fault for the verdict; `fed` are the inputs of an input file. A fault of a
    /// variable that gets or passes on no value is an error.
    pub fn describe(&self, system: &System, wiring: &Wiring, fed: &[Port]) -> Result<Vec<String>> {
        let mut lines = Vec::new();
        let mut wires_at: HashMap<Port, Vec<&Link>> = HashMap::new();
        for link in wiring.links.iter().filter(|link| !link.is_initial) {
            for end in [link.from, link.to] {
                wires_at.entry(end).or_default().push(link);
            }
        }
        let fed: HashSet<Port> = fed.iter().copied().collect();
        for fault in &self.list {
            let (port, name) = (fault.port, system.name(fault.port));
            let mut wires = wires_at.get(&port).into_iter().flatten();
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
                (Some(_), Some(_)) if is_input => format!("the input {name}"),
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
            let effect = fault.effect.describe(unit.unwrap_or_default());
            let mut line = format!("on {what}: {effect}");
            for (word, time) in [(", from", fault.from), (" until", fault.until)] {
                if time.is_finite() {
                    line += &format!("{word} t = {} s", short(time));
                }
            }
            lines.push(line);
        }
        Ok(lines)
    }
}

/// Whether a variable is altered as the source of values, else as their target.
pub fn is_source(system: &System, port: Port) -> bool {
    use Causality::{Input, Parameter};
    !matches!(system.variable(port).causality, Input | Parameter)
}

/// Parse an effect on the variable `port` from its name and value.
pub(crate) fn effect(system: &System, port: Port, word: &str, value: &str) -> Result<Effect> {
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
        _ => bail!("`{word}` is nothing that can be done to a value; it must be {EFFECT_FORMS}"),
    })
}

impl Effect {
    fn describe(self, unit: &str) -> String {
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

/// The faults of a run, with what they remember from one communication point to the next.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Alteration {
    faults: Vec<FaultState>,
    /// Places of the faults of each variable.
    #[serde(skip)]
    by_port: HashMap<Port, Vec<usize>>,
    /// Faults that draw random numbers, in this order.
    draws: Vec<usize>,
    channels: Vec<Channel>,
    generator: ChaCha8Rng,
    stepping: Stepping,
    /// Present communication point, s.
    time: f64,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
struct FaultState {
    fault: Fault,
    is_on: bool,
    /// Standard normal random number of this communication point.
    drawn: f64,
    /// The value at this communication point is lost.
    is_lost: bool,
}

/// The values of a wire, or of the mean effort that passes over it.
#[derive(Clone, Debug, Deserialize, Serialize)]
struct Channel {
    states: Vec<ChannelState>,
    /// Value passed last.
    passed: Option<f64>,
    /// Value passed at the communication point before.
    before: Option<f64>,
}

/// What one fault remembers of one channel. Values may pass several times at a communication point;
/// the last one counts.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
struct ChannelState {
    fault: usize,
    value: f64,
    has_value: bool,
    /// The value is that of an earlier communication point.
    is_held: bool,
    /// Earlier values, the oldest first, as many as the delay has steps.
    before: VecDeque<f64>,
    steps: usize,
}

impl Alteration {
    /// Begin with `faults`, whose delays must be multiples of the communication step.
    pub fn new(system: &System, faults: &Faults, stepping: Stepping) -> Result<Self> {
        let (mut active, mut by_port) = (Vec::new(), HashMap::<Port, Vec<usize>>::new());
        for (k, fault) in faults.list.iter().enumerate() {
            if let Effect::Delay(delay) = fault.effect {
                ensure!(
                    steps_in(delay, stepping.step).is_some(),
                    "the delay of {} s of `{}` must be a multiple of the communication step, {} s",
                    short(delay),
                    system.name(fault.port),
                    short(stepping.step)
                );
            }
            by_port.entry(fault.port).or_default().push(k);
            active.push(FaultState {
                fault: fault.clone(),
                is_on: false,
                drawn: 0.0,
                is_lost: false,
            });
        }
        Ok(Self {
            faults: active,
            by_port,
            draws: Vec::new(),
            channels: Vec::new(),
            generator: ChaCha8Rng::seed_from_u64(faults.seed),
            stepping,
            time: f64::NAN,
        })
    }

    /// The delay of a fault, s, if there is one.
    pub fn delay(&self) -> Option<f64> {
        let mut faults = self.faults.iter();
        faults.find_map(|active| match active.fault.effect {
            Effect::Delay(delay) => Some(delay),
            _ => None,
        })
    }

    /// Whether the same faults concern the same channels.
    pub fn is_like(&self, other: &Self) -> bool {
        let [own, others] = [self, other].map(|of| of.faults.iter().map(|a| &a.fault));
        own.eq(others) && self.channels.len() == other.channels.len()
    }

    /// Add a channel for values of `port`; None if no fault concerns them.
    pub fn channel(&mut self, port: Port) -> Option<usize> {
        let mut states = Vec::new();
        for k in self.by_port.get(&port).into_iter().flatten().copied() {
            let fault = &self.faults[k].fault;
            if fault.draws() && !self.draws.contains(&k) {
                self.draws.push(k);
            }
            states.push(ChannelState::new(k, fault, self.stepping));
        }
        if states.is_empty() {
            return None;
        }
        self.channels.push(Channel {
            states,
            passed: None,
            before: None,
        });
        Some(self.channels.len() - 1)
    }

    /// Begin the communication point at `t`, s, unless it has begun.
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
            channel.before = channel.passed;
            for state in &mut channel.states {
                state.advance();
            }
        }
    }

    /// The altered value.
    pub fn alter(&mut self, channel: usize, value: f64) -> f64 {
        let channel = &mut self.channels[channel];
        let before = channel.before;
        let passed = channel.states.iter_mut().fold(value, |value, state| {
            state.pass(&self.faults[state.fault], self.time, value, before)
        });
        channel.passed = Some(passed);
        passed
    }

    /// The rate of change of an altered value.
    pub fn alter_rate(&self, channel: usize, rate: f64) -> f64 {
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

/// A random number in [0, 1).
fn uniform(generator: &mut ChaCha8Rng) -> f64 {
    (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

impl ChannelState {
    fn new(index: usize, fault: &Fault, stepping: Stepping) -> Self {
        let steps = match fault.effect {
            Effect::Delay(delay) => steps_in(delay, stepping.step),
            _ => None,
        };
        let steps = steps.map_or(0, |n| usize::try_from(n).unwrap_or(usize::MAX));
        Self {
            fault: index,
            before: VecDeque::with_capacity(steps),
            steps,
            ..Self::default()
        }
    }

    /// Begin the next communication point.
    fn advance(&mut self) {
        self.is_held = self.has_value;
        if self.steps == 0 || !self.has_value {
            return;
        }
        if self.before.len() == self.steps {
            self.before.pop_front();
        }
        self.before.push_back(self.value);
    }

    /// The value after this fault; `before` is the value passed at the communication point before.
    fn pass(&mut self, active: &FaultState, time: f64, value: f64, before: Option<f64>) -> f64 {
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
            Effect::Delay(_) => self.before.front().copied().unwrap_or(value),
            Effect::Noise(deviation) => value + deviation * active.drawn,
        }
    }
}
