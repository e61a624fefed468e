//! Tables of the gel, and its extent at rest. The field docs are the descriptions that an editor shows; units are SI.

use super::{
    BranchSpec, CavitySpec, ConstantsSpec, DamageSpec, MaterialModel, Preset, TermSpec, ViscositySpec, VolumeSpec,
};
use crate::constitutive::OgdenTerm;
use crate::math::Vector3;
use serde::{Deserialize, Serialize};

/// Gelatin target: shape, material, supports and initial velocity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct GelSpec {
    /// Shape and size. The entry surface of a block or cylinder is z = 0, the gel lies below it.
    pub shape: GelShape,
    /// Named gel, whose values fill the keys of this table that the scene does not set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<Preset>,
    /// Material model; with a preset `two-network` if absent.
    pub material: MaterialModel,
    /// Mass density at rest, kg/m3.
    pub density: f64,
    /// Shear modulus at rest, Pa. Of a `two-network` gel it is that of the elastic network, which is the long-term
    /// modulus; 0 for none. For `mooney-rivlin` and `ogden` it follows from their constants.
    pub shear_modulus: f64,
    /// Bulk modulus at rest, Pa.
    pub bulk_modulus: f64,
    /// Damage of the elastic network (`two-network` only); none if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damage: Option<DamageSpec>,
    /// Factor on all moduli and dashpot stresses of the networks together (`two-network` only); 1 if absent. Relaxation
    /// times remain.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub strength_scale: f64,
    /// Equation of state: pressure as a function of volume (`two-network` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume: Option<VolumeSpec>,
    /// Bulk viscosity, which spreads shocks over elements (`two-network` only); none if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub viscosity: Option<ViscositySpec>,
    /// Mooney-Rivlin constants C1 and C2 (`mooney-rivlin` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constants: Option<ConstantsSpec>,
    /// Ogden terms in powers of the principal stretches (`ogden` only): 1 to 3.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub terms: Vec<TermSpec>,
    /// Viscous branches, which stiffen the gel at high strain rate (`two-network` only): none to 3.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub branches: Vec<BranchSpec>,
    /// Supports of the faces; a face that is not named is free.
    #[serde(default)]
    pub supports: SupportSpec,
    /// Air in the cavity behind the projectile; `vented` if absent.
    #[serde(default, skip_serializing_if = "CavitySpec::is_vented")]
    pub cavity: CavitySpec,
    /// Part of the gel that is computed (a spatial block only); the mirror images move alike.
    #[serde(default, skip_serializing_if = "GelSymmetry::is_none")]
    pub symmetry: GelSymmetry,
    /// Contact of the gel with itself, where a cavity closes or a rim curls; `auto` if absent.
    #[serde(default, skip_serializing_if = "SelfContactMode::is_auto")]
    pub self_contact: SelfContactMode,
    /// Thickness of a planar gel, m; 1 if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thickness: Option<f64>,
    /// Initial velocity of the whole gel, m/s.
    #[serde(default)]
    pub velocity: [f64; 3],
}

fn one() -> f64 {
    1.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
fn is_one(number: &f64) -> bool {
    *number == 1.0
}

impl GelSpec {
    /// Terms of an Ogden gel.
    #[must_use]
    pub fn ogden_terms(&self) -> Vec<OgdenTerm> {
        self.terms.iter().map(OgdenTerm::from).collect()
    }
}

/// Shape of the gel at rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum GelShape {
    /// Block, centred on the z axis below z = 0.
    Block {
        /// Edge lengths, m: [x, y, z] in `spatial`, [x, z] in `planar`.
        size: Vec<f64>,
    },
    /// Cylinder about the z axis below z = 0.
    Cylinder {
        /// Radius, m.
        radius: f64,
        /// Height, m.
        height: f64,
        /// Radius of a bore along the axis, m (`axisymmetric` only); none if absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bore: Option<f64>,
    },
    /// Lower half of a hollow sphere about the origin, its flat face at z = 0 (`axisymmetric` only). With rollers at
    /// `z_max` it represents the whole sphere. Cells grow with the distance from the centre.
    Shell {
        /// Radius of the inner surface, m.
        inner: f64,
        /// Radius of the outer surface, m.
        outer: f64,
    },
    /// L-shaped beam: two legs of equal length at a right angle, the outer corner pointing down, standing at
    /// `corner`.
    LBeam {
        /// Length of each leg along its outer edge, m.
        leg: f64,
        /// Thickness of each leg in its plane, m.
        thickness: f64,
        /// Width across the plane, m (`spatial` only; `planar` uses `gel.thickness`).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        width: Option<f64>,
        /// Angle of the first leg from the x axis towards z, degrees: at 45 the beam stands on its corner.
        angle: f64,
        /// Position of the outer corner, m.
        corner: [f64; 3],
    },
}

/// Part of the gel that is computed; masses, forces and energies are those of the whole gel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum GelSymmetry {
    /// Whole gel.
    #[default]
    None,
    /// Half at y ≥ 0: bodies move in the plane y = 0.
    Half,
    /// Quarter at x ≥ 0 and y ≥ 0: bodies move along z.
    Quarter,
}

impl GelSymmetry {
    /// Returns true if the whole gel is computed.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::None
    }

    /// Number of copies of the computed part that make the whole gel.
    #[must_use]
    pub fn copies(self) -> f64 {
        f64::from(1 << self.mirrored().len())
    }

    /// Axes normal to the planes of symmetry.
    #[must_use]
    pub fn mirrored(self) -> &'static [usize] {
        match self {
            Self::None => &[],
            Self::Half => &[1],
            Self::Quarter => &[0, 1],
        }
    }
}

/// Contact of the gel with itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum SelfContactMode {
    /// On where gel flows far: in a two-network gel and where the mesh is remade. A fixed mesh ends before its surface folds.
    #[default]
    Auto,
    /// Surfaces pass through each other, except at an axis or a plane of symmetry.
    Off,
    /// The surface is stopped where it meets itself, whatever the gel.
    On,
}

impl SelfContactMode {
    /// Returns true if the scene decides.
    #[must_use]
    pub fn is_auto(&self) -> bool {
        *self == Self::Auto
    }
}

/// Support of one face of the gel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum FaceSupport {
    /// Not supported.
    #[default]
    Free,
    /// Held normal to the face, free to slide along it.
    Roller,
    /// Held in every direction.
    Fixed,
}

/// Supports of the faces of a block, cylinder or shell.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct SupportSpec {
    /// Face of least x of a block.
    pub x_min: FaceSupport,
    /// Face of greatest x of a block.
    pub x_max: FaceSupport,
    /// Face of least y of a spatial block.
    pub y_min: FaceSupport,
    /// Face of greatest y of a spatial block.
    pub y_max: FaceSupport,
    /// Back face (bottom) of a block or cylinder.
    pub z_min: FaceSupport,
    /// Entry surface of a block or cylinder, flat face of a shell.
    pub z_max: FaceSupport,
    /// Lateral surface of a cylinder (`roller` in `axisymmetric` only), outer surface of a shell (`fixed` only).
    pub side: FaceSupport,
}

/// Bounding box of a gel at rest, m; infinite across the plane of a planar gel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GelBox {
    /// Lower corner.
    pub lower: Vector3,
    /// Upper corner.
    pub upper: Vector3,
}

impl GelShape {
    /// Thickness from the entry surface to the back face at rest, m; `None` for a shape without a flat back face.
    #[must_use]
    pub fn thickness(&self) -> Option<f64> {
        match self {
            Self::Block { size } => size.last().copied(),
            Self::Cylinder { height, .. } => Some(*height),
            Self::Shell { .. } | Self::LBeam { .. } => None,
        }
    }

    /// Bounding box of a block or a cylinder at rest.
    #[must_use]
    pub fn bounding_box(&self) -> Option<GelBox> {
        let [x, y] = match self {
            Self::Block { size } if size.len() == 3 => [0.5 * size[0], 0.5 * size[1]],
            Self::Block { size } => [0.5 * size[0], f64::INFINITY],
            Self::Cylinder { radius, .. } => [*radius; 2],
            Self::Shell { .. } | Self::LBeam { .. } => return None,
        };
        Some(GelBox { lower: Vector3::new(-x, -y, -self.thickness()?), upper: Vector3::new(x, y, 0.0) })
    }
}
