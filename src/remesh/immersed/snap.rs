//! Points near the boundary of an immersed body are moved onto it: what would be cut into slivers is none then.

use super::super::boundary_loops::{Feature, features};
use super::super::bounds::Bounds;
use super::super::box_tree::Near;
use super::super::triangle::{Point, distance as apart};
use super::super::{Moved, Origin, RemeshError, delaunay};
use super::background::Background;
use super::boundary::{Boundary, Place};
use crate::math::Vector;

/// Points nearer to the boundary than so many edges of their cell are moved onto it. A cut is then at least 0.2 of an edge away from
/// its ends; with less, slivers remain (in a study without snapping meshes died after 3 to 18 exchanges), and at 0.5 both of
/// two points across the boundary from each other are moved to one place.
const SNAP: f64 = 0.3;
/// No two points on the boundary are nearer than so many edges of their cell, and no others nearer to them. Along a straight boundary
/// points that are moved onto it are at least 0.65 apart: this acts at bends and beside features.
const SPACE: f64 = 0.5;

/// A triangulation that a body is immersed in.
#[derive(Debug, Clone, PartialEq)]
pub struct Immersed {
    /// Its points, m.
    pub points: Vec<Vector<2>>,
    /// Where they come from: those on the boundary from its nodes and edges.
    pub origin: Vec<Origin>,
    /// Their signed distance from the boundary, m; 0 on it.
    pub distance: Vec<f64>,
    /// Its triangles, positively oriented.
    pub triangles: Vec<[usize; 3]>,
}

/// A place on the boundary that wants to be a point.
struct Wish {
    place: Place,
    size: f64,
    /// Whatever is near.
    always: bool,
}

/// Features of the boundary become points, then points near the boundary are moved to its nearest place, the nearest first, and
/// those that have no room there are left out. All points are triangulated again: no triangle is turned over by what moved.
///
/// # Errors
/// If a point is where exact predicates do not reach.
pub fn snapped(
    (old, size): (&Moved<'_, 2>, &[f64]),
    background: &Background,
    distance: &[f64],
) -> Result<Immersed, RemeshError> {
    let is_near = |p: usize| distance[p].abs() < SNAP * background.size[p];
    let (mut close, far): (Vec<usize>, Vec<usize>) = (0..background.points.len()).partition(|p| is_near(*p));
    close.sort_by(|a, b| distance[*a].abs().total_cmp(&distance[*b].abs()).then(a.cmp(b)));
    let places = granted(&wishes((old, size), background, &close));
    let near = Near::points(places.iter().map(|place| place.at));
    let has_room = |p: &usize| {
        let (point, reach) = (&background.points[*p], SPACE * background.size[*p]);
        !near.any(&Bounds::about(point, reach), |i| apart(&places[i].at, point) < reach)
    };
    let free: Vec<usize> = far.into_iter().filter(has_room).collect();
    let points: Vec<Point> =
        places.iter().map(|place| place.at).chain(free.iter().map(|p| background.points[*p])).collect();
    let origin = places.iter().map(|place| place.origin).chain(free.iter().map(|_| Origin::Inside)).collect();
    let distance = places.iter().map(|_| 0.0).chain(free.iter().map(|p| distance[*p])).collect();
    let triangles = delaunay::of_points(&points)?;
    Ok(Immersed { points, origin, distance, triangles })
}

/// The places on the boundary that want to be points: features of any mesh, then corners of this moment, then the nearest places of
/// these points.
fn wishes((old, size): (&Moved<'_, 2>, &[f64]), background: &Background, close: &[usize]) -> Vec<Wish> {
    let boundary = Boundary::of(old);
    let of_feature =
        |(node, feature)| Wish { place: boundary.node(node), size: size[node], always: feature == Feature::Always };
    let mut wishes: Vec<Wish> = features(old).map(of_feature).collect();
    wishes.sort_by_key(|wish| !wish.always);
    let of_point = |p: &usize| {
        let place = boundary.foot(&background.points[*p])?;
        Some(Wish { place, size: background.size[*p], always: false })
    };
    wishes.extend(close.iter().filter_map(of_point));
    wishes
}

/// The places of those who have room beside those before them.
fn granted(wishes: &[Wish]) -> Vec<Place> {
    let near = Near::points(wishes.iter().map(|wish| wish.place.at));
    let mut is_granted = vec![false; wishes.len()];
    for (i, wish) in wishes.iter().enumerate() {
        let reach = SPACE * wish.size;
        let is_taken = |j: usize| is_granted[j] && apart(&wishes[j].place.at, &wish.place.at) < reach;
        is_granted[i] = wish.always || !near.any(&Bounds::about(&wish.place.at, reach), is_taken);
    }
    wishes.iter().zip(is_granted).filter(|(_, granted)| *granted).map(|(wish, _)| wish.place).collect()
}
