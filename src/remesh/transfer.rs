//! Field transfer to a new mesh of the same body: rest positions, masses and velocities (method 4.5, A12).

use super::conservation::{ConservationDefects, ConservedTotals, NodeGroup};
use super::correspondence::MeshCorrespondence;
use super::nodal_fields::{BodySymmetry, NodalFields, TransferredFields, nodal_masses};
use super::overlap_candidates::{self, OverlapCandidates};
use super::rest_positions::{self, RestLocations};
use super::supermesh::{ElementMoments, SupermeshIntegrals};
use super::velocity::MomentumProjection;
use super::{DeformedMesh, ProposedMesh};
use crate::math::Vector;

/// Transfers masses, velocities and rest positions to a new mesh.
///
/// Rest positions of kept nodes stay bit for bit; others are interpolated linearly. The old density is linear in each
/// element, and supermesh integration makes every integral over it exact. Masses are m_i = ∫ρ N_i, which conserves mass
/// and centre of mass. Velocities start from interpolation; four Jacobi sweeps v ← v + m⁻¹ (b − M v) follow, with b_i =
/// ∫ρ N_i v_old and M_ij = ∫ρ N_i N_j. As Σ_j M_ij = m_i, each sweep conserves the momentum Σ b_i. Unchanged elements
/// are not intersected, and a node whose neighbours within reach of the sweeps are unchanged keeps its bits. The
/// remaining defect of angular momentum is returned to the free nodes of changed elements as a rigid rotation about
/// their centre of mass.
#[must_use]
pub fn transfer<const D: usize>(
    old: &DeformedMesh<'_, D>,
    carried: &NodalFields<'_, D>,
    new: &ProposedMesh<D>,
) -> TransferredFields<D> {
    transfer_paired(old, carried, (new, MeshCorrespondence::of(old.mesh, new)))
}

/// Transfers the fields with a known correspondence of the meshes; see [`transfer()`].
#[must_use]
pub fn transfer_paired<const D: usize>(
    old: &DeformedMesh<'_, D>,
    carried: &NodalFields<'_, D>,
    (new, pairing): (&ProposedMesh<D>, MeshCorrespondence),
) -> TransferredFields<D> {
    let gone = overlap_candidates::gone(old, &pairing);
    let under = OverlapCandidates::new(old, new, (&pairing, &gone));
    let traces = RestLocations::of(old, new, (&pairing.gone, &under));
    let parts = SupermeshIntegrals::of((old, carried), (new, &pairing), &under);
    let corner_mass = corner_masses(carried, &pairing, &parts.all);
    let mass = masses(new, (carried, &pairing), &corner_mass);
    let held = rest_positions::held(&old.mesh.held, &new.origin);
    let rest = traces.values(&old.mesh.rest).into_iter().zip(&new.position).map(|(rest, x)| rest.unwrap_or(*x));
    let rest = rest.collect();
    let mut velocity = guess(&traces, carried, &held);
    let balance = MomentumProjection {
        origin: &new.origin,
        old: (&old.mesh.elements, carried),
        new: (&new.elements, &pairing),
        parts: &parts.all,
        mass: &mass,
        held: &held,
    };
    let taken = balance.project_momentum(&mut velocity);
    let before = ConservedTotals::of(old.position, carried.mass, carried.velocity);
    let mut defects =
        ConservationDefects::new(before, ConservedTotals::of(&new.position, &mass, &velocity), (&new.position, &taken));
    (defects.stray_mass, defects.misses) = (parts.stray_mass, traces.misses);
    defects.unchanged = pairing.same.iter().flatten().count() as f64 / pairing.same.len().max(1) as f64;
    defects.massless = mass.iter().filter(|m| **m <= 0.0 || !m.is_finite()).count();
    if carried.symmetry != BodySymmetry::Axisymmetric {
        let changed = NodeGroup { x: &new.position, mass: &mass, members: &free(new, &pairing, &held) };
        changed.add_rotation(&mut velocity, &-defects.angular_defect());
        defects.after = ConservedTotals::of(&new.position, &mass, &velocity);
    }
    TransferredFields { rest, mass, corner_mass, velocity, held, same: pairing.same, sources: parts.sources, defects }
}

/// Corner masses of the new elements, kg.
fn corner_masses<const D: usize>(
    carried: &NodalFields<'_, D>,
    pairing: &MeshCorrespondence,
    parts: &[ElementMoments<D>],
) -> Vec<[f64; 4]> {
    let mut corner_mass: Vec<[f64; 4]> = pairing
        .same
        .iter()
        .map(|same| same.map_or([0.0; 4], |same| same.turned(&carried.corner_mass[same.element.index()])))
        .collect();
    for part in parts {
        corner_mass[part.element] = part.corner_mass();
    }
    corner_mass
}

/// Masses of the new nodes, kg: unchanged nodes keep theirs bit for bit.
fn masses<const D: usize>(
    new: &ProposedMesh<D>,
    (carried, pairing): (&NodalFields<'_, D>, &MeshCorrespondence),
    corner_mass: &[[f64; 4]],
) -> Vec<f64> {
    let mut mass = nodal_masses::<D>(new.position.len(), &new.elements, corner_mass);
    for (mass, unchanged) in mass.iter_mut().zip(&pairing.unchanged) {
        if let Some(old) = unchanged {
            *mass = carried.mass[old.index()];
        }
    }
    mass
}

/// Initial velocities: those of kept nodes, interpolated in between, zero in held directions.
fn guess<const D: usize>(traces: &RestLocations, carried: &NodalFields<'_, D>, held: &[[bool; D]]) -> Vec<Vector<D>> {
    let mut velocity: Vec<Vector<D>> =
        traces.values(carried.velocity).into_iter().map(|v| v.unwrap_or_else(Vector::zeros)).collect();
    for (v, held) in velocity.iter_mut().zip(held) {
        (0..D).filter(|axis| held[*axis]).for_each(|axis| v[axis] = 0.0);
    }
    velocity
}

/// Nodes of changed elements that are free in every direction.
fn free<const D: usize>(new: &ProposedMesh<D>, pairing: &MeshCorrespondence, held: &[[bool; D]]) -> Vec<usize> {
    let mut is_free = vec![false; new.position.len()];
    for node in pairing.changed().flat_map(|e| &new.elements[e][..=D]) {
        is_free[node.index()] = held[node.index()] == [false; D];
    }
    (0..is_free.len()).filter(|i| is_free[*i]).collect()
}

#[cfg(test)]
mod tests {
    use super::super::nodal_fields::heights;
    use super::super::test_bodies::{
        TestBody, TestRandom, check_conserved, check_inverted, check_nothing, check_reach, check_sizes, even, scatter,
    };
    use super::super::{NodeOrigin, corner_masses};
    use super::*;
    use crate::mesh::{NodeId, Simplex};

    /// A rotation with stretch and shear.
    fn affine(xi: &Vector<2>) -> Vector<2> {
        Vector::<2>::new(0.9 * xi[0] - 0.5 * xi[1] + 0.7, 0.6 * xi[0] + 1.1 * xi[1] - 0.4)
    }

    /// A stretch that keeps the axis where it is.
    fn widened(xi: &Vector<2>) -> Vector<2> {
        Vector::<2>::new(1.2 * xi[0], 0.7 * xi[1] + 0.1 * xi[0])
    }

    fn body(symmetry: BodySymmetry, random: &mut TestRandom) -> TestBody<2> {
        let map = if symmetry == BodySymmetry::Planar { affine } else { widened };
        TestBody::new(&[even(8), even(7)], (1.0, random), (symmetry, &map))
    }

    fn wavy(x: &Vector<2>) -> Vector<2> {
        Vector::<2>::new((4.0 * x[0] + x[1]).sin(), (3.0 * x[1] - 2.0 * x[0]).cos())
    }

    /// The body on 9 × 6 other cells.
    fn remeshed(
        body: &TestBody<2>,
        random: &mut TestRandom,
    ) -> (Vec<Vector<2>>, ProposedMesh<2>, TransferredFields<2>) {
        let map = if body.symmetry == BodySymmetry::Planar { affine } else { widened };
        let (xi, new) = body.other(&[even(9), even(6)], (1.0, random), &map);
        let transferred = transfer(&body.moved(), &body.carried(), &new);
        (xi, new, transferred)
    }

    #[test]
    fn a_mesh_that_is_the_same_keeps_every_bit() {
        let mut random = TestRandom::new(1);
        for symmetry in [BodySymmetry::Planar, BodySymmetry::Axisymmetric] {
            let mut body = body(symmetry, &mut random).with_velocity(wavy);
            body.mesh.held[3] = [false, true];
            body.velocity[3][1] = 0.0;
            let mut new = body.again();
            new.elements.reverse();
            for nodes in new.elements.iter_mut().step_by(2) {
                *nodes = [nodes[1], nodes[2], nodes[0], nodes[1]];
            }
            let after = transfer(&body.moved(), &body.carried(), &new);
            assert_eq!((after.rest, after.mass), (body.mesh.rest.clone(), body.mass.clone()));
            assert_eq!((after.velocity, after.held), (body.velocity.clone(), body.mesh.held.clone()));
            assert_eq!((after.defects.unchanged, after.defects.stray_mass), (1.0, 0.0));
            assert_eq!(after.defects.after, after.defects.before);
            for (e, old) in (0..new.elements.len()).rev().enumerate() {
                let [now, was] =
                    [(&new.elements[e], after.corner_mass[e]), (&body.mesh.elements[old], body.corner_mass[old])];
                let corner = |a: usize| (0..3).find(|c| was.0[*c] == now.0[a]).unwrap();
                let [a, b, c] = [0, 1, 2].map(|a| was.1[corner(a)]);
                assert_eq!(now.1, [a, b, c, 0.0]);
            }
        }
    }

    #[test]
    fn nodes_out_of_reach_of_a_change_keep_every_bit() {
        let mut random = TestRandom::new(2);
        let planes = [even(20), even(3)];
        let body = TestBody::new(&planes, (1.0, &mut random), (BodySymmetry::Planar, &affine)).with_velocity(wavy);
        let moved = 22;
        assert!(body.xi[moved][0] < 0.1 && body.xi[moved][1] > 0.0 && body.xi[moved][1] < 0.5);
        let [same, other] = check_reach(&body, moved, Vector::<2>::new(0.004, 0.003));
        assert!(same > 50 && other > 5, "{same} the same, {other} not");
    }

    #[test]
    fn rest_positions_of_an_affine_map_are_exact() {
        let mut random = TestRandom::new(3);
        for symmetry in [BodySymmetry::Planar, BodySymmetry::Axisymmetric] {
            let body = body(symmetry, &mut random);
            let (xi, new, after) = remeshed(&body, &mut random);
            for (rest, xi) in after.rest.iter().zip(&xi) {
                assert!((rest - xi).amax() < 1e-13);
            }
            assert!(new.origin.contains(&NodeOrigin::Inside));
            assert_eq!((after.defects.misses, after.defects.massless, after.defects.unchanged), (0, 0, 0.0));
        }
    }

    #[test]
    fn mass_and_momentum_are_kept_over_twenty_meshes() {
        let mut random = TestRandom::new(4);
        for symmetry in [BodySymmetry::Planar, BodySymmetry::Axisymmetric] {
            let mut body = body(symmetry, &mut random).with_velocity(wavy);
            let scattered: Vec<f64> = scatter(&body.mesh, &mut random).iter().map(|m| 0.01 * (0.5 + m)).collect();
            body = body.with_masses(&scattered);
            let (start, centre) = (body.books(), body.first_moment());
            for n in 0..20 {
                let map = if symmetry == BodySymmetry::Planar { affine } else { widened };
                let planes = [even(6 + n % 5), even(9 - n % 4)];
                let (xi, new) = body.other(&planes, (1.0, &mut random), &map);
                let after = transfer(&body.moved(), &body.carried(), &new);
                check_conserved(&after.defects, 1e-13);
                assert_eq!(after.defects.massless, 0);
                assert!(after.defects.stray_mass == 0.0 && after.defects.misses == 0);
                body = body.after(xi, new, after);
            }
            let end = body.books();
            assert!((end.mass / start.mass - 1.0).abs() < 1e-13);
            assert!((end.momentum - start.momentum).norm() < 1e-13 * start.mass);
            assert!((body.first_moment() - centre).norm() < 1e-13 * start.mass);
            if symmetry == BodySymmetry::Planar {
                assert!((end.angular - start.angular).norm() < 1e-12 * start.mass);
            }
        }
    }

    #[test]
    fn meshes_of_very_different_sizes_take_over_from_one_another() {
        let mut random = TestRandom::new(12);
        let layered = vec![0.0, 1e-6, 0.3, 0.5, 1.0];
        let meshes = [[even(2), even(2)], [even(30), even(40)], [layered.clone(), even(3)], [even(4), layered]];
        for symmetry in [BodySymmetry::Planar, BodySymmetry::Axisymmetric] {
            let body = body(symmetry, &mut random).with_velocity(wavy);
            let map = if symmetry == BodySymmetry::Planar { affine } else { widened };
            check_sizes(body, &meshes, &mut random, &map);
        }
    }

    #[test]
    fn a_uniform_body_stays_uniform_over_twenty_meshes() {
        let mut random = TestRandom::new(11);
        for symmetry in [BodySymmetry::Planar, BodySymmetry::Axisymmetric] {
            let mut body = body(symmetry, &mut random);
            for _ in 0..20 {
                let (xi, new, after) = remeshed(&body, &mut random);
                body = body.after(xi, new, after);
                let ring = |e: &Simplex| e[..3].iter().map(|n| body.mesh.rest[n.index()][0]).sum::<f64>() / 3.0;
                let depth =
                    |e: &Simplex| if symmetry == BodySymmetry::Planar { 1.0 } else { std::f64::consts::TAU * ring(e) };
                let mass: Vec<f64> = body.mesh.elements.iter().map(|e| body.mesh.measure(e) * depth(e)).collect();
                let lumped = corner_masses(&body.mesh.rest, &body.mesh.elements, &mass, symmetry);
                for (found, wanted) in body.corner_mass.iter().flatten().zip(lumped.iter().flatten()) {
                    assert!((found - wanted).abs() < 1e-14, "{found} {wanted}");
                }
            }
        }
    }

    #[test]
    fn a_uniform_velocity_stays_uniform() {
        let mut random = TestRandom::new(5);
        let v = Vector::<2>::new(3.0, -2.0);
        for symmetry in [BodySymmetry::Planar, BodySymmetry::Axisymmetric] {
            let body = body(symmetry, &mut random);
            let scattered: Vec<f64> = scatter(&body.mesh, &mut random).iter().map(|m| 0.01 * (0.5 + m)).collect();
            let body = body.with_masses(&scattered).with_velocity(|_| v);
            let (_, _, after) = remeshed(&body, &mut random);
            for velocity in &after.velocity {
                assert!((velocity - v).amax() < 1e-14 * v.norm(), "{velocity}");
            }
        }
    }

    #[test]
    fn a_rotation_stays_one_and_keeps_its_angular_momentum() {
        let mut random = TestRandom::new(6);
        let body = body(BodySymmetry::Planar, &mut random).with_velocity(|x| Vector::<2>::new(x[1] - 0.3, 0.2 - x[0]));
        let (_, new, after) = remeshed(&body, &mut random);
        let ConservationDefects { before, raw, after: end, .. } = after.defects;
        assert!((raw.momentum - before.momentum).norm() < 1e-13);
        let lost = ((raw.angular - before.angular).y / before.angular.y).abs();
        assert!(lost > 1e-6 && lost < 0.02, "{lost}");
        assert!((end.angular - before.angular).norm() < 1e-14 && (end.momentum - before.momentum).norm() < 1e-13);
        let rate = (after.velocity[0] - after.velocity[9]).norm() / (new.position[0] - new.position[9]).norm();
        assert!((rate - 1.0).abs() < 0.02 && rate != 1.0);
        for (v, x) in after.velocity.iter().zip(&new.position) {
            let turned =
                after.velocity[0] + Vector::<2>::new(x[1] - new.position[0][1], new.position[0][0] - x[0]) * rate;
            assert!((v - turned).norm() < 1e-13);
        }
    }

    #[test]
    fn momentum_absorbed_by_held_nodes_is_accounted_for() {
        let mut random = TestRandom::new(7);
        let mut body = body(BodySymmetry::Planar, &mut random).with_velocity(wavy);
        for i in 0..body.xi.len() {
            body.mesh.held[i] = [body.xi[i][0] == 0.0 || body.xi[i][1] == 0.0, body.xi[i][1] == 0.0];
            (0..2).filter(|axis| body.mesh.held[i][*axis]).for_each(|axis| body.velocity[i][axis] = 0.0);
        }
        let (xi, _, after) = remeshed(&body, &mut random);
        for ((xi, held), v) in xi.iter().zip(&after.held).zip(&after.velocity) {
            assert_eq!(*held, [xi[0] == 0.0 || xi[1] == 0.0, xi[1] == 0.0]);
            assert!((0..2).all(|axis| !held[axis] || v[axis] == 0.0));
        }
        let defects = after.defects;
        check_conserved(&defects, 1e-13);
        assert!(defects.held_momentum.norm() > 1e-6);
        assert!((defects.after.angular + defects.held_angular - defects.before.angular).norm() < 1e-13);
        assert!((defects.raw.angular + defects.held_angular - defects.before.angular).norm() > 1e-6);
    }

    #[test]
    fn mass_cut_off_by_a_dropped_boundary_node_is_deposited_nearby() {
        let mut random = TestRandom::new(8);
        for bulge in [0.02, -0.02] {
            let bulged = |xi: &Vector<2>| Vector::<2>::new(xi[0], xi[1] + bulge * xi[1] * xi[0] * (1.0 - xi[0]));
            let planes = [even(4), even(4)];
            let body = TestBody::new(&planes, (0.0, &mut random), (BodySymmetry::Planar, &bulged)).with_velocity(wavy);
            let (xi, new) = body.other(&[even(2), even(4)], (0.0, &mut random), &bulged);
            let after = transfer(&body.moved(), &body.carried(), &new);
            assert!((after.defects.relative_mass() > 1e-4) == (bulge > 0.0) && after.defects.relative_mass() < 0.01);
            check_conserved(&after.defects, 1e-13);
            assert!((after.defects.after.angular - after.defects.before.angular).norm() < 1e-14);
            assert_eq!((after.defects.misses, after.defects.massless), (0, 0));
            let body = body.after(xi, new, after);
            assert!((body.books().mass - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn a_point_outside_takes_what_is_nearest() {
        let mut random = TestRandom::new(9);
        let body = body(BodySymmetry::Planar, &mut random).with_velocity(wavy);
        let mut new = body.again();
        new.origin[0] = NodeOrigin::Inside;
        new.position[0] += Vector::<2>::new(-0.01, -0.02);
        let after = transfer(&body.moved(), &body.carried(), &new);
        assert_eq!(after.defects.misses, 1);
        assert!((after.rest[0] - body.mesh.rest[0]).norm() < 1e-2);
        check_conserved(&after.defects, 1e-13);
    }

    /// A needle that nothing replaces: with all other elements unchanged, its mass was once lost.
    #[test]
    fn mass_of_a_removed_element_is_deposited_in_its_edge_neighbours() {
        let mut random = TestRandom::new(13);
        let body = body(BodySymmetry::Planar, &mut random).with_velocity(wavy);
        let is_at = |i: usize| body.xi[i].iter().all(|c| c.abs() < 0.3);
        let mut new = body.again();
        let at = (0..new.elements.len()).find(|e| new.elements[*e][..3].iter().all(|n| is_at(n.index()))).unwrap();
        let tip = new.elements.remove(at);
        let after = transfer(&body.moved(), &body.carried(), &new);
        check_conserved(&after.defects, 1e-13);
        assert!(after.defects.stray_mass > 0.0);
        let mut before = body.corner_mass.clone();
        before.remove(at);
        let gains =
            |e: &usize| after.corner_mass[*e].iter().sum::<f64>() > (1.0 + 1e-9) * before[*e].iter().sum::<f64>();
        let heavy: Vec<_> = (0..new.elements.len()).filter(gains).collect();
        assert!(!heavy.is_empty());
        for nodes in heavy.iter().map(|e| &new.elements[*e][..3]) {
            assert_eq!(nodes.iter().filter(|node| tip[..3].contains(node)).count(), 2);
        }
    }

    #[test]
    fn an_element_inside_out_gives_its_mass_to_its_neighbours() {
        let body = body(BodySymmetry::Planar, &mut TestRandom::new(10)).with_velocity(wavy);
        check_inverted(body, Vector::<2>::new(0.25, 0.1));
    }

    #[test]
    fn corner_masses_of_rings_are_those_of_a_constant_density() {
        let x = [[0.0, 0.0], [2.0, 0.5], [1.0, 1.5]].map(Vector::<2>::from);
        let corners = corner_masses(&x, &[[0, 1, 2, 0].map(NodeId)], &[12.0], BodySymmetry::Axisymmetric)[0];
        for (found, wanted) in corners.iter().zip([3.0, 5.0, 4.0]) {
            assert!((found - wanted).abs() < 1e-14);
        }
        for (found, wanted) in heights::<2>(&corners).iter().zip([0.0, 24.0, 12.0]) {
            assert!((found - wanted).abs() < 1e-13);
        }
    }

    #[test]
    fn nothing_at_all_can_be_transferred() {
        check_nothing::<2>(BodySymmetry::Planar);
    }
}
