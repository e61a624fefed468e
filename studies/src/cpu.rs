use std::sync::OnceLock;
use std::time::Instant;

/// CPU time of this thread so far, s; wall time where the system does not tell.
pub fn seconds() -> f64 {
    static BEGUN: OnceLock<Instant> = OnceLock::new();
    thread_cpu_seconds().unwrap_or_else(|| BEGUN.get_or_init(Instant::now).elapsed().as_secs_f64())
}

/// Linux counts the nanoseconds on a core.
fn thread_cpu_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(1e-9 * text.split_whitespace().next()?.parse::<f64>().ok()?)
}
