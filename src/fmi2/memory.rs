//! Memory that a phase needs: compared with what is available, and reserved before the phase begins.

use super::abi::MemoryReserve;
use crate::scene::Scene;
use crate::simulation::{BuildError, Simulation, memory_estimate};
use std::fmt;
use sysinfo::{MemoryRefreshKind, Pid, ProcessRefreshKind, ProcessesToUpdate, System};

/// Phases that need less are reserved without a look at what is available, which takes some 0.1 ms.
const LOOKED_FOR: u64 = 64 << 20;

/// A phase that needs memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum MemoryPhase {
    /// The scene is built.
    Building,
    /// A communication step is made, with a new mesh where the old one is distorted.
    Stepping,
    /// A state is copied or decoded.
    Saving,
    /// A state is restored.
    Restoring,
    /// Frames, tables and the report are written.
    Writing,
}

/// Limit of the memory that is available.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum MemoryLimit {
    /// Memory of the machine.
    System,
    /// Memory of the control group of the process.
    Container,
    /// Address space of the process (RLIMIT_AS).
    Process,
}

/// Memory that can still be had, and its limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AvailableMemory {
    /// Bytes.
    pub bytes: u64,
    /// What limits them.
    pub limit: MemoryLimit,
}

/// A phase that needs more memory than is available.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "memory: {phase} needs about {}, and {}; {}",
    AmountOfMemory(*needed), found(*available), phase.remedy()
)]
pub struct MemoryShortage {
    /// The phase.
    pub phase: MemoryPhase,
    /// Bytes that it needs.
    pub needed: u64,
    /// Memory that is available; absent where that would be enough but cannot be had in one block.
    pub available: Option<AvailableMemory>,
}

/// A scene that is too large.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RoomError {
    /// For any machine.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// For the memory that is available.
    #[error(transparent)]
    Memory(#[from] MemoryShortage),
}

/// Reserves memory for a phase until the return value is dropped.
///
/// # Errors
/// [`MemoryShortage`] if less is available, or the system refuses the reserve.
pub fn reserve_memory(phase: MemoryPhase, needed: u64) -> Result<MemoryReserve, MemoryShortage> {
    let available = (needed >= LOOKED_FOR).then(available_memory);
    if let Some(short) = available.filter(|available| available.bytes < needed) {
        return Err(MemoryShortage { phase, needed, available: Some(short) });
    }
    let reserve = usize::try_from(needed).ok().and_then(MemoryReserve::hold);
    reserve.ok_or(MemoryShortage { phase, needed, available: None })
}

/// Reserves what building a scene takes; in a step of the result [`reserve_for_step`] does.
///
/// # Errors
/// [`RoomError`] if the scene is larger than any that is built, or than the memory.
pub fn reserve_for_building(scene: &Scene) -> Result<MemoryReserve, RoomError> {
    Ok(reserve_memory(MemoryPhase::Building, memory_estimate(scene)?.building)?)
}

/// Reserves what a step may take beside what is held: that of another mesh, if meshes are exchanged.
///
/// # Errors
/// [`MemoryShortage`] if there is less; no step was made then.
pub fn reserve_for_step(simulation: &Simulation) -> Result<Option<MemoryReserve>, MemoryShortage> {
    reserve_large(MemoryPhase::Stepping, simulation.memory_of_remeshing())
}

/// Reserves memory for a phase, unless the standing reserve of all instances is enough.
pub(super) fn reserve_large(phase: MemoryPhase, bytes: u64) -> Result<Option<MemoryReserve>, MemoryShortage> {
    /// A part of the standing reserve.
    const STANDING_PART: u64 = 1 << 18;
    (bytes > STANDING_PART).then(|| reserve_memory(phase, bytes)).transpose()
}

/// The least of what the system, the container and the process have left.
#[must_use]
pub fn available_memory() -> AvailableMemory {
    let none = AvailableMemory { bytes: u64::MAX, limit: MemoryLimit::System };
    let Ok(mut system) = System::new() else { return none };
    system.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
    let own = Pid::from_u32(std::process::id());
    let kind = ProcessRefreshKind::nothing().with_memory();
    system.refresh_processes_specifics(ProcessesToUpdate::Some(&[own]), false, kind);
    let process = system.process(own);
    // What a container has read into its page cache goes when it is needed.
    let container = process.and_then(sysinfo::Process::cgroup_limits);
    let container = container.map(|limits| limits.total_memory.saturating_sub(limits.rss));
    let address_space = process.and_then(|process| Some(address_space()?.saturating_sub(process.virtual_memory())));
    // A system that tells nothing says 0.
    let known = [
        (Some(system.available_memory()).filter(|bytes| *bytes > 0), MemoryLimit::System),
        (container, MemoryLimit::Container),
        (address_space, MemoryLimit::Process),
    ];
    let known = known.into_iter().filter_map(|(bytes, limit)| Some(AvailableMemory { bytes: bytes?, limit }));
    known.min_by_key(|known| known.bytes).unwrap_or(none)
}

/// The limit of the address space of this process, bytes.
#[cfg(unix)]
fn address_space() -> Option<u64> {
    rustix::process::getrlimit(rustix::process::Resource::As).current
}

/// The limit of the address space of this process, bytes: only Unix has one.
#[cfg(not(unix))]
fn address_space() -> Option<u64> {
    None
}

impl MemoryPhase {
    fn remedy(self) -> &'static str {
        match self {
            Self::Building => "raise mesh.size, add mesh.grading or mesh.tree, or free memory",
            Self::Stepping => "raise remesh.smallest or mesh.size, or free memory and repeat the step",
            Self::Saving => "free states that are no longer needed (fmi2FreeFMUstate), or raise mesh.size",
            Self::Restoring => "free memory and repeat the call",
            Self::Writing => "leave output_directory empty, lower output.frames, or free memory",
        }
    }
}

impl fmt::Display for MemoryPhase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Building => "building the scene",
            Self::Stepping => "the step",
            Self::Saving => "the state",
            Self::Restoring => "restoring the state",
            Self::Writing => "writing the results",
        })
    }
}

fn found(available: Option<AvailableMemory>) -> String {
    let Some(AvailableMemory { bytes, limit }) = available else {
        return "the system refuses a block of that size".to_string();
    };
    let of = match limit {
        MemoryLimit::System => "of the memory of the system",
        MemoryLimit::Container => "of the memory of the container (cgroup)",
        MemoryLimit::Process => "of the address space of the process (RLIMIT_AS)",
    };
    format!("{} {of} are available", AmountOfMemory(bytes))
}

/// Bytes in words.
#[derive(Debug, Clone, Copy)]
pub struct AmountOfMemory(pub u64);

impl fmt::Display for AmountOfMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const UNITS: [(f64, &str); 3] = [(1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
        let bytes = self.0 as f64;
        let (size, unit) = UNITS.into_iter().find(|(size, _)| bytes >= *size).unwrap_or((1e3, "kB"));
        write!(f, "{:.1} {unit}", bytes / size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_is_available_is_refused_with_both_figures() {
        let refused = reserve_memory(MemoryPhase::Building, 1 << 60).expect_err("an exabyte");
        let text = refused.to_string();
        assert!(text.contains("needs about 1152921504.6 GB") && text.contains("are available"), "{text}");
        assert!(text.contains("raise mesh.size"), "{text}");
    }

    #[test]
    fn what_is_available_can_be_reserved() {
        let available = available_memory();
        assert!(available.bytes > 1 << 20, "{available:?}");
        assert!(reserve_memory(MemoryPhase::Saving, LOOKED_FOR.min(available.bytes / 2)).is_ok());
    }
}
