//! Elements that hinder the gel: how much, and which do.

use super::adaptive_gel::AdaptiveGel;
use super::layer_parts::parts_at_rest;
use super::settings::AdaptSettings;
use crate::constitutive::{LayerStack, MaterialRatios};
use crate::fem::{Potential, ReferenceShape, Section, SingleElementLaw, SingleElementResponse};
use crate::math::Vector;
use crate::mesh::{CORNERS, ElementId, Simplex, facet_measure, poor_quality, signed_volume};
use crate::remesh::operations::{ElementModel, ElementState};
use crate::state::MeshInstance;

/// Frequency, as a fraction of the one that ends a mesh, from which elements are remade with the others: elements that
/// would end the next mesh soon. It halves the number of remeshings of the ball of `sphere-deep`.
const ANTICIPATION: f64 = 0.7;
/// Quality of a gel that flows at which a mesh ends, as a fraction of the one below which elements are remade.
const POOR: f64 = 0.5;
/// Quality of an element that is never remade for its shape.
const FAIR: f64 = 0.6;
/// Greatest relative change of the volume of a cavity by an operation that smooths the surface of a gel that flows.
const SMOOTHING: f64 = 0.05;
/// Energy of the compression by that change, relative to the energy provided. With the change alone bounded, the smoothed rim of
/// coarse cells gave `fbi-bb-3d` 2.4 % of E₀ on cells of R/5 and 4.2 % on R/3; it is 0.1 and 0.2 % with 1e-4.
const SMOOTHING_ENERGY: f64 = 1e-4;

/// Elements of a gel without history variables.
pub(super) struct ElasticElements {
    law: SingleElementLaw,
    /// Layers on the gel.
    layers: Option<LayerStack>,
    /// Density of the gel, kg/m³.
    density: f64,
    /// Frequency above which an element is remade, 1/s.
    frequency: f64,
    /// J below which an element is remade.
    jacobian: f64,
}

/// Elements of a gel that flows, judged by their present shape: by their least height, which sets the step, and by their
/// quality.
pub(super) struct FlowingElements {
    /// Height, m, below which an element is remade.
    height: f64,
    /// Quality below which an element is remade.
    quality: f64,
    /// True if an element is a ring.
    is_ring: bool,
    /// Volume 2e/K by the [`SMOOTHING_ENERGY`] e, m³ or per thickness or angle: a volume w may change by its part √(2e/Kw).
    smoothed: f64,
}

impl ElasticElements {
    /// Elements of a gel.
    pub fn of<const D: usize>(gel: &AdaptiveGel<D>, settings: &AdaptSettings) -> Self {
        let law = SingleElementLaw {
            material: gel.definition.material,
            section: gel.definition.section,
            has_patches: gel.definition.has_patches,
        };
        let (density, jacobian) = (gel.definition.density, settings.min_volume_ratio);
        let layers = gel.definition.layers.clone();
        Self { law, layers, density, frequency: greatest_frequency(gel, settings), jacobian }
    }
}

impl FlowingElements {
    /// Elements of a gel to which this energy, J, has been provided: an element of height h and wave speed c has the frequency
    /// √(D + 1) c/h, in the fastest of layers.
    pub fn of<const D: usize>(gel: &AdaptiveGel<D>, settings: &AdaptSettings, provided: f64) -> Self {
        let modulus = gel.definition.material.wave_modulus();
        let speed = (modulus / gel.definition.density).sqrt() * gel.definition.greatest_speed();
        let height = ((D + 1) as f64).sqrt() * speed / greatest_frequency(gel, settings);
        let section = gel.definition.section;
        let smoothed = 2.0 * SMOOTHING_ENERGY * provided / (gel.definition.greatest_modulus() * section.extent());
        let is_ring = section == Section::Axisymmetric;
        Self { height, quality: poor_quality_of(settings), is_ring, smoothed }
    }
}

/// Quality below which an element of a gel that flows is remade.
fn poor_quality_of(settings: &AdaptSettings) -> f64 {
    (settings.quality / POOR).min(FAIR).max(settings.quality)
}

/// Frequency above which an element is remade, 1/s.
fn greatest_frequency<const D: usize>(gel: &AdaptiveGel<D>, settings: &AdaptSettings) -> f64 {
    ANTICIPATION * gel.engine.frequency_of_step(gel.least_step(settings))
}

/// Elements that hinder a gel, ascending.
pub(super) fn hindering_elements<const D: usize>(
    gel: &AdaptiveGel<D>,
    old: &MeshInstance<D>,
    settings: &AdaptSettings,
) -> Vec<ElementId> {
    let (potential, position) = (&gel.engine.gel().potential, &gel.engine.state().position);
    let mass = |element: usize| old.corner_mass[element][..=D].iter().sum();
    let mut bad = gel.engine.elements_above(greatest_frequency(gel, settings), mass);
    let quality = if gel.flows() { poor_quality_of(settings) } else { 0.0 };
    let is_poor = |nodes: &Simplex| quality > 0.0 && poor_quality(position, nodes, quality) < quality;
    let all = (0..).map(ElementId).zip(potential.elements());
    bad.extend(
        all.filter(|(element, nodes)| is_poor(nodes) || compression(gel, settings, *element) > 1.0).map(|(e, _)| e),
    );
    bad.sort_unstable();
    bad.dedup();
    bad
}

/// Compression of an element: the least J of the settings over its own; infinite if it is inverted.
fn compression<const D: usize>(gel: &AdaptiveGel<D>, settings: &AdaptSettings, element: ElementId) -> f64 {
    let (potential, position) = (&gel.engine.gel().potential, &gel.engine.state().position);
    let corners = potential.elements()[element.index()].map(|node| position[node.index()]);
    let measure = potential.measure(&corners);
    if measure > 0.0 { settings.min_volume_ratio * potential.rest_measure(element) / measure } else { f64::INFINITY }
}

/// Elements among these that are compressed beyond the limit, with the limit over their J. An element of a patch is not
/// held by its own J, and a ring at the axis may close.
pub(super) fn compressed_elements<const D: usize>(
    gel: &AdaptiveGel<D>,
    settings: &AdaptSettings,
    elements: &[ElementId],
) -> Vec<(ElementId, f64)> {
    let compression = |element: &ElementId| (*element, compression(gel, settings, *element));
    elements.iter().map(compression).filter(|(_, compression)| *compression > 1.0).collect()
}

impl<const D: usize> ElementModel<D> for ElasticElements {
    fn state(&self, rest: &[Vector<D>; 4], now: &[Vector<D>; 4]) -> ElementState {
        let mixed = |stack: &LayerStack| stack.mixed(&parts_at_rest(stack, self.law.section, rest));
        let MaterialRatios { strength, density, .. } = self.layers.as_ref().map_or(MaterialRatios::GEL, mixed);
        let [rest, now] = [rest, now].map(|x| ReferenceShape::of(x, &CORNERS));
        let SingleElementResponse { volume, energy, stiffness, jacobian } = self.law.evaluate(&rest, &now, &[]);
        let (energy, stiffness) = (strength * energy, strength * stiffness);
        let frequency = ((D + 1) as f64 * stiffness / (density * self.density * volume)).sqrt() / self.frequency;
        let is_positive = jacobian > 0.0 && frequency.is_finite();
        let hindrance = if is_positive { frequency.max(self.jacobian / jacobian) } else { f64::INFINITY };
        ElementState { volume, jacobian, density, strength, energy, hindrance }
    }

    fn common_energy(&self, jacobian: f64) -> f64 {
        self.law.common_energy(jacobian)
    }

    fn smoothing(&self, _: f64) -> f64 {
        0.0
    }
}

impl<const D: usize> ElementModel<D> for FlowingElements {
    fn state(&self, _: &[Vector<D>; 4], now: &[Vector<D>; 4]) -> ElementState {
        let volume = signed_volume(now, &CORNERS);
        let facet =
            |k: usize| facet_measure(now, &std::array::from_fn(|i| CORNERS[if i < k { i } else { i + 1 }.min(D)]));
        let widest = (0..=D).map(facet).fold(0.0, f64::max);
        let height = D as f64 * volume / widest;
        let flat = self.height / height;
        // A better shape hinders less than the height.
        let quality = poor_quality(now, &CORNERS, self.quality / flat);
        let hindrance = if volume > 0.0 { flat.max(self.quality / quality) } else { f64::INFINITY };
        let radius = if self.is_ring { ReferenceShape::of(now, &CORNERS).radius } else { 1.0 };
        ElementState { volume: volume * radius, jacobian: 1.0, density: 1.0, strength: 1.0, energy: 0.0, hindrance }
    }

    fn common_energy(&self, _: f64) -> f64 {
        0.0
    }

    fn smoothing(&self, volume: f64) -> f64 {
        SMOOTHING.min((self.smoothed / volume).sqrt())
    }
}
