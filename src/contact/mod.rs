//! Contact: rigid bodies, the detection of contact with the surface of the gel, and the solver of its impulses.

mod batch_travel;
mod body;
mod body_state;
mod bulge;
mod close_pairs;
mod cluster_tree;
mod cone_guard;
mod detection;
mod exchange;
mod expansion;
mod facet;
mod facet_candidate;
mod facet_foot;
mod law;
mod leaf_motion;
mod motion;
mod neighbour_list;
mod pair_chains;
mod point;
mod self_contact;
mod separation_list;
#[cfg(test)]
mod separation_tests;
mod shape_motion;
mod solver;
mod solver_body;
mod surface;
mod surface_motion;
mod symmetry;
#[cfg(test)]
pub(crate) mod test_surface;
mod tip;
mod tolerance;
mod travel_monitor;

pub(crate) use batch_travel::{BatchTravel, TRAVEL_BATCH};
pub use body::{BodyMotion, FreeDirections, RigidBody};
pub use body_state::{BodyState, Wrench};
pub use bulge::DomeMotion;
pub(crate) use detection::ContactDetection;
pub use exchange::ImpulseExchange;
pub use expansion::{ExpansionLaw, ExpansionMotion};
pub(crate) use facet_candidate::FacetCandidate;
pub use law::{ImpulseLaw, impulse, reversal};
pub use motion::WrenchWork;
pub(crate) use neighbour_list::{NeighbourList, STRETCH};
pub(crate) use point::{ContactPoint, TickBodies};
pub(crate) use self_contact::{FacetProximity, SelfContact, look_at_facet};
pub(crate) use separation_list::SeparationList;
pub use shape_motion::ShapeMotion;
pub(crate) use solver::ContactProblem;
pub use surface::{ContactSurface, SurfaceNode};
pub(crate) use surface::{NodalMasses, SurfaceView};
pub(crate) use surface_motion::{NodePlaces, SurfaceMotion, SurfaceStars};
pub(crate) use symmetry::{SymmetryContact, symmetry_contacts};
pub(crate) use tolerance::ContactTolerances;
