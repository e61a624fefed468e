//! The verification suite: closed forms, orders of convergence and conservation, one row of the table in docs/validation.md each.

mod bar;
mod coupling;
mod impulse;
mod locking;
mod momentum;
mod noise;
mod patch;
mod resonance;
mod row;
mod striker;
mod strip;
mod table;
mod vibration;
mod wall;
mod wave;
