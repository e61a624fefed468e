//! `RigidBody.fmu`: a projectile that owns its state, as the partner of the gel.

mod body;
mod fmi;
mod instance;
mod table;

use body::MODEL;
