//! The element kernels on their stand, one by one, and the reduced model: `cargo bench --bench kernels`.

mod reduced;
#[allow(dead_code, reason = "tests ask it for energies, too")]
mod stand;

use ballistic_gel::fem::Section;
use divan::Bencher;
use divan::counter::ItemsCount;
use fearless_simd::Level;
use stand::{KERNELS, Kernel, Stand, block, levels, section};
use std::fmt::{Display, Formatter};
use std::hint::black_box;

/// Elements that no core's own cache holds, built in a second.
const ELEMENTS: usize = 165_000;

/// A kernel on an instruction set.
struct Case {
    name: &'static str,
    kernel: Kernel,
    instructions: &'static str,
    level: Level,
}

impl Display for Case {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let patch = if self.kernel.patched { "patches" } else { "plain" };
        write!(f, "{}, {patch}, {}", self.name, self.instructions)
    }
}

fn main() {
    divan::main();
}

fn cases() -> Vec<Case> {
    let on = |(name, kernel): (&'static str, Kernel)| {
        levels().into_iter().map(move |(instructions, level)| Case { name, kernel, instructions, level })
    };
    KERNELS.into_iter().flat_map(on).collect()
}

/// A run of elements again and again.
#[divan::bench(args = cases())]
fn in_cache(bencher: Bencher<'_, '_>, case: &Case) {
    fn sweep<const D: usize>(bencher: Bencher<'_, '_>, level: Level, mut stand: Stand<D>) {
        let (run, n) = stand.some_run();
        stand.load(run);
        bencher.counter(ItemsCount::new(n)).bench_local(|| stand.sweep(level, run));
    }
    match case.kernel.section {
        Section::Spatial => sweep(bencher, case.level, Stand::new(&block(ELEMENTS), case.kernel)),
        Section::Planar { .. } | Section::Axisymmetric => {
            sweep(bencher, case.level, Stand::new(&section(ELEMENTS), case.kernel));
        }
    }
}

/// All runs, nodes loaded and what they give kept.
#[divan::bench(args = cases())]
fn all(bencher: Bencher<'_, '_>, case: &Case) {
    fn sweep<const D: usize>(bencher: Bencher<'_, '_>, level: Level, mut stand: Stand<D>) {
        bencher.counter(ItemsCount::new(stand.n_elements())).bench_local(|| stand.sweep_all(level));
    }
    match case.kernel.section {
        Section::Spatial => sweep(bencher, case.level, Stand::new(&block(ELEMENTS), case.kernel)),
        Section::Planar { .. } | Section::Axisymmetric => {
            sweep(bencher, case.level, Stand::new(&section(ELEMENTS), case.kernel));
        }
    }
}

/// The scalar form, one element after the other.
#[divan::bench(args = [false, true])]
fn reference(bencher: Bencher<'_, '_>, patched: bool) {
    let mut stand = Stand::new(&block(ELEMENTS), Kernel { section: Section::Spatial, patched, flows: false });
    let counted = bencher.counter(ItemsCount::new(stand.n_elements()));
    counted.bench_local(|| black_box(stand.evaluate(0..stand.n_patches())));
}
