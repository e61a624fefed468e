//! Symmetry contact of the gel with its mirror image: no surface node passes the axis of revolution or a plane of
//! symmetry (method 2.9).

use super::impulse;
use super::neighbour_list::STRETCH;
use super::surface::{NodalMasses, SurfaceNode, SurfaceView};
use super::tolerance::TOUCH_TOLERANCE;
use crate::math::Vector;
use crate::mesh::NodeId;

/// Symmetry contact of a surface node that may reach its mirror image until its next tick.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SymmetryContact {
    /// Surface node.
    pub node: NodeId,
    /// Axis normal to the plane of symmetry.
    pub axis: usize,
    /// −x/Δt, the velocity that brings the node to the plane, m/s; zero for a node beyond the plane, which is only
    /// stopped.
    min_velocity: f64,
    /// u⁻, velocity of the node away from the plane before the tick, m/s.
    pub before: f64,
    /// J, accumulated impulse away from the plane, N·s.
    pub impulse: f64,
}

/// Iterates over the symmetry contacts of a surface node, one per plane that it may reach: it is nearer to the plane
/// than its size, or than twice its path to its next tick.
///
/// `time_ahead` returns the time to the next tick, s; `None` at the last tick of a mesh, where a node at the plane is
/// held there.
pub(crate) fn symmetry_contacts<const D: usize>(
    surface: &impl SurfaceView<D>,
    at: &SurfaceNode,
    axes: &[usize],
    time_ahead: Option<impl Fn() -> f64>,
) -> impl Iterator<Item = SymmetryContact> {
    let SurfaceNode { node, size, .. } = *at;
    let (x, v) = (surface.position(node), surface.velocity(node));
    let may_reach_image = move |axis: usize| match &time_ahead {
        None => (x[axis] < TOUCH_TOLERANCE * size).then_some(0.0),
        Some(ahead) => {
            let is_fast = || x[axis] < STRETCH * size && x[axis] < 2.0 * v[axis].abs() * ahead();
            (x[axis] < size || is_fast()).then(|| (-x[axis] / ahead()).min(0.0))
        }
    };
    let is_free = move |axis: &usize| surface.masses().free(node)[*axis] != 0.0;
    let contact = move |axis: usize| {
        let min_velocity = may_reach_image(axis)?;
        Some(SymmetryContact { node, axis, min_velocity, before: surface.velocity_before(node)[axis], impulse: 0.0 })
    };
    axes.iter().copied().filter(is_free).filter_map(contact)
}

/// Corrects all impulses between nodes and their images once; returns the greatest change of a velocity, m/s.
pub(super) fn correct_symmetry_contacts<const D: usize>(
    contacts: &mut [SymmetryContact],
    masses: &impl NodalMasses<D>,
    velocity: &mut [Vector<D>],
) -> f64 {
    contacts.iter_mut().map(|contact| contact.correct(masses, velocity)).fold(0.0, f64::max)
}

impl SymmetryContact {
    /// Corrects the impulse between a node and its image once; returns the change of velocity, m/s. The image has the
    /// same mass and the mirrored velocity, so its impulse is that of a wall at rest.
    fn correct<const D: usize>(&mut self, masses: &impl NodalMasses<D>, velocity: &mut [Vector<D>]) -> f64 {
        let Self { node, axis, min_velocity, impulse: accumulated, .. } = *self;
        let (a, compliance) = (node.index(), 1.0 / masses.mass(node));
        let free = velocity[a][axis] - compliance * accumulated;
        let change = impulse(free, min_velocity, compliance) - accumulated;
        if change.abs() <= f64::EPSILON * accumulated {
            return 0.0;
        }
        self.impulse += change;
        velocity[a][axis] += compliance * change;
        compliance * change.abs()
    }
}
