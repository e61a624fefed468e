//! Physics and engine: what is computed.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]
#![allow(clippy::duplicate_mod, reason = "modules of the studies name the bodies of these tests by their path")]

#[path = "../../studies/src/deepest.rs"]
mod deepest;
#[path = "../lanes/gels.rs"]
mod gels;
#[path = "../solid/bodies.rs"]
mod solid_bodies;

mod bodies;
mod cavity;
mod conservation;
mod engine;
mod expansion;
mod friction;
mod hyperelastic;
mod impacts;
mod lanes;
mod layers;
mod loads;
mod mirror;
mod patches;
mod reduced;
mod regression;
mod remesh;
mod self_contact;
mod shapes;
mod solid;
mod stl;
mod tree;
mod two_network;
mod verification;
mod viscoelastic;
