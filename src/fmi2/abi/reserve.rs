//! Global allocator: the system allocator, backed by memory reserved in advance.
//!
//! Rust aborts the process if an allocation fails within a computation, and an allocator may not panic. Therefore a
//! phase with a large need (building, remeshing, restoring, a state) first reserves its memory, and a refusal is an
//! ordinary error. A later failed allocation is retried after each release of a reserve to the system. Reserves are
//! fungible: as long as their sum covers the needs of all phases, the order of release does not matter.

use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr;
use std::sync::atomic::{AtomicBool, AtomicIsize, AtomicPtr, Ordering};

/// Limit of simultaneous reserves beside the standing reserve; further reserves hold no block.
const MAX_RESERVES: usize = 128;

/// Size of the standing reserve, bytes, for calls that neither build, save nor write.
const STANDING_BYTES: usize = 1 << 20;

/// Least size of a block, bytes. Blocks of this size are always mapped and unmapped by glibc
/// (DEFAULT_MMAP_THRESHOLD_MAX): they leave its heap unchanged, and every thread can use the released memory.
const MIN_BLOCK: usize = (32 << 20) + 4096;

/// Header of a reserve, bytes, with the size of the reserve.
const HEADER: usize = 16;

static SLOTS: [ReserveSlot; MAX_RESERVES] = [const { ReserveSlot::new() }; MAX_RESERVES];
static STANDING_SLOT: ReserveSlot = ReserveSlot::new();
/// Number of live instances.
static N_INSTANCES: AtomicIsize = AtomicIsize::new(0);
/// Spin lock of the thread that releases reserves; other threads wait for the release.
static IS_RELEASING: AtomicBool = AtomicBool::new(false);

#[global_allocator]
static ALLOCATOR: BackedAllocator = BackedAllocator;

/// Memory reserve of a phase, released on drop or after a failed allocation.
#[derive(Debug)]
pub struct MemoryReserve {
    slot: Option<&'static ReserveSlot>,
}

impl MemoryReserve {
    /// Reserves memory without touching it; `None` if the system refuses.
    #[must_use]
    pub fn hold(bytes: usize) -> Option<Self> {
        let block = allocate_block(bytes.max(MIN_BLOCK))?;
        let slot = SLOTS.iter().find(|slot| !slot.is_claimed.swap(true, Ordering::Acquire));
        match slot {
            Some(slot) => slot.block.store(block, Ordering::Release),
            None => release(block),
        }
        Some(Self { slot })
    }
}

impl Drop for MemoryReserve {
    fn drop(&mut self) {
        if let Some(slot) = self.slot {
            slot.release();
            slot.is_claimed.store(false, Ordering::Release);
        }
    }
}

/// Makes the standing reserve if missing; returns true if the reserve exists afterwards.
pub(super) fn ensure_standing_reserve() -> bool {
    if !STANDING_SLOT.block.load(Ordering::Relaxed).is_null() {
        return true;
    }
    let Some(block) = allocate_block(STANDING_BYTES) else { return false };
    let made = STANDING_SLOT.block.compare_exchange(ptr::null_mut(), block, Ordering::AcqRel, Ordering::Relaxed);
    if made.is_err() {
        release(block);
    }
    true
}

/// Counts a new instance; returns false, and counts no instance, without a standing reserve.
pub(super) fn register_instance() -> bool {
    N_INSTANCES.fetch_add(1, Ordering::AcqRel);
    let is_there = ensure_standing_reserve();
    if !is_there {
        unregister_instance();
    }
    is_there
}

/// Uncounts an instance; the last instance releases the standing reserve.
pub(super) fn unregister_instance() {
    if N_INSTANCES.fetch_sub(1, Ordering::AcqRel) <= 1 {
        STANDING_SLOT.release();
    }
}

/// Slot of a reserve. Only the owner claims and frees the slot; any thread may release its block.
#[derive(Debug)]
struct ReserveSlot {
    is_claimed: AtomicBool,
    block: AtomicPtr<u8>,
}

impl ReserveSlot {
    const fn new() -> Self {
        Self { is_claimed: AtomicBool::new(false), block: AtomicPtr::new(ptr::null_mut()) }
    }

    /// Releases the block; returns true if the slot had a block.
    fn release(&self) -> bool {
        let block = self.block.swap(ptr::null_mut(), Ordering::AcqRel);
        if !block.is_null() {
            release(block);
        }
        !block.is_null()
    }
}

fn block_layout(bytes: usize) -> Option<Layout> {
    Layout::from_size_align(bytes.checked_add(HEADER)?, HEADER).ok()
}

/// Returns a block of the system with its size in front.
#[allow(clippy::cast_ptr_alignment, reason = "the layout aligns the header")]
fn allocate_block(bytes: usize) -> Option<*mut u8> {
    let layout = block_layout(bytes)?;
    // SAFETY: the layout has a size; the header is aligned and within the block.
    unsafe {
        let block = System.alloc(layout);
        if block.is_null() {
            return None;
        }
        block.cast::<usize>().write(bytes);
        Some(block)
    }
}

#[allow(clippy::cast_ptr_alignment, reason = "the layout aligns the header")]
fn release(block: *mut u8) {
    // SAFETY: from `allocate_block`, and taken out of its slot by this thread alone.
    unsafe {
        if let Some(layout) = block_layout(block.cast::<usize>().read()) {
            System.dealloc(block, layout);
        }
    }
}

/// Retries an allocation after each release of a reserve; null without further reserves.
#[cold]
#[inline(never)]
fn retry_allocation(allocate: impl Fn() -> *mut u8) -> *mut u8 {
    while IS_RELEASING.swap(true, Ordering::Acquire) {
        std::thread::yield_now();
    }
    let mut found = allocate();
    for slot in SLOTS.iter().chain([&STANDING_SLOT]) {
        if !found.is_null() {
            break;
        }
        if slot.release() {
            found = allocate();
        }
    }
    IS_RELEASING.store(false, Ordering::Release);
    found
}

/// System allocator with retries while reserves exist.
struct BackedAllocator;

// SAFETY: every block is of `System` with the layout that was asked for, and nothing here allocates or unwinds.
unsafe impl GlobalAlloc for BackedAllocator {
    #[inline]
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the contract of the caller.
        let allocate = || unsafe { System.alloc(layout) };
        let found = allocate();
        if found.is_null() { retry_allocation(allocate) } else { found }
    }

    #[inline]
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the contract of the caller.
        let allocate = || unsafe { System.alloc_zeroed(layout) };
        let found = allocate();
        if found.is_null() { retry_allocation(allocate) } else { found }
    }

    #[inline]
    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the contract of the caller; a block that could not be moved stays valid.
        let allocate = || unsafe { System.realloc(block, layout, size) };
        let found = allocate();
        if found.is_null() { retry_allocation(allocate) } else { found }
    }

    #[inline]
    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: the contract of the caller.
        unsafe { System.dealloc(block, layout) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_allocation_that_fails_is_tried_again_after_each_reserve() {
        // A single test: a second test in this process could release the reserves under test.
        assert!(ensure_standing_reserve());
        let reserves = [0, 1].map(|_| MemoryReserve::hold(1 << 26).expect("64 MiB"));
        let slots = [&reserves[0], &reserves[1]].map(|reserve| reserve.slot.expect("a slot"));
        assert!(slots.iter().all(|slot| !slot.block.load(Ordering::Relaxed).is_null()));
        let n_tries = std::cell::Cell::new(0);
        let byte = std::cell::Cell::new(0_u8);
        let found = retry_allocation(|| {
            n_tries.set(n_tries.get() + 1);
            if n_tries.get() < 3 { ptr::null_mut() } else { byte.as_ptr() }
        });
        assert!(!found.is_null() && n_tries.get() == 3);
        drop(reserves);
        assert!(MemoryReserve::hold(usize::MAX / 2).is_none());
        assert!(MemoryReserve::hold(usize::MAX).is_none());
    }
}
