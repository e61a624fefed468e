//! Whether instances that were freed leave anything behind; alone in its process, because other tests hold memory, too.
#![allow(unsafe_code)] // the interface is one of pointers
#![allow(clippy::unwrap_used)] // a test that cannot go on fails

#[path = "hostile/memory.rs"]
mod cycles;
#[path = "fmi2/host.rs"]
#[allow(dead_code, reason = "the tests of the interface use more of it")]
mod host;

#[test]
fn two_thousand_instances_leave_no_memory_behind() {
    /// Bytes: what the allocator keeps varies by less; an instance that was run holds some 400 kB.
    const SLACK: u64 = 8_000_000;
    let Some([settled, most, last]) = cycles::cycles(&host::coarse(), 2000) else { return };
    assert!(most < settled + SLACK && last < settled + SLACK, "{settled}, at most {most}, at the end {last} bytes");
}
