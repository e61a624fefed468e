//! Eight elements side by side against one after the other, of every gel that has both forms, strained as far as a run never goes.

use crate::gels;
use ballistic_gel::constitutive::{Branch, Dashpot, EquationOfState, Material, NeoHookean, TwoNetwork};
use ballistic_gel::fem::{
    DEPTH, Dissipation, ElementBatches, ElementResponse, GroupKick, GroupKicks, GroupResponse, HeldNodes, HistoryLanes,
    HistoryVariables, LANES, MAX_NODES, NodeCache, Potential, ReportPower, Section, Simplices,
};
use ballistic_gel::math::Vector;
use ballistic_gel::mesh::{ElementId, ElementPatches, Mesh, NodeId};
use fearless_simd::Level;

#[path = "../../benches/kernels/stand.rs"]
#[allow(dead_code, reason = "the benches of the kernels time more of it")]
mod stand;

use stand::Stand;

/// Elastic network beside a branch with a power law that saturates where an element is strained a little.
fn saturating() -> Material {
    let branch = Branch::new(0.7, Dashpot::saturating(0.1, 0.5, 3.0));
    TwoNetwork::new(0.3, &[branch], EquationOfState::new(10.0, 1.5, 0.5), 1.0).into()
}

fn all_gels() -> [Material; 5] {
    [
        NeoHookean::new(1.0, 10.0).into(),
        TwoNetwork::new(0.0, &[], EquationOfState::new(10.0, 1.5, 0.5), 1.0).into(),
        gels::damaged(),
        gels::relaxing(&[[0.7, 0.4], [0.9, 0.03], [0.2, 1e-4]]),
        saturating(),
    ]
}

/// Nine elements apart from each other, so that the second group is nearly empty.
fn apart<const D: usize>(gel: Material, section: Section) -> Simplices<D> {
    let corners = [[0.8, 0.1, 0.0], [1.9, 0.3, 0.1], [1.1, 1.2, -0.1], [1.0, 0.4, 1.1]];
    let corner = |x: &[f64; 3]| Vector::<D>::from_fn(|i, _| x[i]);
    let rest: Vec<_> = (0..9).flat_map(|_| corners[..=D].iter().map(corner)).collect();
    let nodes = |e: u32| std::array::from_fn(|a| NodeId(e * (D as u32 + 1) + if a <= D { a as u32 } else { 0 }));
    let mesh = Mesh::new(rest, (0..9).map(nodes).collect());
    Simplices::in_patches(&mesh, ElementPatches::alone(9), (gel, section))
}

/// Positions of the nodes, each element strained by more than the one before; the first stays at rest.
fn strained<const D: usize>(simplices: &Simplices<D>, size: f64) -> Vec<Vector<D>> {
    let wave = |n: usize, i: usize| ((7 * n + 3 * i) as f64).sin();
    let moved = |(n, x): (usize, &Vector<D>)| {
        x + Vector::<D>::from_fn(|i, _| size * (n / (D + 1)) as f64 * wave(n % (D + 1), i))
    };
    simplices.rest().iter().enumerate().map(moved).collect()
}

/// Both forms of the same elements.
struct Both<const D: usize> {
    simplices: Simplices<D>,
    lanes: ElementBatches<D>,
    local: NodeCache,
    batches: Vec<HistoryLanes>,
    memory: Vec<HistoryVariables<D>>,
}

impl<const D: usize> Both<D> {
    fn new(simplices: Simplices<D>) -> Self {
        let slots: Vec<_> = (0..2 * LANES as u32).map(|slot| (slot < 9).then_some(ElementId(slot))).collect();
        let local: Vec<[u16; MAX_NODES]> = (0..2 * LANES)
            .map(|slot| std::array::from_fn(|a| if slot < 9 && a <= D { (slot * (D + 1) + a) as u16 } else { 0 }))
            .collect();
        let lanes = simplices.lanes(&slots, 1, &local).expect("a gel with a fast form");
        let (batches, memory) = (lanes.memory(), vec![HistoryVariables::default(); 9 * simplices.memories()]);
        Self { simplices, lanes, local: NodeCache::new(0.0), batches, memory }
    }

    /// Goes on to these positions, and compares all responses: one kernel makes both forms, so the bits are the same.
    fn advance(&mut self, x: &[Vector<D>], kick: GroupKick) {
        let nodes = (0..x.len()).map(|number| (number, NodeId(number as u32)));
        self.local.load(Level::new(), &HeldNodes::new(x, self.simplices.rest()), nodes);
        let (mut stiffness, mut groups) = ([0.0; 2 * LANES], [GroupResponse::default(); 2]);
        let found = (&mut stiffness[..], &mut groups[..], self.batches.as_mut_slice());
        self.lanes.sweep(Level::new(), (0..2, GroupKicks::Same(kick), ReportPower::Untold), &mut self.local, found);
        let mut sum = Dissipation::default();
        for (e, swept) in stiffness.iter().enumerate().take(9) {
            let mut answers = [ElementResponse::default(); DEPTH];
            sum += self.simplices.advance(e, x, kick, &mut self.memory, &mut answers);
            assert_eq!(swept.to_bits(), answers[0].stiffness.to_bits(), "{e}: κ");
            let pushed = &self.local.accumulated(9 * (D + 1))[e * (D + 1)..];
            for (pushed, force) in pushed.iter().zip(&answers[0].forces[..=D]) {
                assert!((0..D).all(|i| pushed[i] == kick.length * force[i]), "{e}: {pushed:?} of {force:?}");
            }
        }
        let own: f64 = groups.iter().map(|group| group.energy).sum();
        let spent = self.local.spent();
        assert_eq!(own.to_bits(), spent.energy.to_bits());
        // The order of the sums differs.
        let size = [sum.energy, sum.viscous, sum.bulk, sum.damage].map(f64::abs).into_iter().fold(1e-9, f64::max);
        let all = [
            [spent.energy, sum.energy],
            [spent.viscous, sum.viscous],
            [spent.bulk, sum.bulk],
            [spent.damage, sum.damage],
        ];
        assert!(all.iter().all(|[own, its]| (own - its).abs() < 1e-14 * size), "{spent:?} of {sum:?}");
        self.compare_memories();
    }

    fn compare_memories(&self) {
        let (rows, each) = (self.lanes.rows(), self.simplices.memories());
        for e in 0..if each > 0 { 9 } else { 0 } {
            let mut own = vec![HistoryVariables::default(); each];
            let batch = e / LANES * rows;
            self.lanes.recall(&self.batches[batch..batch + rows], e % LANES, &mut own);
            assert_eq!(own, self.memory[e * each..(e + 1) * each], "{e}");
        }
    }
}

fn check<const D: usize>(section: Section) {
    for gel in all_gels() {
        // Some to and fro, an hour at rest, and so far that elements are turned inside out; and back.
        let mut both = Both::new(apart::<D>(gel, section));
        for (size, elapsed) in [
            (0.0, 0.0),
            (0.01, 0.02),
            (0.03, 0.05),
            (-0.02, 0.1),
            (-0.02, 3600.0),
            (0.08, 0.2),
            (0.3, 0.1),
            (0.02, 0.3),
        ] {
            for length in [1.0, -1.0] {
                both.advance(&strained(&both.simplices, length * size), GroupKick { length, elapsed });
            }
        }
    }
}

#[test]
fn eight_elements_side_by_side_do_what_they_do_one_after_the_other() {
    check::<2>(Section::Planar { thickness: 0.7 });
    check::<2>(Section::Axisymmetric);
    check::<3>(Section::Spatial);
}

#[test]
fn history_variables_survive_a_round_trip_through_the_lanes() {
    let mut both = Both::new(apart::<3>(all_gels()[3], Section::Spatial));
    both.advance(&strained(&both.simplices, 0.05), GroupKick { length: 1.0, elapsed: 0.01 });
    let (rows, mut own) = (both.lanes.rows(), vec![HistoryVariables::default(); both.simplices.memories()]);
    let mut other = both.lanes.memory();
    for lane in 0..LANES {
        both.lanes.recall(&both.batches[..rows], lane, &mut own);
        both.lanes.remember(&mut other[..rows], lane, &own);
        let mut again = own.clone();
        both.lanes.recall(&other[..rows], lane, &mut again);
        assert_eq!(own, again);
    }
}

#[test]
fn every_instruction_set_finds_the_same_energy_and_the_reference_to_round_off() {
    for (name, kernel) in stand::KERNELS {
        match kernel.section {
            Section::Spatial => energies_agree(name, Stand::new(&stand::block(7_000), kernel)),
            Section::Planar { .. } | Section::Axisymmetric => {
                energies_agree(name, Stand::new(&stand::section(7_000), kernel));
            }
        }
    }
}

#[track_caller]
fn energies_agree<const D: usize>(name: &str, mut stand: Stand<D>) {
    let mut energy = |level| {
        stand.forget();
        stand.sweep_all(level);
        stand.energy()
    };
    let energies: Vec<f64> = stand::levels().into_iter().map(|(_, level)| energy(level)).collect();
    assert!(energies[0] > 0.0 && energies.iter().all(|energy| *energy == energies[0]), "{name}: {energies:?}");
    stand.forget();
    let reference = stand.evaluate(0..stand.n_patches());
    assert!((reference / energies[0] - 1.0).abs() < 1e-10, "{name}: {reference} {energies:?}");
}
