use ballistic_gel::algebra::Vector;
use ballistic_gel::avi::{Engine, Gel};
use ballistic_gel::element::{Potential as _, Simplices};
use ballistic_gel::mesh::{ElementId, NodeId};

/// The stable step of each element at these positions, s, not rounded to anything: the integrator's nodal rule,
/// CFL min over its nodes a of 2/√λ_a with λ_a = Σ_{K∋a} κ_K/m_a.
pub fn stable_steps(gel: &Gel<3, Simplices<3>>, x: &[Vector<3>], cfl: f64) -> Vec<f64> {
    let mut forces = [Vector::<3>::zeros(); 4];
    let elements = (0..gel.potential.len()).map(|e| ElementId(e as u32));
    let stiffness: Vec<f64> = elements.clone().map(|e| gel.potential.evaluate(e, x, &mut forces).stiffness).collect();
    let limit = |node: &NodeId| {
        let around: f64 = gel.star.of(*node).iter().map(|e| stiffness[e.index()]).sum();
        2.0 / (around / gel.mass[node.index()]).sqrt()
    };
    elements.map(|e| cfl * gel.potential.nodes(e).iter().map(limit).fold(f64::INFINITY, f64::min)).collect()
}

/// Σ_K 1/Δt_K now, 1/s: updates in a second if every element took its own stable step.
pub fn rate(engine: &Engine<3, Simplices<3>>, t: f64, cfl: f64) -> f64 {
    let gel = engine.gel();
    let x: Vec<Vector<3>> = (0..gel.mass.len()).map(|i| engine.position_at(NodeId(i as u32), t)).collect();
    stable_steps(gel, &x, cfl).iter().map(|step| 1.0 / step).sum()
}
