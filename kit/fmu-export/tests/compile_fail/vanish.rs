use fmu_export::prelude::*;

/// Who decides
#[derive(Clone, Copy, Enumeration)]
enum Mode {
    /// nobody
    Off,
    /// somebody
    On,
}

// Without a derive; with start values they were once no variables, without a word.
#[derive(Clone)]
struct Plain {
    x: f64,
}

#[derive(Output)]
struct Shown {
    /// Width
    #[fmu(unit = "m")]
    width: f64,
}

type Real = f64;

#[derive(Parameters)]
struct Parameters {
    /// Mode
    #[fmu(start = Mode::Off)]
    mode: Mode,
    #[fmu(start = Plain { x: 1.0 })]
    plain: Plain,
    /// Length
    #[fmu(start = 1.0)]
    length: Real,
    #[fmu(skip, start = Plain { x: 1.0 })]
    unsaved: Plain,
}

#[derive(Input)]
struct Input {
    /// Mode
    #[fmu(start = Mode::On)]
    mode: Mode,
    #[fmu(start = [Plain { x: 1.0 }])]
    plain: [Plain; 1],
}

#[derive(Output)]
struct Output {
    /// Mode
    mode: Mode,
}

#[derive(State)]
struct State {
    /// Mode
    mode: Mode,
    shown: Shown,
    #[fmu(skip)]
    memory: Mode,
}

#[derive(State)]
struct Discrete {
    /// Changes by events
    #[fmu(discrete)]
    last: Mode,
}

fn main() {}
