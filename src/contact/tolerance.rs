//! Depths at which contact acts, in element sizes (method 2.5, 2.6).

/// Depth at which a facet is stopped at its deepest point, in the smaller of element size and inner radius of the
/// body. A body sharper than the mesh, or one over which the surface is stretched, must not slip between nodes. Nodes
/// alone carry shallower contact, because holding all facets at the surface would lift their nodes off a curved body.
///
/// At 0.2 the depth of `sphere-block` falls from 14.166 to 14.149 mm (14.5 when converged); from 0.3 on it does not
/// change a bit. Larger values stretch the surface further: at 0.4 the ball of 20 m/s inverts cells of 3.57 mm, which
/// at 0.3 bring it through and back. A blunt ogive on cells of half its radius gets 8 % more impulse at 0.3 than on
/// fine ones, 2 % at 0.4.
const FACE_DEPTH: f64 = 0.3;

/// Facet depth, as [`FACE_DEPTH`], of a remeshed gel in space with history variables. The surface is drawn over the
/// body and remeshing splits the facets; facets split deep in the body have to be pushed out. The energy that this
/// adds in the first 0.3 ms of `fbi-bb-3d`, relative to that of the shot, is 6.5 % at 0.3, 1.6 % at 0.1, 0.9 % at
/// 0.06 and 0.7 % at 0.02. A facet stopped late also turns about the stopped point. At 0.3 the nose of `bullet-yaw`,
/// with cells of 0.39 mm, leaks after 6 mm; at 0.06 it does not.
///
/// Twice [`SLOP`], to let nodes carry flat contact. The slop of the nodes is equal: at 0.03 contact pushed out the
/// nodes of split facets, by 0.8 % of the energy of `fbi-bb-3d`; at 0.06 by 0.15 %.
const DRAWN_DEPTH: f64 = 2.0 * SLOP;

/// Tolerance above the surface within which a node counts as inside, in element sizes. For a node that rests on a
/// moving body at a distance of exactly zero, rounding would decide, and each miss costs an impact. The rebound of a
/// mass that starts in touch with a bar was 2.3 % off. Rounding is ten thousand times smaller.
pub(super) const TOUCH_TOLERANCE: f64 = 1e-9;

/// Upper bound of the bias velocity, as a fraction of the greatest approach speed so far (method 2.5).
pub(super) const BIAS_CAP: f64 = 0.1;

/// Penetration slop: the depth that the bias velocity leaves standing, in element sizes. Removing all penetration
/// pushes nodes off that fall back for ever, and pumps energy through the contact. On `sphere-block` the gain is
/// 4.7 % of the impact energy at 0, 0.05 % at 0.01 and nothing at 0.03. Under an oblique ball on a coarse mesh it is
/// 0.4 % at 0.01 and nothing at 0.03. The mean standing penetration does not grow with the slop: it is 0.005 to 0.008
/// where 0.01 is allowed (A7), because approaching nodes are found at that depth.
pub(super) const SLOP: f64 = 0.03;

/// Depths that depend on how the surface is used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactTolerances {
    /// Depth at which a facet is stopped, in the smaller of element size and inner radius of the body.
    pub facet_depth: f64,
    /// Penetration slop of a node, in element sizes.
    pub slop: f64,
}

impl ContactTolerances {
    /// Returns the depths of a surface, `is_drawn` if it is drawn over the body throughout the run: a gel in space with
    /// history variables that is remeshed.
    pub fn new(is_drawn: bool) -> Self {
        if is_drawn {
            Self { facet_depth: DRAWN_DEPTH, slop: DRAWN_DEPTH }
        } else {
            Self { facet_depth: FACE_DEPTH, slop: SLOP }
        }
    }
}
