//! Views of the phases: which parts of the system each phase of a tick reads and which it writes.
//!
//! Macros make the parts that several views share: a function would borrow the whole of the state, for example, while a
//! phase writes other fields of it.

use super::DistortionLimits;
use super::assembly::StepRule;
use super::balance_phase::BalancePhase;
use super::contact_accounts::ContactAccounts;
use super::contact_phase::ContactPhase;
use super::element_loop::ElementLoopInput;
use super::element_phase::{ElementPhase, ElementResults};
use super::exit::BodyExit;
use super::gap_phase::GapPhase;
use super::impulse_phase::ImpulsePhase;
use super::kick::KickCorrection;
use super::kick_sums::KickSums;
use super::kicked_nodes::KickedNodes;
use super::load::{LoadPhase, LoadedElements};
use super::load_input::LoadInput;
use super::node_chunks::NodeChunks;
use super::node_loop::NodePhase;
use super::node_update::NodeUpdate;
use super::reference::{ReferenceElements, ReferenceKicks};
use super::self_contact_phase::SelfContactPhase;
use super::step_check::StepCheck;
use super::step_limits::StepLimits;
use super::step_size::StepPhase;
use super::stretch_limit::StretchCheck;
use super::substep::{GroupTicks, MeshPhase};
use super::surface_at_tick::SurfaceAtTick;
use super::system::DiscreteSystem;
use super::tick_nodes::TickNodes;
use crate::contact::{BodyState, ContactTolerances};
use crate::fem::Potential;
use crate::state::Tick;

/// Views the nodes in the parts of a system, whose other fields stay free for a phase to write.
macro_rules! tick_nodes {
    ($model:expr, $state:expr, $clock:expr, $workspace:expr) => {
        TickNodes {
            grid: $model.grid,
            position: &$state.position,
            velocity: &$state.velocity,
            last_ticks: &$clock.last_ticks,
            active: &$workspace.active_nodes,
            before: &$workspace.velocities_before,
        }
    };
}

/// Views the surface in the parts of a system.
macro_rules! surface_at_tick {
    ($model:expr, $state:expr, $clock:expr, $workspace:expr) => {
        SurfaceAtTick {
            model: $model,
            nodes: tick_nodes!($model, $state, $clock, $workspace),
            bodies: &$workspace.bodies_before,
        }
    };
}

/// Views the stable limits in the parts of a system.
macro_rules! step_limits {
    ($model:expr, $state:expr, $blocks:expr, $workspace:expr) => {
        StepLimits {
            model: $model,
            active: &$workspace.active_nodes,
            node_limits: &$workspace.node_limits,
            blocks: $blocks.as_ref(),
            stiffness: &$state.stiffness,
        }
    };
}

/// Views the nodes after their kicks in the parts of a system.
macro_rules! kicked_nodes {
    ($model:expr, $state:expr, $clock:expr, $workspace:expr, $contact:expr, $batch_travel:expr) => {
        KickedNodes {
            model: $model,
            active: &$workspace.active_nodes,
            before: &$workspace.velocities_before,
            decay: &$workspace.decay,
            position: &mut $state.position,
            velocity: &mut $state.velocity,
            excess: &mut $state.excess,
            last_ticks: &mut $clock.last_ticks,
            neighbours: &mut $contact.neighbours,
            batch_travel: $batch_travel,
        }
    };
}

impl<const D: usize, P: Potential<D>> DiscreteSystem<D, P> {
    /// Returns the element phase of a tick; `None` in the reference form.
    pub fn element_phase(&mut self, tick: Tick) -> Option<ElementPhase<'_, D>> {
        let moment = self.tick_context(tick);
        let Self { model, state, clock, blocks, workspace, pool, .. } = self;
        let input = ElementLoopInput {
            moment,
            grid: model.grid,
            position: &state.position,
            velocity: &state.velocity,
            rest: model.gel.potential.rest(),
            last: &clock.last_ticks,
            clocks: &state.clocks,
            order: &model.layout,
        };
        Some(ElementPhase {
            input,
            pool: pool.as_deref(),
            blocks: blocks.as_mut()?,
            stiffness: &mut state.stiffness,
            responses: &mut workspace.responses,
            active_nodes: &mut workspace.active_nodes,
        })
    }

    /// Returns the element phase of a tick in the reference form.
    pub fn reference_elements(&mut self, tick: Tick) -> ReferenceElements<'_, D, P> {
        let moment = self.tick_context(tick);
        let Self { model, state, clock, workspace, .. } = self;
        ReferenceElements {
            model,
            ticks: GroupTicks { moment, clocks: &state.clocks, alarms: &state.alarms },
            queue: &mut clock.queue,
            active_groups: &mut workspace.active_groups,
            active_nodes: &mut workspace.active_nodes,
            kick_lengths: &mut workspace.kick_lengths,
            position: &mut state.position,
            velocity: &state.velocity,
            last_ticks: &mut clock.last_ticks,
            before: &mut workspace.velocities_before,
            decay: &mut workspace.decay,
            stiffness: &mut state.stiffness,
            memory: &mut state.memory,
            energy: &mut state.ledger.energy,
            responses: &mut workspace.responses,
            element_responses: &mut workspace.element_responses,
        }
    }

    /// Returns the results of the element phase.
    pub fn element_results(&self) -> ElementResults<'_, D> {
        ElementResults {
            layout: &self.model.layout,
            clocks: &self.state.clocks,
            responses: &self.workspace.responses,
            blocks: self.blocks.as_ref(),
            active_groups: &self.workspace.active_groups,
        }
    }

    /// Returns the node phase of a tick; `None` in the reference form.
    pub fn node_phase(&mut self, tick: Tick) -> Option<NodePhase<'_, D, P>> {
        let leading_share = self.tick_context(tick).leading_share();
        let is_shared = self.is_worth_sharing();
        let Self { model, state, clock, blocks, workspace, batch_travel, pool, .. } = self;
        let blocks = blocks.as_ref()?;
        let n_chunks = workspace.active_nodes.n_chunks(state.position.len());
        workspace.chunk_sums.resize(n_chunks, KickSums::default());
        let nodes = NodeChunks {
            first: 0,
            position: &mut state.position,
            velocity: &mut state.velocity,
            before: &mut workspace.velocities_before,
            last: &mut clock.last_ticks,
            limit: &mut workspace.node_limits,
            excess: &mut state.excess,
            decay: &mut workspace.decay,
            speeds: &mut batch_travel.speeds,
            sums: &mut workspace.chunk_sums,
        };
        let (gel, grid, freedom) = (&*model.gel, model.grid, model.freedom());
        Some(NodePhase {
            update: NodeUpdate { gel, grid, freedom, tick, leading_share, damping_rate: model.settings.damping },
            rule: StepRule { mass: &gel.mass, cfl: model.settings.cfl },
            blocks,
            active: &workspace.active_nodes,
            pool: pool.as_deref().filter(|_| is_shared),
            nodes,
        })
    }

    /// Returns the load phase of a tick.
    pub fn load_phase(&mut self, tick: Tick) -> LoadPhase<'_, D, P> {
        let moment = self.tick_context(tick);
        let Self { model, state, clock, blocks, workspace, .. } = self;
        let time = model.grid.time(tick);
        let input = LoadInput {
            model,
            nodes: tick_nodes!(model, state, clock, workspace),
            ticks: GroupTicks { moment, clocks: &state.clocks, alarms: &state.alarms },
            active_groups: blocks.is_none().then_some(&workspace.active_groups),
            projectile: &state.bodies[0],
            has_left: state.record.contacts[0].exit.is_some(),
            time,
            entry: model.frame.motion(&state.record.outside, time).displacement.z,
        };
        LoadPhase {
            input,
            stiffness: &state.stiffness,
            gas: &mut state.record.gas,
            facet_loads: &mut workspace.facet_loads,
            load_stiffness: &mut workspace.load_stiffness,
        }
    }

    /// Returns the elements behind the loads of this tick.
    pub fn loaded_elements(&mut self) -> LoadedElements<'_, D, P> {
        LoadedElements {
            gel: &self.model.gel,
            loads: &self.workspace.load_stiffness,
            blocks: self.blocks.as_mut(),
            stiffness: &mut self.state.stiffness,
            stiffened: &mut self.workspace.stiffened_blocks,
        }
    }

    /// Returns the stable limits.
    pub fn step_limits(&self) -> StepLimits<'_, D, P> {
        step_limits!(&self.model, self.state, self.blocks, self.workspace)
    }

    /// Returns the gap phase of a tick.
    pub fn gap_phase(&mut self) -> GapPhase<'_, D, P> {
        let horizon = self.horizon();
        let Self { model, state, clock, blocks, contact, workspace, .. } = self;
        GapPhase {
            surface: surface_at_tick!(model, state, clock, workspace),
            limits: step_limits!(model, state, blocks, workspace),
            horizon,
            contact,
            surface_stars: &mut workspace.surface_stars,
            contact_limits: &mut workspace.contact_limits,
        }
    }

    /// Returns the check of the steps at a tick; `None` in the reference form, which checks all active groups.
    pub fn step_check(&mut self, tick: Tick) -> Option<StepCheck<'_, D, P>> {
        let (moment, can_be_distorted) = (self.tick_context(tick), self.can_be_distorted());
        let Self { model, state, blocks, contact, workspace, .. } = self;
        Some(StepCheck {
            model,
            moment,
            active: &workspace.active_nodes,
            node_limits: &workspace.node_limits,
            stiffness: &state.stiffness,
            clocks: &state.clocks,
            responses: &workspace.responses,
            contact,
            contact_limits: &workspace.contact_limits,
            surface_stars: &workspace.surface_stars,
            can_be_distorted,
            blocks: blocks.as_mut()?,
            block_limits: &mut workspace.block_limits,
            groups: &mut workspace.active_groups,
        })
    }

    /// Returns the step phase of a tick.
    pub fn step_phase(&mut self, tick: Tick) -> StepPhase<'_, D, P> {
        let (moment, can_be_distorted) = (self.tick_context(tick), self.can_be_distorted());
        let Self { model, state, clock, blocks, contact, workspace, .. } = self;
        let is_held = clock.ends.distortion.as_ref().is_some_and(DistortionLimits::are_of_edits);
        StepPhase {
            limits: step_limits!(model, state, blocks, workspace),
            moment,
            groups: &workspace.active_groups,
            responses: &workspace.responses,
            contact,
            contact_limits: &workspace.contact_limits,
            can_be_distorted,
            held_steps: state.birth.as_ref().filter(|_| is_held).map(|birth| birth.steps.as_slice()),
            clocks: &mut state.clocks,
            alarms: &mut state.alarms,
            changed_steps: &mut workspace.changed_steps,
        }
    }

    /// Returns the contact phase of a tick.
    pub fn contact_phase(&mut self, tick: Tick) -> ContactPhase<'_, D, P> {
        let (moment, can_be_distorted) = (self.tick_context(tick), self.can_be_distorted());
        let Self { model, state, clock, contact, workspace, .. } = self;
        ContactPhase {
            surface: surface_at_tick!(model, state, clock, workspace),
            ticks: GroupTicks { moment, clocks: &state.clocks, alarms: &state.alarms },
            surface_stars: &workspace.surface_stars,
            tolerances: ContactTolerances::new(D == 3 && can_be_distorted && model.gel.potential.remembers()),
            contact,
            points: &mut workspace.contact_points,
            symmetry: &mut workspace.symmetry_contacts,
            records: &mut state.record.contacts,
        }
    }

    /// Returns the self-contact phase of a tick.
    pub fn self_contact_phase(&mut self, tick: Tick) -> SelfContactPhase<'_, D, P> {
        let moment = self.tick_context(tick);
        let Self { model, state, clock, contact, batch_travel, separation, workspace, .. } = self;
        SelfContactPhase {
            surface: surface_at_tick!(model, state, clock, workspace),
            ticks: GroupTicks { moment, clocks: &state.clocks, alarms: &state.alarms },
            batch_travel: batch_travel.travel(),
            node_travel: contact.neighbours.node_travel(),
            separation,
            contacts: &mut workspace.self_contacts,
            passive_nodes: &mut workspace.passive_nodes,
        }
    }

    /// Returns the check of the stretch of the surface after a tick.
    pub fn stretch_check(&self) -> StretchCheck<'_, D, P> {
        let Self { model, state, clock, contact, workspace, .. } = self;
        StretchCheck {
            surface: surface_at_tick!(model, state, clock, workspace),
            facets: &contact.facets,
            can_be_distorted: self.can_be_distorted(),
            greatest_edge: clock.ends.distortion.as_ref().map_or(f64::INFINITY, |limits| limits.facet_edge),
        }
    }

    /// Returns the kick correction of a tick, none at the first tick of a mesh; `None` in the reference form.
    pub fn kick_correction(&mut self) -> Option<KickCorrection<'_, D, P>> {
        let Self { model, state, clock, blocks, contact, batch_travel, workspace, .. } = self;
        let is_first = clock.phase == MeshPhase::First;
        Some(KickCorrection {
            nodes: kicked_nodes!(model, state, clock, workspace, contact, batch_travel),
            chunk_sums: &workspace.chunk_sums,
            changed_steps: if is_first { &[] } else { &workspace.changed_steps },
            blocks: blocks.as_mut()?,
            memory: &mut state.memory,
            responses: &mut workspace.responses,
            elements: &mut workspace.element_responses.elements,
            ledger: &mut state.ledger,
        })
    }

    /// Returns the impulse phase of a tick.
    pub fn impulse_phase(&mut self, tick: Tick) -> ImpulsePhase<'_, D, P> {
        self.reference_kicks(tick).impulses
    }

    /// Returns the kicks of a tick in the reference form.
    pub fn reference_kicks(&mut self, tick: Tick) -> ReferenceKicks<'_, D, P> {
        let moment = self.tick_context(tick);
        let Self { model, state, clock, blocks, contact, batch_travel, workspace, .. } = self;
        let impulses = ImpulsePhase {
            nodes: kicked_nodes!(model, state, clock, workspace, contact, batch_travel),
            ticks: GroupTicks { moment, clocks: &state.clocks, alarms: &state.alarms },
            blocks: blocks.as_ref(),
            bodies: &workspace.bodies_before,
            bodies_after: &mut workspace.bodies_after,
            facet_loads: &mut workspace.facet_loads,
            points: &mut workspace.contact_points,
            symmetry: &mut workspace.symmetry_contacts,
            self_contacts: &mut workspace.self_contacts,
            passive_nodes: &workspace.passive_nodes,
            impulse_nodes: &mut workspace.impulse_nodes,
            ledger: &mut state.ledger,
            record: &mut state.record,
        };
        ReferenceKicks {
            impulses,
            active_groups: &workspace.active_groups,
            kick_lengths: &mut workspace.kick_lengths,
            responses: &workspace.element_responses,
        }
    }

    /// Returns the balance phase of a tick.
    pub fn balance_phase(&mut self, tick: Tick) -> BalancePhase<'_, D, P> {
        let moment = self.tick_context(tick);
        let Self { model, state, blocks, workspace, .. } = self;
        BalancePhase {
            model,
            moment,
            alarms: &state.alarms,
            active_groups: &workspace.active_groups,
            responses: &workspace.responses,
            changed_steps: &workspace.changed_steps,
            velocity: &state.velocity,
            before: &workspace.velocities_before,
            facet_loads: &workspace.facet_loads,
            impulse_nodes: &workspace.impulse_nodes,
            blocks: blocks.as_mut(),
            clocks: &mut state.clocks,
            energy: &mut state.ledger.energy,
            record: &mut state.record,
        }
    }

    /// Returns the accounts of the contact impulses of a tick.
    pub fn contact_accounts(&mut self) -> ContactAccounts<'_, D, P> {
        let Self { model, state, clock, workspace, .. } = self;
        ContactAccounts {
            surface: surface_at_tick!(model, state, clock, workspace),
            bodies_after: &workspace.bodies_after,
            points: &workspace.contact_points,
            symmetry: &workspace.symmetry_contacts,
            self_contacts: &workspace.self_contacts,
            exits: clock.ends.exits,
            bodies: &mut state.bodies,
            ledger: &mut state.ledger,
            record: &mut state.record,
        }
    }

    /// Returns a body at a state as its exit is found.
    pub fn body_exit<'a>(&'a self, body: usize, at: &'a BodyState) -> BodyExit<'a> {
        let (model, record) = (&self.model, &self.state.record);
        let (rigid, contact) = (&model.bodies[body], &record.contacts[body]);
        BodyExit { rigid, at, frame: &model.frame, outside: &record.outside, contact }
    }
}
