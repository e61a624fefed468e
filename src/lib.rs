//! A block of ballistic gelatin hit by a rigid projectile, as an FMI 2.0 co-simulation component.
//!
//! Explicit finite elements of a hyperelastic gel, stepped by an asynchronous variational integrator (every element at
//! its own time step), meet a rigid body by a penalty-free momentum-exchange contact. `ARCHITECTURE.md` is the map.

pub mod adapt;
pub mod constitutive;
pub mod contact;
pub mod fem;
pub mod fmi2;
pub mod geometry;
pub mod integrator;
pub mod ledger;
pub mod math;
pub mod mesh;
pub mod output;
pub mod reduced;
pub mod remesh;
pub mod scene;
pub mod simulation;
pub mod state;
