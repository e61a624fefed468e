//! Instances made and freed, again and again: what the process holds stays what it is.

use super::host::Host;

/// Cycles between two looks at the memory.
const BETWEEN: u32 = 100;

/// Bytes that the process holds in memory, where the system tells.
pub fn resident() -> Option<u64> {
    const PAGE: u64 = 4096;
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    Some(PAGE * text.split_whitespace().nth(1)?.parse::<u64>().ok()?)
}

/// So many cycles; resident bytes after the first tenth, and the most and the last of what was seen afterwards.
pub fn cycles(scene: &str, n: u32) -> Option<[u64; 3]> {
    let (mut settled, mut most) = (0, 0);
    for i in 0..n {
        cycle(scene, i);
        if i % BETWEEN == BETWEEN - 1 && i >= n / 10 {
            let now = resident()?;
            settled = if settled == 0 { now } else { settled };
            most = most.max(now);
        }
    }
    Some([settled, most, resident()?])
}

/// An instance that is made and freed; of ten one is run, and goes back, before.
fn cycle(scene: &str, i: u32) {
    let mut host = Host::with(scene);
    if i.is_multiple_of(10) {
        host.start();
        let mut state = host.state();
        host.steps(0.0, 1e-6, 2);
        // SAFETY: a state of this instance, freed once.
        unsafe {
            ballistic_gel::fmi2::abi::fmi2SetFMUstate(host.c, state);
            ballistic_gel::fmi2::abi::fmi2FreeFMUstate(host.c, &raw mut state);
        }
    }
}
