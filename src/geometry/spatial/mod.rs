//! Search trees: bounding volume hierarchy over boxes, and orthtree (quadtree or octree) over cells.

mod bounds;
mod bvh;
mod orthtree;

pub(crate) use bounds::{BoundingBox, morton_order};
pub(crate) use bvh::Bvh;
pub(crate) use orthtree::{
    CellContact, CellDivision, FaceNeighbour, OrthCell, OrthTree, cell_indices, morton_code, subdivide,
};
