//! Elements in vector lanes: eight patches at a time.

pub(super) mod batch;
pub(super) mod layout;
pub(super) mod node_cache;
pub(super) mod pipeline;
pub(super) mod transpose;
