//! Fields of the gel in a frame: element values from the constitutive state, and their means at the nodes.

use super::observe::FrameField;
use crate::constitutive::MaterialParts;
use crate::fem::{DEPTH, Potential, Simplices, StressInvariants};
use crate::integrator::Engine;
use crate::math::Vector;
use crate::mesh::{ElementId, NodeId};
use crate::scene::OutputField;

/// Engine of a gel at one instant, with the positions of its nodes there.
pub(super) struct FieldSource<'a, const D: usize> {
    engine: &'a Engine<D, Simplices<D>>,
    /// Number of symmetric copies, which scale the stresses.
    copies: f64,
    positions: Vec<Vector<D>>,
}

impl<'a, const D: usize> FieldSource<'a, D> {
    /// Drifts the nodes to time `t`, s.
    pub fn new(engine: &'a Engine<D, Simplices<D>>, copies: f64, t: f64) -> Self {
        let t = engine.time_in_gel(t);
        let positions = (0..engine.gel().mass.len() as u32).map(|node| engine.position_at(NodeId(node), t)).collect();
        Self { engine, copies, positions }
    }

    /// Evaluates fields.
    pub fn evaluate(&self, fields: &[OutputField]) -> Vec<FrameField> {
        let needs_stress = |field: &OutputField| matches!(field, OutputField::Pressure | OutputField::VonMises);
        let stresses = if fields.iter().any(needs_stress) { self.stresses() } else { vec![] };
        let volumes: Vec<f64> = self.elements().map(|element| self.potential().volume(element)).collect();
        let field = |field: &OutputField| {
            let cells = self.cells(*field, &stresses);
            FrameField { name: field.name(), unit: field.unit(), points: self.nodal_means(&cells, &volumes), cells }
        };
        fields.iter().map(field).collect()
    }

    fn potential(&self) -> &Simplices<D> {
        &self.engine.gel().potential
    }

    fn elements(&self) -> impl Iterator<Item = ElementId> + use<D> {
        (0..self.potential().len() as u32).map(ElementId)
    }

    /// Evaluates the stresses of all elements, patch by patch, Pa.
    fn stresses(&self) -> Vec<StressInvariants> {
        let (potential, memory) = (self.potential(), &self.engine.state().memory);
        let mut stresses = vec![StressInvariants::default(); potential.len()];
        for patch in 0..potential.patches().len() {
            let own: [_; DEPTH] = potential.stress_invariants(patch, &self.positions, memory);
            for (element, StressInvariants { pressure, von_mises }) in potential.patches().of(patch).iter().zip(own) {
                stresses[element.index()] =
                    StressInvariants { pressure: pressure / self.copies, von_mises: von_mises / self.copies };
            }
        }
        stresses
    }

    /// Returns the element values of a field.
    fn cells(&self, field: OutputField, stresses: &[StressInvariants]) -> Vec<f64> {
        let (potential, state) = (self.potential(), self.engine.state());
        match field {
            OutputField::Pressure => stresses.iter().map(|stress| stress.pressure).collect(),
            OutputField::VonMises => stresses.iter().map(|stress| stress.von_mises).collect(),
            OutputField::StrainRate => {
                let rate = |element| potential.strain_rate(element, &self.positions, &state.velocity);
                self.elements().map(rate).collect()
            }
            OutputField::ViscousStrain => {
                self.elements().map(|element| potential.viscous_strain(element, &state.memory)).collect()
            }
            OutputField::Layer => {
                let number = |parts: &MaterialParts| (0..).zip(parts).map(|(n, part)| f64::from(n) * part).sum();
                potential.material_parts().iter().map(number).collect()
            }
            OutputField::Damage => {
                let records = potential.memories();
                self.elements().map(|element| state.memory[element.index() * records].damage).collect()
            }
        }
    }

    /// Returns the mean of the elements around each node, by rest volume; 0 at a node without elements.
    fn nodal_means(&self, cells: &[f64], volumes: &[f64]) -> Vec<f64> {
        let (mut sums, mut weights) = (vec![0.0; self.positions.len()], vec![0.0; self.positions.len()]);
        for element in self.elements() {
            let volume = volumes[element.index()];
            for node in self.potential().nodes(element) {
                sums[node.index()] += volume * cells[element.index()];
                weights[node.index()] += volume;
            }
        }
        sums.iter().zip(weights).map(|(sum, weight)| if weight > 0.0 { sum / weight } else { 0.0 }).collect()
    }
}
