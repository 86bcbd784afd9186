//! Floating-point control of a thread: rounding mode, denormal numbers and traps, which decide what
//! the numbers of all other FMUs are. For `under_way`, which compares it after each call.

#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
use std::arch::asm;

/// Bits that matter in the registers of [`present`]; rounding mode; denormal numbers.
#[cfg(target_arch = "x86_64")]
const BITS: ([u32; 2], u32, u32) = ([0xFFC0, 0x0F3F], 0x6000, 0x8040);
#[cfg(target_arch = "aarch64")]
const BITS: ([u32; 2], u32, u32) = ([0x01C8_9F00, 0], 0x00C0_0000, 0x0108_0000);
/// WebAssembly has no such registers.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
const BITS: ([u32; 2], u32, u32) = ([0; 2], 0, 0);

#[inline]
fn control() -> u32 {
    #[allow(unused_mut)] // for x86-64
    let mut control = 0_u64;
    #[cfg(target_arch = "x86_64")]
    // SAFETY: writes to `control` alone.
    unsafe {
        asm!("stmxcsr [{}]", in(reg) &raw mut control, options(nostack));
    }
    #[cfg(target_arch = "aarch64")]
    // SAFETY: reads a register.
    unsafe {
        asm!("mrs {}, fpcr", out(reg) control, options(nostack, nomem));
    }
    control as u32
}

/// The control of this thread: MXCSR and the control word of the x87 unit, or FPCR.
pub fn present() -> [u32; 2] {
    #[allow(unused_mut)] // for x86-64
    let mut x87 = 0_u32;
    #[cfg(target_arch = "x86_64")]
    // SAFETY: writes to `x87` alone.
    unsafe {
        asm!("fnstcw [{}]", in(reg) &raw mut x87, options(nostack));
    }
    [control(), x87]
}

/// Sets the control to what this thread had before.
fn set(own: [u32; 2]) {
    let [_control, _x87] = own.each_ref().map(|register| &raw const *register);
    #[cfg(target_arch = "x86_64")]
    // SAFETY: reads the values that were there before.
    unsafe {
        asm!("ldmxcsr [{}]", "fldcw [{}]", in(reg) _control, in(reg) _x87, options(nostack));
    }
    #[cfg(target_arch = "aarch64")]
    // SAFETY: the value that was there before.
    unsafe {
        asm!("msr fpcr, {}", in(reg) u64::from(own[0]), options(nostack));
    }
}

/// Whether this thread's control is not `own`, as far as that can be seen cheaply.
#[inline]
pub fn differs(own: u32) -> bool {
    (control() ^ own) & BITS.0[0] != 0
}

/// Puts the control back to `own`; returns what was changed.
pub fn put_back(own: [u32; 2]) -> impl Iterator<Item = &'static str> {
    let ([mask, x87_mask], rounding, denormals) = BITS;
    let [control, x87] = present();
    let [changed, x87] = [(control ^ own[0]) & mask, (x87 ^ own[1]) & x87_mask];
    if changed != 0 || x87 != 0 {
        set(own);
    }
    let all = [
        (changed & rounding, "the rounding mode"),
        (
            changed & denormals,
            "how numbers near 0 are computed (flush to zero)",
        ),
        (
            changed & !(rounding | denormals),
            "the traps of floating-point exceptions",
        ),
        // Those of MXCSR mostly come with it.
        (
            if changed == 0 { x87 } else { 0 },
            "the control word of the x87 unit",
        ),
    ];
    all.into_iter()
        .filter_map(|(bits, what)| (bits != 0).then_some(what))
}
