//! Parts of the materials of a layered gel in its elements: of the first mesh by its rest positions, of a remeshed one by
//! those of the elements that it covers.
//!
//! An element of several materials is a mixture ([`LayerStack::mixed`]). No mesh could follow an interface for long: the
//! layer in front of a projectile is stretched without end, by e² per calibre of its way, and stays in front of it.

use crate::constitutive::{LayerStack, MOST_MATERIALS, MaterialParts};
use crate::fem::{ReferenceShape, Section};
use crate::math::Vector;
use crate::mesh::{CORNERS, Simplex};
use crate::remesh::{OverlapSource, UnchangedElement};

/// Part of a volume, or of a height relative to the extent of an element, that is round-off.
const ROUND_OFF: f64 = 1e-9;
/// Mass of a material, relative to that of the replaced elements, that is round-off.
const MASS_ROUND_OFF: f64 = 1e-14;

/// Parts of mass of the materials of an element, by the rest positions of its corners.
pub(super) fn parts_at_rest<const D: usize>(
    stack: &LayerStack,
    section: Section,
    corners: &[Vector<D>; 4],
) -> MaterialParts {
    let is_ring = section == Section::Axisymmetric;
    let whole = ReferenceShape::of(corners, &CORNERS).size(is_ring);
    let (mut parts, mut above) = ([0.0; MOST_MATERIALS], 0.0);
    for (part, depth) in parts.iter_mut().zip(stack.depths()) {
        let next = volume_above(corners, -depth, is_ring) / whole;
        *part = next - above;
        above = next;
    }
    parts[stack.depths().len()] = 1.0 - above;
    if let Some(pure) = parts.iter().position(|part| *part > 1.0 - ROUND_OFF) {
        return std::array::from_fn(|k| f64::from(u8::from(k == pure)));
    }
    stack.mass_parts(&parts.map(|part| if part > ROUND_OFF { part } else { 0.0 }))
}

/// Parts of mass of the materials of all elements of a first mesh.
pub(super) fn first_parts<const D: usize>(
    stack: &LayerStack,
    section: Section,
    rest: &[Vector<D>],
    elements: &[Simplex],
) -> Vec<MaterialParts> {
    let of = |nodes: &Simplex| parts_at_rest(stack, section, &corners_of(rest, nodes));
    elements.iter().map(of).collect()
}

/// Corners of an element.
pub(super) fn corners_of<const D: usize>(x: &[Vector<D>], nodes: &Simplex) -> [Vector<D>; 4] {
    nodes.map(|node| x[node.index()])
}

/// Area or volume, or area times radius of a ring, of the part of an element above the height `z`, m.
fn volume_above<const D: usize>(corners: &[Vector<D>; 4], z: f64, is_ring: bool) -> f64 {
    let heights = corners.map(|corner| corner[D - 1] - z);
    let heights = &heights[..=D];
    let highest = (0..=D).max_by(|i, j| heights[*i].total_cmp(&heights[*j])).unwrap_or(0);
    let lowest = (0..=D).min_by(|i, j| heights[*i].total_cmp(&heights[*j])).unwrap_or(0);
    let (top, bottom) = (heights[highest], heights[lowest]);
    let round_off = ROUND_OFF * (top - bottom);
    if top <= round_off {
        return 0.0;
    }
    if bottom >= -round_off {
        return ReferenceShape::of(corners, &CORNERS).size(is_ring);
    }
    // The edge between them is cut: of each half one end less is off the plane.
    let mut cut = corners[highest] + (corners[lowest] - corners[highest]) * (top / (top - bottom));
    cut[D - 1] = z;
    let half = |end: usize| std::array::from_fn(|k| if k == end { cut } else { corners[k] });
    volume_above(&half(highest), z, is_ring) + volume_above(&half(lowest), z, is_ring)
}

/// Elements before and after a remeshing, with their masses, kg.
pub(super) struct RemeshedMasses<'a> {
    pub old: &'a [MaterialParts],
    pub old_mass: &'a [f64],
    /// Old element that each new one is, if unchanged.
    pub same: &'a [Option<UnchangedElement>],
    /// Sources of the other elements, in order.
    pub sources: &'a [OverlapSource],
    pub mass: &'a [f64],
}

/// Parts of mass of the materials of remeshed elements: those of their sources by mass, with the mass of each material
/// that the replaced elements had.
pub(super) fn inherited_parts(remeshed: &RemeshedMasses<'_>) -> Vec<MaterialParts> {
    let RemeshedMasses { old, old_mass, same, sources, mass } = *remeshed;
    let mut is_gone = vec![true; old.len()];
    same.iter().flatten().for_each(|same| is_gone[same.element.index()] = false);
    let required = masses((0..old.len()).filter(|e| is_gone[*e]).map(|e| (old_mass[e], &old[e])));
    let whole: f64 = required.iter().sum();
    let mean = mean_parts(&required);
    let mut parts: Vec<MaterialParts> =
        same.iter().map(|same| same.map_or(mean, |same| old[same.element.index()])).collect();
    for own in sources.chunk_by(|a, b| a.new == b.new) {
        let sum = masses(own.iter().map(|source| (source.mass, &old[source.old.index()])));
        parts[own[0].new.index()] = mean_parts(&sum);
    }
    let changed: Vec<usize> = (0..same.len()).filter(|e| same[*e].is_none()).collect();
    let found = masses(changed.iter().map(|e| (mass[*e], &parts[*e])));
    let surplus: MaterialParts = std::array::from_fn(|k| found[k] - required[k]);
    let missing: f64 = surplus.iter().map(|surplus| (-surplus).max(0.0)).sum();
    if missing > MASS_ROUND_OFF * whole.abs() {
        let taken =
            std::array::from_fn(|k| if surplus[k] > 0.0 { (surplus[k] / found[k]).clamp(0.0, 1.0) } else { 0.0 });
        let given = surplus.map(|surplus| (-surplus).max(0.0) / missing);
        for element in &changed {
            convert(&mut parts[*element], &taken, &given);
        }
    }
    parts
}

/// Parts of these masses together, of which one may be negative: elements of negative mass come from transfers.
fn mean_parts(masses: &MaterialParts) -> MaterialParts {
    let positive = masses.map(|mass| mass.max(0.0));
    let sum: f64 = positive.iter().sum();
    if sum > 0.0 { positive.map(|mass| mass / sum) } else { [1.0, 0.0, 0.0, 0.0] }
}

/// Masses of the materials of elements of these masses and parts.
pub(super) fn masses<'a>(elements: impl Iterator<Item = (f64, &'a MaterialParts)>) -> MaterialParts {
    elements.fold([0.0; MOST_MATERIALS], |sum, (mass, parts)| std::array::from_fn(|k| sum[k] + mass * parts[k]))
}

/// Converts the fraction `taken` of each material of an element, and divides it among the materials by `given`: what was
/// deposited outside its source, and round-off.
fn convert(parts: &mut MaterialParts, taken: &MaterialParts, given: &MaterialParts) {
    let converted: f64 = parts.iter().zip(taken).map(|(part, taken)| part * taken).sum();
    *parts = std::array::from_fn(|k| parts[k] * (1.0 - taken[k]) + converted * given[k]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constitutive::{MaterialLayer, MaterialRatios, MixedModuli};
    use crate::mesh::ElementId;

    fn stack(thicknesses: &[f64]) -> LayerStack {
        let of = |thickness: &f64| MaterialLayer { thickness: *thickness, ratios: MaterialRatios::GEL };
        LayerStack::new(&thicknesses.iter().map(of).collect::<Vec<_>>(), MixedModuli::Apart)
    }

    /// A unit tetrahedron whose height is 1: (1 − z)³ of its volume lies above the height z.
    #[test]
    fn a_plane_cuts_a_tetrahedron_by_its_cube() {
        let corners = [[0.0, 0.0, -1.0], [1.0, 0.2, -1.0], [0.1, 1.0, -1.0], [0.3, 0.3, 0.0]].map(Vector::<3>::from);
        let parts = parts_at_rest(&stack(&[0.3, 0.4]), Section::Spatial, &corners);
        let expected = [0.027, 0.343 - 0.027, 1.0 - 0.343, 0.0];
        assert!(parts.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-14), "{parts:?}");
        let above = parts_at_rest(&stack(&[1.0]), Section::Spatial, &corners);
        assert_eq!(above, [1.0, 0.0, 0.0, 0.0]);
    }

    /// A rectangle of two triangles from radius 1 to 3: half of each ring volume lies above its middle.
    #[test]
    fn a_plane_cuts_rings_by_their_volume() {
        let x = [[1.0, -1.0], [3.0, -1.0], [3.0, 0.0], [1.0, 0.0]].map(Vector::<2>::from);
        let triangles = [[0, 1, 2], [0, 2, 3]].map(|[a, b, c]| [x[a], x[b], x[c], x[a]]);
        let size = |corners: &[Vector<2>; 4]| ReferenceShape::of(corners, &CORNERS).size(true);
        let above: f64 = triangles.iter().map(|corners| volume_above(corners, -0.5, true)).sum();
        let whole: f64 = triangles.iter().map(size).sum();
        assert!((above / whole - 0.5).abs() < 1e-14, "{above} of {whole}");
    }

    #[test]
    fn remeshing_conserves_the_mass_of_each_material() {
        let old = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.25, 0.5, 0.25, 0.0]];
        let old_mass = [2.0, 3.0, 4.0];
        let source =
            |new: u32, old: u32, mass: f64| OverlapSource { new: ElementId(new), old: ElementId(old), mass, part: 0.5 };
        let same = [Some(UnchangedElement::in_order(ElementId(1))), None, None, None];
        // A tenth of the first element is deposited elsewhere, and the last element has no source.
        let sources = [source(1, 0, 1.2), source(1, 2, 1.0), source(2, 0, 0.6), source(2, 2, 3.0)];
        let mass = [3.0, 2.2, 3.7, 0.1];
        let parts = inherited_parts(&RemeshedMasses {
            old: &old,
            old_mass: &old_mass,
            same: &same,
            sources: &sources,
            mass: &mass,
        });
        assert_eq!(parts[0], old[1]);
        let [before, after] = [masses(old_mass.iter().copied().zip(&old)), masses(mass.iter().copied().zip(&parts))];
        assert!(before.iter().zip(after).all(|(before, after)| (before - after).abs() < 1e-14), "{after:?}");
        assert!(parts.iter().all(|parts| (parts.iter().sum::<f64>() - 1.0).abs() < 1e-14));
    }

    #[test]
    fn elements_of_negative_mass_leave_no_negative_parts() {
        let old = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]];
        let source = OverlapSource { new: ElementId(1), old: ElementId(1), mass: 3.0, part: 1.0 };
        let (same, mass) = (&[None; 2], &[-0.5, 2.5]);
        for old_mass in [&[-1.0, 3.0], &[-2.0, 2.0], &[-3.0, 2.0]] {
            let parts = inherited_parts(&RemeshedMasses { old: &old, old_mass, same, sources: &[source], mass });
            let is_whole = |parts: &MaterialParts| (parts.iter().sum::<f64>() - 1.0).abs() < 1e-14;
            assert!(parts.iter().all(|parts| is_whole(parts) && parts.iter().all(|part| *part >= 0.0)), "{parts:?}");
        }
    }
}
