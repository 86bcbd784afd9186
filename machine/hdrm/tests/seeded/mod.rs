//! Seeded states and inputs for the tests, and the plant they are for.

use hdrm::{Hdrm, Input, Load, Options, State};
use machine_file::Machine;

/// Seeded numbers in [−1, 1).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub fn within<const N: usize>(&mut self, ranges: [[f64; 2]; N]) -> [f64; N] {
        ranges.map(|[min, max]| 0.5 * (min + max) + 0.5 * (max - min) * self.next())
    }

    pub fn array<const N: usize>(&mut self, scale: f64) -> [f64; N] {
        std::array::from_fn(|_| scale * self.next())
    }

    pub fn state(&mut self, machine: &Machine) -> State {
        State {
            zeta: self.within(machine.limits.zeta()),
            zeta_dot: self.array(1.5),
            ..State::default()
        }
    }

    pub fn input(&mut self) -> Input {
        Input {
            f: self.array(70e3),
            tau_wrist: self.array(700.0),
            wrench_env: self.array(1500.0),
            ..Input::default()
        }
    }
}

/// Reference machine with distinct, non-round options.
pub fn plant() -> (Machine, Hdrm) {
    let machine = Machine::reference();
    let options = Options {
        inertia_scale: 1.13,
        load: Load {
            payload_mass: 271.0,
            ..Load::from_machine(&machine)
        },
        ..Options::from_machine(&machine)
    };
    let hdrm = Hdrm::new(&machine, &options).expect("valid reference");
    (machine, hdrm)
}
