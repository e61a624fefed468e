//! Which nodes of the surface are near a body at a tick, and how near.

use super::blocks::Due;
use super::engine::Engine;
use super::gel::SurfaceNode;
use super::impact::STRETCH;
use crate::algebra::embed;
use crate::element::Potential;
use crate::geometry::Gap;
use crate::state::Tick;

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// φ and n of the active surface nodes to the active bodies, where a body may be within reach.
    pub(super) fn look_around(&mut self, tick: Tick) {
        for surface in self.scratch.reached.drain(..) {
            self.scratch.place[surface as usize] = u32::MAX;
        }
        self.watch.go_on(self.grid.time(tick), &self.scratch.was);
        self.placed = true;
        let horizon = self.horizon() * self.grid.time(1);
        let reach = self.watch.reach(&self.bodies, horizon);
        self.find_reached(reach);
        self.measure_gaps(reach);
        self.find_nearness();
    }

    fn find_reached(&mut self, reach: f64) {
        let (gel, watch, reached) = (&self.gel, &self.watch, &mut self.scratch.reached);
        let mut see = |surface: u32| {
            let size = gel.surface.nodes[surface as usize].size;
            let meets = watch.may_be_within(surface, size.max(reach));
            if meets || (watch.may_be_within(surface, STRETCH * size) && watch.may_touch_facets(surface)) {
                reached.push(surface);
            }
        };
        let Some(blocks) = &self.blocks else {
            self.scratch.active.list.iter().filter_map(|a| gel.surface.of[*a as usize]).for_each(&mut see);
            reached.sort_unstable();
            return;
        };
        for block in blocks.all.iter().filter(|block| block.due != Due::Nothing) {
            let fires = |number: &u16| block.due == Due::All || block.touched.binary_search(number).is_ok();
            block.surface.iter().filter(|(number, _)| fires(number)).for_each(|(_, surface)| see(*surface));
        }
        reached.sort_unstable();
        reached.dedup();
    }

    fn measure_gaps(&mut self, reach: f64) {
        let (scratch, n) = (&mut self.scratch, self.bodies.len());
        scratch.gaps.clear();
        scratch.close.clear();
        for (i, surface) in scratch.reached.iter().enumerate() {
            let SurfaceNode { node, size, .. } = self.gel.surface.nodes[*surface as usize];
            let point = embed(&self.state.position[node.index()]);
            let bodies = self.bodies.iter().zip(&scratch.was);
            scratch.gaps.extend(bodies.map(|(fixed, body)| body.active.then(|| fixed.gap(body, &point))));
            let nearest = scratch.gaps[i * n..].iter().flatten().map(|gap| gap.distance).fold(f64::INFINITY, f64::min);
            self.watch.note(*surface, nearest);
            if nearest < size.max(reach) {
                scratch.close.push(node);
            }
            scratch.place[*surface as usize] = i as u32;
        }
    }

    /// Facets around nodes that bodies are far from need not be looked at for a while.
    pub(super) fn clear_facets(&mut self) {
        /// From how far on it is worth while, in element sizes: facets are about that long.
        const FAR: f64 = 2.0;
        let (gel, n) = (self.gel.clone(), self.bodies.len());
        for (place, surface) in self.scratch.reached.iter().enumerate() {
            let SurfaceNode { node, size, .. } = gel.surface.nodes[*surface as usize];
            let gaps = self.scratch.gaps[place * n..][..n].iter().flatten();
            let nearest = gaps.map(|gap| gap.distance).fold(f64::INFINITY, f64::min);
            if nearest > FAR * size && self.watch.may_touch_facets(*surface) {
                let around = gel.surface.around.of(node).iter();
                let longest = around.map(|facet| self.longest_edge(*facet)).fold(0.0, f64::max);
                self.watch.note_facets(*surface, nearest - 2.0 * longest);
            }
        }
    }

    /// φ and n of a node that was looked at, by its place among those.
    pub(super) fn gap_at(&self, place: usize, body: usize) -> Option<Gap> {
        self.scratch.gaps[place * self.bodies.len() + body]
    }
}
