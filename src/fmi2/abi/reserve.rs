//! The allocator: that of the system, backed by memory that was reserved before it was needed.
//!
//! Rust ends the process when memory cannot be had in the middle of a computation, and an allocator may not panic instead. So a
//! phase that needs much (building, remeshing, restoring, a state) first reserves as much as it needs, which can be
//! refused in words. An allocation that fails later is tried again each time a reserve was given back to the system. Reserves
//! are fungible: as long as together they are what all phases need, it does not matter whose is given back first.

use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr;
use std::sync::atomic::{AtomicBool, AtomicIsize, AtomicPtr, Ordering};

/// Most reserves at a time, beside the standing one: later ones back nothing.
const MOST_RESERVES: usize = 128;

/// Bytes of the standing reserve: what a call needs that builds, saves and writes nothing.
const STANDING: usize = 1 << 20;

/// Blocks of at least this size glibc maps and unmaps, whatever it has learnt (DEFAULT_MMAP_THRESHOLD_MAX): they leave its heap as it is,
/// and every thread has what one of them gives back.
const LEAST: usize = (32 << 20) + 4096;

/// Bytes in front of a reserve, where its size stands.
const HEADER: usize = 16;

static SLOTS: [ReserveSlot; MOST_RESERVES] = [const { ReserveSlot::new() }; MOST_RESERVES];
static STANDING_SLOT: ReserveSlot = ReserveSlot::new();
/// Instances that there are.
static N_INSTANCES: AtomicIsize = AtomicIsize::new(0);
/// Held by the thread that gives reserves back: another one waits until they can be had.
static IS_GIVING_BACK: AtomicBool = AtomicBool::new(false);

#[global_allocator]
static ALLOCATOR: BackedAllocator = BackedAllocator;

/// Memory held for a phase; given back when this is dropped, or when an allocation fails.
#[derive(Debug)]
pub struct MemoryReserve {
    slot: Option<&'static ReserveSlot>,
}

impl MemoryReserve {
    /// Reserves memory without touching it; `None` if the system refuses.
    #[must_use]
    pub fn hold(bytes: usize) -> Option<Self> {
        let block = reserved_block(bytes.max(LEAST))?;
        let slot = SLOTS.iter().find(|slot| !slot.is_claimed.swap(true, Ordering::Acquire));
        match slot {
            Some(slot) => slot.block.store(block, Ordering::Release),
            None => give_back(block),
        }
        Some(Self { slot })
    }
}

impl Drop for MemoryReserve {
    fn drop(&mut self) {
        if let Some(slot) = self.slot {
            slot.give_back();
            slot.is_claimed.store(false, Ordering::Release);
        }
    }
}

/// Returns true if the standing reserve is there, or could be made again.
pub(super) fn stands() -> bool {
    if !STANDING_SLOT.block.load(Ordering::Relaxed).is_null() {
        return true;
    }
    let Some(block) = reserved_block(STANDING) else { return false };
    let made = STANDING_SLOT.block.compare_exchange(ptr::null_mut(), block, Ordering::AcqRel, Ordering::Relaxed);
    if made.is_err() {
        give_back(block);
    }
    true
}

/// Counts an instance that is to be made; returns false, and counts none, without a standing reserve for it.
pub(super) fn begins() -> bool {
    N_INSTANCES.fetch_add(1, Ordering::AcqRel);
    let is_there = stands();
    if !is_there {
        ends();
    }
    is_there
}

/// Counts an instance less; with the last one goes the standing reserve.
pub(super) fn ends() {
    if N_INSTANCES.fetch_sub(1, Ordering::AcqRel) <= 1 {
        STANDING_SLOT.give_back();
    }
}

/// The place of a reserve. Only its owner claims and frees it; anyone may give its block back.
#[derive(Debug)]
struct ReserveSlot {
    is_claimed: AtomicBool,
    block: AtomicPtr<u8>,
}

impl ReserveSlot {
    const fn new() -> Self {
        Self { is_claimed: AtomicBool::new(false), block: AtomicPtr::new(ptr::null_mut()) }
    }

    /// Gives the block back; returns true if there was one.
    fn give_back(&self) -> bool {
        let block = self.block.swap(ptr::null_mut(), Ordering::AcqRel);
        if !block.is_null() {
            give_back(block);
        }
        !block.is_null()
    }
}

fn block_layout(bytes: usize) -> Option<Layout> {
    Layout::from_size_align(bytes.checked_add(HEADER)?, HEADER).ok()
}

/// A block of the system with its size in front.
#[allow(clippy::cast_ptr_alignment, reason = "the layout aligns the header")]
fn reserved_block(bytes: usize) -> Option<*mut u8> {
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
fn give_back(block: *mut u8) {
    // SAFETY: from `reserved_block`, and taken out of its slot by this thread alone.
    unsafe {
        if let Some(layout) = block_layout(block.cast::<usize>().read()) {
            System.dealloc(block, layout);
        }
    }
}

/// Tries an allocation again after each reserve that was given back; null if none is left.
#[cold]
#[inline(never)]
fn retried(allocate: impl Fn() -> *mut u8) -> *mut u8 {
    while IS_GIVING_BACK.swap(true, Ordering::Acquire) {
        std::thread::yield_now();
    }
    let mut found = allocate();
    for slot in SLOTS.iter().chain([&STANDING_SLOT]) {
        if !found.is_null() {
            break;
        }
        if slot.give_back() {
            found = allocate();
        }
    }
    IS_GIVING_BACK.store(false, Ordering::Release);
    found
}

/// The allocator of the system, tried again while there are reserves.
struct BackedAllocator;

// SAFETY: every block is of `System` with the layout that was asked for, and nothing here allocates or unwinds.
unsafe impl GlobalAlloc for BackedAllocator {
    #[inline]
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the contract of the caller.
        let allocate = || unsafe { System.alloc(layout) };
        let found = allocate();
        if found.is_null() { retried(allocate) } else { found }
    }

    #[inline]
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the contract of the caller.
        let allocate = || unsafe { System.alloc_zeroed(layout) };
        let found = allocate();
        if found.is_null() { retried(allocate) } else { found }
    }

    #[inline]
    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the contract of the caller; a block that could not be moved is still there.
        let allocate = || unsafe { System.realloc(block, layout, size) };
        let found = allocate();
        if found.is_null() { retried(allocate) } else { found }
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
        // One test: another one in this process would give back what this one looks at.
        assert!(stands());
        let reserves = [0, 1].map(|_| MemoryReserve::hold(1 << 26).expect("64 MiB"));
        let slots = [&reserves[0], &reserves[1]].map(|reserve| reserve.slot.expect("a slot"));
        assert!(slots.iter().all(|slot| !slot.block.load(Ordering::Relaxed).is_null()));
        let n_tries = std::cell::Cell::new(0);
        let byte = std::cell::Cell::new(0_u8);
        let found = retried(|| {
            n_tries.set(n_tries.get() + 1);
            if n_tries.get() < 3 { ptr::null_mut() } else { byte.as_ptr() }
        });
        assert!(!found.is_null() && n_tries.get() == 3);
        drop(reserves);
        assert!(MemoryReserve::hold(usize::MAX / 2).is_none());
        assert!(MemoryReserve::hold(usize::MAX).is_none());
    }
}
