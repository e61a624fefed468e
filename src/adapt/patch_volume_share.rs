//! Share of an element in the change of volume of its F-bar patch (de Souza Neto et al. 2005), for transfer to a new
//! mesh.
//!
//! In a patch the elements may exchange volume freely; only J̄ is resisted. New elements made of parts of them must
//! therefore get J̄: the part J of each would be a strain that the bulk modulus never saw.

use crate::fem::{Potential, ReferenceShape, Simplices};
use crate::math::{Tensor, Vector, cube_root, det};
use crate::mesh::{ElementId, ElementPatches};
use crate::remesh::UnchangedElement;

/// Ratio J/J̄ of each element to its patch: the factor of the element's rest measure outside of the patch. The
/// factors leave the sum over a patch unchanged. The ratio is 1 for a patch of one element and in an inverted patch.
pub(super) fn shares<const D: usize>(potential: &Simplices<D>, x: &[Vector<D>]) -> Vec<f64> {
    let mut shares = vec![1.0; potential.len()];
    let patches = potential.patches();
    for elements in (0..patches.len()).map(|patch| patches.of(patch)).filter(|elements| elements.len() > 1) {
        let jacobian = |element: ElementId| {
            let (f, out) = potential.deformation_gradient(element, x);
            det(&f) * out
        };
        let each: Vec<(f64, f64)> = elements.iter().map(|e| (potential.volume(*e), jacobian(*e))).collect();
        let rest: f64 = each.iter().map(|(volume, _)| volume).sum();
        let mean = each.iter().map(|(volume, jacobian)| volume * jacobian).sum::<f64>() / rest;
        if mean > 0.0 && each.iter().all(|(_, jacobian)| *jacobian > 0.0) {
            for (element, (_, jacobian)) in elements.iter().zip(&each) {
                shares[element.index()] = jacobian / mean;
            }
        }
    }
    shares
}

/// Factors of the rest measures that keep J̄ in the patches which lose these elements: the mean J of the remaining
/// elements of a patch over its J̄. The factor is 1 in other patches, and where either mean is not positive.
pub(super) fn shares_after_loss<const D: usize>(potential: &Simplices<D>, x: &[Vector<D>], lost: &[bool]) -> Vec<f64> {
    let mut shares = vec![1.0; potential.len()];
    let mean_jacobian = |elements: &mut dyn Iterator<Item = &ElementId>| {
        let (mut rest, mut now) = (0.0, 0.0);
        for element in elements {
            let (f, out) = potential.deformation_gradient(*element, x);
            rest += potential.volume(*element);
            now += potential.volume(*element) * det(&f) * out;
        }
        now / rest
    };
    let is_lost = |element: &&ElementId| lost[element.index()];
    for patch in potential.patches().iter().filter(|patch| patch.iter().any(|element| is_lost(&element))) {
        let remaining = mean_jacobian(&mut patch.iter().filter(|element| !is_lost(element)));
        let whole = mean_jacobian(&mut patch.iter());
        if remaining > 0.0 && whole > 0.0 {
            for element in patch {
                shares[element.index()] = remaining / whole;
            }
        }
    }
    shares
}

/// Returns for each new element true if it is an old one in an unchanged patch.
pub(super) fn stays(old: &ElementPatches, new: &ElementPatches, same: &[Option<UnchangedElement>]) -> Vec<bool> {
    let most = (0..old.len()).flat_map(|patch| old.of(patch)).map(|element| element.index() + 1).max().unwrap_or(0);
    let mut patch_of = vec![0; most];
    for patch in 0..old.len() {
        old.of(patch).iter().for_each(|element| patch_of[element.index()] = patch);
    }
    let mut stays = vec![false; same.len()];
    for elements in (0..new.len()).map(|patch| new.of(patch)) {
        let was = |element: &ElementId| same[element.index()].map(|same| patch_of[same.element.index()]);
        let first = elements.first().and_then(was);
        let is_whole = first.is_some_and(|patch| old.of(patch).len() == elements.len());
        let together = is_whole && elements.iter().all(|element| was(element) == first);
        for element in elements {
            stays[element.index()] = together;
        }
    }
    stays
}

/// Area or volume of the element with these edges.
pub(super) fn measure<const D: usize>(edges: &Tensor<D>) -> f64 {
    det(edges) / if D == 2 { 2.0 } else { 6.0 }
}

impl<const D: usize> ReferenceShape<D> {
    /// Area or volume, or area times radius of a ring.
    pub(super) fn size(&self, is_ring: bool) -> f64 {
        measure(&self.edges) * if is_ring { self.radius } else { 1.0 }
    }

    /// Scales the measure of the reference by `part`, at constant shape.
    pub(super) fn scaled(&self, part: f64) -> Self {
        if part == 1.0 {
            return *self;
        }
        Self { edges: self.edges * if D == 2 { part.sqrt() } else { cube_root(part) }, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constitutive::{Material, NeoHookean};
    use crate::fem::Section;
    use crate::mesh::{BlockSpec, CellSplit, block};

    #[test]
    fn the_rest_of_a_patch_that_loses_an_inverted_element_keeps_its_mean_jacobian() {
        let axis = || vec![0.0, 1.0];
        let mesh = block::<2>(BlockSpec { planes: [axis(), axis()], split: CellSplit::Centred, faces: vec![] });
        let material = (Material::NeoHookean(NeoHookean::new(20e3, 2e6)), Section::Planar { thickness: 1.0 });
        let alone = Simplices::in_patches(&mesh, ElementPatches::alone(4), material);
        // The centre is pushed out through a side.
        let middle = Vector::<2>::new(0.5, 0.5);
        let out = Vector::<2>::new(0.5, -0.2);
        let position: Vec<_> = mesh.rest.iter().map(|x| if *x == middle { out } else { *x }).collect();
        let jacobian: Vec<f64> = (0..4).map(|e| det(&alone.deformation_gradient(ElementId(e), &position).0)).collect();
        let inverted: Vec<_> = (0..4).filter(|e| jacobian[*e] < 0.0).collect();
        let [lost] = inverted[..] else { panic!("{jacobian:?}") };
        let mate = (lost + 1) % 4;
        let labels = [0, 1, 2, 3].map(|e| if e == mate { lost as u32 } else { e as u32 });
        let simplices = Simplices::in_patches(&mesh, ElementPatches::of_labels(&labels), material);
        let shares = shares_after_loss(&simplices, &position, &[0, 1, 2, 3].map(|e| e == lost));
        let mean = 0.5 * (jacobian[lost] + jacobian[mate]);
        assert!(mean > 0.0 && (jacobian[mate] / shares[mate] - mean).abs() < 1e-12, "{jacobian:?} {shares:?}");
        assert!((0..4).all(|e| e == lost || e == mate || shares[e] == 1.0), "{shares:?}");
    }
}
