//! The fast form of the engine against its reference form, and against itself: on every instruction set, with any number of
//! threads, and with what is at rest computed or not.

use crate::gels;
use ballistic_gel::constitutive::{Material, NeoHookean};
use ballistic_gel::contact::{
    BodyMotion, BodyState, ContactSurface, FreeDirections, ImpulseExchange, ImpulseLaw, RigidBody,
};
use ballistic_gel::fem::{HistoryVariables, Potential, Section, Simplices};
use ballistic_gel::geometry::{ShapeGeometry, Sphere};
use ballistic_gel::integrator::{
    AdvanceOutcome, DiscreteGel, DistortionLimits, Engine, IntegratorSettings, SteppingSchedule, UnusableStep,
    WorkerPool,
};
use ballistic_gel::math::{Vector, Vector3};
use ballistic_gel::mesh::{self, BlockSpec, CellSplit, ElementId, ElementPatches, FaceConstraint, HeldFace, Mesh};
use ballistic_gel::state::DynamicState;
use fearless_simd::Level;

#[path = "../engine/turned.rs"]
mod turned;

/// A case: what the gel is made of and how time is stepped.
#[derive(Debug, Clone, Copy)]
struct Case {
    section: Section,
    patches: bool,
    schedule: SteppingSchedule,
    gel: Made,
}

/// History of its elements: nothing, damage and the flow of a power law, or the flow of linear branches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Made {
    Elastic,
    Damaged,
    Relaxing,
}

const MADE: [Made; 3] = [Made::Elastic, Made::Damaged, Made::Relaxing];
const SPACE: Case =
    Case { section: Section::Spatial, patches: false, schedule: SteppingSchedule::Bins, gel: Made::Elastic };

/// Every section, plain and in patches, in bins and with one step for all, of every gel that has a fast form.
fn cases() -> impl Iterator<Item = Case> {
    let sections = [Section::Spatial, Section::Planar { thickness: 0.7 }, Section::Axisymmetric];
    let all = sections.into_iter().flat_map(|section| [false, true].map(|patches| (section, patches)));
    let all = all.flat_map(|made| [SteppingSchedule::Bins, SteppingSchedule::Global].map(|schedule| (made, schedule)));
    all.flat_map(|((section, patches), schedule)| MADE.map(|gel| Case { section, patches, schedule, gel }))
}

/// Every gel in space, plain and in patches.
fn in_space() -> impl Iterator<Item = Case> {
    [false, true].into_iter().flat_map(|patches| MADE.map(|gel| Case { patches, gel, ..SPACE }))
}

/// Neo-Hookean, one that flows under the ball and is damaged, or one with a branch of the time of the contact and one of a few steps.
fn material(case: Case) -> Material {
    match case.gel {
        Made::Elastic => NeoHookean::new(1.0, 10.0).into(),
        Made::Damaged => gels::damaged(),
        Made::Relaxing => gels::relaxing(&[[0.7, 0.4], [0.9, 0.03]]),
    }
}

/// A graded block below z = 0, its bottom held; a coarser one of a gel that remembers, which the reference form steps five times as slowly.
fn block<const D: usize>(case: Case) -> Mesh<D> {
    let finest = if case.gel == Made::Elastic { 0.06 } else { 0.12 };
    let right = mesh::graded(0.6, finest, (0.15, 1.3, 0.15));
    let both: Vec<f64> = right.iter().rev().map(|x| -x).chain(right[1..].iter().copied()).collect();
    let down: Vec<f64> = right.iter().rev().map(|x| -x).collect();
    let across = if case.section == Section::Axisymmetric { right } else { both };
    let planes = std::array::from_fn(|i| if i == D - 1 { down.clone() } else { across.clone() });
    let bottom = HeldFace { axis: D - 1, high: false, hold: FaceConstraint::All };
    let axis = HeldFace { axis: 0, high: false, hold: FaceConstraint::Normal };
    let faces = if case.section == Section::Axisymmetric { vec![bottom, axis] } else { vec![bottom] };
    mesh::block(BlockSpec { planes, split: CellSplit::Centred, faces })
}

fn patches<const D: usize>(case: Case, mesh: &Mesh<D>) -> ElementPatches {
    if case.patches { ElementPatches::grouped(mesh) } else { ElementPatches::alone(mesh.elements.len()) }
}

fn gel<const D: usize>(case: Case) -> DiscreteGel<D, Simplices<D>> {
    let mesh = block(case);
    gel_on(&mesh, patches(case, &mesh), case)
}

fn gel_on<const D: usize>(mesh: &Mesh<D>, patches: ElementPatches, case: Case) -> DiscreteGel<D, Simplices<D>> {
    let simplices = Simplices::in_patches(mesh, patches, (material(case), case.section));
    let mass = simplices.lumped_masses(mesh, 1.0);
    let surface = ContactSurface::new::<D>(mesh.rest.len(), mesh.facets.clone(), |facet| {
        let edge = (mesh.rest[facet[1].index()] - mesh.rest[facet[0].index()]).norm();
        (edge, if D == 2 { edge } else { 0.5 * edge * edge })
    });
    DiscreteGel::new(simplices, mass, &mesh.held, surface)
}

/// The block, and a ball of radius 0.3 above its middle that falls with 0.2.
fn engine<const D: usize>(
    case: Case,
    height: f64,
    (schedule, law): (SteppingSchedule, ImpulseLaw),
) -> Engine<D, Simplices<D>> {
    let gel = gel::<D>(case);
    let nodes = gel.potential.rest().iter().map(|x| (*x, Vector::<D>::zeros())).collect();
    let freedom = match case.section {
        Section::Spatial => FreeDirections::SPATIAL,
        Section::Planar { .. } => FreeDirections::PLANAR,
        Section::Axisymmetric => FreeDirections::AXISYMMETRIC,
    };
    let rules = IntegratorSettings { schedule, cfl: 0.8, law, force_window: 1.0, damping: 0.0 };
    Engine::new(gel, vec![ball(freedom, height)], rules, nodes)
}

fn ball(freedom: FreeDirections, height: f64) -> (RigidBody, BodyState) {
    let inertia = nalgebra::Matrix3::identity() * 0.01;
    let body = RigidBody::new(ShapeGeometry::Sphere(Sphere { radius: 0.3 }), BodyMotion::Free, freedom, 0.3, inertia);
    (body, BodyState::at_start(Vector3::new(0.0, 0.0, 0.3 + height), Vector3::new(0.0, 0.0, -0.2)))
}

const MOREAU: ImpulseLaw = ImpulseLaw::Moreau { restitution: 0.0, bias: 0.1, friction: 0.2 };

fn fast<const D: usize>(case: Case, height: f64) -> Engine<D, Simplices<D>> {
    engine(case, height, (case.schedule, MOREAU))
}

fn run<const D: usize>(mut engine: Engine<D, Simplices<D>>, end: f64) -> DynamicState<D> {
    engine.advance_to(end, &mut [ImpulseExchange::default()]).expect("a slow ball does not fail");
    engine.state().clone()
}

/// Greatest difference of positions over the depth of the ball, and of its velocity.
fn difference<const D: usize>(a: &DynamicState<D>, b: &DynamicState<D>) -> f64 {
    let moved = a.position.iter().zip(&b.position).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    moved.max((a.bodies[0].velocity - b.bodies[0].velocity).norm())
}

fn check_reference<const D: usize>(case: Case) {
    let [fast, reference] = [run(fast::<D>(case, 0.0), 1.0), run(fast::<D>(case, 0.0).with_reference_form(), 1.0)];
    let steps = |state: &DynamicState<D>| state.clocks.iter().map(|clock| clock.step).collect::<Vec<_>>();
    assert_eq!(steps(&fast), steps(&reference), "{case:?}");
    assert!(fast.bodies[0].velocity.z > -0.19, "{case:?}: the ball has met the gel");
    assert!(difference(&fast, &reference) < 1e-11, "{case:?}: {:e}", difference(&fast, &reference));
    let energy = [&fast, &reference].map(|state| state.ledger.energy);
    let differences = [
        energy[0].integration - energy[1].integration,
        energy[0].bulk_viscous - energy[1].bulk_viscous,
        energy[0].viscous - energy[1].viscous,
        energy[0].damage - energy[1].damage,
    ];
    assert!(differences.iter().all(|difference| difference.abs() < 1e-12), "{case:?}: {differences:?}");
    let damaged = fast.memory.iter().filter(|memory| memory.damage > 1e-3).count();
    assert_eq!(damaged > 10, case.gel == Made::Damaged, "{case:?}: {damaged} elements are damaged");
    let of_damage = [fast.ledger.energy.damage, fast.ledger.energy.bulk_viscous];
    assert!(of_damage.iter().all(|lost| (*lost < 0.0) == (case.gel == Made::Damaged)), "{case:?}: {of_damage:?}");
    assert_eq!(fast.ledger.energy.viscous < -1e-5, case.gel != Made::Elastic, "{case:?}: {:?}", fast.ledger.energy);
    for (own, other) in fast.memory.iter().zip(&reference.memory) {
        let off = (own.inverse - other.inverse).norm() + (own.out - other.out).abs();
        let off = off + (own.damage - other.damage).abs() + (own.jacobian - other.jacobian).abs();
        let off = off + (own.stress - other.stress).abs();
        assert!(off < 1e-9, "{case:?}: {off:e} of {own:?}");
    }
}

#[test]
fn the_fast_form_does_what_the_reference_form_does() {
    for case in cases() {
        match case.section {
            Section::Spatial => check_reference::<3>(case),
            Section::Planar { .. } | Section::Axisymmetric => check_reference::<2>(case),
        }
    }
}

/// The levels of this machine, from the widest to none at all.
fn levels() -> Vec<Level> {
    let widest = Level::new();
    let narrower = [
        widest.as_avx512().map(Level::Avx512),
        widest.as_avx2().map(Level::Avx2),
        widest.as_sse4_2().map(Level::Sse4_2),
        widest.as_sse2().map(Level::Sse2),
    ];
    narrower.into_iter().flatten().collect()
}

fn check_levels<const D: usize>(case: Case) {
    let mut digests: Vec<u128> =
        levels().into_iter().map(|level| run(fast::<D>(case, 0.0).with_simd_level(level), 0.5).digest()).collect();
    assert!(digests.len() >= 2, "there are instruction sets to compare");
    digests.dedup();
    assert_eq!(digests.len(), 1, "{case:?}");
}

#[test]
#[cfg(target_arch = "x86_64")]
fn every_instruction_set_gives_the_same_bits() {
    for case in cases() {
        match case.section {
            Section::Spatial => check_levels::<3>(case),
            Section::Planar { .. } | Section::Axisymmetric => check_levels::<2>(case),
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for case in in_space() {
        let digest = |threads| {
            let mut engine = fast::<3>(case, 0.0).with_pool(WorkerPool::new(threads));
            // The second part is a call that begins in a gel that moves.
            engine.advance_to(0.2, &mut [ImpulseExchange::default()]).expect("a slow ball does not fail");
            run(engine, 0.5).digest()
        };
        let one = digest(1);
        assert_eq!([2, 3, 8].map(digest), [one; 3], "{case:?}");
    }
}

#[test]
fn elements_at_rest_give_the_same_bits_whether_swept_or_skipped() {
    // The ball needs half a second to the gel, and then the wave does to the bottom; from farther up it needs three, of
    // which the ticks of the first two and a half are skipped.
    let ends = [(0.1, 0.3), (0.1, 0.6), (0.1, 1.0), (0.6, 3.2)];
    for ((height, end), gel) in ends.iter().flat_map(|fall| MADE.map(|gel| (*fall, gel))) {
        let case = Case { gel, ..SPACE };
        let [resting, computed] = [fast::<3>(case, height), fast::<3>(case, height).with_sweeps_at_rest()];
        let [resting, computed] = [run(resting, end), run(computed, end)];
        assert_eq!(resting.record.updates == 0, end < 5.0 * height, "nothing moves before the ball is there");
        assert!(resting == computed, "the same bits up to {end}");
    }
}

#[test]
fn elements_that_no_wave_has_reached_are_not_swept() {
    let advanced = |mut engine: Engine<3, Simplices<3>>| {
        engine.advance_to(0.505, &mut [ImpulseExchange::default()]).unwrap();
        let swept: Vec<bool> = engine.block_layouts().iter().map(|run| run.was_swept).collect();
        (swept.iter().filter(|swept| **swept).count(), swept.len())
    };
    // With one step for all, all that moves fires at every tick.
    let case = Case { schedule: SteppingSchedule::Global, ..SPACE };
    let (swept, all) = advanced(fast(case, 0.1));
    assert!(swept > 0 && 2 * swept <= all, "{swept} of {all} runs are swept soon after the ball has come");
    assert_eq!(advanced(fast(case, 0.1).with_sweeps_at_rest()), (all, all));
}

#[test]
fn a_body_that_starts_to_move_over_a_gel_at_rest_meets_it() {
    let mut engine = fast::<3>(SPACE, 10.0);
    let mut body = engine.state().bodies[0];
    body.velocity = Vector3::zeros();
    engine.set_body(0, &body);
    let mut exchange = [ImpulseExchange::default()];
    engine.advance_to(0.1, &mut exchange).unwrap();
    engine.rebase_body(0, 0.1);
    let start = BodyState { velocity: Vector3::new(0.0, 0.0, -100.0), ..engine.state().bodies[0] };
    engine.set_body(0, &start);
    // A step too short for a tick, and one that ends after the body has come through its 10 m.
    engine.advance_to(0.1 + 1e-7, &mut exchange).unwrap();
    let reached = engine.advance_to(0.21, &mut exchange);
    assert!(reached.is_err() || exchange[0].is_contact(), "the ball flies through the gel");
}

#[test]
fn a_gel_at_rest_stays_at_rest_to_the_bit() {
    for case in in_space() {
        let start = fast::<3>(case, 10.0);
        let rest = start.state().position.clone();
        let state = run(start.with_sweeps_at_rest(), 2.0);
        assert!(state.position == rest && state.velocity.iter().all(|v| *v == Vector::<3>::zeros()));
        assert_eq!(state.record.min_jacobian, 1.0);
    }
}

#[test]
fn a_restart_in_the_middle_leaves_no_trace() {
    for case in cases().filter(|case| case.section == Section::Spatial) {
        let whole = run(fast::<3>(case, 0.05), 1.0);
        let mut other = fast::<3>(case, 0.05);
        for end in [0.1, 0.26, 0.5, 0.77] {
            let state = run(std::mem::replace(&mut other, fast::<3>(case, 0.05)), end);
            other.restore(&state).unwrap();
        }
        assert!(run(other, 1.0) == whole, "{case:?}");
    }
}

#[test]
fn the_paper_s_law_and_queue_are_stepped_by_the_reference_form() {
    for (schedule, law) in [
        (SteppingSchedule::Bins, ImpulseLaw::Reversal),
        (SteppingSchedule::Queue, MOREAU),
        (SteppingSchedule::Queue, ImpulseLaw::Reversal),
    ] {
        let digest = |reference: bool| {
            let engine = engine::<3>(SPACE, 0.0, (schedule, law));
            run(if reference { engine.with_reference_form() } else { engine }, 0.5).digest()
        };
        assert_eq!(digest(false), digest(true));
    }
}

#[test]
fn an_engine_that_ends_and_goes_on_with_the_same_mesh_gives_the_same_motion() {
    let both = [false, true, true, false, true, false, false, true, false, true, true, false];
    for (case, reference) in cases().filter(|case| case.section == Section::Spatial).zip(both) {
        let n = fast::<3>(case, 0.0).gel().potential.len();
        // A mesh that could be exchanged and never is: contact holds the facets of a gel with history as it does there.
        let mut lasting = fast::<3>(case, 0.0);
        lasting.set_distortion_limits(Some(DistortionLimits::of_shape(vec![0.0; n], vec![0.0; n])));
        let whole = run(lasting, 1.0);
        let start = fast::<3>(case, 0.0);
        let start = if reference { start.with_reference_form() } else { start };
        // Any mesh is worse than the best one: it ends as soon as it is looked at.
        let mut engine = start;
        engine.set_distortion_limits(Some(DistortionLimits::of_shape(vec![1.0; n], vec![0.0; n])));
        let mut exchange = [ImpulseExchange::default()];
        let mut ends = 0;
        while engine.advance_to(1.0, &mut exchange).unwrap() == AdvanceOutcome::MeshEnded {
            let nodes = engine.state().position.iter().copied().zip(engine.state().velocity.iter().copied()).collect();
            let memory = engine.state().memory.clone();
            engine = engine.continue_on_mesh(gel::<3>(case), Some(memory), nodes, None).unwrap();
            ends += 1;
        }
        let state = engine.state();
        assert!(ends > 2, "{ends} ends");
        assert!(difference(&whole, state) < 2e-3, "{case:?}: {:e}", difference(&whole, state));
        let totals = engine.totals(1.0);
        assert!(totals.energy_imbalance.1 < 1e-12, "{case:?}: {totals:?}");
        assert!(
            totals.momentum_imbalance.1 < 1e-13 && totals.angular_momentum_imbalance.1 < 1e-13,
            "{case:?}: {totals:?}"
        );
        assert!(
            totals.ledger.energy.remesh.abs() < 1e-15,
            "the same mesh holds the same energy: {:e}",
            totals.ledger.energy.remesh
        );
    }
}

#[test]
fn an_energy_given_to_elements_changes_neither_momentum_nor_angular_momentum() {
    let mut engine = fast::<3>(SPACE, 0.0);
    engine.advance_to(0.3, &mut [ImpulseExchange::default()]).unwrap();
    let (gel, before) = (engine.gel(), engine.totals(0.3));
    let made: Vec<_> = (0..gel.potential.len() as u32)
        .step_by(3)
        .map(ElementId)
        .map(|element| (element, gel.potential.volume(element)))
        .collect();
    for part in [1e-3, -1e-3] {
        let given = part * before.energies.gel_kinetic;
        let (was, booked) = (engine.totals(0.3), engine.state().ledger.energy);
        engine.return_energy(&made, given);
        let now = engine.totals(0.3);
        let grown = now.energies.gel_kinetic - was.energies.gel_kinetic;
        assert!((grown / given - 1.0).abs() < 1e-10, "{grown:e} of {given:e} J");
        let energy = engine.state().ledger.energy;
        for change in [energy.remesh - booked.remesh, energy.remesh_returned - booked.remesh_returned] {
            assert!((change / given - 1.0).abs() < 1e-10);
        }
        assert!(now.energy_imbalance.1 < 1e-13 && now.momentum_imbalance.1 < 1e-14, "{now:?}");
        assert!(now.angular_momentum_imbalance.1 < 1e-14, "{now:?}");
    }
    let was = engine.state().clone();
    engine.return_energy(&[], 1.0);
    engine.return_energy(&made, 0.0);
    assert_eq!(*engine.state(), was, "nothing is given to nothing, nor does nothing change anything");
}

#[test]
fn a_mesh_that_begins_in_mid_step_settles_every_group_there() {
    for case in in_space() {
        let (mut old, mut in_between) = (fast::<3>(case, 0.0), 0);
        let n = old.gel().potential.len();
        for end in [0.2, 0.23, 0.29, 0.31] {
            old.advance_to(end, &mut [ImpulseExchange::default()]).unwrap();
            // Any mesh is worse than the best one: it ends with the next of the finest steps, in the middle of others.
            old.set_distortion_limits(Some(DistortionLimits::of_shape(vec![1.0; n], vec![0.0; n])));
            assert_eq!(
                old.advance_to(1.0, &mut [ImpulseExchange::default()]),
                Ok(AdvanceOutcome::MeshEnded),
                "{case:?}"
            );
            let mut begun = |by_reference: bool| {
                let nodes = old.state().position.iter().copied().zip(old.state().velocity.iter().copied()).collect();
                let mut new =
                    old.continue_on_mesh(gel::<3>(case), Some(old.state().memory.clone()), nodes, None).unwrap();
                new = if by_reference { new.with_reference_form() } else { new };
                // Its first tick.
                new.advance_to(old.now(), &mut [ImpulseExchange::default()]).unwrap();
                new
            };
            let [new, reference] = [false, true].map(&mut begun);
            in_between += compare_begun(case, &new, &reference);
            old = new;
            old.set_distortion_limits(None);
        }
        assert!(in_between > 0, "{case:?}");
    }
}

/// Compares what the clocks of two meshes have after their first tick; how many fire next before their step is over.
fn compare_begun(case: Case, fast: &Engine<3, Simplices<3>>, reference: &Engine<3, Simplices<3>>) -> usize {
    let clocks = || fast.state().clocks.iter().zip(&reference.state().clocks);
    for (fast, reference) in clocks() {
        assert_eq!(fast.step, reference.step);
        assert!((fast.energy - reference.energy).abs() < 1e-14, "{case:?}: {fast:?}, {reference:?}");
        assert!((fast.ahead - reference.ahead).abs() < 1e-14, "{case:?}: {fast:?}, {reference:?}");
    }
    assert!(clocks().any(|(_, reference)| reference.ahead.abs() > 1e-10), "{case:?}");
    assert!(difference(fast.state(), reference.state()) < 1e-14, "{case:?}");
    clocks().filter(|(clock, _)| !fast.last_tick().is_multiple_of(clock.step)).count()
}

/// Sheared by γ = 300 and relaxed: its steps are some γ⁻¹ of those at the start, and would be γ⁻² and less than a tick had it never flowed.
#[test]
fn a_mesh_that_has_flowed_far_begins_with_steps_by_what_it_remembers() {
    let case = Case { gel: Made::Damaged, ..SPACE };
    let mut old = fast::<3>(case, 1.0);
    old.advance_to(0.0, &mut [ImpulseExchange::default()]).unwrap();
    let mut sheared = nalgebra::Matrix3::identity();
    sheared[(0, 2)] = 300.0;
    let nodes = || old.state().position.iter().map(|x| (sheared * x, Vector::<3>::zeros())).collect::<Vec<_>>();
    let [fresh, flowed] = [old.state().memory.clone(), old.state().memory.clone()];
    let inverse = sheared.try_inverse().unwrap();
    let flowed =
        flowed.into_iter().map(|own| HistoryVariables { inverse: inverse * inverse.transpose(), ..own }).collect();
    let [unmoved, relaxed] = [nodes(), nodes()];
    let unmoved = old.continue_on_mesh(gel::<3>(case), Some(fresh), unmoved, None).map(|_| ());
    assert!(matches!(unmoved, Err(UnusableStep { step, .. }) if step > 0.0), "{unmoved:?}");
    assert_eq!(old.continue_on_mesh(gel::<3>(case), Some(flowed), relaxed, None).map(|_| ()), Ok(()));
}

/// Rows of a long cell and of ones a 64th as long, which go at a speed to where the rows are held: the long cells alone are crushed, by
/// their neighbours.
fn crushed(speed: f64) -> Engine<2, Simplices<2>> {
    let across = std::iter::once(0.0).chain((64..=80).map(|i| f64::from(i) / 64.0)).collect();
    let planes = [across, (0..=12).map(f64::from).collect()];
    let left = HeldFace { axis: 0, high: false, hold: FaceConstraint::All };
    let mesh: Mesh<2> = mesh::block(BlockSpec { planes, split: CellSplit::Kuhn, faces: vec![left] });
    let alone = ElementPatches::alone(mesh.elements.len());
    let material = (NeoHookean::new(1.0, 10.0), Section::Planar { thickness: 1.0 });
    let simplices = Simplices::in_patches(&mesh, alone, material);
    let mass = simplices.lumped_masses(&mesh, 1.0);
    let surface = ContactSurface::new::<2>(mesh.rest.len(), mesh.facets.clone(), |_| (1.0, 1.0));
    let velocity = |x: &Vector<2>| Vector::<2>::new(if x[0] > 0.0 { -speed } else { 0.0 }, 0.0);
    let nodes = mesh.rest.iter().map(|x| (*x, velocity(x))).collect();
    let rules =
        IntegratorSettings { schedule: SteppingSchedule::Bins, cfl: 0.8, law: MOREAU, force_window: 1.0, damping: 0.0 };
    Engine::new(
        DiscreteGel::new(simplices, mass, &mesh.held, surface),
        vec![ball(FreeDirections::PLANAR, 100.0)],
        rules,
        nodes,
    )
}

/// Only elements of the longest step can be worn, and none of them fires before the end of the first one: their mesh ends within it, at the
/// next tick of their neighbours, but not before half of it.
#[test]
fn an_element_that_is_crushed_within_its_step_ends_its_mesh_from_half_of_it_on() {
    for by_reference in [false, true] {
        let made = |speed: f64| if by_reference { crushed(speed).with_reference_form() } else { crushed(speed) };
        let mut still = made(0.0);
        still.advance_to(0.0, &mut [ImpulseExchange::default()]).unwrap();
        let steps = (0..still.gel().potential.len() as u32).map(|element| still.step_of(ElementId(element)));
        let steps: Vec<_> = steps.collect();
        let (step, finest) = (*steps.iter().max().unwrap(), *steps.iter().min().unwrap());
        assert!(step >= 8 * finest, "{step} and {finest} ticks");
        let least: Vec<f64> = steps.iter().map(|own| if *own == step { 1.0 } else { 0.0 }).collect();
        // In a young mesh seven tenths of what they measure at rest: that is so after this part of the step.
        for (part, end) in [(0.3, step / 2), (0.6, step * 5 / 8), (0.74, step * 6 / 8)] {
            let mut engine = made(0.3 / (part * still.grid().time(step)));
            engine.set_distortion_limits(Some(DistortionLimits::of_shape(vec![0.0; least.len()], least.clone())));
            let reached = engine.advance_to(still.grid().time(step), &mut [ImpulseExchange::default()]);
            assert_eq!((reached, engine.last_tick()), (Ok(AdvanceOutcome::MeshEnded), end), "{part} of {step} ticks");
        }
    }
}
