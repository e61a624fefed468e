//! Table of the criteria and sizes of remeshing.

use crate::constitutive::ElasticAverage;
use serde::{Deserialize, Serialize};

pub use crate::adapt::RemeshMethod;

/// Remeshing: criteria for a distorted mesh, method, and element sizes of the new mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct RemeshSpec {
    /// Method that makes the new mesh.
    pub method: RemeshMethod,
    /// Least element quality: an element shaped worse triggers remeshing. 1 is equilateral, 0 flat. With 0 only an
    /// inverted element does. For a gel without history variables, whose shapes ask for nothing, 0.3 stands
    /// for an eighth of the least stable step of the first mesh, in proportion.
    pub quality: f64,
    /// Least ratio of current to rest volume: an element compressed further triggers remeshing.
    pub min_volume_ratio: f64,
    /// Times at which the mesh is replaced whether distorted or not, s, ascending.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub times: Vec<f64>,
    /// True for a mesh that is fine where the fields are curved and near bodies, and coarse elsewhere; false for
    /// `mesh.size` everywhere.
    pub adaptive: bool,
    /// Least target edge length, m; half of `mesh.size` if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smallest: Option<f64>,
    /// Target edge length at the axial ends and at the corners of bodies, m, for a nose sharper than the mesh around
    /// the body. It grows by `growth` with the distance. `mesh.size` if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip_size: Option<f64>,
    /// Curvature indicator: angle by which the graph of displacement or velocity over the gel may bend between
    /// adjacent elements, degrees. 180 disables the indicator.
    pub curvature_angle: f64,
    /// Greatest growth of the target edge length per distance.
    pub growth: f64,
    /// Thickness below which sheets of gel are eroded when the mesh is replaced, m; the eroded gel flies on as drops
    /// without further contact. If absent, erosion is the last resort when every new mesh is refused. It then removes
    /// gel thinner than a hundredth of the least edge, or gel that no mesh can follow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub erosion_thickness: Option<f64>,
    /// Rule by which a new element of a two-network gel gets its elastic state from the matter that it is made of.
    #[serde(skip_serializing_if = "is_usual")]
    pub elastic_average: ElasticAverage,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
fn is_usual(average: &ElasticAverage) -> bool {
    *average == ElasticAverage::default()
}

impl Default for RemeshSpec {
    fn default() -> Self {
        Self {
            method: RemeshMethod::Local,
            quality: 0.3,
            min_volume_ratio: 0.1,
            times: vec![],
            adaptive: true,
            smallest: None,
            tip_size: None,
            curvature_angle: 15.0,
            growth: 0.3,
            erosion_thickness: None,
            elastic_average: ElasticAverage::default(),
        }
    }
}
