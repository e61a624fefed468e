//! The floating-point environment: every entry point computes in the default one and puts the importer's back.
//!
//! An importer may round upwards, flush subnormal numbers to zero or trap on exceptions. The first two change bits without a word, the
//! third kills the process at the first inexact quotient. Worker threads need no code of their own: they are created inside an
//! entry point, and a new thread has either the environment of its creator (Linux) or the default one (Windows, macOS).

/// The importer's floating-point environment, put back when this is dropped, also by a panic.
pub(super) struct HostEnvironment {
    found: Register,
}

impl HostEnvironment {
    /// Sets round-to-nearest with all traps masked and subnormal numbers kept, until the return value is dropped.
    ///
    /// Exception flags are among what is put back: those that the solver raises never reach the importer.
    pub(super) fn replace() -> Self {
        let found = read();
        write(DEFAULT);
        Self { found }
    }
}

impl Drop for HostEnvironment {
    fn drop(&mut self) {
        write(self.found);
    }
}

/// MXCSR: control and exception flags of SSE and AVX. Nothing here uses the x87 unit.
#[cfg(target_arch = "x86_64")]
type Register = u32;

/// All six exceptions masked, the rest zero.
#[cfg(target_arch = "x86_64")]
const DEFAULT: Register = 0x1F80;

#[cfg(target_arch = "x86_64")]
fn read() -> Register {
    let mut value: Register = 0;
    // SAFETY: writes the four bytes of `value`.
    unsafe { std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut value, options(nostack, preserves_flags)) };
    value
}

#[cfg(target_arch = "x86_64")]
fn write(value: Register) {
    // SAFETY: reads the four bytes of `value`, which is the default or was read from the register: no reserved bit is set.
    // A flag that is set beside its unmasked exception raises none.
    unsafe { std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const value, options(nostack)) };
}

/// FPCR, the control, and FPSR, the exception flags.
#[cfg(target_arch = "aarch64")]
type Register = (u64, u64);

/// Round to nearest, nothing trapped, nothing flushed.
#[cfg(target_arch = "aarch64")]
const DEFAULT: Register = (0, 0);

#[cfg(target_arch = "aarch64")]
fn read() -> Register {
    let (control, status): Register;
    // SAFETY: reads two registers that every process may read.
    unsafe {
        std::arch::asm!("mrs {}, fpcr", "mrs {}, fpsr", out(reg) control, out(reg) status, options(nostack, preserves_flags));
    }
    (control, status)
}

#[cfg(target_arch = "aarch64")]
fn write(value: Register) {
    let (control, status) = value;
    // SAFETY: the values are the default ones or were read from the registers.
    unsafe {
        std::arch::asm!("msr fpcr, {}", "msr fpsr, {}", in(reg) control, in(reg) status, options(nostack));
    }
}

/// Nothing: on other architectures the environment stays the importer's.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
type Register = ();

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
const DEFAULT: Register = ();

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn read() -> Register {}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn write(_: Register) {}
