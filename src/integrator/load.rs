//! Pressure loads on faces of the gel: each loaded facet is kicked at the ticks of the element behind it, as part of
//! that element's energy (numerics A6). The work of the pressures is booked.

use super::SteppingSchedule;
use super::blocks::SLOTS;
use super::engine::Engine;
use super::kick::ConstraintReaction;
use crate::fem::{Potential, Section, push};
use crate::math::{Vector, embed};
use crate::mesh::{ElementId, Facet, NodeId};
use crate::state::Tick;

/// Pressure history: linear between its points, constant before the first and after the last, with the depth below
/// which all of it acts.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureHistory {
    /// Times, s, and pressures, Pa.
    points: Vec<(f64, f64)>,
    /// Depth below z = 0 over which the pressure rises from zero, m; 0 if it acts at any height.
    depth: f64,
}

impl PressureHistory {
    /// Creates a pressure from ascending times, s, and the pressures there, Pa.
    ///
    /// # Panics
    /// If there is no point or the times do not ascend.
    #[must_use]
    pub fn new(points: Vec<(f64, f64)>) -> Self {
        let ascending = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
        assert!(!points.is_empty() && ascending, "a pressure has points whose times ascend");
        Self { points, depth: 0.0 }
    }

    /// Sets the depth, m, over which the pressure rises from zero at z = 0.
    #[must_use]
    pub fn below(self, depth: f64) -> Self {
        Self { depth, ..self }
    }

    /// Returns the pressure at a time, s, in Pa.
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        let after = self.points.partition_point(|(t, _)| *t <= time);
        let [before, next] = [after.saturating_sub(1), after.min(self.points.len() - 1)].map(|i| self.points[i]);
        if before.0 < next.0 && time > before.0 {
            before.1 + (next.1 - before.1) * ((time - before.0) / (next.0 - before.0))
        } else {
            before.1
        }
    }

    /// Returns the fraction of the pressure that acts at a height z, m, and its derivative with respect to depth,
    /// 1/m.
    fn part(&self, z: f64) -> (f64, f64) {
        match -z / self.depth {
            _ if self.depth == 0.0 => (1.0, 0.0),
            part if part > 0.0 && part < 1.0 => (part, 1.0 / self.depth),
            part => (if part >= 1.0 { 1.0 } else { 0.0 }, 0.0),
        }
    }
}

/// Facet under pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedFacet {
    /// Nodes of the facet, outward oriented.
    pub facet: Facet,
    /// Element that the facet bounds.
    pub behind: ElementId,
    /// Bit set of the pressures that act: bit i for the i-th.
    pub mark: u8,
}

/// Pressure loads of a gel.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureLoads {
    /// Kinematics of the gel, which tell the area that a plane facet stands for.
    pub section: Section,
    /// Pressure histories.
    pub pressures: Vec<PressureHistory>,
    /// Loaded facets.
    pub facets: Vec<LoadedFacet>,
}

impl PressureLoads {
    /// Creates a set of no loads.
    #[must_use]
    pub fn none() -> Self {
        Self { section: Section::Spatial, pressures: vec![], facets: vec![] }
    }

    /// Returns the sum of the marked pressures at a height z, m, in Pa, and the sum of their derivatives with respect
    /// to depth, Pa/m.
    fn pressure(&self, mark: u8, now: &[f64], z: f64) -> (f64, f64) {
        let named = (0..self.pressures.len()).filter(|i| mark >> i & 1 == 1);
        named.fold((0.0, 0.0), |(sum, growth), i| {
            let (part, steepness) = self.pressures[i].part(z);
            (sum + part * now[i], growth + steepness * now[i].abs())
        })
    }
}

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Returns true if any pressure acts on the gel.
    pub(super) fn is_loaded(&self) -> bool {
        !self.gel.loads.facets.is_empty()
    }

    /// Finds the pressure loads of the facets of active elements and adds their load stiffness; called before the
    /// clocks are set.
    pub(super) fn find_loads(&mut self, tick: Tick) {
        self.scratch.pushed.clear();
        self.scratch.stiffer.clear();
        if !self.is_loaded() {
            return;
        }
        let (gel, time) = (self.gel.clone(), self.grid.time(tick));
        let now: Vec<f64> = gel.loads.pressures.iter().map(|pressure| pressure.at(time)).collect();
        for (facet, loaded) in gel.loads.facets.iter().enumerate() {
            let group = self.order.group(loaded.behind);
            if self.is_group_active(group, tick) {
                let slot = self.order.slot(loaded.behind);
                let (pushed, added) = self.find_load(loaded, &now, group, tick).unzip();
                self.scratch.pushed.extend(pushed);
                let (added, before) = (added.unwrap_or(0.0), self.state.stiffness[slot]);
                self.scratch.stiffer.push(LoadStiffness { facet, slot, added, before });
            }
        }
        self.add_load_stiffness();
    }

    /// Finds the pressure load of a facet, and the stiffness that it adds to the element behind the facet, N/m.
    fn find_load(&self, loaded: &LoadedFacet, now: &[f64], group: usize, tick: Tick) -> Option<(FacetLoad<D>, f64)> {
        let (loads, time) = (&self.gel.loads, self.grid.time(tick));
        let corners = loaded.facet.map(|node| self.position_at(node, time));
        let middle = corners[..D].iter().sum::<Vector<D>>() / D as f64;
        let (pressure, growth) = loads.pressure(loaded.mark, now, middle[D - 1]);
        if pressure == 0.0 {
            return None;
        }
        let push = push(loads.section, &corners);
        // f_a = p(z) w_a A n with Σ w_a = 1 and z = Σ z_b/D: its derivative through p′ has the norm p′A|w|/√D ≤
        // p′A/√D.
        let area = push.forces.iter().sum::<Vector<D>>().norm();
        let added = pressure.abs() * push.stiffness + growth * area / (D as f64).sqrt();
        let (forces, weight) = (push.forces.map(|force| force * pressure), self.owed(group, tick));
        Some((FacetLoad { nodes: loaded.facet, forces, group, weight }, added))
    }

    /// Returns true if a group is active at this tick; called before the clocks are set.
    fn is_group_active(&self, group: usize, tick: Tick) -> bool {
        match self.blocks {
            Some(_) => self.tick_context(tick).fires(self.state.clocks[group].step),
            None => self.scratch.due.binary_search(&(group as u32)).is_ok(),
        }
    }

    /// Returns the trailing half of the kick of an active group, which belongs to the step behind, s; called before
    /// the clocks are set.
    pub(super) fn owed(&self, group: usize, tick: Tick) -> f64 {
        self.grid.length(match self.rules.schedule {
            SteppingSchedule::Queue => 0.5 * (tick - self.state.alarms[group].last) as f64,
            SteppingSchedule::Bins | SteppingSchedule::Global => {
                self.tick_context(tick).owed(self.state.clocks[group].step)
            }
        })
    }

    /// Adds the load stiffness of pressures to the stiffness of active elements. Elements of a block at rest were not
    /// swept: they take the stiffness of their last sweep without the former load stiffness, as a sweep now or a
    /// restart would give.
    pub(super) fn add_load_stiffness(&mut self) {
        let stiffness = &mut self.state.stiffness;
        if let Some(blocks) = &mut self.blocks {
            for stiffer in &self.scratch.stiffer {
                let (found, stored) = (&mut blocks.unloaded[stiffer.facet], &mut stiffness[stiffer.slot]);
                if blocks.all[stiffer.slot / SLOTS].report.is_some() {
                    *found = *stored;
                }
            }
            let is_unswept = |stiffer: &&LoadStiffness| blocks.all[stiffer.slot / SLOTS].report.is_none();
            for stiffer in self.scratch.stiffer.iter().filter(is_unswept) {
                stiffness[stiffer.slot] = blocks.unloaded[stiffer.facet];
            }
        }
        for stiffer in &self.scratch.stiffer {
            stiffness[stiffer.slot] += stiffer.added;
        }
        self.sum_nodal_stiffness();
    }

    /// Sums κ at the nodes of the blocks in which it has changed, in the order of a sweep, and requests a step check
    /// around blocks at rest.
    fn sum_nodal_stiffness(&mut self) {
        let (Some(blocks), stiffness) = (&mut self.blocks, &self.state.stiffness) else { return };
        let mut stiffened = std::mem::take(&mut self.scratch.stiffened);
        for stiffer in &self.scratch.stiffer {
            let (block, behind) = (stiffer.slot / SLOTS, self.gel.loads.facets[stiffer.facet].behind);
            // A sweep leaves out the load stiffness of the tick before.
            let (is_at_rest, was_swept) = (!blocks.all[block].is_moving(), blocks.all[block].report.is_some());
            if stiffness[stiffer.slot] == stiffer.before && !(is_at_rest && was_swept) {
                continue;
            }
            stiffened.push(block);
            if is_at_rest {
                self.gel.potential.nodes(behind).iter().for_each(|node| blocks.request_check_around(node.index()));
            }
        }
        stiffened.sort_unstable();
        stiffened.dedup();
        for block in stiffened.drain(..) {
            let (groups, own) = (blocks.groups_of(block), &blocks.all[block]);
            let part = &mut blocks.parts[own.first..own.first + own.nodes.len()];
            blocks.lanes.sum_stiffness(groups, &stiffness[block * SLOTS..], part);
        }
        self.scratch.stiffened = stiffened;
    }

    /// Kicks the nodes of the loaded facets by their pressures; held directions take up the rest.
    pub(super) fn press(&mut self, tick: Tick) {
        if self.scratch.pushed.is_empty() {
            return;
        }
        let (gel, freedom, mut taken) = (self.gel.clone(), self.freedom(), ConstraintReaction::default());
        let mut pushed = std::mem::take(&mut self.scratch.pushed);
        for pushed in &mut pushed {
            pushed.weight += 0.5 * self.grid.time(self.ahead(pushed.group, tick));
            for (node, impulse) in pushed.impulses() {
                let (a, push) = (node.index(), embed(&impulse));
                self.state.velocity[a] += impulse.component_mul(&gel.free(a)) / gel.mass[a];
                let at = embed(&self.state.position[a]);
                taken.add(&gel.free(a), freedom, (at, push));
                self.state.ledger.momentum.load += freedom.translation(&push);
                self.state.ledger.angular_momentum.load += freedom.rotation(&at.cross(&push));
                self.state.record.pressed += push.norm();
            }
        }
        taken.post(&mut self.state.ledger);
        self.scratch.pushed = pushed;
    }

    /// Iterates over the nodes of the loaded facets of this tick.
    pub(super) fn pressed(&self) -> impl Iterator<Item = NodeId> + '_ {
        self.scratch.pushed.iter().flat_map(|pushed| pushed.nodes[..D].iter().copied())
    }

    /// Returns the velocity of a node of a loaded facet before the kicks of this tick, m/s. In the block form a node
    /// that was still is not active.
    fn velocity_before_loads(&self, node: NodeId) -> Vector<D> {
        match self.scratch.carriers.binary_search_by_key(&node, |carrier| carrier.node) {
            Ok(at) if self.blocks.is_some() => self.scratch.carriers[at].before,
            _ => self.scratch.before[node.index()],
        }
    }

    /// Posts the work of the pressures, Σ J·(v⁻ + v⁺)/2, once all velocities of the tick are known.
    pub(super) fn book_loads(&mut self) {
        let work = |(node, impulse): (NodeId, Vector<D>)| {
            let velocity_sum = self.velocity_before_loads(node) + self.state.velocity[node.index()];
            0.5 * impulse.component_mul(&self.gel.free(node.index())).dot(&velocity_sum)
        };
        let work: f64 = self.scratch.pushed.iter().flat_map(FacetLoad::impulses).map(work).sum();
        self.state.ledger.energy.load += work;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pressure_is_straight_between_its_points_and_constant_outside() {
        let pressure = PressureHistory::new(vec![(1.0, 10.0), (2.0, 30.0), (4.0, 0.0)]);
        let found = [0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 9.0].map(|time| pressure.at(time));
        assert_eq!(found, [10.0, 10.0, 20.0, 30.0, 15.0, 0.0, 0.0]);
    }

    #[test]
    fn a_pressure_below_a_depth_rises_from_nothing_at_the_surface() {
        let pressure = PressureHistory::new(vec![(0.0, 8.0)]).below(0.25);
        let found = [1.0, 0.0, -0.125, -0.25, -3.0].map(|z| pressure.part(z));
        assert_eq!(found, [(0.0, 0.0), (0.0, 0.0), (0.5, 4.0), (1.0, 0.0), (1.0, 0.0)]);
        assert_eq!(PressureHistory::new(vec![(0.0, 8.0)]).part(1.0), (1.0, 0.0));
    }
}
