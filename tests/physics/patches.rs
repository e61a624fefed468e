//! Disjoint patches: every element in one, compact and connected, few left over, on lattices and on what is made of them.

use ballistic_gel::math::Vector;
use ballistic_gel::mesh::{
    BlockSpec, CellSplit, ElementId, ElementPatches, Mesh, NodeId, RectilinearGrid, Simplex, block, boundary,
    face_neighbours, signed_volume, uniform,
};
use proptest::prelude::*;
use std::collections::BTreeSet;

/// A lattice of unit cells that is displaced, pierced and shuffled.
#[derive(Debug, Clone, Copy)]
struct Recipe {
    cells: usize,
    split: CellSplit,
    seed: u64,
    /// Share of cells left out.
    holes: f64,
    /// Share of elements left out.
    missing: f64,
}

/// A fraction of 1 that depends on a seed and a number.
fn random(seed: u64, i: u64) -> f64 {
    let mut z = seed.wrapping_add(i.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

impl Recipe {
    fn mesh<const D: usize>(self) -> Mesh<D> {
        let Self { cells, split, seed, holes, missing } = self;
        let number = move |cell: [usize; D]| cell.iter().fold(1, |n, i| n * 64 + *i as u64);
        let grid = RectilinearGrid {
            planes: std::array::from_fn(|_| uniform(0.0, cells as f64, 1.0)),
            filled: Box::new(move |cell| random(seed, number(cell)) >= holes),
        };
        let (mut points, mut elements) = grid.split(split);
        if D == 2 && split == CellSplit::Kuhn {
            elements
                .chunks_mut(2)
                .enumerate()
                .filter(|(i, _)| random(seed, *i as u64) < 0.5)
                .for_each(|(_, c)| flip(c));
            for nodes in &mut elements {
                orient(&points, nodes);
            }
        }
        for (i, x) in points.iter_mut().enumerate() {
            *x += Vector::<D>::from_fn(|k, _| 0.2 * random(!seed, (D * i + k) as u64) - 0.1);
        }
        let mut order: Vec<usize> = (0..elements.len()).filter(|e| random(seed ^ 1, *e as u64) >= missing).collect();
        order.sort_by(|a, b| random(seed ^ 2, *a as u64).total_cmp(&random(seed ^ 2, *b as u64)));
        Mesh::new(points, order.into_iter().map(|e| elements[e]).collect())
    }
}

/// Two triangles of a square, cut along the other diagonal.
fn flip(pair: &mut [Simplex]) {
    let (shared, apart): (Vec<NodeId>, Vec<NodeId>) = pair[0][..3].iter().partition(|node| pair[1][..3].contains(node));
    let beyond =
        pair[1][..3].iter().find(|node| !shared.contains(node)).copied().expect("two triangles have four corners");
    for (triangle, corner) in pair.iter_mut().zip(shared) {
        *triangle = [apart[0], beyond, corner, NodeId::default()];
    }
}

fn orient<const D: usize>(points: &[Vector<D>], nodes: &mut Simplex) {
    if signed_volume(points, nodes) < 0.0 {
        nodes.swap(0, 1);
    }
}

fn recipe(cells: std::ops::Range<usize>, missing: f64) -> impl Strategy<Value = Recipe> {
    let split = prop_oneof![Just(CellSplit::Centred), Just(CellSplit::Kuhn)];
    (cells, split, any::<u64>(), 0.0..0.3, 0.0..=missing).prop_map(|(cells, split, seed, holes, missing)| Recipe {
        cells,
        split,
        seed,
        holes,
        missing,
    })
}

/// A block of unit cells.
fn cube<const D: usize>(cells: usize, split: CellSplit) -> Mesh<D> {
    let planes = std::array::from_fn(|_| uniform(0.0, cells as f64, 1.0));
    block(BlockSpec { planes, split, faces: vec![] })
}

/// Share of the elements that are in patches of so many.
fn share(patches: &ElementPatches, size: usize) -> f64 {
    let full: usize = patches.iter().map(<[_]>::len).filter(|n| *n == size).sum();
    full as f64 / patches.iter().map(<[_]>::len).sum::<usize>() as f64
}

/// Whether the elements are connected through facets.
fn connected(elements: &[ElementId], across: &[[Option<ElementId>; 4]]) -> bool {
    let mut reached = vec![elements[0]];
    let mut i = 0;
    while i < reached.len() {
        let next = across[reached[i].index()].iter().flatten().filter(|e| elements.contains(e));
        let next: Vec<ElementId> = next.filter(|e| !reached.contains(e)).copied().collect();
        reached.extend(next);
        i += 1;
    }
    reached.len() == elements.len()
}

fn nodes<const D: usize>(mesh: &Mesh<D>, elements: &[ElementId]) -> BTreeSet<NodeId> {
    elements.iter().flat_map(|e| mesh.elements[e.index()][..=D].iter().copied()).collect()
}

/// What holds on every mesh.
fn check<const D: usize>(mesh: &Mesh<D>, patches: &ElementPatches) {
    let (most, across) = (if D == 2 { 2 } else { 4 }, face_neighbours::<D>(&mesh.elements));
    let mut members: Vec<ElementId> = patches.iter().flatten().copied().collect();
    members.sort_unstable();
    assert!(
        members.iter().copied().eq((0..mesh.elements.len() as u32).map(ElementId)),
        "every element is in one patch"
    );
    let firsts: Vec<ElementId> = patches.iter().map(|elements| elements[0]).collect();
    assert!(firsts.is_sorted() && patches.iter().all(<[_]>::is_sorted), "patches follow their first elements");
    let mut small = vec![false; mesh.elements.len()];
    for elements in patches.iter() {
        assert!(elements.len() <= most && connected(elements, &across), "{elements:?}");
        assert!(nodes(mesh, elements).len() <= D + most, "{elements:?}");
        for e in elements {
            small[e.index()] = 2 * elements.len() <= most;
        }
    }
    for elements in patches.iter().filter(|elements| 2 * elements.len() <= most) {
        let outside = elements.iter().flat_map(|e| across[e.index()]).flatten().filter(|e| !elements.contains(e));
        assert!(outside.into_iter().all(|e| !small[e.index()]), "{elements:?} could be joined to a neighbour");
    }
}

/// Whether four elements are all those around an edge.
fn is_octahedron(mesh: &Mesh<3>, elements: &[ElementId]) -> bool {
    let shared = nodes(mesh, elements).into_iter();
    elements.len() == 4
        && shared.filter(|node| elements.iter().all(|e| mesh.elements[e.index()].contains(node))).count() == 2
        && nodes(mesh, elements).len() == 6
}

#[test]
fn the_centred_lattice_falls_into_its_octahedra() {
    for cells in 1..7 {
        let mesh = cube::<3>(cells, CellSplit::Centred);
        let patches = ElementPatches::grouped(&mesh);
        let made_together =
            |elements: &[ElementId]| elements[0].0.is_multiple_of(4) && elements[3].0 == elements[0].0 + 3;
        assert!(patches.iter().all(|elements| is_octahedron(&mesh, elements) && made_together(elements)));
    }
}

#[test]
fn kuhns_lattice_falls_into_fours_but_for_a_twentieth() {
    for cells in 2..13 {
        let mesh = cube::<3>(cells, CellSplit::Kuhn);
        let patches = ElementPatches::grouped(&mesh);
        check(&mesh, &patches);
        assert!(share(&patches, 4) >= 0.95, "{cells} cells: {}", share(&patches, 4));
    }
}

#[test]
fn lattices_of_the_plane_fall_into_pairs_but_for_two_triangles() {
    for split in [CellSplit::Centred, CellSplit::Kuhn] {
        for cells in 1..20 {
            let mesh = cube::<2>(cells, split);
            let patches = ElementPatches::grouped(&mesh);
            check(&mesh, &patches);
            assert!(patches.iter().filter(|elements| elements.len() == 1).count() <= 2, "{cells} cells, {split:?}");
        }
    }
}

#[test]
fn a_gathered_mesh_has_the_same_patches_in_a_row() {
    let mesh = cube::<2>(5, CellSplit::Centred);
    let patches = ElementPatches::grouped(&mesh);
    let (gathered, rows) = patches.clone().made_contiguous(mesh.clone());
    assert_eq!((&gathered.rest, &gathered.facets, &gathered.held), (&mesh.rest, &mesh.facets, &mesh.held));
    assert_ne!(gathered.elements, mesh.elements, "pairs reach across cells");
    for (before, after) in patches.iter().zip(rows.iter()) {
        let simplices =
            |mesh: &Mesh<2>, of: &[ElementId]| of.iter().map(|e| mesh.elements[e.index()]).collect::<Vec<_>>();
        assert_eq!(simplices(&mesh, before), simplices(&gathered, after));
    }
    assert!(rows.iter().flatten().copied().eq((0..mesh.elements.len() as u32).map(ElementId)));
}

#[test]
fn restricted_patches_keep_their_remaining_elements_together() {
    let mesh = cube::<3>(3, CellSplit::Kuhn);
    let patches = ElementPatches::grouped(&mesh);
    let kept: Vec<ElementId> = (0..mesh.elements.len() as u32).map(ElementId).filter(|e| e.0 % 7 > 1).collect();
    let left = patches.restricted_to(&kept);
    let (was, now) = (patches.patch_of_elements(), left.patch_of_elements());
    assert_eq!(now.len(), kept.len());
    let of = |old: &ElementId| was[old.index()];
    for (a, b) in (0..kept.len()).flat_map(|a| (0..a).map(move |b| (a, b))) {
        assert_eq!(of(&kept[a]) == of(&kept[b]), now[a] == now[b], "{a} and {b}");
    }
    let firsts: Vec<_> = left.iter().map(|elements| elements[0]).collect();
    assert!(firsts.is_sorted() && left.iter().all(<[ElementId]>::is_sorted));
    let all: Vec<ElementId> = (0..mesh.elements.len() as u32).map(ElementId).collect();
    assert_eq!(patches.restricted_to(&all), patches);
    let alone = ElementPatches::alone(5).restricted_to(&[ElementId(1), ElementId(4)]);
    assert_eq!(alone.iter().map(<[ElementId]>::len).collect::<Vec<_>>(), [1, 1]);
}

#[test]
fn elements_can_stay_alone() {
    let patches = ElementPatches::alone(3);
    assert_eq!((patches.len(), ElementPatches::alone(0).is_empty()), (3, true));
    assert_eq!((patches.of(2), patches.largest()), (&[ElementId(2)][..], 1));
}

#[test]
#[should_panic(expected = "element 1 stands twice in the new order")]
fn an_order_that_names_an_element_twice_is_refused() {
    let _ = cube::<2>(1, CellSplit::Kuhn).reordered(&[ElementId(1), ElementId(1)]);
}

#[test]
#[should_panic(expected = "the new order leaves out elements")]
fn an_order_that_leaves_out_elements_is_refused() {
    let _ = cube::<2>(1, CellSplit::Kuhn).reordered(&[ElementId(1)]);
}

/// Renumbers a cube of two cells along each axis.
fn renumber<const D: usize>() {
    let mut mesh = cube::<D>(2, CellSplit::Centred);
    mesh.held[3] = std::array::from_fn(|i| i == 0);
    mesh.marks = (0..).take(mesh.facets.len()).collect();
    let n = mesh.rest.len() as u32;
    let order: Vec<NodeId> = (0..n).map(|i| NodeId((7 * i + 3) % n)).collect();
    let other = mesh.clone().renumbered(&order);
    let at = |mesh: &Mesh<D>, nodes: &[NodeId]| nodes.iter().map(|node| mesh.rest[node.index()]).collect::<Vec<_>>();
    assert!(!n.is_multiple_of(7) && other.rest != mesh.rest);
    for (a, b) in mesh.elements.iter().zip(&other.elements) {
        assert_eq!(at(&mesh, &a[..=D]), at(&other, &b[..=D]));
    }
    assert_eq!(other.facets, boundary::<D>(&other.elements));
    assert_eq!(other.marks, mesh.marks);
    let held = |mesh: &Mesh<D>, node: usize| (mesh.rest[node], mesh.held[node]);
    assert!(order.iter().enumerate().all(|(i, was)| held(&other, i) == held(&mesh, was.index())));
}

#[test]
fn nodes_with_other_numbers_make_the_same_mesh() {
    renumber::<2>();
    renumber::<3>();
}

#[test]
#[should_panic(expected = "node 1 stands twice in the new order")]
fn an_order_that_names_a_node_twice_is_refused() {
    let _ = cube::<2>(1, CellSplit::Kuhn).renumbered(&[0, 1, 1, 2].map(NodeId));
}

#[test]
#[should_panic(expected = "the new order names every node")]
fn an_order_that_leaves_out_nodes_is_refused() {
    let _ = cube::<2>(1, CellSplit::Kuhn).renumbered(&[NodeId(1)]);
}

proptest! {
    #[test]
    fn patches_are_disjoint_connected_and_none_too_small_in_the_plane(recipe in recipe(2..12, 0.2)) {
        let mesh = recipe.mesh::<2>();
        check(&mesh, &ElementPatches::grouped(&mesh));
    }

    #[test]
    fn patches_are_disjoint_connected_and_none_too_small_in_space(recipe in recipe(1..5, 0.2)) {
        let mesh = recipe.mesh::<3>();
        check(&mesh, &ElementPatches::grouped(&mesh));
    }

    #[test]
    fn displaced_triangles_with_holes_are_paired_but_for_a_twentieth(recipe in recipe(4..16, 0.0)) {
        let mesh = recipe.mesh::<2>();
        let patches = ElementPatches::grouped(&mesh);
        prop_assert!(share(&patches, 2) >= 0.95, "{}", share(&patches, 2));
    }

    #[test]
    fn a_displaced_centred_lattice_with_holes_falls_into_octahedra(recipe in recipe(1..5, 0.0)) {
        let mesh = Recipe { split: CellSplit::Centred, ..recipe }.mesh::<3>();
        let patches = ElementPatches::grouped(&mesh);
        prop_assert!(patches.iter().all(|elements| is_octahedron(&mesh, elements)));
    }

    #[test]
    fn displaced_kuhn_cells_with_holes_fall_into_fours_but_for_a_twentieth(recipe in recipe(4..7, 0.0)) {
        let mesh = Recipe { split: CellSplit::Kuhn, holes: recipe.holes / 3.0, ..recipe }.mesh::<3>();
        let patches = ElementPatches::grouped(&mesh);
        prop_assert!(share(&patches, 4) >= 0.95, "{}", share(&patches, 4));
    }

    #[test]
    fn neither_a_second_look_nor_the_unit_changes_the_patches(recipe in recipe(1..5, 0.1)) {
        let mut mesh = recipe.mesh::<3>();
        let patches = ElementPatches::grouped(&mesh);
        prop_assert_eq!(&patches, &ElementPatches::grouped(&mesh));
        mesh.rest.iter_mut().for_each(|x| *x /= 1024.0);
        prop_assert_eq!(&patches, &ElementPatches::grouped(&mesh));
    }
}
