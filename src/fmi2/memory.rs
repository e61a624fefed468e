//! Memory checks: the need of a phase is compared with the available memory and reserved before the phase begins.

use super::abi::MemoryReserve;
use crate::scene::Scene;
use crate::simulation::{BuildError, Simulation, memory_estimate};
use std::fmt;

/// Least reserve, bytes, that is checked against the available memory; the check takes some 0.1 ms.
const CHECK_THRESHOLD: u64 = 64 << 20;

/// Phase with a need of memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum MemoryPhase {
    /// Building of the scene.
    Building,
    /// Communication step, with remeshing of a distorted mesh.
    Stepping,
    /// Copying or decoding of a state.
    Saving,
    /// Restoring of a state.
    Restoring,
    /// Writing of frames, tables and the report.
    Writing,
}

/// Limit of the available memory.
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

/// Available memory and its limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AvailableMemory {
    /// Bytes.
    pub bytes: u64,
    /// Limit of the memory.
    pub limit: MemoryLimit,
}

/// Shortage: a phase needs more memory than available.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "memory: {phase} needs about {}, and {}; {}",
    AmountOfMemory(*needed), describe_available(*available), phase.remedy()
)]
pub struct MemoryShortage {
    /// Phase with the need.
    pub phase: MemoryPhase,
    /// Needed bytes.
    pub needed: u64,
    /// Available memory; absent if sufficient in total but not in one block.
    pub available: Option<AvailableMemory>,
}

/// Error of a scene that is too large.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RoomError {
    /// Too large for any machine.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// Too large for the available memory.
    #[error(transparent)]
    Memory(#[from] MemoryShortage),
}

/// Reserves memory for a phase until the return value is dropped.
///
/// # Errors
/// [`MemoryShortage`] if less is available, or the system refuses the reserve.
pub fn reserve_memory(phase: MemoryPhase, needed: u64) -> Result<MemoryReserve, MemoryShortage> {
    let available = (needed >= CHECK_THRESHOLD).then(available_memory).flatten();
    if let Some(short) = available.filter(|available| available.bytes < needed) {
        return Err(MemoryShortage { phase, needed, available: Some(short) });
    }
    let reserve = usize::try_from(needed).ok().and_then(MemoryReserve::hold);
    reserve.ok_or(MemoryShortage { phase, needed, available: None })
}

/// Reserves the memory for building a scene; [`reserve_for_step`] serves the steps.
///
/// # Errors
/// [`RoomError`] if the scene exceeds the size limit of scenes, or the memory.
pub fn reserve_for_building(scene: &Scene) -> Result<MemoryReserve, RoomError> {
    Ok(reserve_memory(MemoryPhase::Building, memory_estimate(scene)?.building)?)
}

/// Reserves the memory of a step beyond the present allocation: a second mesh, if remeshing is on, or a look at the
/// cavity.
///
/// # Errors
/// [`MemoryShortage`] if less is available; no step was made then.
pub fn reserve_for_step(simulation: &Simulation) -> Result<Option<MemoryReserve>, MemoryShortage> {
    reserve_large(MemoryPhase::Stepping, simulation.memory_of_remeshing().max(simulation.memory_of_looks()))
}

/// Reserves memory for a phase, unless the standing reserve of all instances suffices.
pub(super) fn reserve_large(phase: MemoryPhase, bytes: u64) -> Result<Option<MemoryReserve>, MemoryShortage> {
    /// Part of the standing reserve.
    const STANDING_PART: u64 = 1 << 18;
    (bytes > STANDING_PART).then(|| reserve_memory(phase, bytes)).transpose()
}

/// Returns the least of the memory left by system, container and process; `None` where the system does not tell.
#[must_use]
pub fn available_memory() -> Option<AvailableMemory> {
    let MemoryUse { available, container, address_space: used } = memory_use();
    let address_space = address_space().zip(used).map(|(limit, used)| limit.saturating_sub(used));
    let known =
        [(available, MemoryLimit::System), (container, MemoryLimit::Container), (address_space, MemoryLimit::Process)];
    let known = known.into_iter().filter_map(|(bytes, limit)| Some(AvailableMemory { bytes: bytes?, limit }));
    known.min_by_key(|known| known.bytes)
}

/// Memory of the system and of this process, bytes; absent where the system does not tell.
#[derive(Debug, Clone, Copy, Default)]
struct MemoryUse {
    /// Left by the system.
    available: Option<u64>,
    /// Left by the control group.
    container: Option<u64>,
    /// Address space in use.
    address_space: Option<u64>,
}

/// Returns the memory of the system and of this process.
#[cfg(not(target_vendor = "apple"))]
fn memory_use() -> MemoryUse {
    use sysinfo::{MemoryRefreshKind, Pid, Process, ProcessRefreshKind, ProcessesToUpdate, System};
    let Ok(mut system) = System::new() else { return MemoryUse::default() };
    system.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
    let own = Pid::from_u32(std::process::id());
    let kind = ProcessRefreshKind::nothing().with_memory();
    system.refresh_processes_specifics(ProcessesToUpdate::Some(&[own]), false, kind);
    let process = system.process(own);
    // The page cache of a container is released on demand.
    let container = process.and_then(Process::cgroup_limits);
    MemoryUse {
        // A system without this figure reports 0.
        available: Some(system.available_memory()).filter(|bytes| *bytes > 0),
        container: container.map(|limits| limits.total_memory.saturating_sub(limits.rss)),
        address_space: process.map(Process::virtual_memory),
    }
}

/// Returns no figure: macOS tells them by frameworks that the library does not link.
#[cfg(target_vendor = "apple")]
fn memory_use() -> MemoryUse {
    MemoryUse::default()
}

/// Returns the limit of the address space of this process, bytes.
#[cfg(unix)]
fn address_space() -> Option<u64> {
    rustix::process::getrlimit(rustix::process::Resource::As).current
}

/// Returns `None`: only Unix limits the address space.
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

fn describe_available(available: Option<AvailableMemory>) -> String {
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

/// Amount of memory, displayed with a decimal unit.
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

    #[cfg(not(target_vendor = "apple"))]
    #[test]
    fn more_than_is_available_is_refused_with_both_figures() {
        let refused = reserve_memory(MemoryPhase::Building, 1 << 60).expect_err("an exabyte");
        let text = refused.to_string();
        assert!(text.contains("needs about 1152921504.6 GB") && text.contains("are available"), "{text}");
        assert!(text.contains("raise mesh.size"), "{text}");
    }

    #[cfg(not(target_vendor = "apple"))]
    #[test]
    fn memory_that_is_available_can_be_reserved() {
        let available = available_memory().unwrap();
        assert!(available.bytes > 1 << 20, "{available:?}");
        assert!(reserve_memory(MemoryPhase::Saving, CHECK_THRESHOLD.min(available.bytes / 2)).is_ok());
    }
}
