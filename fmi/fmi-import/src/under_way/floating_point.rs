//! Floating-point control of a thread: rounding mode, denormal numbers and traps, which decide what
//! the numbers of all other FMUs are. For `under_way`, which compares it after each call.

#[cfg(target_arch = "x86_64")]
mod registers {
    use std::arch::asm;

    /// Rounding mode, denormal numbers (FTZ, DAZ) and masks of traps in MXCSR, without its flags.
    pub const MASK: u32 = 0xFFC0;
    pub const ROUNDING: u32 = 0x6000;
    pub const DENORMALS: u32 = 0x8040;
    /// Traps, precision and rounding in the control word of the x87 unit, `long double` of C.
    pub const X87_MASK: u32 = 0x0F3F;

    #[inline]
    pub fn control() -> u32 {
        let mut control = 0_u32;
        // SAFETY: writes to `control` alone.
        unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut control, options(nostack)) };
        control
    }

    pub fn set(control: u32) {
        // SAFETY: reads `control` alone, which this thread had before.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const control, options(nostack)) };
    }

    pub fn x87() -> u32 {
        let mut word = 0_u16;
        // SAFETY: writes to `word` alone.
        unsafe { asm!("fnstcw [{}]", in(reg) &raw mut word, options(nostack)) };
        word.into()
    }

    pub fn set_x87(word: u16) {
        // SAFETY: reads `word` alone, which this thread had before.
        unsafe { asm!("fldcw [{}]", in(reg) &raw const word, options(nostack)) };
    }
}

#[cfg(target_arch = "aarch64")]
mod registers {
    use std::arch::asm;

    /// RMode, FZ, FZ16 and the enables of traps in FPCR.
    pub const MASK: u32 = 0x01C8_9F00;
    pub const ROUNDING: u32 = 0x00C0_0000;
    pub const DENORMALS: u32 = 0x0108_0000;
    pub const X87_MASK: u32 = 0;

    #[inline]
    pub fn control() -> u32 {
        let control: u64;
        // SAFETY: reads a register.
        unsafe { asm!("mrs {}, fpcr", out(reg) control, options(nostack, nomem)) };
        control as u32
    }

    pub fn set(control: u32) {
        // SAFETY: a value that this thread had before.
        unsafe { asm!("msr fpcr, {}", in(reg) u64::from(control), options(nostack)) };
    }

    pub fn x87() -> u32 {
        0
    }

    pub fn set_x87(_: u16) {}
}

/// WebAssembly has no such registers.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
mod registers {
    pub const MASK: u32 = 0;
    pub const ROUNDING: u32 = 0;
    pub const DENORMALS: u32 = 0;
    pub const X87_MASK: u32 = 0;

    #[inline]
    pub fn control() -> u32 {
        0
    }

    pub fn set(_: u32) {}

    pub fn x87() -> u32 {
        0
    }

    pub fn set_x87(_: u16) {}
}

use registers::{DENORMALS, MASK, ROUNDING, X87_MASK, control, set, set_x87, x87};

/// The control of this thread: that of vectors (x86-64) or of all (ARM), and that of the x87 unit.
pub fn present() -> [u32; 2] {
    [control(), x87()]
}

/// Whether this thread's control is not `own`, as far as that can be seen cheaply.
#[inline]
pub fn differs(own: u32) -> bool {
    (control() ^ own) & MASK != 0
}

/// Puts the control back to `own`; returns what was changed.
pub fn put_back([own, own_x87]: [u32; 2]) -> Vec<&'static str> {
    let changed = (control() ^ own) & MASK;
    if changed != 0 {
        set(own);
    }
    let is_x87_changed = (x87() ^ own_x87) & X87_MASK != 0;
    if is_x87_changed {
        set_x87(own_x87 as u16);
    }
    let all = [
        (changed & ROUNDING != 0, "the rounding mode"),
        (changed & DENORMALS != 0, "how numbers near 0 are computed (flush to zero)"),
        (changed & !(ROUNDING | DENORMALS) != 0, "the traps of floating-point exceptions"),
        (is_x87_changed, "the control word of the x87 unit"),
    ];
    let all = all.into_iter().filter(|(is_changed, _)| *is_changed);
    all.map(|(_, what)| what).collect()
}
