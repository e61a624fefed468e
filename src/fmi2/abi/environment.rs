//! Floating-point environment: every entry point computes in the default environment and restores that of the
//! importer.
//!
//! An importer may round upwards, flush subnormal numbers to zero or trap on exceptions. The first two change bits
//! silently, the third kills the process at the first inexact quotient. Worker threads need no code of their own:
//! they are created inside an entry point. A new thread has either the environment of its creator (Linux) or the
//! default (Windows, macOS).

/// Floating-point environment of the importer, restored on drop, also after a panic.
pub(super) struct HostEnvironment {
    found: ControlRegister,
}

impl HostEnvironment {
    /// Sets round-to-nearest with all traps masked and subnormal numbers kept, until the return value is dropped.
    ///
    /// Exception flags are restored too: the flags raised by the solver never reach the importer.
    pub(super) fn replace() -> Self {
        let found = read_register();
        write_register(DEFAULT);
        Self { found }
    }
}

impl Drop for HostEnvironment {
    fn drop(&mut self) {
        write_register(self.found);
    }
}

/// MXCSR: control and exception flags of SSE and AVX. The solver does not use the x87 unit.
#[cfg(target_arch = "x86_64")]
type ControlRegister = u32;

/// All six exceptions masked, the rest zero.
#[cfg(target_arch = "x86_64")]
const DEFAULT: ControlRegister = 0x1F80;

#[cfg(target_arch = "x86_64")]
fn read_register() -> ControlRegister {
    let mut value: ControlRegister = 0;
    // SAFETY: writes the four bytes of `value`.
    unsafe { std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut value, options(nostack, preserves_flags)) };
    value
}

#[cfg(target_arch = "x86_64")]
fn write_register(value: ControlRegister) {
    // SAFETY: reads the four bytes of `value`, which is the default or was read from the register: no reserved bit is
    // set.
    // A flag that is set beside its unmasked exception raises none.
    unsafe { std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const value, options(nostack)) };
}

/// FPCR (control) and FPSR (exception flags).
#[cfg(target_arch = "aarch64")]
type ControlRegister = (u64, u64);

/// Round to nearest without traps and without flushing.
#[cfg(target_arch = "aarch64")]
const DEFAULT: ControlRegister = (0, 0);

#[cfg(target_arch = "aarch64")]
fn read_register() -> ControlRegister {
    let (control, status): ControlRegister;
    // SAFETY: reads two registers that every process may read.
    unsafe {
        std::arch::asm!("mrs {}, fpcr", "mrs {}, fpsr", out(reg) control, out(reg) status, options(nostack, preserves_flags));
    }
    (control, status)
}

#[cfg(target_arch = "aarch64")]
fn write_register(value: ControlRegister) {
    let (control, status) = value;
    // SAFETY: the values are the default ones or were read from the registers.
    unsafe {
        std::arch::asm!("msr fpcr, {}", "msr fpsr, {}", in(reg) control, in(reg) status, options(nostack));
    }
}

/// No register: on other architectures the environment stays that of the importer.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
type ControlRegister = ();

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
const DEFAULT: ControlRegister = ();

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn read_register() -> ControlRegister {}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn write_register(_: ControlRegister) {}
