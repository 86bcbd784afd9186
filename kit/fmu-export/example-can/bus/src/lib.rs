//! FMU `CanBus`: a CAN bus of two nodes. It sends one frame at a time, the one whose identifier wins
//! arbitration, and confirms it.
//!
//! A frame takes the time of its bits at the baud rate, without stuff bits; those of CAN FD and CAN
//! XL that of a frame of classical CAN with as many bytes. Nodes see it at the communication point
//! where it ends, or at the next one. Errors of the bus are not simulated.

use fmu_export::can::{
    ArbitrationLost, CanInput, CanOutput, Configuration, Format, Frame, NodeStatus, Operation,
    Queue,
};
use fmu_export::{Terminal, can_clocks, prelude::*};

/// Most bytes of operations at a time, and of frames of a node that wait.
const MOST: usize = 4096;
const NODES: usize = 2;
/// Most bytes that a node receives of one transmission: the largest frame, and an Arbitration Lost.
const LARGEST: usize = 22 + 2048 + 12;

#[derive(Parameters)]
struct Parameters {
    /// Baud rate until a node configures it, bit/s
    #[fmu(start = 500_000, min = 1000, max = 1_000_000)]
    baud_rate: i32,
    /// Whether the bus confirms frames, and may tell of lost arbitration
    #[fmu(start = true)]
    notifies: bool,
}

#[derive(Input)]
struct Input {
    node: [CanInput<MOST>; 2],
}

#[derive(Output)]
struct Output {
    /// Number of frames that were transmitted
    #[fmu(initially_depends_on())]
    frames: i32,
    /// Number of times that a frame has lost arbitration
    #[fmu(initially_depends_on())]
    lost: i32,
    /// Whether the bus tells of what becomes of frames
    #[fmu(
        name = "node[1].BusNotifications",
        calculated,
        initially_depends_on(notifies)
    )]
    notifies_1: bool,
    /// Whether the bus tells of what becomes of frames
    #[fmu(
        name = "node[2].BusNotifications",
        calculated,
        initially_depends_on(notifies)
    )]
    notifies_2: bool,
    node: [CanOutput<MOST>; 2],
}

/// What the bus knows of a node.
#[derive(Clone, Serialize, Deserialize)]
#[serde(crate = "fmu_export::serde")]
struct Node {
    /// The frames that it has sent and that were not yet transmitted.
    frames: Queue<MOST>,
    behavior: ArbitrationLost,
    status: NodeStatus,
}

impl Node {
    /// The frame for which it competes.
    fn frame(&self) -> Option<Frame<'_>> {
        match self.frames.first() {
            Some(Operation::Transmit(frame)) => Some(frame),
            _ => None,
        }
    }
}

#[derive(Clone, Serialize, Deserialize)]
#[serde(crate = "fmu_export::serde")]
struct Bus {
    node: [CanOutput<MOST>; NODES],
    known: [Node; NODES],
    baud_rate: u32,
    /// The node whose first frame is being transmitted, and the time when that ends, s.
    sender: Option<(usize, f64)>,
    frames: i32,
    lost: i32,
    log: Log,
}

/// Number of bits from the start of a frame to the end of the gap after it, without stuff bits.
fn bits(frame: &Frame<'_>) -> f64 {
    let rest = if frame.is_extended { 67 } else { 47 };
    (rest + 8 * frame.data.len()) as f64
}

/// The bits that decide arbitration: the least wins. Between the first 11 bits of the identifier and
/// the rest are the bits RTR or SRR, and IDE.
fn priority(frame: &Frame<'_>) -> u32 {
    let remote = u32::from(frame.format == Format::Can { is_remote: true });
    match frame.is_extended {
        false => frame.id << 21 | remote << 20,
        true => (frame.id >> 18) << 21 | 3 << 19 | (frame.id & 0x3_ffff) << 1 | remote,
    }
}

impl Bus {
    /// Handles what node `K` has sent.
    fn receive<const K: usize>(
        &mut self,
        _p: &Parameters,
        u: &Input,
        tick: Tick,
    ) -> Result<(), ModelError> {
        let t = tick.time;
        for operation in u.node[K].operations() {
            let known = &mut self.known[K];
            match operation {
                Ok(Operation::Transmit(_)) if known.status == NodeStatus::BusOff => {
                    (self.log).warning(
                        "",
                        format_args!("t = {t} s: node[{}] is off the bus and sends", K + 1),
                    );
                }
                Ok(frame @ Operation::Transmit(_)) => {
                    known.frames.push(&frame).map_err(|full| {
                        ModelError::new(format!(
                            "frames of node[{}] wait for the bus: {full}",
                            K + 1
                        ))
                    })?
                }
                Ok(Operation::Configuration(Configuration::BaudRate(rate))) if rate > 0 => {
                    self.baud_rate = rate;
                }
                Ok(Operation::Configuration(Configuration::ArbitrationLost(behavior))) => {
                    known.behavior = behavior;
                }
                Ok(Operation::Status(status)) => {
                    known.status = status;
                    if status == NodeStatus::BusOff {
                        known.frames.clear();
                        self.sender = self.sender.filter(|(sender, _)| *sender != K);
                    }
                }
                Ok(Operation::Wakeup) => {
                    for (other, node) in self.node.iter_mut().enumerate() {
                        if other != K {
                            node.send(&Operation::Wakeup)?;
                        }
                    }
                }
                Ok(other) => {
                    (self.log).warning(
                        "",
                        format_args!(
                            "t = {t} s: node[{}] sends {other:?}, which has no effect",
                            K + 1
                        ),
                    );
                }
                Err(corrupt) => {
                    let reason = corrupt.reason;
                    (self.log).warning(
                        "",
                        format_args!("t = {t} s: node[{}] sends {reason}", K + 1),
                    );
                    self.node[K].reject(&corrupt);
                }
            }
        }
        Ok(())
    }

    /// Transmits frames from `now` to `end`, both s.
    fn transmit(&mut self, p: &Parameters, mut now: f64, end: f64) -> Result<(), ModelError> {
        while self.node.iter().all(|node| node.room() >= LARGEST) {
            if let Some((sender, done)) = self.sender {
                if done > end + 1e-12 * end.abs() {
                    return Ok(());
                }
                self.deliver(p, sender)?;
                (self.sender, now) = (None, done);
            }
            let Some(winner) = self.arbitrate(p)? else {
                return Ok(());
            };
            let frame = self.known[winner].frame();
            let time = frame.map_or(0.0, |frame| bits(&frame)) / f64::from(self.baud_rate);
            self.sender = Some((winner, now + time));
        }
        (self.log).warning(
            "",
            format_args!("t = {end} s: frames wait for the next step; steps must be shorter"),
        );
        Ok(())
    }

    /// The node that may send; tells the others, if they want to know.
    fn arbitrate(&mut self, p: &Parameters) -> Result<Option<usize>, ModelError> {
        let rank = |node: &Node| {
            let frame = node.frame()?;
            Some((node.status == NodeStatus::ErrorPassive, priority(&frame)))
        };
        let ranks = self.known.each_ref().map(rank);
        let competing = (0..NODES).filter(|&k| ranks[k].is_some());
        let Some(winner) = competing.min_by_key(|&k| ranks[k]) else {
            return Ok(None);
        };
        for (k, known) in self.known.iter_mut().enumerate() {
            let Some(frame) = known.frame().filter(|_| k != winner) else {
                continue;
            };
            self.lost += 1;
            if p.notifies && known.behavior == ArbitrationLost::DiscardAndNotify {
                self.node[k].send(&Operation::ArbitrationLost(frame.id))?;
                known.frames.remove_first();
            }
        }
        Ok(Some(winner))
    }

    /// Passes the first frame of a node to the others, and confirms it if one of them takes part.
    fn deliver(&mut self, p: &Parameters, sender: usize) -> Result<(), ModelError> {
        let status = self.known.each_ref().map(|known| known.status);
        let takes_part = |k: usize| k != sender && status[k] != NodeStatus::BusOff;
        if let Some(frame) = self.known[sender].frame() {
            for (k, node) in self.node.iter_mut().enumerate() {
                if takes_part(k) {
                    node.send(&Operation::Transmit(frame))?;
                } else if p.notifies && k == sender && (0..NODES).any(takes_part) {
                    node.send(&Operation::Confirm(frame.id))?;
                }
            }
            self.frames += 1;
        }
        self.known[sender].frames.remove_first();
        Ok(())
    }
}

impl Model for Bus {
    const INFO: Info = Info::new("CanBus", "a CAN bus of two nodes")
        .version(env!("CARGO_PKG_VERSION"))
        .experiment(0.0, 0.1, 1e-4)
        .terminals(&[
            Terminal::can("node[1]", "the first node").of_bus_simulation(),
            Terminal::can("node[2]", "the second node").of_bus_simulation(),
        ]);
    const CLOCKS: &'static [Clock<Self>] = can_clocks!(
        "node[1]" = node[0]: Self::receive::<0>,
        "node[2]" = node[1]: Self::receive::<1>,
    );
    derived!(Parameters, Input, Output);

    fn initialize(p: &Parameters, _u: &Input, _t: f64) -> Result<Self, ModelError> {
        let known = |_| Node {
            frames: Queue::default(),
            behavior: ArbitrationLost::BufferAndRetransmit,
            status: NodeStatus::ErrorActive,
        };
        Ok(Self {
            node: Default::default(),
            known: [0; NODES].map(known),
            baud_rate: p.baud_rate as u32,
            sender: None,
            frames: 0,
            lost: 0,
            log: Log::default(),
        })
    }

    fn output(&self, p: &Parameters, u: &Input, now: &()) -> Result<Output, ModelError> {
        let mut y = Output::default();
        self.output_into(p, u, now, &mut y)?;
        Ok(y)
    }

    fn output_into(
        &self,
        p: &Parameters,
        _u: &Input,
        _now: &(),
        y: &mut Output,
    ) -> Result<(), ModelError> {
        (y.notifies_1, y.notifies_2) = (p.notifies, p.notifies);
        (y.frames, y.lost) = (self.frames, self.lost);
        y.node.clone_from(&self.node);
        Ok(())
    }

    fn step(
        &mut self,
        p: &Parameters,
        _u: &InputPolynomial<Input>,
        _now: &(),
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        self.transmit(p, t, t + h)?;
        let mut end = StepEnd::WHOLE;
        end.event = self.node.iter().any(CanOutput::is_waiting);
        Ok(end)
    }

    fn log(&mut self) -> Option<&mut Log> {
        Some(&mut self.log)
    }
}

export_fmu!(Bus);

#[cfg(test)]
#[path = "../tests/unit/mod.rs"]
mod tests;
