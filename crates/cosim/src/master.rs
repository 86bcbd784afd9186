//! The co-simulation master: initialization, exchange and stepping of a system's instances.

use std::collections::BTreeMap;

use anyhow::{Context, Result, bail};
use fmu_description::{Access, Variability};

use crate::bond::{BondSlots, Residual};
use crate::exchange::{Exchange, Order, Read, Write, reads, writes};
use crate::noise::Noise;
use crate::slave::{At, Slave};
use crate::spare;
use crate::system::{Setting, System};
use crate::wiring::{Link, Port, Wiring};

/// What is exchanged when, and in which order the components are stepped.
///
/// The staged exchange of all but [`Schedule::Standard`] reads outputs again after inputs were set at the same communication point, in the
/// order of direct feedthrough. FMI 2.0 (section 4.2.4) does not promise that: it asks an FMU for it. FMI 3.0 allows it in Event Mode, which
/// the instances of that version are in during the exchange; one that has none is refused.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub enum Schedule {
    /// All that FMI 2.0 promises between masters and FMUs. In initialization mode values are passed in the order of the initial
    /// dependencies, as by every schedule. Then, at every communication point t_k: all connected outputs of all components are read, once;
    /// all connected inputs of all components are set from them, once; all components are stepped to t_(k+1). Nothing is read between a
    /// set and the step that follows it, so a value that goes through a component arrives one step later.
    Standard,
    /// One after the other in the order of the system structure; a component stepped later than the one that exerts an effort on it gets
    /// the mean of that effort over the step.
    #[default]
    GaussSeidel,
    /// All from the values at the communication point, held over the step.
    Jacobi,
    /// As [`Schedule::Jacobi`], with the first time derivatives of continuous outputs passed on to the inputs that can use them.
    JacobiDerivatives,
}

/// Passes of Event Mode after which discrete states that still change are a failure.
const PASSES: usize = 100;

/// Times and schedule of a run.
#[derive(Clone, Copy, Debug)]
pub struct Stepping {
    /// Start, s.
    pub start: f64,
    /// Communication step, s.
    pub step: f64,
    /// Order of stepping.
    pub schedule: Schedule,
}

/// A running system.
pub struct Master {
    slaves: Vec<Slave>,
    stepping: Stepping,
    steps: u64,
    /// Present time, s.
    time: f64,
    exchange: Exchange,
    derivatives: Option<Exchange>,
    means: Means,
    bonds: Vec<BondSlots>,
    residuals: Vec<Residual>,
    bond_steps: Vec<BondStep>,
}

/// What went through a bond in the step just made.
#[derive(Clone, Copy, Debug, Default)]
struct BondStep {
    effort_exerted: f64,
    flow_given: f64,
    effort_given: f64,
    flow_before: f64,
}

/// Step means of the bonds' efforts: read after a component was stepped, given to those stepped later (Gauss–Seidel).
#[derive(Default)]
struct Means {
    reads: Vec<Option<Read>>,
    writes: Vec<Option<Write>>,
    values: Vec<f64>,
    buffer: Vec<f64>,
}

impl Master {
    /// Instantiate and initialize all components of `system`, with the structure's parameter values, then `settings`, in this order;
    /// afterwards all connections are passed at the start time.
    pub fn new(system: &System, settings: &[Setting], stepping: Stepping) -> Result<Self> {
        if !(stepping.step.is_finite() && stepping.step > 0.0 && stepping.start.is_finite()) {
            bail!(
                "step {} s from {} s: both must be finite and the step > 0",
                stepping.step,
                stepping.start
            );
        }
        let wiring = system.wiring()?;
        let is_staged = stepping.schedule != Schedule::Standard;
        let order = if is_staged {
            Order::Stages
        } else {
            Order::AtOnce
        };
        let mut exchange = Exchange::new(&wiring, order, |_| true)?;
        let mut derivatives = None;
        if stepping.schedule == Schedule::JacobiDerivatives {
            derivatives = Some(Exchange::new(&wiring, Order::Stages, |link| {
                passes_derivative(&wiring, link)
            })?);
        }
        let (means, bonds) = Means::new(&wiring, &exchange, derivatives.as_ref())?;
        let slaves: Vec<Slave> = (0..system.fmus.len())
            .map(|k| made(system, k, settings, is_staged))
            .collect::<Result<_>>()?;
        initialize(&slaves, &wiring, stepping.start)?;
        let at = At::Time(stepping.start);
        if is_staged {
            exchange.run(&slaves, at)?;
        } else {
            exchange.read(&slaves, at)?;
        }
        if let Some(d) = &mut derivatives {
            d.run_derivatives(&slaves, at)?;
        }
        let residuals = bonds
            .iter()
            .map(|b| Residual::new(wiring.name(b.effort)))
            .collect();
        let bond_steps = vec![BondStep::default(); bonds.len()];
        Ok(Self {
            slaves,
            stepping,
            steps: 0,
            time: stepping.start,
            exchange,
            derivatives,
            means,
            bonds,
            residuals,
            bond_steps,
        })
    }

    /// Present time, s: `t_0 + k·h` after k steps.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of steps made.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Values of all connected outputs as last exchanged; [`Exchange::slot`] tells whose.
    pub fn exchange(&self) -> &Exchange {
        &self.exchange
    }

    /// Start, communication step and schedule.
    pub fn stepping(&self) -> Stepping {
        self.stepping
    }

    /// Present value of a numeric variable.
    pub fn number(&self, port: Port) -> Result<f64> {
        self.slaves[port.component].number(port.variable, At::Time(self.time))
    }

    /// The instances, in the order of the structure's components.
    pub fn slaves(&self) -> &[Slave] {
        &self.slaves
    }

    /// From now on disturb the chosen inputs; what was passed at the present time is passed again, disturbed.
    pub fn disturb(&mut self, system: &System, noise: &Noise) -> Result<()> {
        self.exchange.disturb(&system.wiring()?, noise)?;
        self.pass()
    }

    /// Pass all connections again at the present time: after inputs that no connection drives have been set. With
    /// [`Schedule::Standard`] nothing is to be done: the next step passes them.
    pub fn pass(&mut self) -> Result<()> {
        if self.stepping.schedule == Schedule::Standard {
            return Ok(());
        }
        self.exchange.run(&self.slaves, At::Time(self.time))
    }

    /// Power residuals of the bonds so far.
    pub fn residuals(&self) -> &[Residual] {
        &self.residuals
    }

    /// One communication step: all components, then the exchange at the new time. Does not allocate unless it fails.
    #[expect(clippy::cast_precision_loss, reason = "2^53 steps are never reached")]
    pub fn step(&mut self) -> Result<()> {
        let Stepping { start, step, .. } = self.stepping;
        self.advance(step, start + (self.steps + 1) as f64 * step)
    }

    /// A last, shorter communication step that ends at `end`, s.
    pub fn step_to(&mut self, end: f64) -> Result<()> {
        self.advance(end - self.time, end)
    }

    fn advance(&mut self, h: f64, end: f64) -> Result<()> {
        let t = self.time;
        let schedule = self.stepping.schedule;
        let gauss_seidel = schedule == Schedule::GaussSeidel;
        if schedule == Schedule::Standard {
            self.exchange.write(&self.slaves, At::Time(t))?;
        } else {
            self.leave_events(At::Time(t))?;
        }
        for (k, slave) in self.slaves.iter().enumerate() {
            if gauss_seidel && let Some(write) = &self.means.writes[k] {
                write.run(
                    &self.slaves,
                    &self.means.values,
                    &mut self.means.buffer,
                    At::Time(t),
                )?;
            }
            slave.step(t, h)?;
            if let Some(read) = &self.means.reads[k] {
                read.run(&self.slaves, &mut self.means.values, At::Time(t))?;
            }
        }
        self.note_bond_steps(h);
        self.steps += 1;
        self.time = end;
        let at = At::Time(end);
        if schedule == Schedule::Standard {
            self.exchange.read(&self.slaves, at)?;
        } else {
            self.slaves.iter().try_for_each(|s| s.enter_events(at))?;
            self.exchange.run(&self.slaves, at)?;
        }
        self.account(h);
        if let Some(d) = &mut self.derivatives {
            d.run_derivatives(&self.slaves, at)?;
        }
        Ok(())
    }

    /// Out of Event Mode, once no discrete state changes any more; where one does, the values are passed again.
    fn leave_events(&mut self, at: At) -> Result<()> {
        for _ in 0..PASSES {
            let mut again = false;
            for slave in &self.slaves {
                again |= slave.update_events(at)?;
            }
            if !again {
                return self.slaves.iter().try_for_each(|s| s.leave_events(at));
            }
            self.exchange.run(&self.slaves, at)?;
        }
        bail!("{at}: discrete states still change after {PASSES} passes of Event Mode")
    }

    /// Note, before the next exchange overwrites them, the means of effort and flow that the components were given.
    fn note_bond_steps(&mut self, h: f64) {
        let half = 0.5 * h;
        let gauss_seidel = self.stepping.schedule == Schedule::GaussSeidel;
        let rise = |slot: Option<usize>| {
            self.derivatives
                .as_ref()
                .zip(slot)
                .map_or(0.0, |(d, slot)| half * d.values[slot])
        };
        for (bond_step, bond) in self.bond_steps.iter_mut().zip(&self.bonds) {
            let effort_exerted = bond.transformation.of(self.means.values[bond.mean_slot]);
            let flow_before = self.exchange.values[bond.flow_slot];
            let held = self.exchange.values[bond.effort_slot] + rise(bond.derivative_slots.0);
            let held = bond.transformation.of(held);
            let effort_given = if gauss_seidel && bond.mean_given {
                effort_exerted
            } else {
                held
            };
            let flow_given = flow_before + rise(bond.derivative_slots.1);
            *bond_step = BondStep {
                effort_exerted,
                flow_given,
                effort_given,
                flow_before,
            };
        }
    }

    /// Add the step to the bonds' residuals; the velocities at its end have just been read.
    fn account(&mut self, h: f64) {
        let bonds = self.bond_steps.iter().zip(&self.bonds);
        for (residual, (given, bond)) in self.residuals.iter_mut().zip(bonds) {
            let moved = 0.5 * (given.flow_before + self.exchange.values[bond.flow_slot]);
            let exerted = given.effort_exerted * given.flow_given;
            residual.add(h, bond.power, exerted, given.effort_given * moved);
        }
    }

    /// End the run for all.
    pub fn terminate(self) -> Result<()> {
        let at = At::Time(self.time);
        self.slaves.iter().try_for_each(|s| s.terminate(at))?;
        spare::keep(self.slaves, self.stepping.schedule != Schedule::Standard);
        Ok(())
    }
}

impl Means {
    fn new(
        wiring: &Wiring,
        exchange: &Exchange,
        derivatives: Option<&Exchange>,
    ) -> Result<(Self, Vec<BondSlots>)> {
        let mut slots = BTreeMap::new();
        let ports = wiring
            .links
            .iter()
            .filter_map(|link| link.bond.map(|b| b.step_mean));
        let count = wiring.component_count();
        let mut means = Self {
            reads: by_component(count),
            writes: by_component(count),
            ..Self::default()
        };
        for read in reads(wiring, ports, &mut slots) {
            let k = read.component();
            means.reads[k] = Some(read);
        }
        let mut bonds = Vec::new();
        let mut given = Vec::new();
        for link in &wiring.links {
            let Some(b) = link.bond else { continue };
            let Some(flow) = wiring.driver(b.flow).map(|k| wiring.links[k].from) else {
                bail!(
                    "power bond of {}: no connection drives its flow {}",
                    wiring.name(link.from),
                    wiring.name(b.flow)
                );
            };
            let slot = |port| exchange.slot(port).context("every connection has a slot");
            let (mean_slot, mean_given) =
                (slots[&b.step_mean], link.from.component < link.to.component);
            if mean_given {
                given.push((link.to, mean_slot, link.transformation));
            }
            let derivative = |port| derivatives.and_then(|d| d.slot(port));
            bonds.push(BondSlots {
                effort: link.from,
                effort_slot: slot(link.from)?,
                flow_slot: slot(flow)?,
                mean_slot,
                mean_given,
                derivative_slots: (derivative(link.from), derivative(flow)),
                transformation: link.transformation,
                power: b.power,
            });
        }
        for write in writes(wiring, given.iter().copied()) {
            let k = write.component();
            means.writes[k] = Some(write);
        }
        means.values = vec![0.0; slots.len()];
        means.buffer = vec![0.0; given.len()];
        Ok((means, bonds))
    }
}

fn by_component<T>(count: usize) -> Vec<Option<T>> {
    std::iter::repeat_with(|| None).take(count).collect()
}

/// An output's derivative is passed where the source gives it, the target uses it and the signal is not sampled.
fn passes_derivative(wiring: &Wiring, link: &Link) -> bool {
    let (from, to) = (
        wiring.description(link.from.component),
        wiring.description(link.to.component),
    );
    wiring.access(link.from) == Access::Real
        && from.capabilities.output_derivative_order >= 1
        && to.capabilities.interpolates_inputs
        && from.variables[link.from.variable].variability == Variability::Continuous
}

/// An instance of the component with the index `k` for itself, with the system's parameter values, then `settings`.
pub fn instantiate(system: &System, k: usize, settings: &[Setting]) -> Result<Slave> {
    made(system, k, settings, false)
}

fn made(system: &System, k: usize, settings: &[Setting], is_staged: bool) -> Result<Slave> {
    let component = &system.structure.components[k];
    let fmu = &system.fmus[k];
    let slave = match spare::take(fmu, &component.name, is_staged) {
        Some(slave) => slave,
        None => Slave::new(fmu, &component.name, is_staged)?,
    };
    for p in &component.parameters {
        slave
            .set_from_text(&p.name, &p.value)
            .with_context(|| p.origin.clone())?;
    }
    for s in settings.iter().filter(|s| s.port.component == k) {
        slave.set_from_text(&system.variable(s.port).name, &s.value)?;
    }
    Ok(slave)
}

/// Value that a variable has in initialization mode under the system's parameter values and `settings`, before any connection is passed.
pub fn start_value(system: &System, settings: &[Setting], port: Port) -> Result<f64> {
    let slave = instantiate(system, port.component, settings)?;
    slave.enter_initialization(system.structure.start_time)?;
    slave.number(port.variable, At::Initialization)
}

/// Pass the connections in initialization mode, in the order of the initial dependencies, so that every component starts from what
/// the others start from.
fn initialize(slaves: &[Slave], wiring: &Wiring, start: f64) -> Result<()> {
    let mut exchange = Exchange::new(wiring, Order::Initialization, |_| true)?;
    for slave in slaves {
        slave.enter_initialization(start)?;
    }
    exchange.run(slaves, At::Initialization)?;
    for slave in slaves {
        slave.exit_initialization()?;
    }
    Ok(())
}
