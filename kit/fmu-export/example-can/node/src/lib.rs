//! FMU `CanNode`: a node of a CAN network. It sends a value in each period and shows the values that
//! it receives.

use fmu_export::can::{
    ArbitrationLost, CanInput, CanOutput, Configuration, Frame, Operation, Unsent,
};
use fmu_export::{Terminal, can_clocks, prelude::*};

/// Most bytes of operations at a time.
const MOST: usize = 2048;

#[derive(Parameters)]
struct Parameters {
    /// Identifier of the frames that the node sends
    #[fmu(start = 0x101, min = 0, max = 0x7ff)]
    id: i32,
    /// Period of the frames
    #[fmu(unit = "s", start = 0.01, min = 1e-6)]
    period: f64,
    /// Baud rate of the network, bit/s
    #[fmu(start = 500_000, min = 1000, max = 1_000_000)]
    baud_rate: i32,
    /// Whether the bus discards frames that lose arbitration, so that the node sends them again
    #[fmu(start = false)]
    discards: bool,
    /// Whether the bus tells of what becomes of frames
    #[fmu(name = "can.BusNotifications", start = false)]
    bus_notifications: bool,
}

#[derive(Input)]
struct Input {
    /// The value that is sent
    #[fmu(unit = "1", discrete)]
    u: f64,
    can: CanInput<MOST>,
}

#[derive(Output)]
struct Output {
    /// The value that was received last
    #[fmu(unit = "1", discrete, initially_depends_on())]
    y: f64,
    /// Number of frames received
    #[fmu(initially_depends_on())]
    received: i32,
    /// Number of frames sent, again where arbitration was lost
    #[fmu(initially_depends_on())]
    sent: i32,
    /// Number of frames that the bus has confirmed
    #[fmu(initially_depends_on())]
    confirmed: i32,
    /// Number of frames that lost arbitration
    #[fmu(initially_depends_on())]
    lost: i32,
    can: CanOutput<MOST>,
}

#[derive(Clone, Serialize, Deserialize)]
#[serde(crate = "fmu_export::serde")]
struct Node {
    can: CanOutput<MOST>,
    y: f64,
    received: i32,
    sent: i32,
    confirmed: i32,
    lost: i32,
    /// Periods that have passed.
    periods: f64,
    /// The value in the frame that was sent last.
    value: f64,
    log: Log,
}

impl Node {
    /// Sends a frame with the value.
    fn send(&mut self, p: &Parameters, value: f64) -> Result<(), Unsent> {
        let data = value.to_le_bytes();
        self.can
            .send(&Operation::Transmit(Frame::standard(p.id as u32, &data)))?;
        (self.value, self.sent) = (value, self.sent + 1);
        Ok(())
    }

    /// Handles what was received.
    fn receive(&mut self, p: &Parameters, u: &Input, tick: Tick) -> Result<(), ModelError> {
        for operation in u.can.operations() {
            match operation {
                Ok(Operation::Transmit(frame)) => {
                    self.received += 1;
                    if let Some(value) = frame.data.first_chunk() {
                        self.y = f64::from_le_bytes(*value);
                    }
                }
                Ok(Operation::Confirm(_)) if p.bus_notifications => self.confirmed += 1,
                Ok(Operation::ArbitrationLost(_)) if p.bus_notifications => {
                    self.lost += 1;
                    self.send(p, self.value)?;
                }
                Ok(_) => {}
                Err(corrupt) => {
                    let (t, reason) = (tick.time, corrupt.reason);
                    self.log
                        .warning("", format_args!("t = {t} s: received {reason}"));
                    self.can.reject(&corrupt);
                }
            }
        }
        Ok(())
    }
}

impl Model for Node {
    const INFO: Info = Info::new("CanNode", "a node of a CAN network")
        .version(env!("CARGO_PKG_VERSION"))
        .experiment(0.0, 0.1, 1e-4)
        .terminals(&[Terminal::can("can", "the CAN network")]);
    const CLOCKS: &'static [Clock<Self>] = can_clocks!("can" = can: Self::receive);
    derived!(Parameters, Input, Output);

    /// Configures the bus.
    fn initialize(p: &Parameters, _u: &Input, _t: f64) -> Result<Self, ModelError> {
        let mut can = CanOutput::default();
        let behavior = match p.discards {
            true => ArbitrationLost::DiscardAndNotify,
            false => ArbitrationLost::BufferAndRetransmit,
        };
        for parameter in [
            Configuration::BaudRate(p.baud_rate as u32),
            Configuration::ArbitrationLost(behavior),
        ] {
            can.send(&Operation::Configuration(parameter))?;
        }
        Ok(Self {
            can,
            y: 0.0,
            received: 0,
            sent: 0,
            confirmed: 0,
            lost: 0,
            periods: 0.0,
            value: 0.0,
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
        _p: &Parameters,
        _u: &Input,
        _now: &(),
        y: &mut Output,
    ) -> Result<(), ModelError> {
        (y.y, y.received, y.sent) = (self.y, self.received, self.sent);
        (y.confirmed, y.lost) = (self.confirmed, self.lost);
        y.can.clone_from(&self.can);
        Ok(())
    }

    /// Sends a frame at the end of a step in which a period ends.
    fn step(
        &mut self,
        p: &Parameters,
        u: &InputPolynomial<Input>,
        _now: &(),
        t: f64,
        h: f64,
    ) -> Result<StepEnd, ModelError> {
        let periods = ((t + h) / p.period + 1e-9).floor();
        if periods > self.periods {
            self.send(p, u.value().u)?;
            self.periods = periods;
        }
        let mut end = StepEnd::WHOLE;
        end.event = self.can.is_waiting();
        Ok(end)
    }

    fn log(&mut self) -> Option<&mut Log> {
        Some(&mut self.log)
    }
}

export_fmu!(Node);

#[cfg(test)]
mod tests {
    use super::Node;

    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<Node>(), [""; 0]);
    }
}
