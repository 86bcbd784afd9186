//! The description of models with CAN: rows, clocks, and mistakes in terminals.

use fmu_export::can::{CanInput, CanOutput};
use fmu_export::{Terminal, can_clocks, check, model_description, model_description3, prelude::*};

macro_rules! node {
    ($name:ident, $terminals:expr) => {
        /// A node
        #[derive(State)]
        #[fmu(input = Input, info = Self::ABOUT)]
        struct $name {
            body: CanOutput<128>,
        }

        impl $name {
            const ABOUT: Info = Info::new(stringify!($name), "A node").terminals($terminals);

            fn receive(&mut self, _p: &(), _u: &Input, _tick: Tick) -> Result<(), ModelError> {
                Ok(())
            }
        }

        impl Ode for $name {
            const CLOCKS: &'static [Clock<Self>] = can_clocks!("body" = body: Self::receive);

            fn derivative(&self, _p: &(), _u: &Input, _t: f64, _dx: &mut Self) {}
        }
    };
}

#[derive(Input)]
struct Input {
    body: CanInput<64>,
}

node!(Node, &[Terminal::can("body", "the body's network")]);
node!(
    WithoutTerminal,
    &[Terminal::new(
        "body",
        "org.example",
        "",
        &[("Rx_Data", "body.Rx_Data")]
    )]
);
node!(
    WrongTerminal,
    &[Terminal::can("Body", "the body's network")]
);

/// One of two networks has no terminal.
#[derive(State)]
#[fmu(input = Inputs, info = Info::new("Two", "A node of two networks").terminals(&[Terminal::can("a", "")]))]
struct Two {
    a: CanOutput<64>,
    b: CanOutput<64>,
}

#[derive(Input)]
struct Inputs {
    a: CanInput<64>,
    b: CanInput<64>,
}

impl Ode for Two {
    const CLOCKS: &'static [Clock<Self>] =
        can_clocks!("a" = a: |_, _, _, _| Ok(()), "b" = b: |_, _, _, _| Ok(()));

    fn derivative(&self, _p: &(), _u: &Inputs, _t: f64, _dx: &mut Self) {}
}

const MIME: &str =
    r#"mimeType="application/org.fmi-standard.fmi-ls-bus.can; version=&quot;1.0.0&quot;""#;

#[test]
fn variables_and_clocks_are_those_of_the_standard() {
    let xml = model_description3::<Node>().unwrap();
    let element = |name: &str| {
        let line = xml
            .lines()
            .find(|line| line.contains(&format!(r#"name="{name}""#)));
        line.unwrap_or_else(|| panic!("{name}: {xml}")).trim()
    };
    let vr = |name: &str| {
        let (_, rest) = element(name).split_once("valueReference=\"").unwrap();
        rest.split_once('"').unwrap().0.to_owned()
    };
    for (direction, causality, size) in [("Rx", "input", 64), ("Tx", "output", 128)] {
        let clock = element(&format!("body.{direction}_Clock"));
        assert!(clock.starts_with("<Clock "), "{clock}");
        for text in [
            r#"intervalVariability="triggered""#,
            &format!(r#"causality="{causality}""#),
        ] {
            assert!(clock.contains(text), "{clock}");
        }
        let data = element(&format!("body.{direction}_Data"));
        assert!(data.starts_with("<Binary "), "{data}");
        let clocks = format!(r#"clocks="{}""#, vr(&format!("body.{direction}_Clock")));
        let causality = format!(r#"causality="{causality}""#);
        for text in [
            MIME,
            &causality,
            &clocks,
            r#"variability="discrete""#,
            &format!(r#"maxSize="{size}""#),
        ] {
            assert!(data.contains(text), "{data} lacks {text}");
        }
    }
    // Sent operations change from one instant to the next only: no importer sees a loop.
    let sent = format!(
        r#"<Output valueReference="{}" dependencies="""#,
        vr("body.Tx_Data")
    );
    assert!(xml.contains(&sent), "{xml}");
    assert_eq!(check::<Node>(), [""; 0]);
    assert!(
        model_description::<Node>().is_err(),
        "FMI 2.0 has no Binary"
    );
}

#[test]
fn mistakes_in_terminals_are_named() {
    assert_eq!(
        model_description3::<WithoutTerminal>().unwrap_err(),
        "`body.Rx_Data` belongs to no terminal: name it by `Terminal::can` in `Info::terminals`"
    );
    assert_eq!(
        model_description3::<WrongTerminal>().unwrap_err(),
        "terminal `Body`: there is no variable `Body.Rx_Data`; a CanInput, a CanOutput and `can_clocks!` of this name make it"
    );
    assert_eq!(
        model_description3::<Two>().unwrap_err(),
        "`b.Rx_Data` belongs to no terminal: name it by `Terminal::can` in `Info::terminals`"
    );
}

/// With frames that a partition sends, and the next one would replace.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Scheduled {
    body: CanOutput<64>,
}

#[derive(Output)]
struct Sent {
    body: CanOutput<64>,
}

impl Model for Scheduled {
    const INFO: Info = Info::new("Scheduled", "A node").terminals(&[Terminal::can("body", "")]);
    const CLOCKS: &'static [Clock<Self>] = can_clocks!("body" = body: |_, _, _, _| Ok(()));
    const SCHEDULED_EXECUTION: bool = true;
    derived!((), Input, Sent);

    fn initialize(_p: &(), _u: &Input, _t: f64) -> Result<Self, ModelError> {
        Ok(Self::default())
    }

    fn output(&self, _p: &(), _u: &Input, _now: &()) -> Result<Sent, ModelError> {
        let body = self.body.clone();
        Ok(Sent { body })
    }

    fn step(
        &mut self,
        _p: &(),
        _u: &InputPolynomial<Input>,
        _now: &(),
        _t: f64,
        _h: f64,
    ) -> Result<StepEnd, ModelError> {
        Ok(StepEnd::WHOLE)
    }
}

#[test]
fn scheduled_execution_is_refused() {
    assert_eq!(
        model_description3::<Scheduled>().unwrap_err(),
        "terminal `body` is one of CAN, and `SCHEDULED_EXECUTION` is set: each partition would replace the frames that the one before has \
         sent; leave one of the two out"
    );
}
