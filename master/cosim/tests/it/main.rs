//! All tests of this crate from outside, as one program.
#![forbid(unsafe_code)]

mod alarms;
mod allocation;
mod chosen_steps;
mod error_messages;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod events;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod exchange;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod exchange_fmu;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod exchange_inputs;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod exchange_refused;
mod faults;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod finite;
mod foreign;
mod hostile;
mod inputs;
#[cfg(target_os = "linux")]
mod isolated;
mod loops;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod loops_of_arrays;
mod oscillator;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod osp;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod outputs;
mod packages;
mod printed;
mod program;
mod rates;
mod run_key;
mod saved;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod sizes;
mod support;
mod threads;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod ticks;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod told;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod whole_values;
mod wires;
