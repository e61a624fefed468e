//! `RigidBody.fmu`: a projectile that owns its state, as the partner of the gel.

mod body;
mod fmi;
mod instance;
mod starts;
mod table;

use body::MODEL;
