//! Sensors: pressure, displacement and velocity at material points of the gel (method 7).

use super::observe::SensorReport;
use crate::fem::{Potential, Simplices};
use crate::integrator::Engine;
use crate::math::{Vector, Vector3, embed, restrict};
use crate::mesh::{ElementId, NodeId};
use crate::remesh;

/// Sensor located in the mesh.
pub(super) struct LocatedSensor<const D: usize> {
    /// Material point at rest, or its image in the computed part, m.
    rest: Vector<D>,
    /// Sign of each axis: −1 where the point is mirrored, 1 elsewhere.
    mirror: Vector3,
    /// Corners of the element that contains the point.
    corners: Vec<SensorCorner>,
}

/// Corner of the element that contains a sensor.
struct SensorCorner {
    node: NodeId,
    /// Barycentric weight.
    weight: f64,
    /// Elements around the node.
    shares: Vec<ElementShare>,
}

/// Share of an element in the volume around a node.
struct ElementShare {
    element: ElementId,
    patch: usize,
    /// Fraction of the rest volume of all elements around the node.
    fraction: f64,
}

/// Sensors at these points at rest, m, in the mesh of an engine that computes one side of the planes of symmetry.
pub(super) fn place_sensors<const D: usize>(
    points: &[Vector3],
    symmetry_planes: &[usize],
    engine: &Engine<D, Simplices<D>>,
) -> Vec<LocatedSensor<D>> {
    let place = |point: &Vector3| {
        let is_image = |axis: usize| symmetry_planes.contains(&axis) && point[axis] < 0.0;
        let mirror = Vector3::from_fn(|axis, _| if is_image(axis) { -1.0 } else { 1.0 });
        LocatedSensor { rest: restrict::<D>(&point.component_mul(&mirror)), mirror, corners: vec![] }
    };
    let mut sensors: Vec<_> = points.iter().map(place).collect();
    locate_sensors(&mut sensors, engine);
    sensors
}

/// Locates each sensor in the element that contains its point at rest. If the rest positions of a new mesh have a gap
/// at the point, the nearest element is taken.
pub(super) fn locate_sensors<const D: usize>(sensors: &mut [LocatedSensor<D>], engine: &Engine<D, Simplices<D>>) {
    if sensors.is_empty() {
        return;
    }
    let potential = &engine.gel().potential;
    let patch_of = potential.patches().patch_of_elements();
    let shares_at = |node: NodeId| {
        let elements = engine.gel().star.of(node);
        let whole: f64 = elements.iter().map(|element| potential.volume(*element)).sum();
        let share = |element: &ElementId| ElementShare {
            element: *element,
            patch: patch_of[element.index()].index(),
            fraction: potential.volume(*element) / whole,
        };
        elements.iter().map(share).collect()
    };
    for sensor in sensors {
        let (element, weights) =
            remesh::nearest(potential.rest(), potential.elements(), &sensor.rest).expect("a gel has elements");
        let corner = |(node, weight): (&NodeId, f64)| SensorCorner { node: *node, weight, shares: shares_at(*node) };
        sensor.corners = potential.nodes(element).iter().zip(weights).map(corner).collect();
    }
}

impl<const D: usize> LocatedSensor<D> {
    /// Report at time `t`, s, of a gel of which `copies` make the whole.
    ///
    /// Position and velocity are interpolated linearly between the corners. The pressure at a corner is the mean of the
    /// elements around it by rest volume, since element pressures jump. It is divided by the number of symmetric
    /// copies, which scale the stiffness.
    pub fn report(&self, engine: &Engine<D, Simplices<D>>, copies: f64, t: f64) -> SensorReport {
        let t = engine.time_in_gel(t);
        let (gel, velocities) = (&engine.gel().potential, &engine.state().velocity);
        let x = |node: NodeId| engine.position_at(node, t);
        let (mut position, mut velocity, mut pressure) = (Vector::<D>::zeros(), Vector::<D>::zeros(), 0.0);
        for corner in self.corners.iter().filter(|corner| corner.weight > 0.0) {
            position += x(corner.node) * corner.weight;
            velocity += velocities[corner.node.index()] * corner.weight;
            let weighted = |share: &ElementShare| share.fraction * gel.pressure(share.element, share.patch, x);
            pressure += corner.weight * corner.shares.iter().map(weighted).sum::<f64>();
        }
        SensorReport {
            position: embed(&position).component_mul(&self.mirror),
            displacement: embed(&(position - self.rest)).component_mul(&self.mirror),
            velocity: embed(&velocity).component_mul(&self.mirror),
            pressure: pressure / copies,
        }
    }
}
