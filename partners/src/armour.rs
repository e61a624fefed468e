//! `Armour.fmu`: a plate and the bulge behind it, as the partner of gel and projectile.

mod fmi;
mod instance;
mod plate;
mod starts;
mod table;

use plate::MODEL;
