//! A network that is read can be evaluated anywhere and gives numbers, or says why it was refused.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let Ok(network) = emla::Surrogate::from_json(text) else {
        return;
    };
    for tau_e in [-1e3, -1.0, 0.0, 0.5, 1e3] {
        for w_m in [-1e4, 0.0, 1.0, 1e4] {
            let _ = network.evaluate(tau_e, w_m);
        }
    }
});
