//! Settings of remeshing: method, criteria of distortion, and target edge lengths.

use crate::constitutive::ElasticAverage;
use serde::{Deserialize, Serialize};

/// Method that makes a new mesh from an old one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum RemeshMethod {
    /// Local remeshing: operations on elements that hinder the step. They keep the rest map of a gel without history
    /// variables; those of a two-network gel are performed in its present shape. Where they do not suffice, the immersed
    /// method makes a mesh in the plane and about an axis.
    #[serde(alias = "retained")]
    Local,
    /// Immersed method of the original paper: the gel is cut out of the triangulation of a quadtree. Only corners and
    /// the ends of supports are retained.
    Immersed,
}

/// Settings of remeshing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AdaptSettings {
    pub method: RemeshMethod,
    /// Least element quality: an element shaped worse triggers remeshing.
    pub quality: f64,
    /// Least ratio of current to rest volume: an element compressed further triggers remeshing.
    pub min_volume_ratio: f64,
    /// True for sizes that follow the fields and bodies, false for the usual edge everywhere.
    pub adaptive: bool,
    /// Least target edge, m.
    pub least: f64,
    /// Edge of the first mesh where it is finest, and near bodies, m.
    pub usual: f64,
    /// Longest target edge, m.
    pub longest: f64,
    /// Target edge at the axial ends and corners of bodies, m, if not the usual one.
    pub tip_size: Option<f64>,
    /// Curvature angle of displacement or velocity between adjacent elements, rad.
    pub curvature_angle: f64,
    /// Greatest growth of the target edge per distance.
    pub growth: f64,
    /// Thickness below which gel is eroded when the mesh is replaced, m.
    pub erosion_thickness: Option<f64>,
    /// Rule by which new elements of a two-network gel get their elastic state.
    pub average: ElasticAverage,
}

/// Quality by which a mesh is remade that ends by inverted elements alone.
const REPAIRED: f64 = 0.3;

impl AdaptSettings {
    /// Settings of the operations. Where only inverted elements end a mesh, elements beside them that are about to invert are
    /// remade with them: `sphere-deep` about an axis took 20 000 remeshings otherwise.
    #[must_use]
    pub fn of_operations(mut self) -> Self {
        if self.quality == 0.0 {
            self.quality = REPAIRED;
        }
        self
    }
}
