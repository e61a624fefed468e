//! The table of when and how the mesh is exchanged.

use serde::{Deserialize, Serialize};

/// When the mesh is exchanged for a new one, how that is made, and how fine it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Remesh {
    /// How the new mesh is made.
    pub method: RemeshMethod,
    /// An element shaped worse than this wears the mesh out: 1 is equilateral, 0 flat. With 0 only one that is turned inside out
    /// does.
    pub quality: f64,
    /// So does one that is compressed to less than this part of its volume.
    pub compression: f64,
    /// Times at which the mesh is exchanged, worn or not, s, ascending.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub times: Vec<f64>,
    /// Whether a new mesh is fine where the fields bend and where a body is near, and coarse elsewhere; if not, it has
    /// `mesh.size` everywhere.
    pub adaptive: bool,
    /// Shortest edge that is asked for, m; half of `mesh.size` if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smallest: Option<f64>,
    /// Edge at the ends of bodies on their axes and at their corners, m, from which it grows by `growth` as elsewhere: a nose that is
    /// sharper than the mesh around the body; `mesh.size` there, too, if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip: Option<f64>,
    /// Angle by which displacement or velocity, drawn over the gel, may bend between two elements beside each other, degrees;
    /// at 180 their bends ask for nothing.
    pub bend: f64,
    /// Edges may grow by so much per length of distance.
    pub growth: f64,
    /// Sheets of gel thinner than this break off when the mesh is exchanged, and fly on as drops that nothing meets again, m; if absent,
    /// only what is thinner than a hundredth of the least edge or no mesh can follow, and only where no mesh is taken with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thinnest: Option<f64>,
}

impl Default for Remesh {
    fn default() -> Self {
        Self {
            method: RemeshMethod::Retained,
            quality: 0.3,
            compression: 0.2,
            times: vec![],
            adaptive: true,
            smallest: None,
            tip: None,
            bend: 15.0,
            growth: 0.3,
            thinnest: None,
        }
    }
}

/// How a new mesh is made of an old one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum RemeshMethod {
    /// The old nodes and the old surface are kept where they are good, points of a quadtree fill the rest.
    Retained,
    /// The paper's: the gel is immersed in the triangulation of a quadtree and cut out of it; only corners and the ends of
    /// what is held are kept.
    Immersed,
}
