//! Where the nodes of a new mesh are in the old one, and what the old one has there.

use super::barycentric::{Cell, weighed};
use super::overlap_candidates::Under;
use super::{Moved, Origin, Proposal};
use crate::math::Vector;
use crate::mesh::{ElementId, NodeId};

/// A point that lies further outside the old mesh than this part of the nearest element's longest edge is a miss: far
/// above what rounding moves a point on the boundary, far below what could matter to a field.
const OUTSIDE: f64 = 1e-9;

/// Where a new node was in the old mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Trace {
    Node(NodeId),
    /// As many nodes as an element has, and their weights.
    Between([NodeId; 4], [f64; 4]),
    /// There was no old element at all.
    Nowhere,
}

/// Where all nodes were.
#[derive(Debug)]
pub(super) struct Traces {
    traces: Vec<Trace>,
    /// How many points inside were found outside the old mesh: they were taken to the nearest place in it.
    pub misses: usize,
}

impl Traces {
    /// Of a new mesh, given the old elements that are gone, whose place new points inside take.
    pub fn of<const D: usize>(
        old: &Moved<'_, D>,
        new: &Proposal<D>,
        (gone, under): (&[ElementId], &Under<'_, D>),
    ) -> Self {
        let mut misses = 0;
        let element_of = elements_of(new);
        let mut inside = |node: usize, p: &Vector<D>| {
            let Some(place) = under.nearest(element_of[node], p) else {
                misses += 1;
                return Trace::Nowhere;
            };
            let nodes = old.mesh.elements[gone[place.cell].index()];
            if place.distance > OUTSIDE * OUTSIDE * Cell::of(old.position, &nodes).longest_edge_squared() {
                misses += 1;
            }
            Trace::Between(nodes, place.weights)
        };
        let trace = |(node, (p, origin)): (usize, (&Vector<D>, &Origin))| match *origin {
            Origin::Kept(node) => Trace::Node(node),
            Origin::Surface([a, b, c], [u, v, w]) => Trace::Between([a, b, c, c], [u, v, w, 0.0]),
            Origin::Inside => inside(node, p),
        };
        let traces = new.position.iter().zip(&new.origin).enumerate().map(trace).collect();
        Self { traces, misses }
    }

    /// The values of an old field at the new nodes: those of nodes that were kept bit for bit, linear in between.
    pub fn values<const D: usize>(&self, field: &[Vector<D>]) -> Vec<Option<Vector<D>>> {
        let at = |node: NodeId| field[node.index()];
        let value = |trace: &Trace| match trace {
            Trace::Node(node) => Some(at(*node)),
            Trace::Between(nodes, weights) => Some(weighed(&nodes.map(at), weights)),
            Trace::Nowhere => None,
        };
        self.traces.iter().map(value).collect()
    }
}

/// An element of each new node.
fn elements_of<const D: usize>(new: &Proposal<D>) -> Vec<usize> {
    let mut element_of = vec![0; new.position.len()];
    for (element, nodes) in new.elements.iter().enumerate() {
        nodes[..=D].iter().for_each(|node| element_of[node.index()] = element);
    }
    element_of
}

/// Which directions of the new nodes are held: of old nodes as they were, of points of the boundary what all nodes share that
/// they are made of.
pub(super) fn held<const D: usize>(old: &[[bool; D]], origin: &[Origin]) -> Vec<[bool; D]> {
    let of = |origin: &Origin| match *origin {
        Origin::Kept(node) => old[node.index()],
        Origin::Surface(nodes, weights) => std::array::from_fn(|axis| {
            nodes.iter().zip(weights).all(|(node, weight)| weight == 0.0 || old[node.index()][axis])
        }),
        Origin::Inside => [false; D],
    };
    origin.iter().map(of).collect()
}
