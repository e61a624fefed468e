//! An element by itself, by its rest shape and its shape, outside any mesh.

use super::one_lane::LoneElement;
use crate::constitutive::{Material, MaterialRatios, VolumetricEnergy};
use crate::fem::history::{HistoryLanes, MOST_ROWS};
use crate::fem::law::element_law::{ElementDeformation, ElementLaw, LawInput, VolumetricSlopes};
use crate::fem::{GroupKick, HistoryVariables, ReferenceShape, Section};
use crate::math::array;

/// Law of elements outside any mesh.
#[derive(Debug, Clone, Copy)]
pub struct SingleElementLaw {
    /// Material.
    pub material: Material,
    /// Kinematic model.
    pub section: Section,
    /// True if the elements share their change of volume in patches.
    pub has_patches: bool,
}

/// Response of an element by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SingleElementResponse {
    /// Rest volume, m³.
    pub volume: f64,
    /// Stored energy, J, without the volumetric part that is common to a patch.
    pub energy: f64,
    /// Upper bound κ of the greatest eigenvalue of the stiffness matrix, N/m.
    pub stiffness: f64,
    /// J = det F.
    pub jacobian: f64,
}

/// Evaluates `$body` with the law `$gel` of a material.
macro_rules! by_material {
    ($material:expr, $gel:ident => $body:expr) => {
        match $material {
            Material::NeoHookean($gel) => $body,
            Material::MooneyRivlin($gel) => $body,
            Material::Ogden($gel) => $body,
            Material::TwoNetwork($gel) => $body,
        }
    };
}

impl SingleElementLaw {
    /// Evaluates an element of this rest shape and this shape; `memory` holds its history variables.
    #[must_use]
    pub fn evaluate<const D: usize>(
        &self,
        rest: &ReferenceShape<D>,
        now: &ReferenceShape<D>,
        memory: &[HistoryVariables<D>],
    ) -> SingleElementResponse {
        by_material!(&self.material, gel => self.evaluate_by_law(gel, rest, now, memory))
    }

    /// Returns the volumetric energy density that is common to the elements of a patch, by their mean J, J/m³.
    #[must_use]
    pub fn common_energy(&self, jacobian: f64) -> f64 {
        fn shared<G: ElementLaw<2>>(gel: &G, jacobian: f64) -> f64 {
            gel.volume().shared(jacobian).energy
        }
        if self.has_patches { by_material!(&self.material, gel => shared(gel, jacobian)) } else { 0.0 }
    }

    fn evaluate_by_law<const D: usize, G: ElementLaw<D>>(
        &self,
        gel: &G,
        rest: &ReferenceShape<D>,
        now: &ReferenceShape<D>,
        memory: &[HistoryVariables<D>],
    ) -> SingleElementResponse {
        let LoneElement { volume, scale, rest } = LoneElement::of(gel, self.section, rest, MaterialRatios::GEL);
        let mut strain = ElementDeformation::at_rest(0.0);
        strain.f = array::rows(&now.edges);
        strain.deform::<G>(self.section, &rest, volume, scale, 1.0, 3.0 * now.radius);
        let jacobian = strain.jacobian();
        let whole = gel.volume().volumetric(jacobian);
        let own = if self.has_patches { gel.volume().own(jacobian).energy } else { whole.energy };
        let slopes = VolumetricSlopes { slope: whole.slope, curvature: whole.curvature.max(0.0) };
        let mut rows = [0.0; MOST_ROWS];
        gel.store_history(&mut rows[..gel.rows()], memory);
        let mut history = rows.map(HistoryLanes);
        let history = &mut history[..gel.rows()];
        let input = LawInput { volume, scale, rest: &rest, kick: GroupKick::NONE, history };
        let forces = gel.evaluate(self.section, input, &strain, &slopes);
        let energy = forces.energy + volume * own;
        SingleElementResponse { volume, energy, stiffness: forces.stiffness, jacobian }
    }
}
