//! The C interface, called as an importer calls it: order, bad arguments, states, meaning.

#[path = "../fmi2/bodies.rs"]
mod bodies;
#[path = "../fmi2/cavity.rs"]
mod cavity;
#[path = "../fmi2/coupling.rs"]
mod coupling;
#[cfg(target_arch = "x86_64")]
#[path = "../fmi2/environment.rs"]
mod environment;
#[path = "../fmi2/exit.rs"]
mod exit;
#[path = "../fmi2/expansion.rs"]
mod expansion;
#[path = "../fmi2/fidelity.rs"]
mod fidelity;
#[path = "../fmi2/files.rs"]
mod files;
#[path = "../fmi2/fragments.rs"]
mod fragments;
#[path = "../fmi2/interface.rs"]
mod interface;
#[path = "../fmi2/order.rs"]
mod order;
#[path = "../fmi2/refusal.rs"]
mod refusal;
#[path = "../fmi2/sensors.rs"]
mod sensors;
#[allow(dead_code, reason = "they are shared with the tests of their geometry")]
#[path = "../solid/bodies.rs"]
mod solids;
#[path = "../fmi2/stack.rs"]
mod stack;
#[path = "../fmi2/state.rs"]
mod state;
#[path = "../fmi2/stl.rs"]
mod stl;
use crate::host;
